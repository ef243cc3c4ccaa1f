"""What was typed: settings, and the folders of the user's own configs. A config that a program composes by itself comes without either."""

from __future__ import annotations

from pathlib import Path

from hydra.core.hydra_config import HydraConfig


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
