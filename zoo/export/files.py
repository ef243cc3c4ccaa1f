"""What the exported files are called."""

from __future__ import annotations

SCRIPT, PROGRAM, STEP, METADATA = "model.ts", "model.pt2", "step.pt2", "metadata.json"
FORMATS = {SCRIPT: "TorchScript", PROGRAM: "torch.export", STEP: "torch.export"}
