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


class FineBlocks(FeatureModel):
    """A model over whole blocks: a row holds the features of S samples and the share that each has in the block, the output is the mean.

    To all that trains maps of features it is one more of them, with the weights of the model within.

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
        first = torch.searchsorted(block, torch.arange(run.blocks, device=block.device))
        place = torch.arange(len(block), device=block.device) - first[block]
        rows = torch.cat([features[kept[first]], torch.zeros_like(features[:1, :1]).expand(run.blocks, 1)], dim=-1)
        rows = rows.unsqueeze(1).repeat(1, self.samples, 1)
        rows[block, place] = torch.cat([features[kept], share.unsqueeze(-1)], dim=-1)
        return rows.flatten(1)

    def head(self, features: Tensor) -> Tensor:
        """(..., S·(F + 1)) rows -> (...) mean predicted errors."""
        own, share = self._parted(features)
        return (self.model.head(own) * share).sum(-1)

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
    """S of the fullest block."""
    return max((int(torch.bincount(_members(run)[0]).max()) for run in runs if run.blocks), default=1)


def _members(run: Run) -> tuple[Tensor, Tensor, Tensor]:
    """(K,) block, place on the fine grid, and share in the block, of all samples that belong to one, block by block."""
    averager = run.averager
    block, kept = averager.indices()
    return block, kept, averager.values()
