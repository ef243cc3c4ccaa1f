"""The effects a verb works with, from its config and from the catalogue."""

from __future__ import annotations

import shlex
from typing import Any

from omegaconf import DictConfig, OmegaConf

from zoo.catalog import build, create, names
from zoo.cli.inputs import searchpath
from zoo.effects.base import Effect
from zoo.errors import InputError, nearest


def model_effects(config: DictConfig) -> list[str]:
    """Names of the effects in the model as it stands.

    Raises:
        InputError: none is named.
    """
    chosen = [str(name) for name in config.get("effects") or {}]
    if not chosen:
        raise InputError("effects=[] leaves nothing to fit; start from effects=[static_bias,shupe,mohr]")
    return chosen


def catalogue(config: DictConfig, wanted: list[str] | None = None) -> dict[str, Effect]:
    """Every effect that can be named, the model's own first and as configured.

    Args:
        config: with `effects` and `candidates`.
        wanted: effects needed besides those of the model; by default what `candidates` allows.

    Raises:
        InputError: a name that is not in the catalogue.
    """
    folders = searchpath()
    known = names("effects", folders)
    own = {str(name): create(settings) for name, settings in (config.get("effects") or {}).items()}
    allowed = "all" if wanted is not None else config.candidates
    others = wanted if wanted is not None else known if allowed == "all" else named("candidates", allowed, "all")
    for name in others:
        if name not in known and name not in own:
            raise InputError(f"unknown effect '{name}': {nearest(name, known)}")
    return own | {name: build("effects", name, folders) for name in others if name not in own}


def named(key: str, given: Any, word: str) -> list[str]:
    """The names under a key: one name or a list of them.

    Args:
        key: of the config, for the message.
        given: its value.
        word: what else is possible, for the message.

    Raises:
        InputError: neither.
    """
    if isinstance(given, str):
        return [given]
    if not OmegaConf.is_list(given):
        raise InputError(f"{key}={'null' if given is None else given}: {word}, an effect's name or a list of names is needed")
    return [str(name) for name in given]


def next_commands(config: DictConfig, missing: list[str]) -> list[str]:
    """What to type after a diagnosis."""
    files = ",".join(str(file) for file in ([config.data.files] if isinstance(config.data.files, str) else config.data.files))
    parts = [
        "fogzoo",
        "refine",
        f"add=[{','.join(missing)}]" if missing else "add=auto",
        f"effects=[{','.join(model_effects(config))}]",
        f"data.files=[{files}]",
    ]
    return [shlex.join([*parts, *_mapping(config)])] if missing else []


def _mapping(config: DictConfig) -> list[str]:
    """The data settings that differ from the defaults, so that a printed command can be pasted."""
    columns = [
        f"{'+' if role.startswith('temperature_') else ''}data.columns.{role}={name}"
        for role, name in config.data.columns.items()
        if name is not None
    ]
    others = [
        f"data.{key}={config.data[key]}"
        for key, usual in (("output_unit", None), ("reference", 0.0), ("average_s", "auto"), ("holdout", 0.0))
        if config.data[key] != usual
    ]
    checks = config.data.check_files
    listed = ",".join([checks] if isinstance(checks, str) else [str(file) for file in checks])
    return [*columns, *others, *([f"data.check_files=[{listed}]"] if listed else []), *_searchpath()]


def _searchpath() -> list[str]:
    folders = ",".join(f"file://{folder}" for folder in searchpath())
    return [f"hydra.searchpath=[{folders}]"] if folders else []
