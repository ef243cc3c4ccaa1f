"""The same as `fogzoo export`."""

import sys

from zoo.cli import run

sys.exit(run("export", sys.argv[1:]))
