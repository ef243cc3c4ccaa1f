"""The same as `fogzoo compensate`."""

import sys

from zoo.cli import run

sys.exit(run("compensate", sys.argv[1:]))
