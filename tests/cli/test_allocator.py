"""Large blocks that were freed are used again instead of being asked for anew, unless the user said otherwise."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

PAGES = """
import resource, sys
from zoo.cli.allocator import keep_freed_memory
if sys.argv[1] == "kept": keep_freed_memory()
import numpy as np
once = [np.ones(size << 17) for size in (3, 6, 9)]  # of several megabytes each
del once
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(40):
    several = [np.ones(size << 17) for size in (3, 6, 9)]
    del several
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""


def faults(way: str, **environment: str) -> int:
    """Pages that the system had to give."""
    told = {key: value for key, value in os.environ.items() if not key.startswith(("MALLOC_", "GLIBC_TUNABLES"))}
    run = subprocess.run([sys.executable, "-c", PAGES, way], env={**told, **environment}, capture_output=True, text=True, check=True)
    return int(run.stdout)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="another allocator")
def test_freed_memory_is_used_again_unless_the_user_told_the_allocator() -> None:
    trims = {"MALLOC_TRIM_THRESHOLD_": "131072"}
    assert faults("kept") < 5_000
    assert faults("as it is", **trims) > 30_000
    assert faults("kept", **trims) > 30_000, "what the user says counts"
