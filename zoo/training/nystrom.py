"""A kernel of many samples by few of them."""

from __future__ import annotations

import torch
from torch import Generator, Tensor

from zoo.models.ls_svm import VALUES_AT_ONCE, gaussians

WEAKEST = 1e-12
"""Eigenvalue of the landmarks' kernel over the largest below which a direction is rounding."""


def landmarks(points: Tensor, count: int, generator: Generator) -> Tensor:
    """(count,) which samples stand for all: each next one with a chance that grows with its squared distance from those chosen.

    That is the start of k-means++ (Arthur & Vassilvitskii 2007): ramps are short beside holds, and uniform draws would all but miss them.

    Args:
        points: (M, F) standardised.
        count: wanted; fewer where fewer samples differ.
        generator: source of chance, on the CPU.
    """
    here = points.cpu()
    chosen = [int(torch.randint(len(here), (1,), generator=generator))]
    distance = (here - here[chosen[0]]).square().sum(-1)
    while len(chosen) < count and bool(distance.max() > 0):
        chosen.append(int(torch.multinomial(distance, 1, generator=generator)))
        distance = torch.minimum(distance, (here - here[chosen[-1]]).square().sum(-1))
    return torch.tensor(chosen, device=points.device)


def nystrom_solve(points: Tensor, target: Tensor, support: Tensor, gamma: float) -> tuple[Tensor, Tensor]:
    """The dual system with K replaced by K_MS·K_SS⁻¹·K_SM (Williams & Seeger 2001), solved in its S features, rows some at a time.

    Args:
        points: (M, F) in widths.
        target: (M,).
        support: (S, F) landmarks in widths.
        gamma: γ.

    Returns:
        (S,) weights of the landmarks and () bias; as exact as the dual system where every sample is a landmark.
    """
    values, vectors = torch.linalg.eigh(gaussians(support, support))
    kept = values > WEAKEST * values[-1]
    root = vectors[:, kept] / values[kept].sqrt()
    size = root.shape[1] + 1
    normal, right = points.new_zeros(size, size), points.new_zeros(size)
    rows = max(VALUES_AT_ONCE // len(support), 1)
    for part, wanted in zip(points.split(rows), target.split(rows), strict=True):
        columns = torch.cat([gaussians(part, support) @ root, torch.ones_like(wanted).unsqueeze(-1)], dim=-1)
        normal += columns.mT @ columns
        right += columns.mT @ wanted
    normal.diagonal()[:-1] += 1.0 / gamma
    found = torch.linalg.solve(normal, right)
    return root @ found[:-1], found[-1]
