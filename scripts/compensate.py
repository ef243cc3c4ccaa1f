"""The same as `fogzoo compensate`."""

import sys

from zoo.cli.application import run

sys.exit(run("compensate", sys.argv[1:]))
