"""A closed loop that does not feel small rates."""

from __future__ import annotations

from torch import Tensor

from zoo.effects.base import Effect, History, Parameter

STEEPEST = 80.0
"""Logarithm at which |z|^p ends, far from where numbers do: what is left there is 1e-30 of A."""


class DeadBand(Effect):
    """Error −A·p·z/(p − 1 + |z|^p), z = Ω/d with Ω the true input: the output lags behind a small rate by up to A, reached at Ω = ±d.

    Cross-talk from the feedback to the detector holds the loop at zero until the rate overcomes it. A dead zone in the strict sense, no output below
    d, is −Ω up to there, the limit of a large p; two oscillators that lock leave √(Ω² − d²) − Ω, whose tail −d²/2Ω is that of p = 2; vibration and
    noise smooth the edges. Random steps of the phase remove it.
    """

    name = "dead_band"
    runs_together = True
    place = "housing"
    needs_varied_reference = True
    shape = (
        Parameter("width", 0.1, "unit", 1e-8, 1e7, "log", source="prior: 0.01–0.1 °/h; wide for any unit", meaning="d, where it is largest", grid=58),
        Parameter("edge", 4.0, "1", 2.0, 1000.0, "log", source="engineering prior: locking 2, dead zone ∞", meaning="p, how steeply it ends", grid=6),
    )
    amplitudes = (Parameter("depth", 0.0, "unit", -100.0, 100.0, source="prior: 0.01–0.1 °/h", meaning="A"),)
    formula = "−A·p·z/(p − 1 + |z|^p),  z = Ω/d"
    source = "Lefèvre, The Fiber-Optic Gyroscope (dead zone of a closed loop); smoothed, engineering prior"
    signature = "pulls the output towards zero near zero input, opposite for the two directions; nothing at rest and at large rates"
    confused_with = ("scale_factor", "scale_factor_nonlinearity", "misalignment")

    def driven_to(self, largest: float) -> DeadBand:
        """Widths that the input leaves, see `Effect.driven_to`: within one that it never leaves, this is a scale factor that is another one at
        another rate."""
        return self.bounded(0, self.shape[0].low, largest)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """−p·z/(p − 1 + |z|^p), at most 1, see `Effect.columns`."""
        width, edge = shape[..., 0:1], shape[..., 1:2]
        place = history.reference / width
        steep = place.abs().minimum((STEEPEST / edge).exp()).pow(edge)
        return (-edge * place / (edge - 1.0 + steep)).unsqueeze(-1)
