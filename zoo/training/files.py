"""What the files of a training are called."""

from __future__ import annotations

import struct
from pickle import UnpicklingError

CHECKPOINT, MEMBERS, PICTURE = "last.ckpt", "members.pt", "prediction.png"

UNREADABLE = (OSError, RuntimeError, LookupError, EOFError, TypeError, ValueError, AttributeError, UnpicklingError, struct.error)
"""What reading one of them raises where it is damaged, or holds something else."""
