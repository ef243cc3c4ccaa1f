"""Methods trained by a paper's protocol, and their figures beside the printed ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from types import MappingProxyType
from typing import Any

import torch
from torch import Tensor

from zoo.errors import WorkError
from zoo.measurements.run import Run
from zoo.scoring.comparison import UNCOMPENSATED

BAND = (0.05, 0.95)
"""Share of the seeds below the ends of a band."""


@dataclass(frozen=True)
class Row:
    """One number of a paper's table, and ours.

    Attributes:
        quantity: what it is, such as ``"bias stability"``.
        unit: as usually written.
        stage: part of the run; ``"whole"`` for all of it.
        sample: which run.
        model: which method; `UNCOMPENSATED` for none.
        paper: the printed value; None where the paper prints none.
        ours: median over the seeds, or over what else there are several of.
        low: 5 % of them are below.
        high: 5 % are above.
    """

    quantity: str
    unit: str
    stage: str
    sample: str
    model: str
    paper: float | None
    ours: float
    low: float
    high: float

    def record(self) -> dict[str, Any]:
        """As a table takes it: the contract's columns, and what it does not ask for."""
        told = asdict(self)
        return told | {"unit": told.pop("unit")}


@dataclass(frozen=True)
class Claim:
    """A sentence of a paper, or one asked of the zoo, and whether it holds here.

    Attributes:
        text: the sentence, with its bound.
        value: what was found, in words.
        holds: whether it is so.
    """

    text: str
    value: str
    holds: bool


@dataclass(frozen=True, eq=False)
class Study:
    """What every method leaves of every run.

    Attributes:
        runs: those that were fitted first.
        fitted: how many of them were fitted.
        left: by method, a tensor (E, N) a run: error less prediction in block means, of E seeds [output's unit].
        others: the same methods, each fitted once to other data as well, by name.
    """

    runs: Sequence[Run]
    fitted: int
    left: Mapping[str, Sequence[Tensor]]
    others: Mapping[str, Study] = field(default_factory=dict)

    @classmethod
    def of(
        cls, runs: Sequence[Run], fitted: int, predicted: Mapping[str, Sequence[Tensor]], others: Mapping[str, Study] = MappingProxyType({})
    ) -> Study:
        """From predictions (E, N) by method and run [output's unit]."""
        errors = [run.block_mean(run.error) for run in runs]
        left = {name: [error - one for error, one in zip(errors, each, strict=True)] for name, each in predicted.items()}
        return cls(runs, fitted, {UNCOMPENSATED: [error.unsqueeze(0) for error in errors], **left}, others)

    @property
    def methods(self) -> list[str]:
        """Their names, without `UNCOMPENSATED`."""
        return [name for name in self.left if name != UNCOMPENSATED]


def seed_by_seed(predicted: Mapping[str, Mapping[int, Sequence[Tensor]]]) -> dict[str, list[Tensor]]:
    """Predictions (E, N) by method and run, of the seeds that all methods of several have: one with which a training failed is left out of all.

    Args:
        predicted: (N,) for every run, by method and seed.

    Raises:
        WorkError: there is no such seed.
    """
    several = [set(seeds) for seeds in predicted.values() if len(seeds) > 1]
    common = sorted(set.intersection(*several)) if several else []
    if several and not common:
        raise WorkError("no seed with which every method's training came to an end")

    def stacked(seeds: Mapping[int, Sequence[Tensor]]) -> list[Tensor]:
        kept = [seeds[seed] for seed in common] if len(seeds) > 1 else list(seeds.values())
        return [torch.stack(run) for run in zip(*kept, strict=True)]

    return {name: stacked(seeds) for name, seeds in predicted.items()}


Measure = Callable[[Tensor], Tensor]
"""(E, N) residuals -> (E,) one figure a seed."""


def row(values: Tensor, quantity: str, unit: str, stage: str, sample: str, model: str, paper: float | None) -> Row:
    """Median and band of one figure (E,) over the seeds."""
    low, high = torch.quantile(values, torch.tensor(BAND, dtype=values.dtype)).tolist()
    return Row(quantity, unit, stage, sample, model, paper, float(values.quantile(0.5)), low, high)


def spread(left: Tensor) -> Tensor:
    """(E, N) -> (E,) sample standard deviation, what the papers call bias stability."""
    return left.std(dim=-1)


def removed(study: Study, model: str, samples: Sequence[int]) -> Tensor:
    """(E,) share by which a method lowers the standard deviation, its mean over some runs."""
    shares = [1.0 - spread(study.left[model][one]) / spread(study.left[UNCOMPENSATED][one]) for one in samples]
    return torch.stack([share.expand(max(len(part) for part in shares)) for share in shares]).mean(0)


def in_words(values: Tensor, style: str = "{:.1%}") -> str:
    """``64.2 % (60.1 % to 66.0 %)``: median and band."""
    low, high = torch.quantile(values, torch.tensor(BAND, dtype=values.dtype)).tolist()
    middle = style.format(float(values.quantile(0.5)))
    return middle if len(values) == 1 else f"{middle} ({style.format(low)} to {style.format(high)})"
