"""The noise level from the data, and whitening with a noise model."""

from __future__ import annotations

import math

import pytest
import torch
from torch import Generator, Tensor

from zoo.scoring.noise import WHITENED_AT_ONCE, Blocks, NoiseModel, Whitener, effective_samples, white_level

BLOCK_S = 100.0
SIGMA = 0.008


def normal(count: int, seed: int) -> Tensor:
    return torch.randn(count, generator=Generator().manual_seed(seed), dtype=torch.float64)


def grid(count: int) -> Blocks:
    """Full blocks without a gap."""
    return Blocks(BLOCK_S * (torch.arange(count, dtype=torch.float64) + 0.5), torch.ones(count, dtype=torch.float64))


def level(values: list[Tensor]) -> float:
    return white_level([SIGMA * value for value in values]) / SIGMA


# The level of white noise


def test_variance_is_the_covariances_diagonal() -> None:
    blocks = Blocks(100.0 * torch.arange(1, 300, dtype=torch.float64), torch.linspace(0.5, 1, 299, dtype=torch.float64), begin=-7000.0)
    noise = NoiseModel(0.3, 0.2, 0.1)
    torch.testing.assert_close(noise.variance(blocks), noise.covariance(blocks).diagonal(), rtol=1e-12, atol=0)
    torch.testing.assert_close(noise.scaled(2.0).variance(blocks), 4 * noise.variance(blocks), rtol=1e-12, atol=0)


def test_it_is_unbiased_on_white_noise() -> None:
    found = torch.tensor([level([normal(400, seed)]) for seed in range(300)])
    assert float(found.mean()) == pytest.approx(1, abs=0.02)
    assert float(found.std()) < 0.06, "and one run of 400 blocks is enough for 6 %"


def test_several_runs_are_pooled_and_never_joined() -> None:
    found = torch.tensor([level([normal(200, seed), 50 + normal(200, 1000 + seed), -9 + normal(100, 2000 + seed)]) for seed in range(200)])
    assert float(found.mean()) == pytest.approx(1, abs=0.02)


@pytest.mark.parametrize("drift", ["line", "parabola", "sine", "ramps"])
def test_it_is_blind_to_slow_drift(drift) -> None:
    """A hundred times the noise over the run."""
    t = torch.linspace(0, 1, 1000, dtype=torch.float64)
    slow = {"line": t, "parabola": t**2, "sine": torch.sin(12 * t), "ramps": (4 * t % 2 - 1).abs()}[drift] * 100
    found = torch.tensor([level([normal(1000, seed) + slow]) for seed in range(60)])
    assert float(found.mean()) == pytest.approx(1, abs=0.03)


def test_it_is_nearly_blind_to_spikes_in_two_percent_of_the_blocks() -> None:
    """Each spoils three second differences; 6 % of them are among the tenth left out, which costs a few per cent."""
    found = []
    for seed in range(60):
        values = normal(1000, seed)
        values[torch.randperm(1000, generator=Generator().manual_seed(seed))[:20]] += 1000.0
        found.append(level([values]))
    assert 0.97 < sum(found) / 60 < 1.12


def test_a_step_and_an_edge_do_not_move_it() -> None:
    values = normal(1000, 1)
    stepped = values.clone()
    stepped[500:] += 100.0
    assert level([stepped]) == pytest.approx(level([values]), rel=0.02)


def test_it_sees_the_white_noise_beneath_flicker() -> None:
    root = torch.linalg.cholesky(NoiseModel(0.0, 0.25).covariance(grid(600)) + torch.eye(600, dtype=torch.float64))
    found = torch.tensor([level([root @ normal(600, seed)]) for seed in range(60)])
    assert float(found.mean()) == pytest.approx(1, abs=0.06)


def test_its_scale_is_that_of_the_values() -> None:
    values = normal(400, 1)
    assert white_level([1e-9 * values]) == pytest.approx(1e-9 * white_level([values]))
    assert white_level([7 + values]) == pytest.approx(white_level([values]))


def test_too_few_values_have_no_level() -> None:
    assert math.isnan(white_level([normal(3, 1), normal(2, 1)]))
    assert math.isnan(white_level([]))
    assert white_level([torch.ones(50, dtype=torch.float64)]) == 0


# The covariance of block means

MIXTURES = [(1.0, 0.0, 0.0), (1.0, 0.25, 0.0), (1.0, 2.0, 0.0), (1.0, 0.0, 0.8), (0.3, 1.2, 0.3), (1e-3, 1.0, 1.0)]


@pytest.mark.parametrize("mixture", MIXTURES)
def test_a_covariance_is_symmetric_and_positive_definite(mixture) -> None:
    time, share = grid(300).time, grid(300).share
    time = torch.cat([time[:100], time[100:] + 5000])  # a gap
    share[::7] = 0.5
    matrix = NoiseModel(*mixture).covariance(Blocks(time, share))
    torch.testing.assert_close(matrix, matrix.mT, rtol=0, atol=0)
    assert float(torch.linalg.eigvalsh(matrix).min()) > 0
    assert bool((matrix.diagonal() >= mixture[0] ** 2 - 1e-15).all())


def test_without_flicker_and_walk_it_is_white_and_thin_blocks_are_noisier() -> None:
    blocks = grid(5)
    blocks.share[2] = 0.5
    matrix = NoiseModel(SIGMA, 0.0).covariance(blocks)
    torch.testing.assert_close(matrix, SIGMA**2 * torch.diag(torch.tensor([1.0, 1.0, 2.0, 1.0, 1.0], dtype=torch.float64)))


def test_parts_of_a_mixture_add() -> None:
    whole = NoiseModel(0.3, 0.5, 0.7).covariance(grid(50))
    parts = [NoiseModel(*part).covariance(grid(50)) for part in ((0.3, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, 0.7))]
    torch.testing.assert_close(whole, sum(parts))


def test_one_block_has_a_variance() -> None:
    assert NoiseModel(0.1, 0.5).covariance(grid(1)).tolist() == [[pytest.approx(0.01)]]


def test_a_walks_variance_is_k_squared_t() -> None:
    blocks = grid(100)
    matrix = NoiseModel(0.0, 0.0, 0.02).covariance(blocks)
    hours = (blocks.time - blocks.time[0]) / 3600
    torch.testing.assert_close(matrix.diagonal(), 0.02**2 * hours)
    torch.testing.assert_close(matrix[30, 70], 0.02**2 * hours[30], rtol=1e-12, atol=0)
    step = matrix[60, 60] + matrix[50, 50] - 2 * matrix[50, 60]
    assert float(step) == pytest.approx(0.02**2 * float(hours[10])), "increments depend on their length alone"


def allan_deviation(matrix: Tensor, m: int) -> float:
    """Expected Allan deviation at m blocks, every place of the window with equal weight: E½(ȳ₂ − ȳ₁)²."""
    count = len(matrix)
    windows = torch.zeros(count - 2 * m + 1, count, dtype=torch.float64)
    for i in range(len(windows)):
        windows[i, i : i + m], windows[i, i + m : i + 2 * m] = -1 / m, 1 / m
    return math.sqrt(0.5 * float(((windows @ matrix) * windows).sum(1).mean()))


def test_flickers_allan_deviation_is_flat_at_its_floor() -> None:
    """0.664·B within 15 % over a decade and more (IEEE Std 952: √(2 ln2/π)·B)."""
    matrix = NoiseModel(0.0, 0.01).covariance(grid(600))
    for m in (3, 5, 10, 20, 30, 60, 100):
        assert allan_deviation(matrix, m) == pytest.approx(0.664 * 0.01, rel=0.15), m


def test_draws_from_the_covariance_have_that_allan_deviation() -> None:
    count = 512
    root = torch.linalg.cholesky(NoiseModel(1e-6, 0.01).covariance(grid(count)))
    draws = root @ torch.randn(count, 200, generator=Generator().manual_seed(1), dtype=torch.float64)
    for m in (4, 8, 16, 32):
        means = draws.reshape(count // m, m, 200).mean(1)
        assert math.sqrt(0.5 * float(torch.diff(means, dim=0).square().mean())) == pytest.approx(0.00664, rel=0.15)


def test_white_noise_and_walk_have_the_allan_deviations_of_the_textbook() -> None:
    white, walk = NoiseModel(SIGMA, 0.0).covariance(grid(300)), NoiseModel(0.0, 0.0, 0.02).covariance(grid(300))
    for m in (1, 4, 25):
        assert allan_deviation(white, m) == pytest.approx(SIGMA / math.sqrt(m), rel=1e-6)
    for m in (10, 40):  # of points, not of means over a block: the two agree for long windows
        assert allan_deviation(walk, m) == pytest.approx(0.02 * math.sqrt(m * BLOCK_S / 3600 / 3), rel=0.02)


# Whitening


@pytest.mark.parametrize("mixture", MIXTURES)
def test_whitened_noise_has_the_identity_for_covariance(mixture) -> None:
    noise, runs = NoiseModel(*mixture), [grid(60), Blocks(grid(25).time + 777, torch.full((25,), 0.7).double())]
    whitener = Whitener(noise, runs)
    covariance = torch.block_diag(*[noise.covariance(blocks) for blocks in runs])
    root = whitener(torch.eye(85, dtype=torch.float64))
    torch.testing.assert_close(root @ covariance @ root.mT, torch.eye(85, dtype=torch.float64), rtol=0, atol=1e-7)
    assert whitener.log_determinant == pytest.approx(float(torch.linalg.slogdet(covariance).logabsdet), rel=1e-9, abs=1e-6)


def test_draws_come_out_white() -> None:
    noise, blocks = NoiseModel(1.0, 0.6, 0.3), grid(200)
    draws = torch.linalg.cholesky(noise.covariance(blocks)) @ torch.randn(200, 400, generator=Generator().manual_seed(1), dtype=torch.float64)
    white = Whitener(noise, [blocks])(draws)
    sample = white @ white.mT / 400
    assert float((sample - torch.eye(200, dtype=torch.float64)).abs().max()) < 6 / math.sqrt(400)
    assert float(white.square().mean()) == pytest.approx(1, abs=0.02)


def test_leading_axes_are_kept() -> None:
    whitener = Whitener(NoiseModel(1.0, 0.6), [grid(40)])
    columns = torch.randn(3, 2, 40, 5, generator=Generator().manual_seed(1), dtype=torch.float64)
    found = whitener(columns)
    assert found.shape == columns.shape
    torch.testing.assert_close(found[1, 0], whitener(columns[1, 0]))


def test_white_noise_is_only_scaled() -> None:
    columns = torch.randn(40, 2, generator=Generator().manual_seed(1), dtype=torch.float64)
    torch.testing.assert_close(Whitener(NoiseModel(0.5, 0.0), [grid(40)])(columns), 2 * columns)


def test_runs_do_not_know_of_each_other() -> None:
    noise, one = NoiseModel(1.0, 0.6, 0.5), torch.randn(40, 1, generator=Generator().manual_seed(1), dtype=torch.float64)
    both = Whitener(noise, [grid(40), grid(40)])
    torch.testing.assert_close(both(torch.cat([one, 5 + one]))[:40], Whitener(noise, [grid(40)])(one))


@pytest.mark.parametrize("mixture", [(1.0, 0.0, 0.5), (1.0, 0.6, 0.0), (0.5, 0.3, 0.3)])
def test_pieces_of_a_run_have_their_share_of_its_covariance(mixture) -> None:
    """All of it for white noise and walk; for flicker that of differences, for a shorter piece lacks the slowest Markov processes."""
    count, noise = WHITENED_AT_ONCE + 30, NoiseModel(*mixture)
    whole, at = noise.covariance(grid(count)), 0
    for piece in grid(count).pieces:
        found, expected = noise.covariance(piece), whole[at : at + len(piece.time), at : at + len(piece.time)]
        at += len(piece.time)
        near = (slice(0, 30), slice(0, 30))
        if not mixture[1]:
            torch.testing.assert_close(found, expected, rtol=1e-12, atol=0)
        torch.testing.assert_close(differences(found[near]), differences(expected[near]), rtol=0.02, atol=0)
    assert at == count


def differences(matrix: Tensor) -> Tensor:
    """Variance of the difference of any two values."""
    return matrix.diagonal().unsqueeze(0) + matrix.diagonal().unsqueeze(1) - 2 * matrix


@pytest.mark.parametrize("kept", [0.3, 0.5, 0.9])
def test_however_many_differences_are_kept_the_level_is_that_of_the_noise(kept) -> None:
    assert white_level([SIGMA * normal(40000, 3)], kept) == pytest.approx(SIGMA, rel=0.02)


def test_a_long_run_is_cut_into_pieces() -> None:
    count = WHITENED_AT_ONCE + 30
    whitener = Whitener(NoiseModel(1.0, 0.3), [grid(count)])
    assert whitener.sizes == [WHITENED_AT_ONCE, 30]
    assert whitener(torch.ones(count, 1, dtype=torch.float64)).shape == (count, 1)


@pytest.mark.parametrize(("short", "shared"), [(400, True), (300, True), (20, False)])
def test_a_shorter_run_recorded_alike_has_the_first_part_of_a_longer_ones_noise(short, shared) -> None:
    """Unless it is so short that its flicker lacks the slowest processes of the other's."""
    noise, long, less = NoiseModel(1.0, 0.4, 0.2), grid(500), grid(short)
    assert less.begins(long) is shared
    assert not long.begins(less)
    difference = (noise.covariance(long)[:short, :short] - noise.covariance(less)).abs().max()
    assert bool(difference < 1e-12) is shared
    whitener = Whitener(noise, [less, long])
    assert whitener.sizes == [short, 500]
    torch.testing.assert_close(whitener.factors[0] @ noise.covariance(less) @ whitener.factors[0].mT, torch.eye(short, dtype=torch.float64))


@pytest.mark.parametrize(("apart", "alike"), [(1e-10, True), (1e-3, False), (50.0, False)])
def test_times_that_are_the_same_but_for_rounding_are_the_same(apart, alike) -> None:
    """Means of times are rounded by how many there are; blocks after a gap are others all the same."""
    long, other = grid(60), grid(40)
    late = Blocks(torch.cat([other.time[:20], other.time[20:] + apart]), other.share)
    assert late.begins(long) is alike
    assert late.same(other) is alike


def test_white_noise_has_as_many_effective_samples_as_blocks_and_coloured_noise_fewer() -> None:
    blocks = Blocks(torch.arange(300, dtype=torch.float64) * 100.0, torch.ones(300, dtype=torch.float64))
    counts = [effective_samples(NoiseModel(1.0, flicker), [blocks, blocks]) for flicker in (0.0, 0.3, 1.0)]
    assert counts[0] == pytest.approx(600)
    assert counts[0] > counts[1] > counts[2] > 1


def test_effective_samples_scatter_as_the_mean_square_does() -> None:
    """Var(mean of squares)/(2·its mean²) is 1/n, by drawing."""
    noise, blocks = NoiseModel(1.0, 1.2), Blocks(torch.arange(200, dtype=torch.float64) * 100.0, torch.ones(200, dtype=torch.float64))
    root = torch.linalg.cholesky(noise.covariance(blocks))
    squares = (root @ torch.randn(200, 20000, generator=Generator().manual_seed(3), dtype=torch.float64)).square().mean(dim=0)
    assert 2 * float(squares.mean() ** 2 / squares.var()) == pytest.approx(effective_samples(noise, [blocks]), rel=0.05)


@pytest.mark.parametrize("size", [7, 60, 400])
def test_the_product_by_bands_is_the_product(size) -> None:
    """Also where whole columns are zero, and others but for one row."""
    blocks = Blocks(torch.arange(size, dtype=torch.float64) * 100.0, torch.ones(size, dtype=torch.float64))
    whitener = Whitener(NoiseModel(1.0, 0.4, 0.2), [blocks, blocks])
    columns = torch.randn(5, 2 * size, 30, generator=Generator().manual_seed(1), dtype=torch.float64)
    columns[:, :size, :25] = 0.0
    columns[:, 1, :10] = 1.0
    expected = torch.cat([whitener.factors[0] @ columns[:, :size], whitener.factors[1] @ columns[:, size:]], dim=1)
    torch.testing.assert_close(whitener(columns), expected, rtol=1e-12, atol=1e-12)


def test_runs_recorded_alike_of_any_length_are_whitened_as_each_is_alone() -> None:
    """In one product for all of them, beside one that was recorded otherwise."""
    noise, runs = NoiseModel(1.0, 0.4, 0.2), [grid(300), grid(500), Blocks(grid(80).time * 1.7, grid(80).share), grid(450)]
    columns = torch.randn(3, sum(len(run.time) for run in runs), 4, generator=Generator().manual_seed(1), dtype=torch.float64)
    parts = columns.split([len(run.time) for run in runs], dim=1)
    expected = torch.cat([Whitener(noise, [run])(part) for run, part in zip(runs, parts, strict=True)], dim=1)
    whiten = Whitener(noise, runs)
    assert len(whiten.shared) == 2
    torch.testing.assert_close(whiten(columns), expected, rtol=1e-12, atol=1e-12)
    assert whiten.log_determinant == pytest.approx(sum(Whitener(noise, [run]).log_determinant for run in runs))


def test_single_precision_stays_single_and_says_the_same() -> None:
    whiten = Whitener(NoiseModel(SIGMA, 0.5 * SIGMA, 0.1 * SIGMA), [grid(300), grid(120)])
    columns = torch.stack([SIGMA * normal(420, seed) for seed in range(6)], dim=1).view(420, 3, 2).movedim(1, 0)
    found = whiten(columns.float())
    assert found.dtype == torch.float32
    torch.testing.assert_close(found.double(), whiten(columns), rtol=0, atol=1e-4)
