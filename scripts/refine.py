"""The same as `fogzoo refine`."""

import sys

from zoo.cli import run

sys.exit(run("refine", sys.argv[1:]))
