"""Whether the exported files say what the trained model says, measured on the files themselves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from zoo.errors import WorkError
from zoo.export.files import PROGRAM, SCRIPT, STEP
from zoo.export.program import load_program
from zoo.export.torchscript import load_torchscript
from zoo.models.base import Model
from zoo.models.ranges import Ranges, Watched, outside

AGREEMENT = 1e-9
"""Largest difference that is let pass, over the largest prediction: far more than rounding, far less than single precision would leave."""
STEPPED = 1000
"""Rows of each run that are taken one by one."""


@dataclass(frozen=True, eq=False)
class Files:
    """Exported files as they are loaded; that takes seconds each.

    Attributes:
        script: ``model.ts``.
        whole: ``model.pt2``; None where there is none.
        step: ``step.pt2``, likewise.
        fresh: (S,) the state before its first row, likewise.
    """

    script: Any
    whole: Callable[..., Tensor] | None = None
    step: Callable[..., tuple[Tensor, Tensor]] | None = None
    fresh: Tensor | None = None

    @classmethod
    def of(cls, files: Mapping[str, bytes]) -> Files:
        """From their contents, by name."""
        script = load_torchscript(files[SCRIPT])
        if PROGRAM not in files:
            return cls(script)
        whole, step = load_program(files[PROGRAM]), load_program(files[STEP])
        return cls(script, whole.module(), step.module(), torch.full(step.example_inputs[0][1].shape, torch.nan, dtype=torch.float64))


def differences(model: Model, asked: Model, files: Files, tables: Mapping[str, Tensor], refused: Ranges) -> dict[str, float]:
    """Largest differences between files and model over some runs, and between sample by sample and whole runs.

    Args:
        model: trained.
        asked: the same, as it was exported: without the raw columns that decide nothing.
        files: the exported ones.
        tables: (T, C) raw columns of the model by run.
        refused: ranges outside of which the files refuse to predict.

    Returns:
        Largest |Δ| [output's unit] by what was compared.

    Raises:
        WorkError: one of them is too large.
    """
    found: dict[str, float] = {}
    watched = Watched(asked)
    with torch.no_grad():
        for run, x in tables.items():
            truth = model(x)
            own = x[:, [model.inputs.index(name) for name in asked.inputs]]
            refusing = outside(watched(own), watched.names, refused).any(1)
            scale = float(truth.abs().max())
            for what, (given, wanted) in _pairs(files, own, truth).items():
                if given.shape != wanted.shape:
                    raise WorkError(
                        f"{what}: shapes {tuple(given.shape)} and {tuple(wanted.shape)}; one row of features (F,) must give one number ()"
                    )
                silent = refusing[: len(given)]
                if refused and not torch.equal(given.isnan(), silent):
                    raise WorkError(f"{run}: {what} differ in which rows lie outside of the trained range; nothing was written")
                if bool(silent.all()):
                    continue
                apart = float((given - wanted)[~silent].abs().amax())
                if not apart <= AGREEMENT * scale:
                    raise WorkError(f"{run}: {what} differ by {apart:.3g} where predictions reach {scale:.3g}; nothing was written")
                found[what] = max(found.get(what, 0.0), apart)
    return found


def _pairs(files: Files, x: Tensor, truth: Tensor) -> dict[str, tuple[Tensor, Tensor]]:
    """What has to be equal, by name."""
    script, first = files.script, x[:STEPPED]
    script.reset()
    forward = script(x)
    pairs = {
        "model.ts forward and the model": (forward, truth),
        "model.ts step and forward": (torch.stack([script.step(row) for row in first]), forward[:STEPPED]),
    }
    if files.whole is not None and files.step is not None and files.fresh is not None:
        pairs["model.pt2 and the model"] = files.whole(x), truth
        pairs["step.pt2 and the model"] = _handed_on(files.step, first, files.fresh), truth[:STEPPED]
    return pairs


def _handed_on(step: Callable[..., tuple[Tensor, Tensor]], x: Tensor, state: Tensor) -> Tensor:
    """(T,) predictions of single steps, each with the state that the one before it gave."""
    predicted = []
    for row in x:
        one, state = step(row, state)
        predicted.append(one)
    return torch.stack(predicted)
