"""What is known of nonlinear parameters before any run is looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from zoo.effects.base import Parameter, unit_value


@dataclass(frozen=True, eq=False)
class Prior:
    """Independent normal distributions in the coordinates in which every bound is 0…1.

    Attributes:
        center: (P,).
        weight: (P,) one over the variance; 0 where every value between the bounds is as likely.
        simplest: (P,) the value of a share by default, which means that there is nothing to share, to either side of which it may mean something
            else; not a number of what has none.
    """

    center: Tensor
    weight: Tensor
    simplest: Tensor = field(default_factory=lambda: torch.empty(0))

    @classmethod
    def of(cls, parameters: Sequence[Parameter]) -> Prior:
        """What the declarations say."""
        found = []
        for one in parameters:
            far = one.default * one.within if one.scale == "log" else one.default + one.within
            center, edge = unit_value(torch.tensor([one.default, far], dtype=torch.float64), one).tolist() if one.within else (0.5, 0.0)
            simplest = float(unit_value(torch.tensor(one.default, dtype=torch.float64), one)) if one.scale == "share" else torch.nan
            found.append((center, (edge - center) ** -2 if one.within else 0.0, simplest))
        values = torch.tensor(found, dtype=torch.float64).reshape(-1, 3)
        return cls(*values.unbind(dim=1))

    def cost(self, theta: Tensor) -> Tensor:
        """What (..., P) parameters add to χ²: (...), minus twice their log density but for a constant."""
        return ((theta - self.center.to(theta)).square() * self.weight.to(theta)).sum(dim=-1)

    def simpler(self, theta: Tensor) -> Tensor:
        """(P,) parameters with every share as it is by default."""
        if not len(self.simplest):
            return theta
        simplest = self.simplest.to(theta)
        return torch.where(simplest.isnan(), theta, simplest)

    def slope(self, theta: Tensor) -> Tensor:
        """(P,) how parameters are drawn, as the scores Jᵀr are."""
        return (self.center.to(theta) - theta) * self.weight.to(theta)
