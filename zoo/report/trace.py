"""One run as the report draws it: block means of what was measured and of what the model says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from zoo.units import convert, own_time

HELD_OUT = "(held out)"
"""How the name ends of pieces of a run that is fitted otherwise, see `Run.split`."""


@dataclass(frozen=True, eq=False)
class Trace:
    """Block means of one run.

    Attributes:
        run: name of the run.
        role: ``"fit"`` or ``"check"``.
        time_s: (N,) block centres [s].
        temperature_c: (N,) main thermometer [°C].
        rate_k_per_min: (N,) its derivative [K/min].
        error: (N,) output − reference [output's unit].
        model: (N,) the error that the model as it stands predicts [output's unit].
        refined: (N,) the same with the missing effects added; None where nothing was added.
        stage: ``hold``, ``heating``, ``cooling`` or ``edge`` for each of the N blocks.
        start_s: time of the run's first sample [s].
    """

    run: str
    role: str
    time_s: np.ndarray
    temperature_c: np.ndarray
    rate_k_per_min: np.ndarray
    error: np.ndarray
    model: np.ndarray
    refined: np.ndarray | None
    stage: list[str]
    start_s: float = 0.0

    @property
    def hours(self) -> np.ndarray:
        """(N,) block centres [h], as the run's reader counts."""
        hours: np.ndarray = convert(own_time(np.asarray(self.time_s, dtype=float), self.start_s), "s", "h")
        return hours

    @property
    def held_out(self) -> bool:
        """Whether these are pieces of a run that is fitted otherwise."""
        return self.run.endswith(HELD_OUT)

    @property
    def residual(self) -> np.ndarray:
        """(N,) what the model as it stands leaves [output's unit]."""
        return self.error - self.model

    @property
    def residual_after(self) -> np.ndarray | None:
        """(N,) what the model with the missing effects leaves [output's unit]."""
        return None if self.refined is None else self.error - self.refined


def rms(values: np.ndarray | None) -> float | None:
    """Root mean square of the finite values; None where there are none."""
    if values is None:
        return None
    finite = np.asarray(values, dtype=float)
    finite = finite[np.isfinite(finite)]
    return float(np.sqrt(np.mean(finite**2))) if finite.size else None


def worst_first(traces: list[Trace]) -> list[Trace]:
    """The runs by the RMS of their residual, largest first."""
    return sorted(traces, key=lambda trace: -(rms(trace.residual) or 0.0))
