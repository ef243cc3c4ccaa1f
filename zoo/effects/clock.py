"""How long a gyro was how hot in the runs before one: what ages or dries does not start anew with every file."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import Any, Self

import torch
from torch import Tensor, nn

from zoo.effects.base import Effect, Parameter

COLDEST_C, STEP_C, BINS = -60.0, 2.0, 81
"""Temperatures at which time is counted, −60…100 °C."""
GOES_ON = Parameter("goes_on", 0.0, "1", 0.0, 1.0, "index", "an option", "1: goes on from run to run, 0: every run starts anew", usual=True)


class Clock(nn.Module):
    """Time spent at each temperature before a run [s]; none before it is told, see `Effect.after`."""

    dwell: Tensor

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("dwell", torch.zeros(1, BINS, dtype=torch.float64))

    @property
    def celsius(self) -> Tensor:
        """(B,) the temperatures."""
        return COLDEST_C + STEP_C * torch.arange(BINS, dtype=self.dwell.dtype, device=self.dwell.device)

    def forward(self, run: Tensor) -> Tensor:
        """Time at each temperature before runs of these numbers (...,) -> (..., B) [s]; a run that was not fitted comes after all that were."""
        last = len(self.dwell) - 1
        return self.dwell.to(run.device)[torch.where(run < 0, last, run - 1).clamp(0, last).long()]

    def _load_from_state_dict(self, state_dict: dict[str, Any], prefix: str, *rest: Any) -> None:
        """Take as many runs as were saved."""
        if prefix + "dwell" in state_dict:
            self.dwell = self.dwell.new_zeros(state_dict[prefix + "dwell"].shape)
        super()._load_from_state_dict(state_dict, prefix, *rest)


class Continuing(Effect):
    """Abstract: an effect that may go on from run to run; `GOES_ON` is among its shapes."""

    clock: Clock

    def __init__(self) -> None:
        super().__init__()
        self.clock = Clock()

    def after(self, dwell: Tensor) -> Self:
        """A copy whose clock knows what went on before each run, see `Effect.after`; itself where that is known to it."""
        if torch.equal(self.clock.dwell, dwell.to(self.clock.dwell)):
            return self
        told = copy.deepcopy(self)
        told.clock.dwell = dwell.to(self.clock.dwell)
        return told


def dwell_before(runs: Iterable[tuple[Tensor, Tensor]]) -> Tensor:
    """(R+1, B) time at each temperature before each of R runs, and after all of them [s].

    Files do not tell when they were recorded: runs are taken in the order they are given in, one after the other without a pause. Time between two
    temperatures is shared by them as a straight line does.

    Args:
        runs: time (T,) [s] and temperature (T,) [°C] of each.
    """
    found = [torch.zeros(BINS, dtype=torch.float64)]
    for time, celsius in runs:
        place = ((celsius[1:] + celsius[:-1]) / 2 - COLDEST_C).div(STEP_C).clamp(0, BINS - 1).double()
        below = place.floor().clamp_max(BINS - 2)
        step_s, share = torch.diff(time).double(), place - below
        low = torch.bincount(below.long(), step_s * (1 - share), BINS)
        found.append(found[-1] + (low + torch.bincount(below.long() + 1, step_s * share, BINS)).cpu())
    return torch.stack(found)


def anew_or_on(runs: int) -> Tensor:
    """(G,) values of `GOES_ON` that a search should try: with one run there is nothing before."""
    return torch.arange(2.0 if runs > 1 else 1.0, dtype=torch.float64)
