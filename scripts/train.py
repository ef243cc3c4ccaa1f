"""The same as `fogzoo train`."""

import sys

from zoo.cli import run

sys.exit(run("train", sys.argv[1:]))
