"""Where a curve is best cut into segments with one polynomial each: the exact optimum over a few dozen candidates."""

import torch
from torch import Tensor

from zoo.errors import InputError

CANDIDATES = 64
"""Edges tried, at quantiles of the samples; engineering prior."""
RIDGE = 1e-7
"""Weight kept on each coefficient, so that a column that is constant within a segment cannot take up noise; columns are of order 1."""


def best_edges(place: Tensor, columns: Tensor, target: Tensor, segments: int, least: int) -> Tensor:
    """The edges that leave the smallest residual sum of squares, each segment having least-squares coefficients of its own.

    Dynamic programming over the segments (Bellman 1961) on the cost of every stretch between two candidates. The cost is the last entry of the
    triangular factor of [columns, target], to which samples are added stretch by stretch, so that normal equations are never formed.

    Args:
        place: (M,) the feature that is cut, any unit.
        columns: (M, K) of order 1, with a constant.
        target: (M,) of order 1.
        segments: S, at least 1.
        least: fewest samples of a segment.

    Returns:
        (S − 1,) ascending, each between two samples [unit of `place`].

    Raises:
        InputError: there are too few samples, or too few different ones.
    """
    order = torch.argsort(place)
    value, rows = place[order].cpu(), torch.cat([columns, target.unsqueeze(-1)], dim=-1)[order].cpu()
    cuts = _candidates(value)
    cost = _costs(rows, cuts, least)
    places = _cheapest(cost, segments)
    if places is None:
        raise InputError(
            f"model.segments={segments}: {len(value)} samples do not make {segments} segments of at least {least}; "
            "take fewer segments, lower orders, more runs or a shorter data.average_s"
        )
    inner = cuts[torch.tensor(places, dtype=torch.int64)]
    return ((value[inner - 1] + value[inner]) / 2).to(place.device)


def _candidates(value: Tensor) -> Tensor:
    """(J + 1,) first sample after each possible cut of ascending values (M,), from 0 to M; equal values are never cut apart."""
    wanted = torch.linspace(0, len(value), CANDIDATES + 2, dtype=torch.float64).round().long()[1:-1]
    first_of_equals = torch.searchsorted(value, value[wanted.clamp(max=len(value) - 1)])
    return torch.unique(torch.cat([torch.tensor([0, len(value)]), first_of_equals]))


def _costs(rows: Tensor, cuts: Tensor, least: int) -> Tensor:
    """(J, J + 1) residual sum of squares of the samples from cut i to cut j; infinite where they are too few.

    Args:
        rows: (M, K + 1) columns and target, in order.
        cuts: (J + 1,) ascending.
        least: fewest samples.
    """
    width = rows.shape[1]
    start = RIDGE * torch.eye(width, dtype=rows.dtype)
    start[-1] = 0.0
    cost = rows.new_full((len(cuts) - 1, len(cuts)), torch.inf)
    factors = rows.new_empty(0, width, width)
    for last in range(1, len(cuts)):
        added = rows[int(cuts[last - 1]) : int(cuts[last])]
        added = torch.linalg.qr(torch.cat([added, torch.zeros_like(start)]), mode="r").R
        stacked = torch.cat([torch.cat([factors, start.unsqueeze(0)]), added.expand(last, width, width)], dim=1)
        factors = torch.linalg.qr(stacked, mode="r").R
        enough = cuts[last] - cuts[:last] >= least
        cost[:last, last] = torch.where(enough, factors[:, -1, -1].square(), torch.inf)
    return cost


def _cheapest(cost: Tensor, segments: int) -> list[int] | None:
    """Numbers of the S − 1 inner cuts of the cheapest chain of S stretches from the first cut to the last; None where there is no such chain.

    Args:
        cost: (J, J + 1).
        segments: S.
    """
    best, came_from = cost[0], []
    for _ in range(segments - 1):
        total = best[:-1].unsqueeze(1) + cost
        best, before = total.min(dim=0)
        came_from.append(before)
    if not bool(torch.isfinite(best[-1])):
        return None
    chain = [cost.shape[1] - 1]
    for before in reversed(came_from):
        chain.append(int(before[chain[-1]]))
    return sorted(chain[1:])
