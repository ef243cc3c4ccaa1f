"""Fuzzy clusters that may be long, flat and tilted: Gustafson–Kessel, several random starts in one batch."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Generator, Tensor

from zoo.errors import WorkError

SMALLEST = 1e-300
VALUES_AT_ONCE = 4_000_000
"""Memberships in a batch of starts: more of them only take memory."""


class Clusters(NamedTuple):
    """K clusters of M points in D dimensions; S of them beside each other, or one.

    Attributes:
        centre: (..., K, D).
        covariance: (..., K, D, D) fuzzy covariance, regularised.
        membership: (..., M, K), summing to 1 over the clusters.
        objective: (..., I) its course from one iteration to the next; the last value stands where a start has settled.
    """

    centre: Tensor
    covariance: Tensor
    membership: Tensor
    objective: Tensor


def gustafson_kessel(
    points: Tensor,
    partition: Tensor,
    *,
    fuzziness: float = 2.0,
    tolerance: float = 1e-4,
    iterations: int = 300,
    regularisation: float = 1e-6,
) -> Clusters:
    """Lower Σ_i Σ_k u_ik^m·d²_ik from some partitions, each by itself, until no membership changes by more than the tolerance.

    Gustafson & Kessel 1979 (IEEE CDC, 761), with all cluster volumes 1:
        v_k = Σ u^m z / Σ u^m,  F_k = Σ u^m (z − v_k)(z − v_k)ᵀ / Σ u^m,  A_k = det(F_k)^{1/D}·F_k⁻¹,  d² = (z − v_k)ᵀ A_k (z − v_k),
        u_k ∝ d_k^{−2/(m−1)}.
    As in Babuška, van der Veen & Kaymak 2002 (FUZZ-IEEE, 1081), F_k is replaced by (1 − γ)·F_k + γ·s·I. Here s is the mean variance of all points,
    not the D-th root of their determinant, which is 0 where they lie in a plane; and d² becomes (1 − γ)·d² + γ·s·tr(A_k), for then A_k is still where
    the objective is least, which never rises, and no distance is 0.

    Args:
        points: (M, D), of comparable scales.
        partition: (S, M, K) memberships to start from.
        fuzziness: m, above 1.
        tolerance: see above.
        iterations: most of them.
        regularisation: γ, above 0.
    """
    size = points.shape[1]
    mean = points.mean(dim=0)
    centred = points - mean
    powers = torch.cat([torch.ones_like(centred[:, :1]), centred, (centred.unsqueeze(2) * centred.unsqueeze(1)).flatten(1)], dim=1)
    ridge = regularisation * float(centred.square().mean().clamp_min(SMALLEST)) * torch.eye(size, dtype=points.dtype, device=points.device)
    membership, moving = partition, torch.ones(len(partition), dtype=torch.bool, device=points.device)
    course: list[Tensor] = []
    for _ in range(iterations):
        before = membership[moving]
        centre, covariance = _moments(powers, before**fuzziness, size)
        shape = _shapes((1 - regularisation) * covariance + ridge)
        distance = (1 - regularisation) * _distances(powers, centre, shape) + (shape * ridge).sum(dim=(-2, -1)).unsqueeze(-2)
        after = torch.softmax(-distance.log() / (fuzziness - 1), dim=-1)
        objective = course[-1].clone() if course else distance.new_zeros(len(partition))
        objective[moving] = (after**fuzziness * distance).sum(dim=(-2, -1))
        course.append(objective)
        membership = membership.index_put((moving,), after)
        moving = moving.index_put((moving,), (after - before).abs().amax(dim=(-2, -1)) > tolerance)
        if not bool(moving.any()):
            break
    centre, covariance = _moments(powers, membership**fuzziness, size)
    return Clusters(centre + mean, (1 - regularisation) * covariance + ridge, membership, torch.stack(course, dim=-1))


def random_partitions(starts: int, points: int, clusters: int, generator: Generator, like: Tensor) -> Tensor:
    """(S, M, K) memberships, each point's drawn evenly from all that sum to 1.

    Args:
        starts: S.
        points: M.
        clusters: K.
        generator: source of chance; draws are made on its device.
        like: gives precision and device.
    """
    drawn = torch.rand(starts, points, clusters, generator=generator, dtype=like.dtype, device=generator.device).to(like.device)
    share = -torch.log1p(-drawn) + SMALLEST
    return share / share.sum(dim=-1, keepdim=True)


def best_clusters(points: Tensor, clusters: int, starts: int, generator: Generator, **settings: float) -> Clusters:
    """The clusters of lowest objective from some random partitions.

    Args:
        points: (M, D), of comparable scales.
        clusters: K.
        starts: random partitions.
        generator: source of chance.
        **settings: of `gustafson_kessel`.
    """
    at_once, best = max(VALUES_AT_ONCE // (len(points) * clusters), 1), []
    for first in range(0, starts, at_once):
        partition = random_partitions(min(at_once, starts - first), len(points), clusters, generator, points)
        found = gustafson_kessel(points, partition, **settings)  # type: ignore[arg-type]
        lowest = int(found.objective[:, -1].argmin())
        best.append(Clusters(*(one[lowest] for one in found)))
    return min(best, key=lambda one: float(one.objective[-1]))


def _moments(powers: Tensor, weight: Tensor, size: int) -> tuple[Tensor, Tensor]:
    """Weighted centres (S, K, D) and covariances (S, K, D, D), from all points' (1, z, z·zᵀ), one matrix product."""
    sums = weight.mT @ powers
    sums = sums / sums[..., :1].clamp_min(SMALLEST)
    centre = sums[..., 1 : 1 + size]
    square = sums[..., 1 + size :].unflatten(-1, (size, size))
    return centre, square - centre.unsqueeze(-1) * centre.unsqueeze(-2)


def _shapes(covariance: Tensor) -> Tensor:
    """(..., D, D) A = det(F)^{1/D}·F⁻¹.

    Raises:
        WorkError: a cluster has no extent in some direction.
    """
    factor, failed = torch.linalg.cholesky_ex(covariance)
    if bool(failed.any()):
        raise WorkError("a cluster has shrunk to a line or a point; take a larger regularisation, or fewer rules")
    root = factor.diagonal(dim1=-2, dim2=-1).log().mean(dim=-1).exp().square()
    return root[..., None, None] * torch.cholesky_inverse(factor)


def _distances(powers: Tensor, centre: Tensor, shape: Tensor) -> Tensor:
    """(S, M, K) squared distances, which are linear in (1, z, z·zᵀ)."""
    along = (shape @ centre.unsqueeze(-1)).squeeze(-1)
    constant = (along * centre).sum(dim=-1, keepdim=True)
    distance = powers @ torch.cat([constant, -2 * along, shape.flatten(-2)], dim=-1).mT
    return distance.clamp_min(0.0)
