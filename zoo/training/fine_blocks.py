"""Blocks as a fit sees them: with their fine samples, where the mean of what a model predicts is not what it predicts of the mean."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import torch
from torch import Tensor

from zoo.measurements.datamodule import RunsDataModule
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel
from zoo.models.prediction import block_features, raw_columns

MOST = 10
"""Samples of a block that are told apart: as many as a block of rows has before its fine samples are a fifth of it. Of a block that has more, as in a
burst of a recorder, neighbours are taken together, so that no block costs more than others."""


class FineBlocks(FeatureModel):
    """A model over whole blocks: a row holds the features of S samples and the share that each has in the block, the output is the mean.

    To all that trains maps of features it is one more of them, with the weights of the model within, which sees a table of samples as ever.

    Attributes:
        model: the one that is fitted.
        samples: S.
    """

    model: FeatureModel

    def __init__(self, model: FeatureModel, samples: int) -> None:
        """Wrap a model, which stays what it is."""
        super().__init__()
        self.model, self.samples = model, samples
        self.linear_in = tuple(f"model.{name}" for name in model.linear_in)  # type: ignore[misc]

    def rows(self, run: Run) -> Tensor:
        """(N, S·(F + 1)) the blocks of a run: features and share of each sample, sample by sample; what a block has not is of no weight."""
        with torch.no_grad():
            features = self.model.features(raw_columns(self.model, run))
        block, kept, share = _members(run)
        sizes = torch.bincount(block, minlength=run.blocks)
        first = sizes.cumsum(0) - sizes
        place = torch.arange(len(block), device=block.device) - first[block]
        crowded = sizes[block] > self.samples
        place = torch.where(crowded, place * self.samples // sizes[block].clamp_min(1), place)
        rows = torch.zeros(run.blocks, self.samples, features.shape[1] + 1, dtype=features.dtype, device=features.device)
        rows.index_put_((block, place), torch.cat([features[kept] * share.unsqueeze(-1), share.unsqueeze(-1)], dim=-1), accumulate=True)
        weight = rows[..., -1:]
        means = rows[..., :-1] / torch.where(weight > 0, weight, torch.ones_like(weight))
        own = torch.where(weight > 0, means, features[kept[first]].unsqueeze(1))
        return torch.cat([own, weight], dim=-1).flatten(1)

    def head(self, features: Tensor) -> Tensor:
        """(..., S·(F + 1)) rows -> (...) mean predicted errors."""
        own, share = self._parted(features)
        return (self.model.head(own.reshape(-1, own.shape[-1])).view(share.shape) * share).sum(-1)

    def mean_of(self, columns: Callable[[Tensor], Tensor], features: Tensor) -> Tensor:
        """(..., S·(F + 1)) rows -> (..., K) means of some columns, given as (..., S, F) -> (..., S, K)."""
        own, share = self._parted(features)
        return (columns(own) * share.unsqueeze(-1)).sum(-2)

    def standardise(self, features: Tensor, error: Tensor) -> None:
        """By the means of the blocks, as any model; see `FeatureModel.standardise`."""
        self.model.standardise(self.means(features), error)

    def parts(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """By the means of the blocks, see `FeatureModel.parts`; a block may have samples in two groups."""
        return self.model.parts(self.means(features))

    def means(self, features: Tensor) -> Tensor:
        """(..., S·(F + 1)) rows -> (..., F) the model's mean features."""
        return self.mean_of(lambda own: own, features)

    def _parted(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """(..., S, F) features and (..., S) shares."""
        samples = features.unflatten(-1, (self.samples, -1))
        return samples[..., :-1], samples[..., -1]


def seen(model: FeatureModel, samples: int) -> FeatureModel:
    """What a fit works on: a model over blocks of so many samples; itself where a block is one sample."""
    return model if samples == 1 else FineBlocks(model, samples)


def rows_of(model: FeatureModel, samples: int) -> Callable[[Run], Tensor]:
    """One run -> (N, ·) the rows that go with `seen`."""
    return partial(block_features, model) if samples == 1 else FineBlocks(model, samples).rows


def standardised(model: FeatureModel, runs: Sequence[Run]) -> tuple[FeatureModel, Tensor, Tensor]:
    """What a fit of some runs works on, after it has been standardised on them: model, rows (M, ·) and errors (M,) [output's unit].

    Raises:
        InputError: a run lacks a column that the model takes, or there is no block to fit.
    """
    samples = samples_of(runs)
    whole = seen(model, samples)
    rows, error = RunsDataModule(runs, [], rows_of(model, samples)).fitted
    whole.standardise(rows, error)
    return whole, rows, error


def samples_of(runs: Sequence[Run]) -> int:
    """S of the fullest block, and `MOST` at most."""
    return min(max((int(torch.bincount(_members(run)[0]).max()) for run in runs if run.blocks), default=1), MOST)


def samples_in(model: FeatureModel) -> int:
    """How many samples a row of a model's features holds."""
    return model.samples if isinstance(model, FineBlocks) else 1


def _members(run: Run) -> tuple[Tensor, Tensor, Tensor]:
    """(K,) block, place on the fine grid, and share in the block, of all samples that belong to one, block by block."""
    averager = run.averager
    return averager.block, averager.sample, averager.share
