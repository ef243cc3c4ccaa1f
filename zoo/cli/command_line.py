"""What was typed: settings, and the folders of the user's own configs. A config that a program composes by itself comes without either."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import hydra
from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig, OmegaConf


def typed() -> list[str]:
    """The settings as they were typed, such as ``data.reference=0``."""
    return list(HydraConfig.get().overrides.task) if HydraConfig.initialized() else []


def is_typed(key: str) -> bool:
    """Whether a setting, or one below it, was typed."""
    return any(one.lstrip("+~").startswith((f"{key}=", f"{key}.")) for one in typed())


def searchpath() -> list[Path]:
    """The user's own config folders, as given by `hydra.searchpath`."""
    if not HydraConfig.initialized():
        return []
    sources = HydraConfig.get().runtime.config_sources
    return [Path(source.path) for source in sources if source.schema == "file" and source.provider not in {"main", "hydra"}]


def plain(value: Any) -> Any:
    """A setting as plain Python, with what it refers to in its place."""
    return OmegaConf.to_container(value, resolve=True) if OmegaConf.is_config(value) else value


def composed(verb: str, settings: Sequence[str], with_hydra: bool = False) -> DictConfig:
    """The settings of another verb as they would be if it were typed, with the user's own configs at hand.

    Args:
        verb: the name of its YAML.
        settings: such as ``gyro=medium``.
        with_hydra: Hydra's own settings as well.
    """
    own = [one for one in HydraConfig.get().overrides.hydra if one.startswith("hydra.searchpath=")] if HydraConfig.initialized() else []
    return hydra.compose(verb, [*own, *settings], return_hydra_config=with_hydra)
