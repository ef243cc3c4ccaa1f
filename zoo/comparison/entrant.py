"""One that predicts: a saved model, an exported file, or what was computed elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isclose
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from zoo.comparison.facts import fitted_runs, uncompensated_rms
from zoo.comparison.known_noise import KnownNoise
from zoo.measurements.recording import JITTER
from zoo.measurements.run import HELD_OUT, Run
from zoo.scoring.stages import rms
from zoo.units import convert

WHOLE = {"holdout": "0", "points.where": "None", "points.fitted": "None", "points.checked": "0"}
"""Settings of the data under which a fit saw all of its runs."""
SAME_ERROR = 0.05
"""Share by which the RMS of a run's error may differ from that of the fitted run of its name: outliers are taken out of some."""
SAME_RUN = 1e-6
"""The same, by which a run of another name may differ from a fitted one to be taken for a copy of it."""


@dataclass(frozen=True, eq=False)
class Entrant:
    """One that predicts.

    Attributes:
        name: its type, with what tells it from others of its type.
        kind: its type.
        folder: where it was found.
        facts: what is known of how it was made, such as ``seed`` and ``unit``.
        settings: of its method, flat, such as ``model.hidden``; empty where they are not known.
        predict: (N,) predicted error of a run's blocks [output's unit].
        scripted: whether it is an exported file, of whose training not everything is known.
        beyond: how far a run goes beyond what it was fitted to, see `zoo.models.reach.Reach`; nothing where that is not known.
    """

    name: str
    kind: str
    folder: Path
    facts: dict[str, Any]
    settings: Mapping[str, str]
    predict: Callable[[Run, torch.device], Tensor]
    scripted: bool = False
    beyond: Callable[[Run], dict[str, Any]] = lambda _: {}

    def unit(self, run: Run) -> str:
        """The one that it predicts in; a run's own where that is not known."""
        return str(self.facts.get("unit", run.unit))

    def fitted(self, run: Run) -> bool:
        """Whether the model was fitted to a run or to a part of it, to go by its name and, where means are as long, by the size of its error.

        An error as large to many digits is that of a fitted run, whatever it is called.
        """
        name, known, own = run.name.removesuffix(HELD_OUT), uncompensated_rms(self.facts), self.facts.get("average_s") or 0.0
        named = name in fitted_runs(self.facts)
        parts = any(self.settings.get(f"data.{key}", whole) != whole for key, whole in WHOLE.items())
        if parts or run.name.endswith(HELD_OUT) or not isclose(own, run.average_s, rel_tol=JITTER):
            return named
        here = convert(rms(run.block_mean(run.error)), run.unit, self.unit(run))
        if named:
            return name not in known or isclose(here, known[name], rel_tol=SAME_ERROR)
        return any(isclose(here, one, rel_tol=SAME_RUN) for one in known.values())

    @property
    def noise(self) -> KnownNoise | None:
        """Of the gyro, where it was refined until nothing else was left."""
        return KnownNoise.read(self.facts, self.fitted)
