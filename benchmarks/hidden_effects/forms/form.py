"""What a hidden effect is: a signal of one run's truth, and those of its numbers that the catalogue has as well."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from hidden_effects.body import Array, Body


@dataclass(frozen=True, eq=False)
class Form:
    """A hidden effect before it is scaled.

    Attributes:
        variant: which form of the effect it is.
        signal: (T,) of one run, of any size.
        amplitudes: the catalogue's amplitudes of the unscaled signal, where the forms share them.
        shapes: the catalogue's shapes, where the forms share them, in their units.
    """

    variant: str
    signal: Callable[[Body], Array]
    amplitudes: Mapping[str, float] = field(default_factory=dict)
    shapes: Mapping[str, float] = field(default_factory=dict)


Draw = Callable[[np.random.Generator], Form]
Forms = dict[str, tuple[Draw, ...]]


def decade(chance: np.random.Generator, low: float, high: float) -> float:
    """One number, spread evenly in its logarithm."""
    return float(np.exp(chance.uniform(np.log(low), np.log(high))))
