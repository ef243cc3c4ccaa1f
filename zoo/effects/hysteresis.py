"""Rate-independent memory: friction and plasticity of coil, spool and potting."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import History, Parameter
from zoo.effects.earlier import ROOM_C, Continuing
from zoo.physics.recurrence import clamped

WIDTHS = (0.5, 1.0, 2.0)
"""Half-widths of the three plays, over the one that is fitted."""


class Hysteresis(Continuing):
    """Preisach hysteresis with relays spread over widths and over temperature.

    A relay that switches up at c + r and down at c − r is up exactly where the play operator w_r of the temperature exceeds c. Summed over relays
    with density sech²((c − c0)/s) in c this is tanh((w_r − c0)/s): a play seen through a saturating curve (generalised Prandtl–Ishlinskii;
    Al Janaideh, Rakheja & Su 2009). Widths are spread over r/2, r, 2r, for contacts do not slip all at once.
    The first temperature puts all relays but those within the loop, and these are where the past left them: for 1 as the way from room temperature
    does, for −1 as the one through all the runs before does (`zoo.effects.earlier`), for 0 half of them up, as after swings that faded.
    """

    name = "hysteresis"
    runs_together = True
    shape = (
        Parameter("width", 6.0, "K", 0.5, 20.0, "log", source="prior: radii 2–20 K", meaning="r, half-width of the loop in temperature", grid=5),
        Parameter("centre", 20.0, "°C", -40.0, 80.0, source="middle of the operating range", meaning="temperature where the loop is widest", grid=4),
        Parameter(
            "spread", 40.0, "K", 8.0, 200.0, "log", source="from one contact to a plain play", meaning="temperature range in which it acts", grid=3
        ),
        Parameter(
            "past", 0.0, "1", -1.0, 1.0, "share", source="0 none", meaning="share of the way to the start from room, negative: through earlier runs"
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
        past, turns = shape[..., 3:4], self.earlier.turned(history.run, width)
        plays = [torch.tanh((play(history.temperature, factor * width, past, turns) - centre) / spread) for factor in WIDTHS]
        return (sum(plays[1:], plays[0]) / len(WIDTHS)).unsqueeze(-1)


def play(temperature: Tensor, width: Tensor, past: Tensor, turns: Tensor) -> Tensor:
    """Play operator (backlash) of half-width r, w[k] = min(max(w[k−1], T − r), T + r).

    It starts at w = T + |p|·(w0 − T) with T the first temperature: at T itself for p = 0, and for 1 where a straight way from room temperature to T
    leaves it, for −1 where the way through the turns does.

    Args:
        temperature: (..., T) [°C].
        width: (..., 1) r [K].
        past: (..., 1) p in −1…1.
        turns: (..., M) temperatures at which the way before turned, first where it began [°C].

    Returns:
        (..., T) [°C].
    """
    if width.dim() == 2 and (temperature.dim() == 1 or temperature.shape[-2] == 1):  # in a grid of shapes, many have one width
        few, which = torch.unique(torch.cat([width, past], dim=-1), dim=0, return_inverse=True)
        return _play(temperature, few[:, :1], few[:, 1:], turns).index_select(-2, which)
    return _play(temperature, width, past, turns)


def _play(temperature: Tensor, width: Tensor, past: Tensor, turns: Tensor) -> Tensor:
    first, came = temperature[..., 0:1], turns[..., 0:1]
    for turn in turns.split(1, dim=-1):
        came = _led(came, turn, width)
    way = _led(torch.where(past < 0, came, first.clamp(*ROOM_C)), first, width) - first
    return clamped(temperature - width, temperature + width, (first + past * torch.where(past < 0, -way, way)).squeeze(-1))


def _led(play: Tensor, to: Tensor, width: Tensor) -> Tensor:
    """The play after the temperature has gone straight to another."""
    return torch.maximum(torch.minimum(play, to + width), to - width)
