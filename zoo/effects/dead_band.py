"""A closed loop that does not feel small rates."""

from __future__ import annotations

from torch import Tensor

from zoo.effects.base import REFERENCE_C, Effect, History, Parameter

STEEPEST = 80.0
"""Logarithm at which |z|^p ends, far from where numbers do: what is left there is 1e-30 of A."""


class DeadBand(Effect):
    """Error −A·p·z/(p − 1 + |z|^p), z = Ω/d + c + s·θ with Ω the true input and θ = T − 20 °C: the output lags behind a small rate by up to A.

    Cross-talk from the feedback to the detector holds the loop at zero until the rate overcomes it. A dead zone in the strict sense, no output below
    d, is −Ω up to there, the limit of a large p; two oscillators that lock leave √(Ω² − d²) − Ω, whose tail −d²/2Ω is that of p = 2; vibration and
    noise smooth the edges. Random steps of the phase remove it.

    The loop does not tell the input from the gyro's own bias, and is held where their sum is small: c and s are that bias, in widths.
    """

    name = "dead_band"
    runs_together = True
    place = "housing"
    needs_varied_reference = True
    shape = (
        Parameter("width", 0.1, "unit", 1e-8, 1e7, "log", source="prior: 0.01–0.1 °/h; wide for any unit", meaning="d, where it is largest", grid=58),
        Parameter("edge", 4.0, "1", 2.0, 1000.0, "log", source="engineering prior: locking 2, dead zone ∞", meaning="p, how steeply it ends", grid=6),
        Parameter("centre", 0.0, "1", -30.0, 30.0, source="bias over width, prior", meaning="c, the bias at 20 °C, in widths", grid=1, within=3.0),
        Parameter("drift", 0.0, "1/K", -1.0, 1.0, source="its slope over width, prior", meaning="s, of the bias, in widths", grid=1, within=0.03),
    )
    amplitudes = (Parameter("depth", 0.0, "unit", -100.0, 100.0, source="prior: 0.01–0.1 °/h", meaning="A"),)
    formula = "−A·p·z/(p − 1 + |z|^p),  z = Ω/d + c + s·θ,  θ = T − 20 °C"
    source = "Lefèvre, The Fiber-Optic Gyroscope (dead zone of a closed loop); smoothed, engineering prior"
    signature = "pulls the output towards zero where input and bias are about zero, opposite for the two directions; nothing at large rates"
    confused_with = ("scale_factor", "scale_factor_nonlinearity", "misalignment")

    def driven_to(self, largest: float) -> DeadBand:
        """Widths that the input leaves, see `Effect.driven_to`: within one that it never leaves, this is a scale factor that is another one at
        another rate."""
        return self.bounded(0, self.shape[0].low, largest)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """−p·z/(p − 1 + |z|^p), at most 1, see `Effect.columns`."""
        width, edge, centre, drift = (shape[..., i : i + 1] for i in range(4))
        place = history.reference / width + centre + drift * (history.temperature - REFERENCE_C)
        steep = place.abs().minimum((STEEPEST / edge).exp()).pow(edge)
        return (-edge * place / (edge - 1.0 + steep)).unsqueeze(-1)
