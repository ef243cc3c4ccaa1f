"""The command line: one file a verb, each a thin Hydra application."""

from __future__ import annotations

import gc
import importlib
import os
import re
import sys

import zoo
from zoo.cli.allocator import keep_freed_memory
from zoo.cli.closed_pipe import print_to_nobody
from zoo.cli.interrupts import leaving_at_once

USAGE = """fogzoo: the thermal drift of fibre-optic gyroscopes

  fogzoo simulate    chamber runs of a simulated gyro, with the truth beside them
  fogzoo diagnose    how far the model is from measurements, where it fails, which effect is missing, what to measure next
  fogzoo refine      add effects (add=NAME | add=auto), refit, watch the error fall
  fogzoo train       fit a model of the zoo (-m sweeps models and seeds)
  fogzoo compare     trained models side by side, by run and stage
  fogzoo compensate  subtract a model from recordings of any length
  fogzoo export      a model as files that run with torch alone, sample by sample
  fogzoo reproduce   a paper's methods trained, its tables and figures beside ours

fogzoo VERB --help lists the settings; fogzoo VERB key=value sets them. Start: fogzoo diagnose 'data.files=[run_*.csv]'
eval "$(fogzoo -sc install=bash)" lets bash complete verbs and settings"""
COMPLETION = frozenset({"-sc", "--shell-completion"})
"""Hydra's flag, by which a shell asks what may come next on a half-typed line, and the user for what makes the shell ask."""


def main() -> None:
    """Entry point of the console command `fogzoo`."""
    arguments = sys.argv[1:]
    if not arguments or arguments[0] in {"-h", "--help", "help"}:
        sys.exit(_print(USAGE, 0 if arguments else 2))
    if "--version" in arguments[:2]:
        sys.exit(_print(f"fogzoo {zoo.__version__}", 0))
    if arguments[0] in COMPLETION:
        arguments = [_verb_to_complete(arguments), *arguments]
    keep_freed_memory()
    with leaving_at_once():
        importlib.import_module("zoo.cli.application")
    gc.freeze()  # modules stay; the collector, going through them again and again, took 6 % of a diagnosis
    sys.exit(run(arguments[0], arguments[1:]))


def run(verb: str, arguments: list[str]) -> int:
    """Run one verb, with torch and Hydra imported only now.

    Args:
        verb: one of those in `USAGE`.
        arguments: Hydra flags and overrides.

    Returns:
        The exit code.
    """
    with leaving_at_once():
        from zoo.cli import application
        from zoo.errors import nearest

    if verb not in application.VERBS:
        print(f"error: unknown verb '{verb}': {nearest(verb, application.VERBS)}", file=sys.stderr)
        return 2
    return application.run(verb, arguments)


def _verb_to_complete(asked: list[str]) -> str:
    """The verb on the line that the shell asks about, taken out of it, so that Hydra finds there what it knows: a program and its settings.

    Where no verb stands there yet, the process ends with those that it may become; what installs completion is the same for all.
    """
    verbs = re.findall(r"^  fogzoo (\w+)", USAGE, re.MULTILINE)
    if not any(one.startswith("query=") for one in asked):
        return str(verbs[0])
    _, begun, settings = re.fullmatch(r"\s*(\S*)\s*(\S*)(.*)", os.environ.get("COMP_LINE", ""), re.DOTALL).groups()  # type: ignore[union-attr]
    if not settings:
        sys.exit(_print("\n".join(verb for verb in verbs if verb.startswith(begun)), 0))
    if begun not in verbs:
        sys.exit(0)
    os.environ["COMP_LINE"] = f"fogzoo{settings}"
    return str(begun)


def _print(text: str, code: int) -> int:
    try:
        print(text, flush=True)
    except BrokenPipeError:  # a pager that was closed early
        print_to_nobody()
    return code
