"""Fuzzy clusters: planted ones come back, and the laws of the algorithm hold."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Generator, Tensor

from zoo.errors import WorkError
from zoo.training.fuzzy_clusters import _shapes, best_clusters, gustafson_kessel, random_partitions


def planted(samples: int = 400) -> tuple[Tensor, Tensor]:
    """Two clusters 20 times as long as wide that cross at right angles, and which of them each point is of."""
    chance = torch.randn(samples, 2, generator=Generator().manual_seed(1), dtype=torch.float64) * torch.tensor([4.0, 0.2], dtype=torch.float64)
    of_second = torch.arange(samples) % 2 == 1
    angle = torch.where(of_second, math.radians(120), math.radians(30)).double()
    turned = torch.stack([chance[:, 0] * angle.cos() - chance[:, 1] * angle.sin(), chance[:, 0] * angle.sin() + chance[:, 1] * angle.cos()], dim=-1)
    return turned + torch.tensor([3.0, -5.0], dtype=torch.float64), of_second


def agreement(membership: Tensor, of_second: Tensor) -> float:
    share = float((membership.argmax(dim=-1).bool() == of_second).double().mean())
    return max(share, 1 - share)


def fuzzy_c_means(points: Tensor, partition: Tensor) -> Tensor:
    """Bezdek 1981, m = 2: the same with spheres."""
    membership = partition
    for _ in range(200):
        weight = membership.square()
        centre = (weight.T @ points) / weight.sum(dim=0).unsqueeze(1)
        membership = 1 / torch.cdist(points, centre).square()
        membership = membership / membership.sum(dim=-1, keepdim=True)
    return membership


def test_long_clusters_at_an_angle_are_found_where_spheres_fail() -> None:
    points, of_second = planted()
    found = best_clusters(points, 2, 5, Generator().manual_seed(1))
    spheres = fuzzy_c_means(points, random_partitions(1, len(points), 2, Generator().manual_seed(1), points)[0])
    assert agreement(found.membership, of_second) > 0.9
    assert agreement(spheres, of_second) < 0.75
    values, vectors = torch.linalg.eigh(found.covariance)
    assert float((values[:, 1] / values[:, 0]).sqrt().min()) > 8
    angles = sorted(math.degrees(math.atan2(float(axis[1]), float(axis[0]))) % 180 for axis in vectors[..., 1])
    assert angles == pytest.approx([30, 120], abs=1.5)
    torch.testing.assert_close(found.centre, torch.tensor([[3.0, -5.0]] * 2, dtype=torch.float64), rtol=0, atol=0.5)


@pytest.mark.parametrize("regularisation", [1e-12, 1e-6, 1e-2, 0.5])
@pytest.mark.parametrize("fuzziness", [1.5, 2.0, 3.0])
def test_the_objective_never_rises_and_memberships_sum_to_one(regularisation: float, fuzziness: float) -> None:
    points, _ = planted(100)
    start = random_partitions(8, 100, 4, Generator().manual_seed(2), points)
    found = gustafson_kessel(points, start, regularisation=regularisation, fuzziness=fuzziness, tolerance=1e-9, iterations=150)
    course = found.objective
    assert float((torch.diff(course, dim=-1) / course[:, :-1]).max()) < 1e-9
    assert bool((course[:, -1] < course[:, 0]).all())
    torch.testing.assert_close(found.membership.sum(dim=-1), torch.ones(8, 100, dtype=torch.float64), rtol=0, atol=1e-12)


def test_starts_side_by_side_are_those_alone() -> None:
    points, _ = planted(150)
    start = random_partitions(4, 150, 3, Generator().manual_seed(3), points)
    together = gustafson_kessel(points, start)
    for k in range(4):
        alone = gustafson_kessel(points, start[k : k + 1])
        torch.testing.assert_close(together.membership[k], alone.membership[0], rtol=1e-9, atol=1e-12)
        assert float(together.objective[k, -1]) == pytest.approx(float(alone.objective[0, -1]), rel=1e-9)


def test_units_and_turns_of_the_space_do_not_matter() -> None:
    """A norm that adapts to each cluster knows no other (Gustafson & Kessel 1979), but for the regularisation."""
    points, _ = planted(150)
    start = random_partitions(2, 150, 2, Generator().manual_seed(4), points)
    other = points @ torch.tensor([[3.0, -1.0], [0.5, 0.02]], dtype=torch.float64) + 7
    settings = {"regularisation": 1e-13, "iterations": 60}
    one, two = gustafson_kessel(points, start, **settings), gustafson_kessel(other, start, **settings)
    torch.testing.assert_close(one.membership, two.membership, rtol=0, atol=1e-6)


def test_where_it_ends_centre_and_covariance_are_those_of_its_memberships() -> None:
    points, _ = planted()
    found = gustafson_kessel(points, random_partitions(1, 400, 2, Generator().manual_seed(5), points), tolerance=1e-12, regularisation=1e-9)
    weight = found.membership[0].square()
    for k in range(2):
        share = weight[:, k] / weight[:, k].sum()
        centre = share @ points
        torch.testing.assert_close(found.centre[0, k], centre, rtol=1e-9, atol=1e-9)
        covariance = (points - centre).T @ (share.unsqueeze(1) * (points - centre))
        torch.testing.assert_close(found.covariance[0, k], covariance, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    "points",
    [
        torch.linspace(-1, 1, 40).double().unsqueeze(1) * torch.tensor([1.0, 2.0, -0.5]).double(),  # all on one line
        torch.tensor([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]).double(),  # fewer than a covariance takes
        torch.tensor([[2.0, 3.0]]).double().repeat(30, 1),  # all the same
    ],
)
def test_points_that_span_nothing_are_borne(points: Tensor) -> None:
    found = best_clusters(points, 3, 4, Generator().manual_seed(1))
    for one in found:
        assert bool(torch.isfinite(one).all())
    torch.testing.assert_close(found.membership.sum(dim=-1), torch.ones(len(points), dtype=torch.float64))


def test_partitions_are_even_over_all_that_sum_to_one() -> None:
    """Of a point that is shared by K clusters evenly at random, each has a beta distribution: mean 1/K, variance (K − 1)/(K²(K + 1))."""
    drawn = random_partitions(2, 20000, 4, Generator().manual_seed(1), torch.zeros(1, dtype=torch.float64))
    torch.testing.assert_close(drawn.sum(dim=-1), torch.ones(2, 20000, dtype=torch.float64))
    assert float(drawn.mean()) == pytest.approx(1 / 4)
    assert float(drawn.var()) == pytest.approx(3 / (16 * 5), rel=0.02)


def test_a_cluster_without_extent_is_told() -> None:
    with pytest.raises(WorkError, match="shrunk to a line or a point"):
        _shapes(torch.zeros(1, 2, 2, dtype=torch.float64))
