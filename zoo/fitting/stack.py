"""Runs recorded at the same times, computed as one with a leading axis: small tensors cost by their number more than by their size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import torch
from torch import Tensor

from zoo.effects.base import OF_PLACE, Effect, History
from zoo.measurements.averager import Averager
from zoo.measurements.run import Run
from zoo.models.graybox import GrayBox

SAME_TIMES = 1e-6
"""Share of a sampling step by which the clocks of runs may differ that were recorded alike."""
PADDED = 1.5
"""How many times the samples that there are may be computed where shorter runs go on to the length of the longest."""


def stacked(runs: list[Run], numbers: list[int], model: GrayBox) -> list[Stack]:
    """The runs in one stack where all were recorded alike and are not too unlike in length, else in one each.

    Args:
        runs: R runs with the model's inputs.
        numbers: of each run, from 1.
        model: what is fitted to them; where their first temperatures are fitted as well, each run has its own.
    """
    if len(runs) > 1 and not model.in_motion and _alike(runs):
        return [Stack(runs, numbers, model.inputs)]
    return [Stack([run], [number], model.inputs) for run, number in zip(runs, numbers, strict=True)]


def _alike(runs: list[Run]) -> bool:
    """Whether there is one clock for all of them, as far as anybody looks: of an odd number of rows the last mean of two stands for one, and so comes
    early, but what belongs to no block changes nothing that was before it."""
    longest = max(runs, key=lambda run: len(run.time))
    clock = longest.time - longest.time[0]
    if len(clock) < 2 or len(clock) * len(runs) > PADDED * sum(len(run.time) for run in runs):
        return False
    looked_at = [(run.block >= 0).flip(0).cumsum(0).flip(0) > 0 for run in runs]
    apart = [float(((run.time - run.time[0] - clock[: len(run.time)]) * own).abs().max()) for run, own in zip(runs, looked_at, strict=True)]
    return max(apart) <= SAME_TIMES * float(torch.diff(clock).min())


class Stack:
    """One run, or R runs whose histories have a leading axis: (R, ..., T) where those of one have (..., T)."""

    def __init__(self, runs: list[Run], numbers: list[int], inputs: list[str]) -> None:
        """Keep the tensors ready; shorter runs go on as they ended, which nobody looks at.

        Args:
            runs: recorded alike.
            numbers: of each run, from 1.
            inputs: columns that models take.
        """
        self.runs, self.numbers = runs, numbers
        tables = [run.select(inputs) for run in runs]
        self.lengths = [len(table) for table in tables]
        self.samples = max(self.lengths) * len(runs)
        self.table, self.number = tables[0], numbers[0] if len(runs) == 1 else torch.tensor(numbers).to(tables[0]).reshape(-1, 1, 1)
        if len(runs) > 1:
            longest = max(tables, key=len)
            self.table = torch.stack([_lasting(table, longest[:, 0]) for table in tables]).unsqueeze(1)
        self._housing: dict[frozenset[str], History] = {}

    def places(self, model: GrayBox, coil: Tensor) -> dict[str, History]:
        """A model's histories at each place for parameters of its coil (..., P); the housing's, which no parameter changes, is computed once."""
        needs = model.needs
        places = model.histories(self.table, coil, self.number, self._housing.get(needs))
        self._housing[needs] = places["housing"]
        return places

    def one_of(self, places: dict[str, History], i: int) -> dict[str, History]:
        """The histories at one of several coils."""
        at = torch.tensor([i] if len(self.runs) > 1 else i, device=self.table.device)
        return {name: history.take(at) if name == "coil" else history for name, history in places.items()}

    def apart(self, history: History) -> list[History]:
        """A history run by run, as long as each is."""
        if len(self.runs) == 1:
            return [history]
        return [_one(history, i, number, length) for i, (number, length) in enumerate(zip(self.numbers, self.lengths, strict=True))]

    def block_means(self, effect: Effect, history: History, columns: Callable[[History], Tensor], batch: int) -> Tensor:
        """(B, N, K) means of an effect's columns over the blocks of all its runs, time first in memory.

        Args:
            effect: whose they are.
            history: of its place.
            columns: of a history, (B, T, K).
            batch: B.
        """
        if len(self.runs) == 1 or not effect.runs_together:
            parts = [run.block_mean_columns(columns(one)) for run, one in zip(self.runs, self.apart(history), strict=True)]
            return torch.cat([part.movedim(-2, 0) for part in parts]).movedim(0, -2)
        found = columns(history)
        return self._averaged(found.expand(len(self.runs), batch, *found.shape[-2:]))

    def means(self, effect: Effect, history: History) -> list[History]:
        """The block means of everything that a history at one θ has; of an instant effect in single precision, and where it takes runs together, all
        in one."""
        if len(self.runs) == 1 or not effect.runs_together or not effect.instant:
            dtype = torch.float32 if effect.instant else history.temperature.dtype
            return [_means(one, run.block_mean_columns, dtype) for run, one in zip(self.runs, self.apart(history), strict=True)]
        return [_means(history, lambda values: self._averaged(values).squeeze(0), torch.float32)]

    def _averaged(self, columns: Tensor) -> Tensor:
        """(R, B, T, K) -> (B, N, K), time first in memory."""
        return self._averager(columns.movedim(2, 1).flatten(0, 1)).movedim(0, -2)

    @cached_property
    def _averager(self) -> Averager:
        """Of all runs one after the other."""
        return Averager.joined([run.averager for run in self.runs], max(self.lengths))


def _lasting(table: Tensor, clock: Tensor) -> Tensor:
    """A table (T, C) that goes on with its last row, while the time, its first column, is a longer run's, counted from its own start."""
    whole = torch.cat([table, table[-1:].repeat(len(clock) - len(table), 1)])
    whole[:, 0] = table[0, 0] + clock - clock[0]
    return whole


def _means(history: History, averaged: Callable[[Tensor], Tensor], dtype: torch.dtype) -> History:
    of_place = ("time", *OF_PLACE)
    fields = torch.broadcast_tensors(*(getattr(history, name) for name in of_place), *history.inputs.values())
    means = averaged(torch.stack(fields, dim=-1)).to(dtype).mT
    inputs = dict(zip(history.inputs, means[len(of_place) :], strict=True))
    return replace(history, **dict(zip(of_place, means, strict=False)), inputs=inputs)


def _one(history: History, i: int, number: int, length: int) -> History:
    """One run's share of a stacked history."""

    def own(value: Tensor) -> Tensor:
        mine = value[i, ..., :length]
        return mine.squeeze(0) if len(mine) == 1 else mine

    of_place = {name: own(getattr(history, name)) for name in OF_PLACE}
    return replace(history, time=history.time[:length], run=number, inputs={name: own(value) for name, value in history.inputs.items()}, **of_place)
