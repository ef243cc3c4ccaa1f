"""What Hydra's parsers do not understand, said with what to type instead."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import NoReturn, cast

import hydra
from hydra._internal.utils import get_args_parser
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import IntervalSweep, Override
from hydra.errors import HydraException, OverrideParseException
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from zoo.catalog import LISTS, config_folder, find, names
from zoo.cli.command_line import searchpath
from zoo.cli.papers import GROUP
from zoo.errors import InputError, causes, nearest
from zoo.given import in_quotes, listed
from zoo.measurements.files import SUFFIXES

DIFFERENT = ("run", "multirun", "cfg", "info", "shell_completion")
"""Flags of which Hydra takes one."""


def check_flags(arguments: list[str], verb: str) -> None:
    """Refuses a flag that does not exist, which argparse would answer with its whole usage, and flags that exclude each other.

    Args:
        arguments: as typed.
        verb: whose settings may be meant.

    Raises:
        InputError: names the flag, and what is possible.
    """
    parser = get_args_parser()
    flags = re.findall(r"--[a-z_-]+", parser.format_usage())

    def refuse(message: str) -> NoReturn:
        unknown = message.removeprefix("unrecognized arguments: ").split()[0]
        if unknown.startswith("-"):
            raise InputError(f"unknown flag {unknown}: {_setting(unknown, verb) or nearest(unknown, flags)}")
        apart = f"{unknown} stands apart from the other settings; all come before the flags, or all behind them"
        raise InputError(apart if message.startswith("unrecognized") else message)

    parser.error = refuse  # type: ignore[method-assign]
    given = vars(parser.parse_args(arguments))
    asked = [f"--{one}" for one in DIFFERENT if given[one]]
    if len(asked) > 1:
        raise InputError(f"{' and '.join(asked)}: each asks for something else; one of them is possible")


def _setting(flag: str, verb: str) -> str | None:
    """What to type instead of a flag that is called like a setting; None where it is not.

    Args:
        flag: such as ``--files`` or ``--data.files=a.csv``.
        verb: whose settings there are.
    """
    key = flag.lstrip("-").partition("=")[0].replace("-", "_")
    own = _keys(verb)
    full = key if key.partition(".")[0] in own else f"data.{key}" if "data" in own and key in _keys("data/files") else None
    return None if full is None else f"settings are given without dashes: {full}=…{' (files as [a.csv,b.csv])' if key.endswith('files') else ''}"


def check_searchpath() -> None:
    """Refuses a folder of the user's own configs that is not there, which Hydra passes over with a warning.

    Raises:
        InputError: says which.
    """
    if told := absent_folder(searchpath()):
        raise InputError(told)


def absent_folder(folders: Iterable[Path]) -> str | None:
    """A line on the first folder of configs that is not there; None where all are."""
    absent = next((folder for folder in folders if not folder.is_dir()), None)
    return None if absent is None else f"hydra.searchpath: {absent}: no such folder; give that of your own configs, as file:///FOLDER"


def check_lists(overrides: Iterable[str]) -> None:
    """Refuses a list of names from a config group of which there is one, whose settings Hydra would mix, or with a name twice, taken for one.

    Args:
        overrides: as typed.

    Raises:
        InputError: says which.
    """
    for override in overrides:
        setting = OverridesParser.create().parse_override(override)
        group, value = setting.key_or_group, setting.value()
        if not isinstance(value, list) or not names(group, searchpath()):
            continue
        if group not in LISTS and len(value) != 1:
            each = f"; for a command with each: -m {group}={','.join(map(str, value))}" if value else ""
            raise InputError(f"{override}: one is needed{each}")
        twice = next((name for name in value if value.count(name) > 1), None)
        if twice is not None:
            raise InputError(f"{override}: {twice} is there twice; once is all there can be of it")


def no_choice(error: BaseException) -> str | None:
    """A line for what is no name of a config group, such as null; None where that is not what is wrong.

    Args:
        error: of Hydra.
    """
    if not str(error).startswith("Config group override must be a string or a list"):
        return None
    for typed in sys.argv[1:]:
        group, _, value = typed.partition("=")
        if value and (possible := names(group.lstrip("+"))):
            with suppress(HydraException):
                if not isinstance(OverridesParser.create().parse_override(typed).value(), str | list):
                    return f"{typed}: possible: {', '.join(possible)}"
    return str(error)


def check_known(verb: str, overrides: Iterable[str]) -> None:
    """Refuses a setting added with + at the top of a config where there is none of that name, which nothing would read.

    Args:
        verb: whose config it is.
        overrides: as typed.

    Raises:
        InputError: names it, and what is meant perhaps.
    """
    added = {override: found.group(1) for override in overrides if (found := re.match(r"\+{1,2}([^.=@]+)", override))}
    known = _known(verb) if added else set()
    for override, key in added.items():
        if key not in known:
            raise InputError(f"{override}: there is no setting '{key}'; {nearest(key, known)}")


def _known(verb: str) -> set[str]:
    """What may stand at the top of a verb's config; with a paper's protocol chosen, also what that or any other paper's brings."""
    known = {"hydra"} | _keys(verb)
    protocol = HydraConfig.get().runtime.choices.get(GROUP)
    return known if protocol is None else known.union(*(_keys(f"{GROUP}/{name}") for name in (protocol, *names(GROUP))))


def _keys(name: str) -> set[str]:
    """The keys of a config, the groups that it chooses from, and the same of the configs that it starts from.

    Args:
        name: as Hydra has it, such as `experiment/qiu2023`.
    """
    path = find("", name, searchpath())
    if path is None:
        return set()
    config = cast(DictConfig, OmegaConf.load(path))
    defaults = config.pop("defaults", None) or []
    groups = {str(key).split()[-1].strip("/") for one in defaults if isinstance(one, DictConfig) for key in one}
    included = [str(PurePosixPath(name).parent / one).strip("/") for one in defaults if isinstance(one, str) and one != "_self_"]
    return {str(key) for key in config}.union(groups, *map(_keys, included))


def unknown_key(error: BaseException, verb: str) -> str | None:
    """A line with the keys that there are where one was typed that there is not; None where that is not what is wrong.

    Args:
        error: of Hydra.
        verb: whose config it is.
    """
    typed = re.search(r"Could not override '([^']+)'", str(error))
    if typed is None:
        return None
    place = next((cause.parent_node for cause in causes(error) if isinstance(cause, OmegaConfBaseException)), None)
    within = str(place._get_full_key(None)) if isinstance(place, DictConfig) else ""
    wrong = typed.group(1).removeprefix(f"{within}.").split(".")[0]
    known = {str(key): place._get_node(key) for key in place} if isinstance(place, DictConfig) else dict.fromkeys(_keys(verb))
    known = {key: inner for key, inner in known.items() if not key.startswith("_")}
    if not known:
        return f"unknown key '{typed.group(1)}': {within} is a value and has no keys"
    deeper = [f"{key}.{wrong}" for key, inner in known.items() if isinstance(inner, DictConfig) and wrong in list(inner)]
    plural = f"{wrong}s" in known
    meant = f"did you mean {', '.join(deeper)}?" if deeper and not plural else nearest(wrong, known)
    return f"unknown key '{typed.group(1)}': {f'{within} has no {wrong}; {meant} (a new key takes a leading +)' if within else meant}"


def check_proposals(arguments: list[str]) -> None:
    """Refuses a sweep by Optuna without a range to propose from, in which all trials would be the same.

    Args:
        arguments: as typed.

    Raises:
        InputError: says what a range looks like.
    """
    settings = _optunas(arguments)
    keys = {one.partition("=")[0].lstrip("+") for one in settings}
    own = any(key == "experiment" or (key.startswith("hydra.sweeper.") and not key.startswith("hydra.sweeper.n_")) for key in keys)
    if own or not settings:
        return
    with suppress(HydraException):
        if not any(one.is_sweep_override() for one in OverridesParser.create().parse_overrides(settings)):
            such = "'model.hidden=range(2,12)', 'optimizer.lr=interval(1e-3,1e-1)' or init=random,aco"
            raise InputError(f"hydra/sweeper=optuna: no setting is given as a range to propose values from, such as {such}")


def check_choices(verb: str, arguments: list[str]) -> None:
    """Refuses a sweep by Optuna that may propose settings that do not go together, before its first trial, as Hydra's own sweeper does.

    Of every setting with a range one value is taken, of every config group each in turn.

    Args:
        verb: whose settings they are.
        arguments: as typed.

    Raises:
        HydraException: of the first that do not.
    """
    settings = _optunas(arguments)
    if not settings:
        return
    parsed = OverridesParser.create().parse_overrides(settings)
    own = [one for one in parsed if not one.key_or_group.startswith("hydra") or one.key_or_group == "hydra.searchpath"]
    values = [_values(one) for one in own]
    with hydra.initialize_config_dir(str(config_folder()), version_base=None):
        for place, one in enumerate(own):
            for value in values[place] if one.is_choice_sweep() and names(one.key_or_group) else ():
                hydra.compose(verb, [*(first for first, *_ in values[:place]), value, *(first for first, *_ in values[place + 1 :])])


def _optunas(arguments: list[str]) -> list[str]:
    """The settings of a sweep by Optuna, as typed; none where there is no such sweep."""
    settings = [one for one in arguments if "=" in one and not one.startswith("-")]
    return settings if "hydra/sweeper=optuna" in settings and {"-m", "--multirun"} & {*arguments} else []


def _values(override: Override) -> list[str]:
    """A setting as a job gets it, once for each value that a sweep may give it; of an interval, for its start."""
    if not override.is_sweep_override():
        return [str(override.input_line)]
    value = override.value()
    each = [value.start] if isinstance(value, IntervalSweep) else override.sweep_string_iterator()
    return [f"{override.get_key_element()}={one}" for one in each]


def several(error: BaseException) -> str | None:
    """A line for values with commas between them, which are a sweep or else a list; None where that is not what is wrong."""
    found = re.search(r"Ambiguous value for argument '([^=]+)=(.*)'", str(error))
    if found is None:
        return None
    key, values = found.groups()
    return f"{key}={values}: one list is {shlex.quote(f'{key}=[{values}]')}; a job for each is -m {shlex.quote(f'{key}={values}')}"


def instead(error: BaseException) -> str | None:
    """A line or two with what was probably meant by a setting that cannot be parsed; None where nothing better is known than what Hydra says."""
    if not isinstance(error, OverrideParseException):
        return None
    if "=" not in error.override:
        files = [one for one in sys.argv[1:] if one.lower().endswith(SUFFIXES) and "=" not in one]
        meant = f"; files go into {shlex.quote(listed('data.files', files))}" if error.override in files else " (--cfg job prints all keys)"
        return f"'{error.override}' is no setting; settings are key=value{meant}"
    if _half_typed(error.override.partition("=")[2]):
        return f"{error.override}: a bracket is open, or one too many closed"
    quoted = _quoted(error.override)
    if quoted is None:
        return None
    return f"{error.override}: names with special characters need quotes of their own inside those of the shell:\n{shlex.quote(quoted)}"


def _quoted(override: str) -> str | None:
    """The same setting with quotes around what needs them; None where that does not help either."""
    key, _, value = override.partition("=")
    several = value.startswith("[") and value.endswith("]")
    quoted = listed(key, value[1:-1].split(",")) if several else f"{key}={in_quotes(value)}"
    try:
        OverridesParser.create().parse_override(quoted)
    except HydraException:
        return None
    return quoted if quoted != override else None


def _half_typed(value: str) -> bool:
    """Whether a bracket was opened and the rest is still to come."""
    return value.startswith(("[", "{")) and value.count(value[0]) != value.count("]" if value[0] == "[" else "}")
