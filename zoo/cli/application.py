"""Turns a verb into a Hydra application with the contract's exit codes: 0 done, 1 the work failed, 2 the input is wrong."""

from __future__ import annotations

import importlib
import io
import os
import re
import shlex
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, redirect_stderr, redirect_stdout, suppress
from pathlib import Path

import hydra
from hydra.errors import (
    ConfigCompositionException,
    HydraException,
    MissingConfigException,
    OverrideParseException,
    SearchPathException,
)
from omegaconf import DictConfig, open_dict
from omegaconf.errors import OmegaConfBaseException
from yaml import YAMLError  # type: ignore[import-untyped]

from zoo.catalog import config_folder, names
from zoo.cli import COMPLETION
from zoo.cli.closed_pipe import nobody_reads, print_to_nobody, unread_logs
from zoo.cli.folders import hollow_removed
from zoo.cli.interrupts import tell_interrupted
from zoo.cli.jobs import Job
from zoo.cli.papers import GROUP, PAPER, paper_settings
from zoo.cli.plugins import missing_plugin, prefer_own_settings
from zoo.cli.saved_models import folder_settings
from zoo.cli.sweeps import sweep_told
from zoo.cli.wrong_settings import (
    absent_folder,
    check_choices,
    check_flags,
    check_known,
    check_lists,
    check_proposals,
    check_searchpath,
    instead,
    no_choice,
    several,
    unknown_key,
)
from zoo.errors import InputError, WorkError, causes, nearest
from zoo.given import check_seed

WRONG_SETTINGS = (
    ConfigCompositionException,
    OverrideParseException,
    MissingConfigException,
    SearchPathException,
    OmegaConfBaseException,
    YAMLError,
)
OF_A_MODEL = ("diagnose", "refine")
"""Verbs to which `model=` gives a trained model's folder."""
VERBS = ("simulate", "train", "compare", "diagnose", "refine", "compensate", "export", "reproduce")


def run(verb: str, arguments: list[str]) -> int:
    """Run one verb as a Hydra application.

    Args:
        verb: one of `VERBS`.
        arguments: Hydra flags and overrides.

    Returns:
        The exit code.
    """
    traced = os.environ.get("HYDRA_FULL_ERROR") == "1"
    arguments, completing = _in_hydras_words(verb, arguments), not COMPLETION.isdisjoint(arguments)
    sys.argv = [*(sys.argv[:1] if completing else [f"fogzoo {verb}"]), *arguments]  # completion is of a program, not of a verb
    asked = completing and any(one.startswith("query=") for one in arguments)
    codes: list[int] = []
    with warnings.catch_warnings(), _unwrapped(), unread_logs(), _half_typed(verb) if asked else nullcontext():
        try:
            with hollow_removed(), sweep_told(codes), suppress(SystemExit):  # Hydra's own end after --help
                check_flags(arguments, verb)
                check_proposals(arguments)
                check_choices(verb, arguments)
                prefer_own_settings()
                warnings.filterwarnings("ignore", r"provider=.* is not available", UserWarning)  # `check_searchpath` refuses it
                hydra.main(version_base="1.3", config_path=str(config_folder()), config_name=verb)(_task(verb, codes, traced))()
            sys.stdout.flush()
        except KeyboardInterrupt:
            return tell_interrupted()
        except Exception as error:
            codes.append(_tell(error, verb, traced))
    return max(codes, default=0)


def _in_hydras_words(verb: str, arguments: list[str]) -> list[str]:
    return folder_settings(arguments) if verb in OF_A_MODEL else paper_settings(arguments) if verb == "reproduce" else arguments


@contextmanager
def _half_typed(verb: str) -> Iterator[None]:
    """Lets Hydra complete a shell's line as if its settings were typed without quotes and in its own words; what it cannot read yet is no error."""
    line, offered = os.environ.get("COMP_LINE", ""), io.StringIO()
    before, last = re.fullmatch(r"(.*\s)?(\S*)", line, re.DOTALL).groups(default="")  # type: ignore[union-attr]
    *words, begun = _in_hydras_words(verb, [*_without_quotes(before), last])
    os.environ["COMP_LINE"] = " ".join([*words, begun])
    try:
        with redirect_stdout(offered), redirect_stderr(io.StringIO()):
            yield
    finally:
        os.environ["COMP_LINE"] = line
    hydras, own = (one[: one.find("=") + 1] for one in (begun, last))
    print(offered.getvalue().replace(hydras, own), end="")


def _without_quotes(text: str) -> list[str]:
    """Words as a shell hands them over; Hydra would take one with blanks in it for several, so it is left out."""
    try:
        words = shlex.split(text)
    except ValueError:  # a quote is still open
        words = text.split()
    return [one for one in words if not re.search(r"\s", one)]


@contextmanager
def _unwrapped() -> Iterator[None]:
    """Lets exceptions out of Hydra as they are, instead of its own trace and exit code."""
    before = os.environ.get("HYDRA_FULL_ERROR")
    os.environ["HYDRA_FULL_ERROR"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["HYDRA_FULL_ERROR"]
        else:
            os.environ["HYDRA_FULL_ERROR"] = before


def _tell(error: BaseException, verb: str, traced: bool) -> int:
    if nobody_reads(error):
        return print_to_nobody()
    if traced:
        traceback.print_exception(error)
    code, message = explain(error, verb)
    print(message, file=sys.stderr)
    return code


def _task(verb: str, codes: list[int], traced: bool) -> Callable[[DictConfig], float | None]:
    """The function that Hydra runs: one job. A failing job is told and remembered, so that the other jobs of a sweep still run."""

    def task(config: DictConfig) -> float | None:
        with open_dict(config):
            config.setdefault("effects", {})  # effects=[] leaves nothing that a model could refer to
        job = Job(verb, config)
        with job.output():
            try:
                check_searchpath()
                check_lists(job.overrides)
                check_known(verb, job.overrides)
                check_seed("seed", config.seed)
                with job.alone():
                    out = job.begin()
                    if job.result is None:
                        job.end(importlib.import_module(f"zoo.cli.{verb}").run(config, out))
                print(job.result, flush=True)
            except (Exception, SystemExit) as error:
                codes.append(_tell(error, verb, traced))
                job.fail(error, *((codes[-1], "") if nobody_reads(error) else explain(error, verb)))
        return job.value

    task.__name__ = verb
    return task


def explain(error: BaseException, verb: str) -> tuple[int, str]:
    """The exit code and the one or two lines for an exception that a verb came to; never a traceback."""
    for cause in causes(error):
        if isinstance(cause, InputError):
            return 2, f"error: {cause}"
        if isinstance(cause, WorkError):
            return 1, f"failed: {cause}"
    if absent := missing_plugin(error) or _unknown_choice(error, verb) or no_choice(error):
        return 2, f"error: {absent}"
    if isinstance(error, OSError) and error.filename:
        return 2, f"error: {error.filename}: {error.strerror}; if results were to go there, choose another folder with hydra.run.dir=…"
    if isinstance(error, WRONG_SETTINGS):
        return 2, f"error: {_first_lines(error, verb)}"
    known = "" if isinstance(error, HydraException) else f"{type(error).__name__}: "
    return 1, f"failed: {known}{_first_lines(error, verb)} (HYDRA_FULL_ERROR=1 shows where)"


def _unknown_choice(error: BaseException, verb: str) -> str | None:
    unknown = re.search(r"Could not (?:find|load) '([^']+)/([^'/]+)'", str(error))
    if unknown is None or not isinstance(error, MissingConfigException):
        return None
    group, name = unknown.groups()
    if told := absent_folder(_searched(error)):
        return told
    typed = PAPER if (verb, group) == ("reproduce", GROUP) else group.removesuffix("s")
    possible = [*names(group, _searched(error)), *(["basic"] if group in {"hydra/launcher", "hydra/sweeper"} else [])]  # Hydra's own, without a file
    return f"unknown {typed} '{name}': {nearest(name, possible)}"


def _searched(error: MissingConfigException) -> list[Path]:
    """The folders that Hydra looked in, the user's own included, which only its message tells: there is no configuration yet to ask."""
    return [Path(folder) for folder in re.findall(r"path=file://(.+)$", str(error), re.MULTILINE)]


def _first_lines(error: BaseException, verb: str) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    needed = re.search(r"Missing mandatory value: .*?full_key: (\S+)", str(error), re.DOTALL)
    if needed:
        return f"{needed.group(1)} is not set and has no default: give {needed.group(1)}=…"
    better = unknown_key(error, verb) or several(error) or instead(error)
    return better or " ".join(lines if isinstance(error, YAMLError) else lines[:2]) or type(error).__name__
