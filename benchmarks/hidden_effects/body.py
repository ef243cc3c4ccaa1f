"""What one run of one gyro was in truth: the places where hidden effects live, as NumPy sees them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from zoo.simulator.plant import Scenario

Array = NDArray[Any]
REFERENCE_C = 20.0


@dataclass(frozen=True, eq=False)
class Body:
    """One run's truth.

    Attributes:
        time: (T,) since power-on [s], evenly spaced.
        coil: (T,) mean over the winding [°C].
        coil_rate: (T,) [K/min].
        housing: (T,) [°C].
        spool: (T,) where the main thermometer sits [°C].
        outer: (T,) outermost layer [°C].
        air: (T,) of the chamber [°C].
        reference: (T,) true rate [°/h].
        cross: (T,) true rate about the axis across the input axis [°/h].
        supply: (T,) [V].
        field: (T,) [µT].
        number: of the run, counted from 1; the check run's is 0.
    """

    time: Array
    coil: Array
    coil_rate: Array
    housing: Array
    spool: Array
    outer: Array
    air: Array
    reference: Array
    cross: Array
    supply: Array
    field: Array
    number: int

    @property
    def step_s(self) -> float:
        """From row to row [s]."""
        return float(self.time[1] - self.time[0])

    @property
    def above(self) -> Array:
        """(T,) coil's temperature over 20 °C [K]."""
        return self.coil - REFERENCE_C


def body(run: Scenario, cross: Array) -> Body:
    """The only device of a scenario."""
    heat = run.heat
    places = {
        key: np.broadcast_to(getattr(heat, key).numpy(), (1, len(run.time)))[0] for key in ("coil", "coil_rate", "housing", "spool", "outer", "air")
    }
    supply, field = (run.inputs[name][0].numpy() for name in ("supply_v", "field_ut"))
    number = run.label if isinstance(run.label, int) else 0
    reference = run.reference.expand_as(run.time).numpy()
    return Body(time=run.time.numpy(), **places, reference=reference, cross=cross, supply=supply, field=field, number=number)


def delayed(value: Array, tau_s: float, step_s: float) -> Array:
    """(T,) behind a first-order lag, soaked at the start: the drive held over each step, x += (1 − e^(−h/τ))·(u − x)."""
    decay = np.exp(-step_s / tau_s)
    late, _ = lfilter([1 - decay], [1.0, -decay], value, zi=[decay * value[0]])
    return np.asarray(late)
