"""The same as `fogzoo reproduce`."""

import sys

from zoo.cli import run

sys.exit(run("reproduce", sys.argv[1:]))
