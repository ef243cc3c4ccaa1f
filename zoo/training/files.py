"""What the files of a training are called."""

from __future__ import annotations

CHECKPOINT, MEMBERS, PICTURE = "last.ckpt", "members.pt", "prediction.png"
