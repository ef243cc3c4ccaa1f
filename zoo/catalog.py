"""The YAML folder is the registry: what can be named, and how a name becomes an object."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf

import zoo
from zoo.artifacts import replacing, write_text
from zoo.errors import InputError, nearest

MODEL_FILE = "model.yaml"
WEIGHTS_FILE = "weights.pt"


def config_folder() -> Path:
    """The configs shipped with the package: inside an installed wheel, beside `zoo/` in a checkout."""
    package = Path(zoo.__file__).resolve().parent
    inside = package / "conf"
    return inside if inside.is_dir() else package.parent / "conf"


def names(group: str, searchpath: Sequence[Path] = ()) -> list[str]:
    """Every name of a config group, the user's own folders included.

    Args:
        group: such as ``"effects"``.
        searchpath: further config folders.
    """
    folders = [config_folder(), *searchpath]
    return sorted({path.stem for folder in folders for path in (folder / group).glob("*.yaml")})


def load(group: str, name: str, searchpath: Sequence[Path] = ()) -> DictConfig:
    """The YAML behind a name; the user's folders go before the package's.

    Raises:
        InputError: no such name; the nearest are offered.
    """
    for folder in [*searchpath, config_folder()]:
        path = folder / group / f"{name}.yaml"
        if path.is_file():
            config = OmegaConf.load(path)
            if isinstance(config, DictConfig):
                return config
            raise InputError(f"{path}: a mapping was expected, found {type(config).__name__}")
    raise InputError(f"unknown {group.removesuffix('s')} '{name}': {nearest(name, names(group, searchpath))}")


def create(config: DictConfig | dict[str, Any], **overrides: Any) -> Any:
    """Build an object from its config, lists as plain lists (a ListConfig breaks TorchScript)."""
    return instantiate(config, _convert_="all", **overrides)


def build(group: str, name: str, searchpath: Sequence[Path] = (), **overrides: Any) -> Any:
    """Build the object behind a name, ``build("effects", "shupe")``."""
    config = load(group, name, searchpath)
    if "_target_" not in config and name in config:
        config = config[name]
    return create(config, **overrides)


def save_model(folder: Path, config: dict[str, Any], module: torch.nn.Module) -> None:
    """Write a model so that `load_model` rebuilds it: its config beside its weights.

    Args:
        folder: an existing folder.
        config: a plain mapping with `_target_`, as `create` takes it.
        module: the fitted model.
    """
    write_text(folder / MODEL_FILE, OmegaConf.to_yaml(OmegaConf.create(config), resolve=True))
    with replacing(folder / WEIGHTS_FILE) as path:
        torch.save(module.state_dict(), path)


def load_model(folder: Path) -> torch.nn.Module:
    """Rebuild a model saved by `train` or `refine`, in evaluation mode.

    Raises:
        InputError: the folder holds no saved model.
    """
    for file in (MODEL_FILE, WEIGHTS_FILE):
        if not (folder / file).is_file():
            raise InputError(f"{folder}: no saved model here ({file} is missing); give the output folder of a train or refine command")
    module: torch.nn.Module = create(OmegaConf.load(folder / MODEL_FILE))  # type: ignore[arg-type]
    module.load_state_dict(torch.load(folder / WEIGHTS_FILE, weights_only=True))
    return module.eval()
