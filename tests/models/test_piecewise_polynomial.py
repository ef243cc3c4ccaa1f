"""Polynomials by segments: planted ones come back, edges are found where they are, and continuous means continuous."""

from __future__ import annotations

import itertools

import pytest
import torch
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.models.piecewise_polynomial import PiecewisePolynomial
from zoo.models.polynomial import Polynomial
from zoo.models.segmentation import best_edges
from zoo.training.least_squares import solve
from zoo.training.population import Population
from zoo.training.weights import reset, set_weights, weight_vector

BOTH = ["temperature", "temperature_rate"]
EDGES = [0.0, 15.0, 30.0, 37.0]


def features(samples: int = 800, seed: int = 1, low: float = -15.0, high: float = 50.0) -> Tensor:
    """(M, 2) temperatures over the range of tong2019 and lively rates, in no order."""
    chance = Generator().manual_seed(seed)
    place = low + (high - low) * torch.rand(samples, generator=chance, dtype=torch.float64)
    return torch.stack([place, torch.randn(samples, generator=chance, dtype=torch.float64)], dim=-1)


def fitted(model: PiecewisePolynomial | Polynomial, given: Tensor, error: Tensor) -> PiecewisePolynomial | Polynomial:
    """By least squares, as `LeastSquares` does it for runs."""
    model.standardise(given, error)
    offset, columns = Population(model, given).affine()
    set_weights(model, solve(columns.T, error - offset))
    return model


def physical(polynomial: dict[str, float], given: Tensor) -> Tensor:
    """(M,) of `coefficients`, evaluated as they read."""
    columns = {"temperature": given[:, 0], "temperature_rate": given[:, 1]}
    total = torch.full_like(given[:, 0], polynomial["1"])
    for key, value in polynomial.items():
        name, _, power = key.partition("^")
        total = total + (0 if key == "1" else value * columns[name] ** int(power or 1))
    return total


def planted(given: Tensor, edges: list[float], seed: int = 3) -> tuple[Tensor, list[dict[str, float]]]:
    """A cubic of temperature and a square of the rate in each segment."""
    chance = Generator().manual_seed(seed)
    names = ["1", "temperature", "temperature^2", "temperature^3", "temperature_rate", "temperature_rate^2"]
    scale = torch.tensor([1.0, 0.05, 1e-3, 2e-5, 0.3, 0.1], dtype=torch.float64)
    every = [dict(zip(names, (scale * torch.randn(6, generator=chance, dtype=torch.float64)).tolist(), strict=True)) for _ in range(len(edges) + 1)]
    segment = torch.bucketize(given[:, 0].contiguous(), torch.tensor(edges, dtype=torch.float64), right=True)
    values = torch.stack([physical(one, given) for one in every])
    return values.gather(0, segment.unsqueeze(0))[0], every


def polynomials(model: PiecewisePolynomial) -> list[dict[str, float]]:
    return [segment["coefficients"] for segment in model.formula()["segments"]]


def test_planted_coefficients_come_back_segment_by_segment() -> None:
    given = features()
    error, expected = planted(given, EDGES)
    model = fitted(PiecewisePolynomial(BOTH, EDGES), given, error)
    torch.testing.assert_close(model.head(given), error, rtol=0, atol=1e-9)
    assert [segment["temperature"] for segment in model.formula()["segments"]] == [list(ends) for ends in itertools.pairwise([None, *EDGES, None])]
    for found, wanted in zip(polynomials(model), expected, strict=True):
        for name, value in found.items():
            assert value == pytest.approx(wanted.get(name, 0.0), rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("continuous", [False, True])
def test_the_physical_coefficients_are_the_model_also_beyond_the_data(continuous: bool) -> None:
    model = PiecewisePolynomial(BOTH, EDGES, continuous=continuous)
    reset(model, Generator().manual_seed(1))
    set_weights(model, torch.randn(len(weight_vector(model)), generator=Generator().manual_seed(2), dtype=torch.float64))
    given = features()
    model.standardise(given, torch.sin(given[:, 0]))
    wide = features(seed=2, low=-40.0, high=80.0)
    segment = torch.bucketize(wide[:, 0].contiguous(), model.edges, right=True)
    expected = torch.stack([physical(one, wide) for one in polynomials(model)]).gather(0, segment.unsqueeze(0))[0]
    torch.testing.assert_close(model.head(wide).detach(), expected, rtol=1e-9, atol=1e-9)


def test_one_segment_is_the_polynomial() -> None:
    given = features()
    error = torch.sin(given[:, 0] / 9) + 0.3 * given[:, 1] ** 3
    for edges, segments in (([], 5), (None, 1)):
        for continuous in (False, True):
            one = fitted(PiecewisePolynomial(BOTH, edges, segments, 3, 2, continuous), given, error)
            torch.testing.assert_close(one.head(given), fitted(Polynomial(BOTH, 3, 2), given, error).head(given), rtol=1e-9, atol=1e-9)


def test_segments_that_do_not_share_are_fitted_as_if_alone() -> None:
    given = features()
    error = torch.sin(given[:, 0] / 9) + 0.3 * given[:, 1] ** 3
    model = fitted(PiecewisePolynomial(BOTH, EDGES), given, error)
    here = (given[:, 0] >= 15) & (given[:, 0] < 30)
    alone = fitted(Polynomial(BOTH, 4, 4), given[here], error[here])
    torch.testing.assert_close(model.head(given[here]), alone.head(given[here]), rtol=1e-8, atol=1e-8)


def test_continuous_is_continuous_at_any_rate_and_the_rest_is_not() -> None:
    given = features()
    error = torch.sin(given[:, 0] / 4) + given[:, 0].gt(15) * 0.5 + given[:, 0].gt(30) * given[:, 1]
    jumps = {}
    for continuous in (False, True):
        model = fitted(PiecewisePolynomial(BOTH, EDGES, continuous=continuous), given, error)
        edge = torch.stack([model.edges.repeat(5), torch.linspace(-2, 2, 5, dtype=torch.float64).repeat_interleave(4)], dim=-1)
        below = edge - torch.tensor([1e-9, 0.0], dtype=torch.float64)
        jumps[continuous] = float((model.head(edge) - model.head(below)).detach().abs().max())
    assert jumps[True] < 1e-7
    assert jumps[False] > 0.1


def test_continuous_reaches_every_continuous_function_of_its_kind() -> None:
    """Truncated powers (u − e)_+^k are the textbook's basis of these functions (de Boor 1978, ch. VIII)."""
    given = features()
    place = given[:, :1]
    cut = (place - torch.tensor(EDGES, dtype=torch.float64)).clamp_min(0.0)
    basis = torch.cat([place ** torch.arange(5), *(cut**k for k in range(1, 5)), given[:, 1:] ** torch.arange(1, 5)], dim=-1)
    error = (basis / basis.norm(dim=0)) @ torch.randn(basis.shape[1], generator=Generator().manual_seed(4), dtype=torch.float64)
    model = PiecewisePolynomial(BOTH, EDGES, continuous=True)
    assert len(weight_vector(model)) == basis.shape[1]
    torch.testing.assert_close(fitted(model, given, error).head(given), error, rtol=0, atol=1e-9)


@pytest.mark.parametrize("continuous", [False, True])
def test_kinks_are_found_to_a_candidate(continuous: bool) -> None:
    """What a kink of 0.2/K that stands one candidate off leaves is no more than 0.2 times that distance."""
    given = features(2000)
    place = given[:, 0]
    truth = 0.02 * place - 0.1 * (place - 5).clamp_min(0) + 0.2 * (place - 33).clamp_min(0) + 0.1 * given[:, 1]
    error = truth + 0.02 * torch.randn(2000, generator=Generator().manual_seed(5), dtype=torch.float64)
    model = fitted(PiecewisePolynomial(BOTH, None, 3, 1, 1, continuous), given, error)
    assert model.edges.tolist() == pytest.approx([5.0, 33.0], abs=65 / 64)
    assert float((model.head(given) - truth).detach().abs().max()) < 0.2 * 65 / 64


def test_no_choice_of_candidates_leaves_less() -> None:
    """Against all pairs of edges between samples, each segment solved by itself."""
    chance = Generator().manual_seed(6)
    place = torch.rand(40, generator=chance, dtype=torch.float64).sort().values
    target = torch.sin(12 * place) + 0.1 * torch.randn(40, generator=chance, dtype=torch.float64)
    columns = torch.stack([torch.ones_like(place), place, place.square()], dim=-1)

    def left(start: int, stop: int) -> float:
        part = columns[start:stop]
        return float((target[start:stop] - part @ solve(part, target[start:stop])).square().sum())

    pairs = [(i, j) for i, j in itertools.combinations(range(41), 2) if min(i, j - i, 40 - j) >= 5]
    first, second = min(pairs, key=lambda pair: left(0, pair[0]) + left(*pair) + left(pair[1], 40))
    order = torch.randperm(40, generator=chance)
    edges = best_edges(place[order], columns[order], target[order], 3, least=5)
    assert edges.tolist() == pytest.approx([float(place[i - 1 : i + 1].mean()) for i in (first, second)])


def test_a_column_that_stands_still_in_a_segment_takes_up_no_noise() -> None:
    """A hold has no rate: the optimum is that without the column, in which columns of rounding errors must have no part."""
    chance = Generator().manual_seed(7)
    place = torch.linspace(0, 1, 60, dtype=torch.float64)
    target = place.gt(0.5).double() + 0.1 * torch.randn(60, generator=chance, dtype=torch.float64)
    columns = torch.stack([torch.ones_like(place), place], dim=-1)
    still = 0.1 + 1e-17 * torch.randn(60, 3, generator=chance, dtype=torch.float64)
    assert torch.equal(best_edges(place, columns, target, 4, 8), best_edges(place, torch.cat([columns, still], dim=-1), target, 4, 8))


def test_equal_temperatures_are_never_cut_apart() -> None:
    given = features(600)
    given[:, 0] = (given[:, 0] / 5).round() * 5
    model = PiecewisePolynomial(BOTH, None, 3, 1, 1)
    model.standardise(given, torch.sin(given[:, 0] / 5))
    assert all(abs(edge % 5 - 2.5) < 1e-9 for edge in model.edges.tolist())


def test_a_record_at_one_temperature_gives_its_mean() -> None:
    given = torch.full((50, 2), 20.0, dtype=torch.float64)
    given[:, 1] = 0.0
    model = fitted(PiecewisePolynomial(BOTH, []), given, torch.full((50,), 0.7, dtype=torch.float64))
    torch.testing.assert_close(model.head(given), torch.full((50,), 0.7, dtype=torch.float64), rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"edges": [0.0, 30.0, 15.0]}, r"model.edges=\[0.0, 30.0, 15.0\]: ascending"),
        ({"edges": [0.0, float("nan")]}, "ascending"),
        ({"edges": [0, "x"]}, "ascending"),
        ({"edges": 15}, r"model\.edges=15: ascending"),
        ({"segments": 0}, "segments=0: a whole number"),
        ({"segments": 2.5}, r"segments=2\.5: a whole number"),
        ({"order": 0}, "order=0"),
    ],
)
def test_impossible_segments_are_named(settings, message) -> None:
    with pytest.raises(InputError, match=message):
        PiecewisePolynomial(BOTH, **settings)


def test_what_the_data_leave_open_is_named() -> None:
    given = features(200, high=36.9)
    with pytest.raises(InputError, match=r"segment 37 … ∞ has 0 samples for 9 coefficients.*from -14.6513 to 36.8869: move or leave out an edge"):
        PiecewisePolynomial(BOTH, EDGES).standardise(given, given[:, 0])
    with pytest.raises(InputError, match="segment 37 … ∞ has 0 samples for 4"):
        PiecewisePolynomial(BOTH, EDGES, continuous=True).standardise(given, given[:, 0])
    with pytest.raises(InputError, match=r"segments=12: 200 samples do not make 12 segments of at least 18"):
        PiecewisePolynomial(BOTH, segments=12).standardise(given, given[:, 0])


def test_the_weights_of_a_part_change_what_its_samples_see_and_nothing_else() -> None:
    given, chance = features(), Generator().manual_seed(1)
    for model in (PiecewisePolynomial(BOTH, EDGES, order=3, rate_order=2), PiecewisePolynomial(BOTH, EDGES, order=3, rate_order=2, continuous=True)):
        model.standardise(given, given[:, 0])
        places, part = model.parts(given)
        assert sorted(places.flatten().tolist()) == list(range(len(weight_vector(model))))
        for group, own in enumerate(places):
            weights = torch.zeros(2, len(weight_vector(model)), dtype=torch.float64)
            weights[1, own] = torch.randn(len(own), generator=chance, dtype=torch.float64)
            changed = Population(model, given).outputs(weights).diff(dim=0)[0] != 0
            assert bool(changed[part == group].any())
            assert not bool(changed[part != group].any())
    assert len(PiecewisePolynomial(BOTH, EDGES).parts(given)[0]) == len(EDGES) + 1
