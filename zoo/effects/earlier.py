"""What a gyro went through in the runs before one: what ages, dries or slips does not start anew with every file."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from typing import Any, NamedTuple, Self

import torch
from torch import Tensor, nn

from zoo.effects.base import Effect, Parameter

COLDEST_C, STEP_C, BINS = -60.0, 2.0, 81
"""Temperatures at which time is counted, −60…100 °C."""
ROOM_C = (15.0, 25.0)
"""Where a gyro is before it is put into a chamber; a run that begins there has no other past."""
GOES_ON = Parameter("goes_on", 0.0, "1", 0.0, 1.0, "index", "an option", "1: goes on from run to run, 0: every run starts anew", usual=True)


class Before(NamedTuple):
    """What went on before each of R runs, and after all of them.

    Attributes:
        dwell: (R+1, B) time at each temperature [s].
        turns: (R+1, M) the temperatures at which the way turned, as far as what has no time of its own remembers them; first the room temperature
            at which it began [°C].
    """

    dwell: Tensor
    turns: Tensor


class Earlier(nn.Module):
    """Holds that for an effect; nothing went on before it is told, see `Effect.after`."""

    dwell: Tensor
    turns: Tensor
    celsius: Tensor
    """(B,) the temperatures at which time is counted."""

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("dwell", torch.zeros(1, BINS, dtype=torch.float64))
        self.register_buffer("turns", torch.full((1, 1), 0.5 * sum(ROOM_C), dtype=torch.float64))
        self.register_buffer("celsius", COLDEST_C + STEP_C * torch.arange(BINS, dtype=torch.float64), persistent=False)

    def dwelt(self, run: Tensor) -> Tensor:
        """Time at each temperature before runs of these numbers (...,) -> (..., B) [s]; a run that was not fitted comes after all that were."""
        return _of_run(self.dwell, run)

    def turned(self, run: float | Tensor, like: Tensor) -> Tensor:
        """The turns before a run (M,) [°C], or before several that come together (R, 1, M), see there; where another tensor is."""
        turns = _of_run(self.turns, numbered(run, like))
        return turns.squeeze(-2) if turns.dim() > 1 else turns

    def _load_from_state_dict(self, state_dict: dict[str, Any], prefix: str, *rest: Any) -> None:
        """Take as many runs as were saved."""
        for name in ("dwell", "turns"):
            if prefix + name in state_dict:
                setattr(self, name, getattr(self, name).new_zeros(state_dict[prefix + name].shape))
        super()._load_from_state_dict(state_dict, prefix, *rest)


def _of_run(known: Tensor, run: Tensor) -> Tensor:
    last = len(known) - 1
    places = torch.where(run < 0, last, run - 1).clamp(0, last).long()
    return beside(run, known).index_select(0, places.flatten()).reshape(*run.shape, -1)


def beside(other: Tensor, known: Tensor) -> Tensor:
    """What is known, where another tensor is. Where it is there already nothing is done to it: a traced program would keep the device."""
    return known if known.device == other.device and known.dtype == other.dtype else known.to(other)


def numbered(run: float | Tensor, other: Tensor) -> Tensor:
    """A run's number, or those of several, as a tensor that is where another is."""
    return torch.zeros_like(other.flatten()[0]) + run


class Continuing(Effect):
    """Abstract: an effect that may go on from run to run, as one of its shapes tells."""

    earlier: Earlier

    def __init__(self) -> None:
        super().__init__()
        self.earlier = Earlier()

    def after(self, before: Before) -> Self:
        """A copy that knows what went on before each run, see `Effect.after`; itself where that is known to it."""
        known = Before(self.earlier.dwell, self.earlier.turns)
        if all(torch.equal(one, new.to(one)) for one, new in zip(known, before, strict=True)):
            return self
        told = copy.deepcopy(self)
        told.earlier.dwell, told.earlier.turns = (new.to(one) for one, new in zip(known, before, strict=True))
        return told


def before_each(runs: Iterable[tuple[Tensor, Tensor]]) -> Before:
    """What went on before each of R runs, and after all of them.

    Files do not tell when they were recorded: runs are taken in the order they are given in, one after the other without a pause. Time between two
    temperatures is shared by them as a straight line does.

    Args:
        runs: time (T,) [s] and temperature (T,) [°C] of each, one run at least.
    """
    dwell, turns = [torch.zeros(BINS, dtype=torch.float64)], list[Tensor]()
    for time, celsius in runs:
        way = celsius.double().cpu()
        turns = turns or [way[:1].clamp(*ROOM_C)]
        turns.append(turns_of(torch.cat([turns[-1], way])))
        place = ((celsius[1:] + celsius[:-1]) / 2 - COLDEST_C).div(STEP_C).clamp(0, BINS - 1).double()
        below = place.floor().clamp_max(BINS - 2)
        step_s, share = torch.diff(time).double(), place - below
        low = torch.bincount(below.long(), step_s * (1 - share), BINS)
        dwell.append(dwell[-1] + (low + torch.bincount(below.long() + 1, step_s * share, BINS)).cpu())
    most = max(map(len, turns))
    return Before(torch.stack(dwell), torch.stack([torch.cat([one, one[-1:].expand(most - len(one))]) for one in turns]))


def turns_of(celsius: Tensor) -> Tensor:
    """(M,) where a way (T,) began, its turns that are left, and where it ends: a larger swing wipes out smaller ones before it (Madelung's rules).

    Seen backwards, these are the values that go beyond all later ones, of several on one side without another in between the last so seen.
    """
    back = celsius.flip(0)
    beyond = torch.diff(back.cummax(0).values).sign() + torch.diff(back.cummin(0).values).sign()  # 1 above, −1 below all later ones
    places = torch.nonzero(beyond).squeeze(-1)
    last_seen = torch.diff(beyond[places], append=beyond.new_zeros(1)) != 0
    ends = torch.tensor([0, len(back) - 1])
    return back[torch.cat([places[last_seen] + 1, ends]).unique()].flip(0)


def anew_or_on(runs: int) -> Tensor:
    """(G,) values of `GOES_ON` that a search should try: with one run there is nothing before."""
    return torch.arange(2.0 if runs > 1 else 1.0, dtype=torch.float64)
