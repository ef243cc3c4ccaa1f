"""Features of any number of rows by one fixed list of tensor operations, with the state handed in and out: what `torch.export` can write down."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from zoo.export.recipe import Recipe
from zoo.units import convert


class FeatureScan(nn.Module):
    """(T, C) raw columns and the state before them -> (T, F) features and the state after them.

    The state is one vector (C + 2K,): the last row, then of the K features with memory the columns behind one lag and their rates behind two; NaN
    at first, and empty where no feature has memory. Equations as in `zoo.export.feature_stream`.
    """

    tau: Tensor

    def __init__(self, recipes: list[Recipe], inputs: list[str], longest: int) -> None:
        """Put together.

        Args:
            recipes: of the features.
            inputs: names of the raw columns.
            longest: largest T that will be asked for.
        """
        super().__init__()
        self.recipes = recipes
        self.inputs = inputs
        self.column = [one.column for one in recipes if one.lag_s > 0]
        self.register_buffer("tau", torch.tensor([one.lag_s for one in recipes if one.lag_s > 0], dtype=torch.float64))
        self.size = len(inputs) + 2 * len(self.column) if self.column else 0
        self.passes = (longest - 1).bit_length()
        self.per_minute = convert(1.0, "min", "s")

    def fresh(self) -> Tensor:
        """(C + 2K,) the state before the first row."""
        return torch.full((self.size,), torch.nan, dtype=torch.float64)

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """Compute the features, see the class."""
        if self.column:
            before, once, rate = self._start(x[0], state)
            once, rate = self._lagged(torch.cat([before.unsqueeze(0), x]), once, rate)
            state = torch.cat([x[-1], once[-1], rate[-1]])
        features, k = [x[:, 0]], 0
        for one in self.recipes:
            if one.lag_s > 0:
                features.append(self.per_minute * rate[:, k] if one.is_rate else once[:, k])
                k += 1
            else:
                features.append(x[:, one.column])
        return torch.stack(features, dim=-1)[:, 1:], state

    def _start(self, first: Tensor, state: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Row, lagged values and rates before the first row; without a past, everything has been as it is now for a second."""
        fresh = torch.isnan(state[0])
        earlier = torch.cat([first[:1] - 1.0, first[1:]])
        before, once, rate = state.split([len(self.inputs), len(self.column), len(self.column)])
        soaked = first[self.column]
        return torch.where(fresh, earlier, before), torch.where(fresh, soaked, once), torch.where(fresh, torch.zeros_like(rate), rate)

    def _lagged(self, rows: Tensor, once: Tensor, rate: Tensor) -> tuple[Tensor, Tensor]:
        """(T, K) columns behind one lag, and their rates behind two, from rows (1 + T, C) and what was before them (K,)."""
        step = (rows[1:, 0] - rows[:-1, 0]).unsqueeze(-1)
        last, now = rows[:-1, self.column], rows[1:, self.column]
        ratio = step / self.tau
        decay, lost = torch.exp(-ratio), -torch.expm1(-ratio)
        mean = lost / ratio
        lagged = self._affine(decay, (mean - decay) * last + (1 - mean) * now, once)
        slope = (now - last) / step
        behind = torch.cat([once.unsqueeze(0), lagged])[:-1] - last + slope * self.tau
        return lagged, self._affine(decay, lost * slope - decay * ratio / self.tau * behind, rate)

    def _affine(self, gain: Tensor, offset: Tensor, start: Tensor) -> Tensor:
        """`zoo.physics.recurrence.affine` along the first axis, with as many passes as the longest run needs, whatever the length of this one."""
        place = torch.arange(offset.shape[0], device=offset.device)
        for k in range(self.passes):
            source, there = (place - (1 << k)).clamp_min(0), (place >= (1 << k)).unsqueeze(-1)
            offset = offset + gain * torch.where(there, offset[source], 0.0)
            gain = gain * torch.where(there, gain[source], 1.0)
        return offset + gain * start
