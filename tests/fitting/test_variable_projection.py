"""Separable least squares: planted parameters come back, bounds hold, error bars mean what they say."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import pytest
import torch
from torch import Generator, Tensor

from zoo.fitting.prior import Prior
from zoo.fitting.projection import project
from zoo.fitting.variable_projection import STEP, Fit, _second_moment, fit

TIME = torch.linspace(0, 10, 600, dtype=torch.float64)
LOW, HIGH = 0.1, 30.0


def unit(tau: float) -> float:
    return math.log(tau / LOW) / math.log(HIGH / LOW)


def tau_of(theta: Tensor) -> Tensor:
    return LOW * torch.exp(theta * math.log(HIGH / LOW))


def decays(theta: Tensor) -> Tensor:
    """(B, P) → (B, N, P + 1): a decay for every time constant, and a constant."""
    shapes = torch.exp(-TIME.unsqueeze(-1) / tau_of(theta).unsqueeze(1))
    return torch.cat([shapes, torch.ones(len(theta), len(TIME), 1, dtype=torch.float64)], -1)


def planted(tau: tuple[float, ...], amplitudes: tuple[float, ...]) -> Tensor:
    theta = torch.tensor([[unit(one) for one in tau]], dtype=torch.float64)
    return decays(theta)[0] @ torch.tensor(amplitudes, dtype=torch.float64)


def at(*tau: float) -> Tensor:
    return torch.tensor([unit(one) for one in tau], dtype=torch.float64)


@pytest.mark.parametrize("start", [(0.2, 20.0), (1.0, 3.0), (0.5, 9.0)])
def test_a_sum_of_exponentials_is_taken_apart(start) -> None:
    found = fit(decays, planted((0.6, 4.0), (2.0, -1.5, 0.5)), at(*start), iterations=60, tolerance=1e-12)
    tau, order = tau_of(found.theta).sort()
    torch.testing.assert_close(tau, torch.tensor([0.6, 4.0], dtype=torch.float64), rtol=1e-4, atol=0)
    torch.testing.assert_close(found.amplitudes[:2][order], torch.tensor([2.0, -1.5], dtype=torch.float64), rtol=1e-3, atol=0)
    assert float(found.amplitudes[2]) == pytest.approx(0.5, rel=1e-3)
    assert found.cost < 1e-8
    assert 1 <= found.iterations <= 60


def test_a_last_bit_that_a_batch_rounds_otherwise_moves_nothing() -> None:
    """Whether a parameter moves a column decides what it is counted for; each row of a batch may be rounded in its own way."""

    def rounded(theta: Tensor) -> Tensor:
        last_bits = 1.0 + 2e-16 * torch.arange(len(theta), dtype=torch.float64)
        return decays(theta) * last_bits[:, None, None]

    found = fit(rounded, planted((0.6, 4.0), (2.0, -1.5, 0.5)), at(0.5, 5.0), iterations=20)
    assert found.moves.tolist() == [[True, False, False], [False, True, False]]


def test_the_fit_is_where_the_gradient_vanishes() -> None:
    """With noise: no small move of θ, amplitudes projected out, lowers the cost."""
    target = planted((0.6, 4.0), (2.0, -1.5, 0.5)) + 0.05 * torch.randn(600, generator=Generator().manual_seed(1), dtype=torch.float64)
    found = fit(decays, target, at(0.5, 5.0), iterations=100, tolerance=1e-14)
    for i in range(2):
        for move in (-3e-3, 3e-3):
            theta = found.theta.clone()
            theta[i] += move
            assert fit(decays, target, theta, iterations=0).cost > found.cost
    torch.testing.assert_close(found.residual, target - found.columns @ found.amplitudes, rtol=0, atol=1e-9)
    assert found.cost == pytest.approx(float(found.residual.square().sum()))
    assert float((found.columns.mT @ found.residual).abs().max()) < 1e-6, "amplitudes are those of least squares"
    assert float((found.tangent.mT @ found.residual).abs().max()) < 1e-2 * float(found.tangent.norm(dim=0).max())


@pytest.mark.parametrize(("outside", "bound"), [(100.0, 1.0), (0.01, 0.0)])
def test_bounds_hold_and_the_fit_rests_on_them(outside, bound) -> None:
    seen: list[Tensor] = []

    def watched(theta: Tensor) -> Tensor:
        seen.append(theta)
        return decays(theta)[..., :1]

    found = fit(watched, torch.exp(-TIME / outside), at(2.0), iterations=60, tolerance=1e-12)
    assert float(found.theta[0]) == bound
    assert not bool(found.tangent.any()), "its bound holds it back: to first order it explains nothing more"
    assert not bool(found.plain[:, 1:].any())
    assert all(float(theta.min()) >= 0 and float(theta.max()) <= 1 for theta in seen), "nothing was ever computed out of bounds"


@pytest.mark.parametrize(("bound", "side"), [(1.0, 1.0), (0.0, -1.0)], ids=["above", "below"])
@pytest.mark.parametrize("beyond", [0.5, 2.0, 6.0])
def test_how_far_what_fits_best_lies_beyond_the_bound(bound, side, beyond) -> None:
    """In standard deviations, as a fit would have it that knows of no bound."""
    accuracy, near = 1e-6, 1e-4
    edge, inside = (decays(torch.tensor([[theta]], dtype=torch.float64))[0, :, :1] / accuracy for theta in (bound, bound - side * near))
    change = (edge - inside)[:, 0] / near
    spread = 1.0 / float(project(edge, change).cost) ** 0.5
    target = decays(torch.tensor([[bound + side * beyond * spread]], dtype=torch.float64))[0, :, 0]
    found = fit(lambda theta: decays(theta)[..., :1] / accuracy, target / accuracy, at(2.0), iterations=60, tolerance=1e-12)
    assert float(found.theta[0]) == bound
    assert float(found.pressed[0]) == pytest.approx(side * beyond, rel=0.02)


def test_nothing_is_pressed_where_the_best_fit_lies_within() -> None:
    assert fit(decays, planted((0.6, 4.0), (2.0, -1.5, 0.5)), at(0.5, 5.0), iterations=60).pressed.tolist() == [0.0, 0.0]


def test_a_parameter_on_a_bound_does_not_hold_the_others_up() -> None:
    """The slow decay is slower than the bound allows; the fast one still goes where the profile of the cost is least."""

    def two(theta: Tensor) -> Tensor:
        return decays(theta)[..., :2]

    target = torch.exp(-TIME) + torch.exp(-TIME / 500.0)
    found = fit(two, target, at(5.0, 25.0), iterations=80, tolerance=1e-12)
    profile = {tau: fit(two, target, at(tau, HIGH), iterations=0).cost for tau in torch.linspace(0.3, 1.5, 241).tolist()}
    assert tau_of(found.theta).tolist() == [pytest.approx(min(profile, key=profile.__getitem__), abs=0.01), pytest.approx(HIGH)]
    assert found.cost <= min(profile.values()) * (1 + 1e-6)


def test_it_never_gets_worse_than_its_start() -> None:
    target = planted((0.6, 4.0), (2.0, -1.5, 0.5))
    for start in ((0.11, 0.12), (29.0, 28.0), (0.2, 20.0)):
        first = fit(decays, target, at(*start), iterations=0)
        assert first.iterations == 0
        torch.testing.assert_close(first.theta, at(*start))
        assert fit(decays, target, at(*start), iterations=5).cost <= first.cost


def test_a_bent_valley_is_followed_to_its_end() -> None:
    """Rosenbrock's (1960, Computer J. 3:175), from where it is started, as the residual of a linear model: 1 + (1 − x)² + 100·(y − x²)²."""

    def columns(theta: Tensor) -> Tensor:
        x, y = 4 * theta[:, 0] - 2, 4 * theta[:, 1] - 1
        return torch.stack([torch.ones_like(x), 1 - x, 10 * (y - x.square())], dim=-1).unsqueeze(-1)

    target, start = torch.tensor([1.0, 0.0, 0.0], dtype=torch.float64), torch.tensor([0.2, 0.5], dtype=torch.float64)
    found = fit(columns, target, start, tolerance=1e-12)
    torch.testing.assert_close(found.theta, torch.tensor([0.75, 0.5], dtype=torch.float64), rtol=0, atol=1e-6)
    assert found.iterations <= 20


def test_one_parameter_that_misleads_does_not_hold_the_others_up() -> None:
    """A jagged one, which is steep and leads nowhere."""
    time = torch.linspace(0, 1, 400, dtype=torch.float64)

    def columns(theta: Tensor) -> Tensor:
        centre, jagged = theta[:, :1], 100.0 * theta[:, 1:]
        return (torch.exp(-(((time - centre) / 0.15) ** 2)) + 0.3 * (jagged - jagged.floor()) * torch.cos(9 * time)).unsqueeze(-1)

    noise = torch.randn(400, dtype=torch.float64, generator=Generator().manual_seed(0))
    target = 50.0 * columns(torch.tensor([[0.6, 0.4]], dtype=torch.float64))[0, :, 0] + noise
    for start in ((0.45, 0.5), (0.4, 0.72), (0.7, 0.13), (0.5, 0.9)):
        found = fit(columns, target, torch.tensor(start, dtype=torch.float64))
        assert found.total < float(noise.square().sum()) + 10.0
        assert found.iterations <= 8


def test_without_nonlinear_parameters_it_is_plain_least_squares() -> None:
    columns = torch.randn(50, 3, generator=Generator().manual_seed(1), dtype=torch.float64)
    truth = torch.tensor([1.0, -2.0, 3.0], dtype=torch.float64)
    found = fit(lambda theta: columns.expand(len(theta), -1, -1), columns @ truth, torch.zeros(0, dtype=torch.float64))
    torch.testing.assert_close(found.amplitudes, truth, rtol=1e-8, atol=0)
    assert found.tangent.shape == (50, 0)
    assert found.covariance().shape == (3, 3)


def test_a_step_into_nonsense_is_not_taken() -> None:
    def broken(theta: Tensor) -> Tensor:
        columns = decays(theta)
        return torch.where((theta[:, :1] > 0.5).unsqueeze(-1), torch.nan, columns)

    found = fit(broken, planted((4.0,), (1.0, 0.0)), torch.tensor([0.3], dtype=torch.float64))
    assert float(found.theta[0]) <= 0.5
    assert math.isfinite(found.cost)


def test_where_every_step_is_nonsense_the_start_is_kept() -> None:
    def only_there(theta: Tensor) -> Tensor:
        return torch.where(((theta - 0.3).abs() > 2 * STEP).unsqueeze(-1), torch.nan, decays(theta))

    found = fit(only_there, planted((4.0,), (1.0, 0.0)), torch.tensor([0.3], dtype=torch.float64))
    assert (float(found.theta[0]), found.iterations) == (pytest.approx(0.3), 0)
    assert math.isfinite(found.cost)


@pytest.mark.parametrize("theta", [0.2, 0.5, 0.9, 0.0, 1.0])
def test_tangents_are_derivatives_and_never_leave_the_bounds(theta) -> None:
    inside: list[Tensor] = []

    def watched(where: Tensor) -> Tensor:
        inside.append(where)
        return decays(where)

    amplitudes = torch.tensor([2.0, 1.0], dtype=torch.float64)
    where = torch.tensor([theta], dtype=torch.float64)
    weights = torch.linspace(0.5, 2.0, len(TIME), dtype=torch.float64).unsqueeze(1)
    target = weights.squeeze(1) * (decays(where.unsqueeze(0))[0] @ amplitudes)
    found = fit(watched, target, where, iterations=0, weigh=lambda columns: weights * columns)
    torch.testing.assert_close(found.amplitudes, amplitudes)
    torch.testing.assert_close(torch.cat([found.columns, found.tangent], dim=1), weights * found.plain)
    columns, slope = found.plain.split([2, 1], dim=1)
    torch.testing.assert_close(columns, decays(where.unsqueeze(0))[0])
    _, expected = torch.func.jvp(lambda t: decays(t.unsqueeze(0))[0] @ amplitudes, (where,), (torch.ones_like(where),))
    torch.testing.assert_close(slope[:, 0], expected, rtol=0, atol=20 * STEP)
    assert all(float(one.min()) >= 0 and float(one.max()) <= 1 for one in inside)


# Error bars

TRUTH = ((2.0,), (1.0, 0.3))
SIGMA = 0.05


def plain_errors(found: Fit) -> Tensor:
    """The textbook's standard errors of (θ, amplitudes): s²·(JᵀJ)⁻¹."""
    jacobian = torch.cat([found.tangent, found.columns], 1)
    scale = found.cost / (len(found.residual) - jacobian.shape[1])
    return (scale * torch.linalg.inv(jacobian.mT @ jacobian)).diagonal().sqrt()


def coverage(noise: Callable[[Generator], Tensor], fits: int = 200) -> tuple[Tensor, Tensor, Tensor]:
    """Share of fits whose 95 % interval holds the truth, for θ and each amplitude, by `covariance` and by the plain formula; estimates (F, 3)."""
    truth = torch.cat([at(*TRUTH[0]), torch.tensor(TRUTH[1], dtype=torch.float64)])
    clean, chance = planted(*TRUTH) / SIGMA, Generator().manual_seed(1)
    ours, plain, estimates = [], [], []
    for _ in range(fits):
        found = fit(lambda theta: decays(theta) / SIGMA, clean + noise(chance), at(1.0), tolerance=1e-9)
        estimate = torch.cat([found.theta, found.amplitudes])
        ours.append((estimate - truth).abs() < 1.96 * found.covariance().diagonal().sqrt())
        plain.append((estimate - truth).abs() < 1.96 * plain_errors(found))
        estimates.append(estimate)
    return torch.stack(ours).double().mean(0), torch.stack(plain).double().mean(0), torch.stack(estimates)


def white(chance: Generator) -> Tensor:
    return torch.randn(len(TIME), generator=chance, dtype=torch.float64)


def autoregressive(chance: Generator) -> Tensor:
    """Unit variance, correlation 0.7 from sample to sample."""
    kicks, state, states = white(chance), 0.0, []
    for kick in kicks.tolist():
        state = 0.7 * state + math.sqrt(1 - 0.7**2) * kick
        states.append(state)
    return torch.tensor(states, dtype=torch.float64)


def test_with_white_noise_95_percent_intervals_hold_the_truth_as_often() -> None:
    covered, plain, estimates = coverage(white)
    assert bool(((covered >= 0.90) & (covered <= 0.99)).all()), covered
    assert bool((covered >= plain).all()), "never smaller than the ordinary formula"
    truth = torch.cat([at(*TRUTH[0]), torch.tensor(TRUTH[1], dtype=torch.float64)])
    bias = (estimates.mean(0) - truth).abs() / (estimates.std(0) / math.sqrt(len(estimates)))
    assert bool((bias < 4).all()), "and the estimates scatter about the truth"


def test_with_correlated_noise_the_robust_intervals_cover_better_than_the_plain_ones() -> None:
    covered, plain, _ = coverage(autoregressive)
    assert bool((covered > plain + 0.06).all()), (covered, plain)
    assert bool((covered > 0.78).all()), covered
    assert float(plain.max()) < 0.75, "the plain formula is badly wrong here"


def test_error_bars_scale_with_the_noise_but_never_below_what_was_assumed() -> None:
    """The target is whitened: a residual smaller than 1 is luck, a larger one widens the intervals."""
    noise, clean = white(Generator().manual_seed(3)), planted(*TRUTH) / SIGMA
    errors = [fit(lambda t: decays(t) / SIGMA, clean + size * noise, at(2.0)).covariance().diagonal().sqrt() for size in (0.01, 1.0, 4.0)]
    assert bool((errors[2] > 3 * errors[1]).all())
    assert bool((errors[0] > 0.7 * errors[1]).all())


@pytest.mark.parametrize(("samples", "pieces"), [(10, 10), (30, 15), (240, 24), (250, 23)])
def test_the_error_of_a_mean_is_that_of_its_pieces(samples: int, pieces: int) -> None:
    """G/(G − 1)·Σ(sum of residuals in a piece)²/N², with as many pieces as there are (Liang & Zeger 1986 with the usual correction for few)."""
    level = 5.0 * torch.randn(samples, generator=Generator().manual_seed(1), dtype=torch.float64).cumsum(0)
    found = fit(lambda theta: torch.ones(len(theta), samples, 1, dtype=torch.float64), level, torch.zeros(0, dtype=torch.float64))
    size = -(-samples // pieces)
    sums = torch.stack([piece.sum() for piece in (level - level.mean()).split(size)])
    assert len(sums) == pieces
    assert float(found.covariance()) == pytest.approx(pieces / (pieces - 1) * float(sums.square().sum()) / samples**2, rel=1e-9)


def test_a_single_sample_has_no_error_but_that_assumed() -> None:
    one = torch.ones(1, dtype=torch.float64)
    assert float(fit(lambda theta: torch.ones(len(theta), 1, 1, dtype=torch.float64), one, one[:0]).covariance()) == pytest.approx(1.0)


def test_the_covariance_is_symmetric_and_positive() -> None:
    found = fit(lambda t: decays(t) / SIGMA, planted(*TRUTH) / SIGMA + white(Generator().manual_seed(3)), at(2.0))
    covariance = found.covariance()
    torch.testing.assert_close(covariance, covariance.mT)
    scale = covariance.diagonal().sqrt()
    assert float(torch.linalg.eigvalsh(covariance / scale / scale.unsqueeze(1)).min()) > 0
    assert float((covariance / scale / scale.unsqueeze(1)).abs().max()) <= 1 + 1e-9


def test_a_parameter_without_influence_has_no_error_bar() -> None:
    def deaf(theta: Tensor) -> Tensor:
        return decays(theta[:, :1])

    found = fit(deaf, planted(*TRUTH) / SIGMA + white(Generator().manual_seed(3)), torch.tensor([unit(2.0), 0.5], dtype=torch.float64))
    errors = found.covariance().diagonal()
    assert math.isnan(float(errors[1]))
    assert bool(torch.isfinite(errors[[0, 2, 3]]).all())


def test_a_parameter_that_moves_nothing_but_digits_leaves_the_error_bars_of_the_others() -> None:
    """Its prior is all that is known of it."""
    width = 0.5

    def hard_of_hearing(theta: Tensor) -> Tensor:
        return decays(theta[:, :1]) * (1.0 + 1e-9 * theta[:, 1:].unsqueeze(-1))

    target = planted(*TRUTH) / SIGMA + white(Generator().manual_seed(3))
    start, of_second = torch.tensor([unit(2.0), 0.5], dtype=torch.float64), torch.tensor([0.0, width**-2], dtype=torch.float64)
    found = fit(lambda t: hard_of_hearing(t) / SIGMA, target, start, prior=Prior(torch.full((2,), 0.5, dtype=torch.float64), of_second))
    assert 0 < float(found.jacobian[:, 1].norm()) < 1e-6, "not quite deaf"
    errors = found.covariance().diagonal().sqrt()
    alone = fit(lambda t: decays(t) / SIGMA, target, at(2.0)).covariance().diagonal().sqrt()
    torch.testing.assert_close(errors[[0, 2, 3]], alone, rtol=1e-3, atol=0)
    assert float(errors[1]) == pytest.approx(width, rel=0.1)


@pytest.mark.parametrize("beyond", [0.0, 0.3, 1.0, 5.0, 30.0, 99.0, 101.0, 1e5])
def test_the_second_moment_of_a_normal_distribution_cut_off_is_that_of_a_sum(beyond: float) -> None:
    reach = 40.0 / (1.0 + beyond)
    x = torch.linspace(0.0, reach, 400_001, dtype=torch.float64)
    density = torch.exp(-beyond * x - x.square() / 2)
    expected = torch.trapezoid(x.square() * density, x) / torch.trapezoid(density, x)
    found = _second_moment(torch.tensor(beyond, dtype=torch.float64))
    assert float(found) == pytest.approx(float(expected), rel=1e-3)


def test_a_bound_hides_no_uncertainty() -> None:
    """A time constant near its bound: half of the fits end there, and what goes with it may yet be what it is a little inside."""
    truth, amplitudes, count = 24.0, (1.0, 0.3), 200
    generator, target = Generator().manual_seed(8), planted((truth,), amplitudes) / SIGMA
    inside, held, as_if_known = [], 0, []
    for _ in range(count):
        found = fit(lambda t: decays(t) / SIGMA, target + white(generator), at(10.0), prior=Prior(*torch.zeros(2, 1, dtype=torch.float64)))
        off = (found.amplitudes - torch.tensor(amplitudes, dtype=torch.float64)).abs()
        known = torch.linalg.inv(found.columns.mT @ found.columns).diagonal().sqrt()
        at_bound = bool(found.edge.any())
        held += at_bound
        inside.append(off < 1.96 * found.covariance().diagonal()[1:].sqrt())
        as_if_known += [off < 1.96 * known] if at_bound else []
    assert held > count / 5
    assert float(torch.stack(as_if_known).double().mean()) < 0.8, "what error bars for a known time constant would cover"
    covered = torch.stack(inside).double().mean(0)
    assert bool((covered >= 0.9).all()), covered


def test_what_only_two_together_determine_has_no_error_bar() -> None:
    """Of two columns that are the same only the sum is known; what they cannot stand for keeps its own."""

    def doubled(theta: Tensor) -> Tensor:
        columns = decays(theta) / SIGMA
        return torch.cat([columns, 3.0 * columns[..., -1:]], dim=-1)

    target = planted(*TRUTH) / SIGMA + white(Generator().manual_seed(3))
    errors = fit(doubled, target, at(2.0)).covariance().diagonal()
    assert errors.isnan().tolist() == [False, False, True, True]
    alone = fit(lambda t: decays(t) / SIGMA, target, at(2.0)).covariance().diagonal()
    torch.testing.assert_close(errors[:2], alone[:2], rtol=1e-6, atol=0)


def test_a_parameter_that_hardly_matters_within_its_bounds_is_no_freedom() -> None:
    """A hundredth of the noise over its whole range: to first order, a hundred times that range would stand for something as large as the noise."""

    def deaf(theta: Tensor) -> Tensor:
        return decays(theta[:, :1]) * (1.0 + 1e-3 * theta[:, 1:].unsqueeze(-1)) / SIGMA

    start = torch.tensor([unit(2.0), 0.5], dtype=torch.float64)
    found = fit(deaf, planted(*TRUTH) / SIGMA + white(Generator().manual_seed(3)), start)
    assert 0 < float(found.jacobian[:, 1].norm()) < 1.0
    assert not bool(found.tangent[:, 1].any())
    assert bool(found.tangent[:, 0].any())


def test_a_parameter_at_its_bound_that_others_can_stand_for_leaves_finite_error_bars() -> None:
    """Its column is there already: nothing tells how far inside it may be."""

    def redundant(theta: Tensor) -> Tensor:
        return decays(theta[:, :1]) * torch.stack([torch.ones_like(theta[:, 1]), 1.0 + theta[:, 1]], dim=-1).unsqueeze(1) / SIGMA

    start = torch.tensor([unit(2.0), 0.0], dtype=torch.float64)
    found = fit(redundant, planted(*TRUTH) / SIGMA + white(Generator().manual_seed(3)), start)
    assert bool(torch.isfinite(found.covariance().diagonal()[[0, 2]]).all())


def _left(found: Fit, target: Tensor, held: bool) -> float:
    """χ² that amplitudes and tangents leave, free or held back, less what the prior charges for where θ is."""
    joined = torch.cat([found.plain, target.unsqueeze(1)], dim=1)
    joined = torch.cat([joined, found.held]) if held else joined
    return float(project(joined[:, :-1], joined[:, -1]).cost) - (float(found.held[:, -1].square().sum()) if held else 0.0)


def test_tangents_are_held_to_what_the_prior_or_the_bounds_allow() -> None:
    """At the solution nothing is gained by moving on; what lies many ranges along a tangent is not accounted for, what lies within them is."""
    target = planted((0.6, 4.0), (2.0, -1.5, 0.5)) + 0.02 * torch.randn(600, generator=Generator().manual_seed(1), dtype=torch.float64)
    prior = Prior(torch.tensor([0.5, 0.5], dtype=torch.float64), torch.tensor([400.0, 0.0], dtype=torch.float64))
    scaled, weigh = target / 0.02, lambda columns: columns / 0.02
    found = fit(decays, scaled, at(0.5, 5.0), iterations=100, tolerance=1e-14, weigh=weigh, prior=prior)
    assert found.moved > 1.0, "the prior pulls"
    found = replace(found, plain=weigh(found.plain))
    assert _left(found, scaled, held=True) == pytest.approx(found.cost, rel=1e-6)
    for along in range(2):
        tangent = found.plain[:, 3 + along]
        near, far = (scaled + ranges * tangent for ranges in (0.02, 5.0))
        assert _left(found, far, held=False) < 1.01 * found.cost
        assert _left(found, far, held=True) > found.cost + 5.0**2 * (400.0, 12.0)[along] * 0.5
        assert _left(found, near, held=True) < found.cost + 0.03**2 * 400.0 + 2 * 0.02 * (found.moved * 400.0) ** 0.5


def test_a_parameter_at_rest_on_its_bound_has_no_row() -> None:
    found = fit(decays, planted((0.6, 100.0), (2.0, -1.5, 0.5)), at(0.5, 20.0), iterations=60)
    assert float(found.theta[1]) == 1.0
    assert not bool(found.held[1].any())
    assert float(found.held[0, 3]) == pytest.approx(12.0**0.5)
