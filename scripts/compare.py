"""The same as `fogzoo compare`."""

import sys

from zoo.cli.application import run

sys.exit(run("compare", sys.argv[1:]))
