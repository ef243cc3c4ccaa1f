"""The fit of Takagi–Sugeno models in liu2010: fuzzy clusters become rules, and recursive least squares finds their planes."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import torch
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.given import check_number, check_seed, is_number
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.models.takagi_sugeno import TakagiSugeno
from zoo.training.fine_blocks import FineBlocks, standardised
from zoo.training.fuzzy_clusters import best_clusters
from zoo.training.init import Init, Log
from zoo.training.problem import Problem
from zoo.training.recursive_least_squares import Information, begin, learn
from zoo.training.weights import weight_vector

OVERLAPS = tuple(2 ** (k / 2) for k in range(7))
"""Planes that bend into each other over a wider stretch follow a curve more closely than those that clusters as they stand keep apart."""
BOUNDS = (
    ("fuzziness", 1.0, math.inf),
    ("tolerance", 0.0, 1.0),
    ("regularisation", 0.0, 1.0),
    ("alpha", 0.0, math.inf),
    ("overlap", 0.0, math.inf),
)
"""Settings, and what they must lie between."""
ENOUGH = 2000
"""Points that clusters are searched among; of more, so many are drawn (engineering prior: a cluster's moments are sure to a few per cent by then)."""
ROWS_AT_ONCE = 1024


@dataclass(frozen=True)
class Clustering:
    """The numbers that steer the fit.

    Attributes:
        restarts: random partitions that clusters are searched from; the lowest objective is taken.
        fuzziness: m (liu2010: 2).
        tolerance: ends where no membership changes by more (liu2010: 1e-4).
        iterations: most of them.
        regularisation: γ, see `zoo.training.fuzzy_clusters.gustafson_kessel` (engineering prior: a cluster at most a thousand times as long as flat).
        alpha: P0 = αI of the recursive least squares (liu2010: above 300).
        overlap: widths over the clusters' standard deviations; None for whichever of `OVERLAPS` leaves least (liu2010 names none, which is 1).
    """

    restarts: int = 10
    fuzziness: float = 2.0
    tolerance: float = 1e-4
    iterations: int = 300
    regularisation: float = 1e-6
    alpha: float = 1e6
    overlap: float | None = None

    def check(self, group: str) -> None:
        """Raises InputError for a number that cannot be; `group` is where the user gave it, ``"optimizer"`` or ``"init"``."""
        for name in ("restarts", "iterations"):
            check_number(f"{group}.{name}", getattr(self, name), 1, whole=True)
        for name, low, high in BOUNDS:
            value = getattr(self, name)
            if name == "overlap" and value is None:
                continue
            if not is_number(value) or not low < value < high:
                above = f"above {low:g}" if high == math.inf else f"between {low:g} and {high:g}"
                raise InputError(f"{group}.{name}={value}: a number {above} is needed")


def clustered_weights(whole: Model, rows: Tensor, error: Tensor, generator: Generator, settings: Clustering = Clustering()) -> None:
    """Set all weights of a Takagi–Sugeno model from its training data.

    Clusters are searched in the space of standardised features and error, of blocks by their means. A cluster's centre, and the roots of its points'
    fuzzy variances around it, Σ u·(x − c)²/Σ u, become a rule's c and σ; all planes together are one linear problem.

    Args:
        whole: the model, or one over blocks, see `zoo.training.fine_blocks`; changed in place, standardised on these data.
        rows: (M, F), or those of blocks.
        error: (M,) [output's unit].
        generator: source of chance.
        settings: see `Clustering`.

    Raises:
        InputError: the model is no `TakagiSugeno`, or has more rules than there are data.
    """
    blocks = whole if isinstance(whole, FineBlocks) else None
    model, features = (whole, rows) if blocks is None else (blocks.model, blocks.means(rows))
    if not isinstance(model, TakagiSugeno):
        raise InputError(f"gustafson_kessel sets the rules of model=takagi_sugeno; {type(model).__name__} has none: init=random, optimizer=auto")
    rules = len(model.centre)
    if rules > len(error):
        raise InputError(f"model.rules={rules}: the runs have {len(error)} block means; at most as many rules are possible")
    scaler = model.scaler
    target = (error - scaler.error_centre) / scaler.error_scale
    points = torch.cat([scaler(features), target.unsqueeze(-1)], dim=-1)
    if len(points) > max(ENOUGH, rules):
        order = torch.randperm(len(points), generator=generator, device=generator.device)
        points = points[order[: max(ENOUGH, rules)].to(points.device)]
    found = best_clusters(
        points,
        rules,
        settings.restarts,
        generator,
        fuzziness=settings.fuzziness,
        tolerance=settings.tolerance,
        iterations=settings.iterations,
        regularisation=settings.regularisation,
    )
    centre, share = found.centre[:, :-1], found.membership / found.membership.sum(dim=0)
    width = (share.T.unsqueeze(-1) * (points[:, :-1] - centre.unsqueeze(1)).square()).sum(dim=1).sqrt()
    columns = model.columns if blocks is None else partial(blocks.mean_of, model.columns)
    _fit_planes(model, columns, rows, target, centre, width, settings)


def _fit_planes(
    model: TakagiSugeno,
    columns: Callable[[Tensor], Tensor],
    rows: Tensor,
    target: Tensor,
    centre: Tensor,
    width: Tensor,
    settings: Clustering,
) -> None:
    """Rules at (R, F) centres with (R, F) widths times the best overlap, and the planes that follow (M,) standardised errors."""

    @torch.no_grad()
    def solved(overlap: float) -> Information:
        model.set_antecedents(centre, overlap * width)
        known = begin(model.consequent.numel(), settings.alpha, target)
        for some, targets in zip(rows.split(ROWS_AT_ONCE), target.split(ROWS_AT_ONCE), strict=True):
            known = learn(known, columns(some), targets)
        return known

    overlaps = OVERLAPS if settings.overlap is None else (settings.overlap,)
    best = min(overlaps, key=lambda overlap: solved(overlap).cost)
    with torch.no_grad():
        model.consequent.copy_(solved(best).estimate.view_as(model.consequent))


class GustafsonKessel:
    """Optimizer of Takagi–Sugeno models."""

    follows_device = True

    def __init__(self, **settings: Any) -> None:
        """Remember.

        Args:
            **settings: see `Clustering`.
        """
        self.settings = Clustering(**settings)
        self.settings.check("optimizer")

    def fit(self, model: Model, runs: Sequence[Run], generator: Generator) -> None:
        """Fit in place.

        Args:
            model: a `TakagiSugeno`.
            runs: fitted.
            generator: source of chance of the partitions.

        Raises:
            InputError: see `clustered_weights`.
        """
        if not isinstance(model, FeatureModel):
            raise InputError(f"gustafson_kessel sets the rules of model=takagi_sugeno; {type(model).__name__} has none: leave optimizer=auto")
        clustered_weights(*standardised(model, runs), generator, self.settings)


class ClusteredInit(Init):
    """Starts a training from where the fit of liu2010 ends."""

    def __init__(self, seed: int = 1, **settings: Any) -> None:
        """Remember.

        Args:
            seed: of the partitions.
            **settings: see `Clustering`.
        """
        check_seed("init.seed", seed)
        self.seed, self.settings = seed, Clustering(**settings)
        self.settings.check("init")

    def weights(self, problem: Problem, members: int, log: Log) -> Tensor:
        """See `Init.weights`."""
        model, found = copy.deepcopy(problem.model), []
        for seed in range(self.seed, self.seed + members):
            clustered_weights(model, problem.features, problem.error, torch.Generator().manual_seed(seed), self.settings)
            found.append(weight_vector(model))
        return torch.stack(found)
