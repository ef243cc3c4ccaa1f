"""The same as `fogzoo compare`."""

import sys

from zoo.cli import run

sys.exit(run("compare", sys.argv[1:]))
