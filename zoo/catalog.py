"""The YAML folder is the registry: what can be named, and how a name becomes an object."""

from __future__ import annotations

import copy
import importlib
import json
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from pickle import UnpicklingError
from typing import Any, cast

import torch
from hydra.errors import InstantiationException
from hydra.utils import instantiate
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError  # type: ignore[import-untyped]

import zoo
from zoo.artifacts import replacing, write_json, write_text
from zoo.errors import InputError, WorkError, causes, in_brief, nearest
from zoo.models.ranges import Ranges, checked
from zoo.training.files import MEMBERS, UNREADABLE
from zoo.training.members import read_members

MODEL_FILE = "model.yaml"
WEIGHTS_FILE = "weights.pt"
RANGES_FILE = "ranges.json"
LISTS = ("effects",)
"""Groups of which a config takes several: in their YAMLs the settings stand below the name, so that several can be merged."""


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


def find(group: str, name: str, searchpath: Sequence[Path] = ()) -> Path | None:
    """The YAML behind a name, where there is one; the user's folders go before the package's."""
    paths = (folder / group / f"{name}.yaml" for folder in [*searchpath, config_folder()])
    return next((path for path in paths if path.is_file()), None)


def load(group: str, name: str, searchpath: Sequence[Path] = ()) -> DictConfig:
    """What the YAML behind a name says.

    Raises:
        InputError: no such name, and the nearest are offered; or the YAML is wrong.
    """
    path = find(group, name, searchpath)
    if path is None:
        raise InputError(f"unknown {group.removesuffix('s')} '{name}': {nearest(name, names(group, searchpath))}")
    config = _read(path)
    if group in LISTS:
        _check_entry(config, name, f"{group.removesuffix('s')} '{name}' ({path})")
        return config
    included = _included(config, group)
    own = config[group] if isinstance(config.get(group), DictConfig) else config  # a YAML may also choose from other groups
    return cast(DictConfig, OmegaConf.merge(*(load(group, one, searchpath) for one in included), own))


def _read(path: Path, resolved: bool = False) -> DictConfig:
    try:
        config = OmegaConf.load(path)
        if resolved:
            OmegaConf.resolve(config)
    except (YAMLError, OmegaConfBaseException, OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: {in_brief(error)}") from error
    if not isinstance(config, DictConfig):
        raise InputError(f"{path}: a mapping was expected, found {type(config).__name__}")
    return config


def _included(config: DictConfig, group: str) -> list[str]:
    """Takes the defaults list out of a config, and gives the names of its own group in there, such as ``parts/parameters@_here_``."""
    entries = [str(one).partition("@")[0] for one in config.pop("defaults", None) or [] if isinstance(one, str)]
    return [one.removeprefix(f"/{group}/") for one in entries if one != "_self_"]


def _check_entry(config: DictConfig, name: str, which: str) -> None:
    """Raises InputError where the settings do not stand below the name, and nothing else beside it."""
    keys = [str(key) for key in config]
    below = config[name] if keys == [name] else None
    if isinstance(below, DictConfig) and "_target_" in below:
        return
    found = f"no _target_ below '{name}:'" if keys == [name] else f"'{', '.join(keys)}' at the top" if keys else "nothing"
    raise InputError(f"{which}: has {found}; two lines are needed, '{name}:' at the top and below it, indented, '_target_: MODULE.CLASS'")


def create(config: DictConfig | dict[str, Any], **overrides: Any) -> Any:
    """Build an object from its config, lists as plain lists (a ListConfig breaks TorchScript).

    Raises:
        InputError: there is no such class, or it does not take these settings.
    """
    try:
        return instantiate(config, _convert_="all", **overrides)
    except InstantiationException as error:
        raise _in_our_words(error) from error


def _in_our_words(error: InstantiationException) -> InputError | WorkError:
    """What the object itself said, or why there is none, instead of how Hydra came to ask for it."""
    located = re.search(r"Error locating target '([^']+)'", str(error))
    if located:
        return InputError(f"{located.group(1)}: {unlocated(located.group(1))}")
    own = next((cause for cause in causes(error) if isinstance(cause, InputError | WorkError)), None)
    if own:
        return type(own)(*own.args)
    called = re.search(r"Error in call to target '([^']+)'", str(error))
    return InputError(f"{called.group(1)}: {in_brief(error.__cause__)}" if called and error.__cause__ else in_brief(error))


def unlocated(target: str) -> str:
    """Why there is no such class or function: what Python says when its module is imported.

    Args:
        target: as in `_target_`, MODULE.CLASS.
    """
    module, _, name = target.rpartition(".")
    try:
        inside = importlib.import_module(module) if module else None
    except SyntaxError as error:
        return f"SyntaxError: {error.msg} ({error.filename}, line {error.lineno})"
    except ModuleNotFoundError as error:
        own = f"{module}.".startswith(f"{error.name}.")
        return f"there is no module '{error.name}'; is its folder on PYTHONPATH?" if own else in_brief(error)
    except Exception as error:
        return in_brief(error)
    if inside is None:
        return "MODULE.CLASS is needed"
    classes = [key for key, value in vars(inside).items() if isinstance(value, type) and value.__module__.startswith(module)]
    return f"module '{module}' has no '{name}': {nearest(name, classes)}"


def build(group: str, name: str, searchpath: Sequence[Path] = (), **overrides: Any) -> Any:
    """Build the object behind a name, ``build("effects", "shupe")``."""
    config = load(group, name, searchpath)
    return create(config[name] if group in LISTS else config, **overrides)


def save_model(folder: Path, config: dict[str, Any], module: torch.nn.Module, ranges: Ranges | None = None) -> None:
    """Write a model so that `load_model` rebuilds it: its config beside its weights.

    Args:
        folder: an existing folder.
        config: a plain mapping with `_target_`, as `create` takes it.
        module: the fitted model.
        ranges: of its raw columns, rates and lags over the runs that it was fitted to, see `zoo.models.ranges`.
    """
    if ranges is not None:
        write_json(folder / RANGES_FILE, ranges)
    write_text(folder / MODEL_FILE, OmegaConf.to_yaml(OmegaConf.create(config), resolve=True))
    with replacing(folder / WEIGHTS_FILE) as path:
        torch.save(module.state_dict(), path)


def load_model(folder: str | Path) -> torch.nn.Module:
    """Rebuild a model saved by `train` or `refine`, in evaluation mode.

    Of what its files name, only subclasses of `torch.nn.Module` are called, and weights are but numbers, so that a folder may come from elsewhere.

    Raises:
        InputError: the folder holds no saved model, or one that is damaged.
    """
    folder = Path(folder)
    for file in (MODEL_FILE, WEIGHTS_FILE):
        if not (folder / file).is_file():
            raise InputError(f"{folder}: no saved model here ({file} is missing); give the output folder of a train or refine command")
    config = _read(folder / MODEL_FILE, resolved=True)
    strange = next((target for target in _targets(OmegaConf.to_container(config)) if not _makes_modules(target)), None)
    module = None if strange else create(config)
    if not isinstance(module, torch.nn.Module):
        raise InputError(f"{folder / MODEL_FILE}: {strange or 'nothing there'} is no model and no effect; give the folder that a command left")
    try:
        module.load_state_dict(torch.load(folder / WEIGHTS_FILE, weights_only=True))
    except UnpicklingError as error:
        why = f"damaged, or of another model than {MODEL_FILE}, or more than numbers is in it, which could be a program and is not loaded"
        raise InputError(f"{folder / WEIGHTS_FILE}: {why}; train it again") from error
    except UNREADABLE as error:
        raise InputError(f"{folder / WEIGHTS_FILE}: damaged, or of another model than {MODEL_FILE} ({_start(error)}); train it again") from error
    return module.eval()


def _targets(config: Any) -> Iterator[str]:
    """Whatever a configuration would have called."""
    for key, value in config.items() if isinstance(config, dict) else enumerate(config) if isinstance(config, list) else ():
        if key == "_target_":
            yield str(value)
        else:
            yield from _targets(value)


def _makes_modules(target: str) -> bool:
    """Whether it is a model or an effect, or cannot be found, which is told when it is asked for."""
    module, _, name = target.rpartition(".")
    try:
        found = getattr(importlib.import_module(module), name)
    except Exception:  # whatever comes of importing a user's own code
        return True
    return isinstance(found, type) and issubclass(found, torch.nn.Module)


def _start(error: Exception) -> str:
    return (str(error) or type(error).__name__).strip().splitlines()[0][:100]


def load_members(folder: str | Path) -> list[tuple[int, torch.nn.Module]]:
    """Rebuild all members of an ensemble that `train` saved, each with its seed, in evaluation mode.

    Raises:
        InputError: the folder holds no ensemble, or a damaged one.
    """
    folder = Path(folder)
    members = read_members(folder)
    pattern = load_model(folder)
    models = []
    for member in members:
        one = copy.deepcopy(pattern)
        try:
            one.load_state_dict(member.state)
        except UNREADABLE as error:
            raise InputError(f"{folder / MEMBERS}: of another model than {MODEL_FILE} ({_start(error)}); train it again") from error
        models.append((member.seed, one.eval()))
    return models


def load_ranges(folder: str | Path) -> Ranges:
    """Within which values a saved model was fitted, by raw column, rate and lag; empty where that was not saved with it.

    Raises:
        InputError: the file holds something else.
    """
    path = Path(folder) / RANGES_FILE
    if not path.is_file():
        return {}
    try:
        return checked(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, OSError) as error:
        raise InputError(f"{path}: {in_brief(error)}; train the model again, or take the file away") from error
