"""Block means of a model's features, split by run, as Lightning wants them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import torch
from lightning.pytorch import LightningDataModule
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.measurements.run import Run

Batch = tuple[Tensor, Tensor]


class Prebatched:
    """Batches that are there already, pass after pass: a sampler and a collate function would cost more than a step of a small net.

    With `batch_size` None, every batch is the whole set; else each pass is shuffled anew. With several generators, each belongs to a member of an
    ensemble, which gets batches of its own: (E, B, F) features and (E, B) errors. Where `begun` batches were seen before, by a training that goes on,
    the first round is what is left of the one that was broken off, in the order that it would have had.
    """

    def __init__(
        self,
        batch: Batch,
        passes: int = 1,
        batch_size: int | None = None,
        generator: Generator | Sequence[Generator] | None = None,
        begun: int = 0,
    ) -> None:
        self.batch = batch
        self.begun = begun
        self.passes = passes
        self.size = min(batch_size or len(batch[1]), len(batch[1]))
        self.generator = generator

    def _order(self) -> Tensor:
        """(M,) or (E, M) places in a new order."""
        count = len(self.batch[1])
        if isinstance(self.generator, Sequence):
            return torch.stack([torch.randperm(count, generator=one) for one in self.generator])
        return torch.randperm(count, generator=self.generator)

    @property
    def batches_per_pass(self) -> int:
        """Steps that see every block once."""
        return -(-len(self.batch[1]) // self.size)

    def __len__(self) -> int:
        return self.passes * self.batches_per_pass

    def __iter__(self) -> Iterator[Batch]:
        features, error = self.batch
        (over, seen), self.begun = divmod(self.begun, self.batches_per_pass), 0
        if self.batches_per_pass > 1:
            for _ in range(over):
                self._order()
        for _ in range(self.passes - over % self.passes):
            if self.batches_per_pass == 1:
                yield self.batch
                continue
            for index in self._order().to(error.device).split(self.size, dim=-1)[seen:]:
                yield features[index], error[index]
            seen = 0


class RunsDataModule(LightningDataModule):
    """Runs to fit and runs only to check on, as (features, error) block means.

    Attributes:
        begun: batches that were seen before, where a training goes on.
        fitted: (M, F) features and (M,) errors [output's unit] of all runs to fit.
        checked: the same of the runs to check on; None where there are none.
    """

    def __init__(
        self,
        runs: Sequence[Run],
        check_runs: Sequence[Run],
        features: Callable[[Run], Tensor],
        *,
        passes: int = 1,
        batch_size: int | None = None,
        generator: Generator | Sequence[Generator] | None = None,
    ) -> None:
        """Compute all features once.

        Args:
            runs: fitted.
            check_runs: never fitted.
            features: one run -> its (N, F) block means.
            passes: passes over the data in one of Lightning's epochs, whose price is many times a small net's step.
            batch_size: blocks a step; None for all.
            generator: source of chance of the shuffling; several for the members of an ensemble, see `Prebatched`.

        Raises:
            InputError: no run to fit, or none with a block.
        """
        super().__init__()
        if not sum(run.blocks for run in runs):
            raise InputError("data.files: no block means to train on; check data.average_s against the length of the runs")
        self.fitted = _stacked(runs, features)
        self.checked = _stacked(check_runs, features) if check_runs else None
        self.passes, self.batch_size, self.generator, self.begun = passes, batch_size, generator, 0

    def setup(self, stage: str) -> None:
        """Move the data to the trainer's device, once instead of every step."""
        if self.trainer is None:
            return
        device = self.trainer.strategy.root_device
        self.fitted = _moved(self.fitted, device)
        self.checked = None if self.checked is None else _moved(self.checked, device)

    def train_dataloader(self) -> Prebatched:
        """Batches of the fitted runs."""
        return Prebatched(self.fitted, self.passes, self.batch_size, self.generator, self.begun)

    def val_dataloader(self) -> Prebatched | list[Batch]:
        """One batch with all check runs, or nothing."""
        return [] if self.checked is None else Prebatched(self.checked)


def _stacked(runs: Sequence[Run], features: Callable[[Run], Tensor]) -> Batch:
    return torch.cat([features(run) for run in runs]), torch.cat([run.block_mean(run.error) for run in runs])


def _moved(batch: Batch, device: torch.device) -> Batch:
    return batch[0].to(device), batch[1].to(device)
