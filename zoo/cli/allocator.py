"""Freed memory kept for the next tensor.

By default glibc gives large blocks back to the system as soon as they are free, and gets each page of the next one zeroed anew: at the sizes of a
diagnosis, some megabytes thousands of times, also in copies of the process, that is a tenth of its time.
"""

from __future__ import annotations

import ctypes
import os
import sys

TRIM_THRESHOLD, TOP_PAD, MMAP_THRESHOLD = -1, -2, -3
"""Numbers of `mallopt`, see its manual."""
LARGEST, KEPT, AHEAD = 32 << 20, 512 << 20, 64 << 20
"""Up to which size a block comes from memory that is kept; how much of that may lie idle; how much more than needed is asked for [bytes]."""


def keep_freed_memory() -> None:
    """Tell the allocator, where it can be told and nobody has told it otherwise by MALLOC_… in the environment."""
    told = any(name.startswith("MALLOC_") or name == "GLIBC_TUNABLES" for name in os.environ)
    mallopt = None if told or sys.platform != "linux" else getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:
        for parameter, value in ((MMAP_THRESHOLD, LARGEST), (TRIM_THRESHOLD, KEPT), (TOP_PAD, AHEAD)):
            mallopt(parameter, value)
