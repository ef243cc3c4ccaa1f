"""The same as `fogzoo simulate`."""

import sys

from zoo.cli.application import run

sys.exit(run("simulate", sys.argv[1:]))
