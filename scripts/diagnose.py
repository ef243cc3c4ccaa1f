"""The same as `fogzoo diagnose`."""

import sys

from zoo.cli import run

sys.exit(run("diagnose", sys.argv[1:]))
