"""The command line: one file a verb, each a thin Hydra application."""

from __future__ import annotations

import gc
import importlib
import sys

import zoo
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

fogzoo VERB --help lists the settings; fogzoo VERB key=value sets them. Start: fogzoo diagnose 'data.files=[run_*.csv]'"""


def main() -> None:
    """Entry point of the console command `fogzoo`."""
    arguments = sys.argv[1:]
    if not arguments or arguments[0] in {"-h", "--help", "help"}:
        sys.exit(_print(USAGE, 0 if arguments else 2))
    if "--version" in arguments[:2]:
        sys.exit(_print(f"fogzoo {zoo.__version__}", 0))
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


def _print(text: str, code: int) -> int:
    try:
        print(text, flush=True)
    except BrokenPipeError:  # a pager that was closed early
        print_to_nobody()
    return code
