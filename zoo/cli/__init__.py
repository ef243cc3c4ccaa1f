"""The command line: one file a verb, each a thin Hydra application."""

from __future__ import annotations

import os
import sys

USAGE = """fogzoo: the thermal drift of fibre-optic gyroscopes

  fogzoo simulate    chamber runs of a simulated gyro, with the truth beside them
  fogzoo diagnose    how far the model is from measurements, where it fails, which effect is missing
  fogzoo refine      add effects (add=NAME | add=auto), refit, watch the error fall
  fogzoo train       fit a model of the zoo (-m sweeps models and seeds)
  fogzoo compare     trained models side by side, by run and stage
  fogzoo compensate  subtract a model from recordings of any length   (not yet)
  fogzoo export      a model as one file for firmware                 (not yet)
  fogzoo reproduce   the tables and figures of a paper                (not yet)

fogzoo VERB --help lists the settings; fogzoo VERB key=value sets them. Start: fogzoo diagnose 'data.files=[run_*.csv]'"""


def main() -> None:
    """Entry point of the console command `fogzoo`."""
    from zoo.cli.application import VERBS, run
    from zoo.errors import nearest

    arguments = sys.argv[1:]
    if not arguments or arguments[0] in {"-h", "--help", "help"}:
        sys.exit(_usage(0 if arguments else 2))
    verb = arguments[0]
    if verb not in VERBS:
        print(f"error: unknown verb '{verb}': {nearest(verb, VERBS)}", file=sys.stderr)
        sys.exit(2)
    sys.exit(run(verb, arguments[1:]))


def _usage(code: int) -> int:
    try:
        print(USAGE, flush=True)
    except BrokenPipeError:  # a pager that was closed early
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return code
