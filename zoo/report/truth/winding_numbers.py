"""What the picture of a winding shows of it, layer by layer, in the units of a data sheet."""

from __future__ import annotations

import math

import numpy as np
import torch

from zoo.physics.winding import Winding, shupe_weight
from zoo.units import convert

WEIGHT = "(°/h)/(K/min)"
ROUNDED = 1e-9
"""Less of the fibre is only how its length was rounded."""


def layer_weights(winding: Winding) -> np.ndarray:
    """(layers, 2) share of each layer's temperature rate in Shupe's error, by supply [(°/h)/(K/min)]."""
    weights = _per_minute(winding.weights())
    return torch.stack([torch.where(winding.supply == one, weights, 0.0).sum(1) for one in (0, 1)], 1).numpy()


def summed_weight(winding: Winding) -> np.ndarray:
    """(layers,) C_w added up from the innermost layer to each, so that the last one is C_w [(°/h)/(K/min)]."""
    return np.cumsum(layer_weights(winding).sum(1) * _place(winding.coil.layers).numpy())


def radial_weight(winding: Winding) -> float:
    """C_w: error where the rates of the outer and the inner face differ by 1 K/min [(°/h)/(K/min)]."""
    return convert(shupe_weight(winding), "rad_per_s", "dph")


def axial_weight(winding: Winding) -> float:
    """The same for the rates of the upper and the lower face [(°/h)/(K/min)]."""
    return float((_per_minute(winding.weights()).sum(0) * _place(winding.coil.turns)).sum())


def excess_turns(winding: Winding) -> np.ndarray:
    """(layers, 2) fibre that each layer has too much, by supply, in turns; NaN where a supply has none in it."""
    coil = winding.coil
    share = winding.length / (2 * math.pi * coil.radii.unsqueeze(1)) - 1
    each = [torch.where(winding.supply == one, share, torch.nan).nanmean(1) * coil.turns for one in (0, 1)]
    return torch.stack(each, 1).numpy()


def trimmed(winding: Winding) -> tuple[float, str]:
    """How much fibre was cut off [m], and whose end of it; exactly 0 for none."""
    whole = float(winding.length.sum())
    cut, end = max((float(winding.first), "A"), (whole - float(winding.last), "B"))
    return (cut, end) if cut > ROUNDED * whole else (0.0, end)


def _per_minute(weights: torch.Tensor) -> torch.Tensor:
    """Weights in [rad/s per K/s] -> [°/h per K/min]."""
    return convert(weights, "rad_per_s", "dph") / convert(1.0, "min", "s")


def _place(count: int) -> torch.Tensor:
    """(count,) middles of equal parts of −½ … ½."""
    return (torch.arange(count, dtype=torch.float64) + 0.5) / count - 0.5
