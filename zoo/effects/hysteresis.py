"""Rate-independent memory: friction and plasticity of coil, spool and potting."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter
from zoo.physics.recurrence import clamped

WIDTHS = (0.5, 1.0, 2.0)


class Hysteresis(Effect):
    """Preisach hysteresis with relays spread over widths and over temperature.

    A relay that switches up at c + r and down at c − r is up exactly where the play operator w_r of the temperature exceeds c. Summed over relays
    with density sech²((c − c0)/s) in c this is tanh((w_r − c0)/s): a play seen through a saturating curve (generalised Prandtl–Ishlinskii;
    Al Janaideh, Rakheja & Su 2009). Widths are spread over r/2, r, 2r, for contacts do not slip all at once.
    Before the first sample every relay is where the starting temperature alone puts it.
    """

    name = "hysteresis"
    runs_together = True
    shape = (
        Parameter("width", 6.0, "K", 0.5, 20.0, "log", source="prior: radii 2–20 K", meaning="r, half-width of the loop in temperature", grid=5),
        Parameter("centre", 20.0, "°C", -40.0, 80.0, source="middle of the operating range", meaning="temperature where the loop is widest", grid=4),
        Parameter(
            "spread", 40.0, "K", 8.0, 200.0, "log", source="from one contact to a plain play", meaning="temperature range in which it acts", grid=3
        ),
    )
    amplitudes = (
        Parameter(
            "amplitude",
            0.0,
            "unit",
            -10.0,
            10.0,
            source="prior: loops five times as narrow, 0.002–0.02 medium",
            meaning="half of what lies between all relays down and all up",
        ),
    )
    formula = "A·mean_r tanh((play_r(T) − c0)/s)"
    source = "Preisach; Al Janaideh et al. 2009, Smart Mater. Struct. 18:045001"
    signature = "the bias in holds depends on whether they were reached from below or above, however slowly"
    confused_with = ("viscoelastic",)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """The normalised operator in −1…1, see `Effect.columns`."""
        width, centre, spread = shape[..., 0:1], shape[..., 1:2], shape[..., 2:3]
        plays = [torch.tanh((play(history.temperature, factor * width) - centre) / spread) for factor in WIDTHS]
        return (sum(plays[1:], plays[0]) / len(WIDTHS)).unsqueeze(-1)


def play(temperature: Tensor, width: Tensor) -> Tensor:
    """Play operator (backlash) of half-width r, w[k] = min(max(w[k−1], T − r), T + r), starting at the first temperature.

    Args:
        temperature: (..., T) [°C].
        width: (..., 1) r [K].

    Returns:
        (..., T) [°C].
    """
    if width.dim() == 2 and (temperature.dim() == 1 or temperature.shape[-2] == 1):  # in a grid of shapes, many have one width
        few, which = torch.unique(width, return_inverse=True)
        return _play(temperature, few.unsqueeze(-1)).index_select(-2, which.squeeze(-1))
    return _play(temperature, width)


def _play(temperature: Tensor, width: Tensor) -> Tensor:
    start = temperature[..., 0] + torch.zeros_like(width[..., 0])
    return clamped(temperature - width, temperature + width, start)
