"""One run of a simulated gyro as the page draws it: means that are as fine as the page's pixels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from zoo.report.truth.effect_stack import Parts, grouped, means
from zoo.simulator.recorded import Recorded
from zoo.units import convert

FINEST, BLOCK_S = 700, 100.0
"""At most so many means in a curve; the recorded output, which has noise, is not shown finer than this [s]."""


@dataclass(frozen=True, eq=False)
class EffectTrace:
    """One run of a simulated gyro.

    Attributes:
        hours: (N,) [h].
        change: (N,) what each effect adds [°/h], the largest first, as changes from rest.
        hours_recorded: (M,) [h].
        recorded: (M,) error as recorded, without what the effects have at rest [°/h].
        asked_c: (N,) set point [°C].
        coil_c: (N,) mean over the fibre [°C].
        thermometers_k: (N,) what each thermometer shows besides the coil's temperature [K], by its place.
    """

    hours: np.ndarray
    change: Mapping[str, np.ndarray]
    hours_recorded: np.ndarray
    recorded: np.ndarray
    asked_c: np.ndarray
    coil_c: np.ndarray
    thermometers_k: Mapping[str, np.ndarray]

    @property
    def total(self) -> np.ndarray:
        """(N,) what all effects add [°/h]."""
        return np.sum(list(self.change.values()), axis=0) if self.change else np.zeros_like(self.hours)


def trace_of(run: Recorded, parts: Parts, order: Sequence[str], places: Sequence[str]) -> EffectTrace:
    """What of a run is drawn.

    Args:
        run: one simulated run.
        parts: its effects.
        order: all effects of the gyro, the largest first.
        places: where the thermometers sit, in the order of their columns.
    """
    time = run.table["time_s"]
    hours, coil = convert(time.numpy(), "s", "h"), run.truth["temperature_coil_c"].numpy()
    shown = [column.numpy() for name, column in run.table.items() if name.startswith("temperature")]
    error = run.error.numpy() - sum(parts.constant.values())
    blocks = min(FINEST, int(float(time[-1]) / BLOCK_S) + 1)
    return EffectTrace(
        hours=means(hours, FINEST),
        change={name: means(values, FINEST) for name, values in grouped(parts.change, order).items()},
        hours_recorded=means(hours, blocks),
        recorded=means(error, blocks),
        asked_c=means(run.program.asked(time).numpy(), FINEST),
        coil_c=means(coil, FINEST),
        thermometers_k={place: means(column - coil, FINEST) for place, column in zip(places, shown, strict=True)},
    )
