"""What a model costs on data that its amplitudes were not fitted to."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.projection import project, ridge_of
from zoo.scoring.stages import rms

SEGMENTS, OF_A_RUN = 8, 3
"""Consecutive pieces that are left out one at a time, and how many of one run at least, so that every run keeps most of its blocks. Fewer and longer
ones ask for more: neighbours of a short piece give its misfit away."""
ENOUGH = 5
"""Blocks for each amplitude that other runs must have to predict one."""
KNOWN = 0.3
"""Share of a run's blocks that the others must know something of."""
HARDLY_SEEN = 1e-4
"""Share of what all runs know of an amplitude below which the pieces that are left do not say what it is: those of an early warm-up, where the
first hour is left out. It counts for nothing there, or noise would decide it."""


def segment_cost(bench: Workbench, solved: Solved) -> float:
    """Sum of squared whitened errors on pieces of the runs, each predicted with amplitudes from all the others."""
    return float(_left_out(solved.fit.columns, solved.design.target, _folds(bench)).square().sum())


def rms_by_run(bench: Workbench, solved: Solved) -> float:
    """RMS [unit] over runs, each predicted with amplitudes from the others; over eight pieces or more where the others are too few or too short.

    The nonlinear parameters stay as fitted to all runs.
    """
    enough = bench.blocks - max(run.blocks for run in bench.runs) >= ENOUGH * solved.plain_columns.shape[1]
    parts = _runs(bench) if enough else _folds(bench)
    return rms(_left_out(solved.plain_columns, solved.design.error, parts))


class FromOthers(NamedTuple):
    """A run as others predict it.

    Attributes:
        left: RMS of what they leave of it [unit].
        bare: RMS of its error [unit].
        known: whether they know enough of it; if so, both are of what they know, else of the whole run.
        beside_own: RMS of what is left of the whole run once what happens in it alone is fitted to that [unit].
    """

    left: float
    bare: float
    known: bool
    beside_own: float


def from_other_runs(bench: Workbench, solved: Solved, places: list[int]) -> list[FromOthers]:
    """Some runs, each predicted with amplitudes from the others of them.

    Where a row of columns asks for more than any of theirs does (its leverage), they would only extrapolate. They do not know enough of a run where
    they do so nearly everywhere, or are too short.
    """
    every = _runs(bench)
    runs = [every[place] for place in places]
    rows = torch.cat(runs)
    columns = solved.plain_columns[rows]
    parts = list(torch.arange(len(rows)).split([len(run) for run in runs]))
    target = solved.design.error[rows]
    left = _left_out(columns, target, parts)
    found = []
    for part in parts:
        keep = torch.ones(len(rows), dtype=torch.bool, device=target.device)
        keep[part] = False
        known = _reached(columns[keep], columns[part])
        enough = int(keep.sum()) >= ENOUGH * columns.shape[1] and float(known.double().mean()) >= KNOWN
        counts = known if enough else torch.ones_like(known)
        own = (columns[keep] == 0.0).all(dim=0)
        beside_own = project(columns[part][:, own], left[part]).residual if bool(own.any()) else left[part]
        found.append(FromOthers(rms(left[part][counts]), rms(target[part][counts]), enough, rms(beside_own)))
    return found


def _reached(own: Tensor, asked: Tensor) -> Tensor:
    """(N,) bool: which rows of columns (N, K) have no more leverage than the largest of others (M, K)."""
    lengths = own.norm(dim=0)
    seen = lengths > 0
    own, others = own[:, seen] / lengths[seen], asked[:, seen] / lengths[seen]
    gram = own.mT @ own
    inverse = torch.linalg.inv(gram + ridge_of(gram))
    ours, theirs = ((rows @ inverse * rows).sum(dim=1) for rows in (own, others))
    return (theirs <= ours.max()) & (asked[:, ~seen] == 0).all(dim=1)


def _runs(bench: Workbench) -> list[Tensor]:
    return list(torch.arange(bench.blocks).split([run.blocks for run in bench.runs]))


def _folds(bench: Workbench) -> list[Tensor]:
    count = max(OF_A_RUN, -(-SEGMENTS // len(bench.runs)))
    return [piece for run in _runs(bench) for piece in run.tensor_split(count) if len(piece)]


def _left_out(columns: Tensor, target: Tensor, parts: list[Tensor]) -> Tensor:
    errors, known = [], HARDLY_SEEN**0.5 * _own_lengths(columns).diag()
    for part in parts:
        keep = torch.ones(len(target), dtype=torch.bool, device=target.device)
        keep[part] = False
        # As if each amplitude alone had been seen to be 0, with this share of what the runs know of it. As if all together had made no error, with
        # this share of all that is known, a step in the piece that is left out would be set against the static bias there.
        rows, values = torch.cat([columns[keep], known]), torch.cat([target[keep], target.new_zeros(len(known))])
        errors.append(target[part] - columns[part] @ project(rows, values).amplitudes)
    return torch.cat(errors)


def _own_lengths(columns: Tensor) -> Tensor:
    """(K,) norms of what the others do not have of each column (N, K): one over the error of its amplitude in unit noise."""
    lengths = columns.norm(dim=0)
    scaled = columns / torch.where(lengths > 0, lengths, 1.0)
    gram = scaled.mT @ scaled
    inverse = torch.linalg.inv(gram + ridge_of(gram))
    return lengths / inverse.diagonal().sqrt()
