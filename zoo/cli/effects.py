"""The effects a verb works with, from its config and from the catalogue."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from omegaconf import DictConfig, OmegaConf

from zoo.catalog import create, find, load, names
from zoo.cli.command_line import searchpath, typed
from zoo.effects.base import Effect
from zoo.effects.checks import check_effect
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


def chosen(config: DictConfig) -> dict[str, Effect]:
    """The effects of the model as it stands, as configured.

    Raises:
        InputError: one of them is wrong, see `made`.
    """
    folders = searchpath()
    for name in _typed("effects"):
        load("effects", name, folders)  # Hydra merges the YAMLs unseen: of a wrong one nothing is left, or something else
    return {str(name): made(str(name), settings, folders) for name, settings in (config.get("effects") or {}).items()}


def _typed(group: str) -> list[str]:
    """The names given to a config group on the command line."""
    overrides = OverridesParser.create().parse_overrides(typed())
    last = next((one.value() for one in reversed(overrides) if one.key_or_group == group), None)
    return [last] if isinstance(last, str) else [str(name) for name in last] if isinstance(last, list) else []


def made(name: str, settings: Any, folders: list[Path]) -> Effect:
    """One effect, tried before it is trusted.

    Args:
        name: in the catalogue.
        settings: with `_target_`.
        folders: the user's own.

    Raises:
        InputError: it is wrong; names the effect, its class, its YAML, what was found and what is possible.
    """
    target = settings.get("_target_") if OmegaConf.is_dict(settings) else None
    if target is None:
        raise InputError(f"effects.{name}={settings}: no _target_ in it; {nearest(name, names('effects', folders))}")
    try:
        effect: Effect = create(settings)
        check_effect(effect, name)
    except InputError as error:
        raise InputError(f"effect '{name}' ({find('effects', name, folders) or target}): {error}") from error
    return effect


def catalogue(config: DictConfig, wanted: list[str] | None = None) -> dict[str, Effect]:
    """Every effect that can be named, the model's own first and as configured.

    Args:
        config: with `effects` and `candidates`.
        wanted: effects needed besides those of the model; by default what `candidates` allows.

    Raises:
        InputError: a name that is not in the catalogue, or an effect that is wrong, see `made`.
    """
    folders = searchpath()
    known, own = names("effects", folders), chosen(config)
    allowed = "all" if wanted is not None else config.candidates
    others = wanted if wanted is not None else known if allowed == "all" else named("candidates", allowed, "all")
    for name in others:
        if name not in known and name not in own:
            raise InputError(f"unknown effect '{name}': {nearest(name, known)}")
    return own | {name: made(name, load("effects", name, folders)[name], folders) for name in others if name not in own}


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
