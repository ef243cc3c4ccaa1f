"""The same as `fogzoo simulate`."""

import sys

from zoo.cli import run

sys.exit(run("simulate", sys.argv[1:]))
