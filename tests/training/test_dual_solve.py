"""The dual system against its limits, leaving out against fitting without, landmarks against all samples, and planted functions."""

from dataclasses import replace
from statistics import median

import pytest
import torch
from torch import Generator, Tensor

from zoo.catalog import build
from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.models.bp import BP
from zoo.models.ls_svm import LsSvm, gaussians
from zoo.models.prediction import block_features, predict_blocks
from zoo.training.dual_solve import BLOCK, DualSolve, _folds, exact_solve
from zoo.training.kernel_search import MOST_OF_WEIGHTS, search
from zoo.training.least_squares import LeastSquares
from zoo.training.leave_out import Dual
from zoo.training.nystrom import landmarks, nystrom_solve
from zoo.training.run import train

FEATURES = ["temperature", "temperature_rate"]


def chance(seed: int = 1) -> Generator:
    return Generator().manual_seed(seed)


def samples(count: int = 60, noise: float = 0.1) -> tuple[Tensor, Tensor]:
    points = torch.randn(count, 2, generator=chance(), dtype=torch.float64)
    target = torch.sin(2 * points[:, 0]) + 0.5 * points[:, 1] + noise * torch.randn(count, generator=chance(2), dtype=torch.float64)
    return points, target


def gammas(*values: float) -> Tensor:
    return torch.tensor(values, dtype=torch.float64)


def test_the_solution_solves_the_bordered_system() -> None:
    points, target = samples()
    kernel = gaussians(points, points)
    weights, biases = Dual(kernel, target, gammas(0.5, 40.0, 3000.0)).solution
    for weight, bias, gamma in zip(weights.mT, biases, (0.5, 40.0, 3000.0), strict=True):
        system = torch.ones(61, 61, dtype=torch.float64)
        system[0, 0], system[1:, 1:] = 0.0, kernel + torch.eye(60, dtype=torch.float64) / gamma
        expected = torch.linalg.solve(system, torch.cat([gammas(0.0), target]))
        torch.testing.assert_close(torch.cat([bias.unsqueeze(0), weight]), expected, rtol=1e-9, atol=1e-9)
        alone = exact_solve(points, target, gamma)
        torch.testing.assert_close(torch.cat([alone[1].unsqueeze(0), alone[0]]), expected, rtol=1e-9, atol=1e-9)


def test_limits_of_gamma_are_interpolation_and_the_mean() -> None:
    points, target = samples()
    points = points / 0.05  # Gaussians that hardly overlap: K is far from singular
    kernel = gaussians(points, points)
    weight, bias = Dual(kernel, target, gammas(1e12)).solution
    torch.testing.assert_close(kernel @ weight[:, 0] + bias, target, rtol=1e-9, atol=1e-9)
    weight, bias = Dual(kernel, target, gammas(1e-9)).solution
    torch.testing.assert_close(kernel @ weight[:, 0] + bias, target.mean().expand(60), rtol=0, atol=1e-7)


def test_wide_gaussians_are_a_linear_function() -> None:
    points, _ = samples()
    target = 0.3 + points @ gammas(2.0, -1.0)
    wide = points / 300.0
    weight, bias = exact_solve(wide, target, 2.0**32)
    unseen = torch.randn(40, 2, generator=chance(5), dtype=torch.float64)
    torch.testing.assert_close(gaussians(unseen / 300.0, wide) @ weight + bias, 0.3 + unseen @ gammas(2.0, -1.0), rtol=0, atol=2e-3)


def test_a_choice_leaves_rounding_little_to_do() -> None:
    """Without noise the longer the weights the better is what is left out predicted, until rounding is all that is left."""
    points, target = samples(noise=0.0)
    kernel = search(points, target, None, lambda: None)
    near = points / 2.0**kernel.width
    weight, bias = exact_solve(near, target, 2.0**kernel.gamma)
    assert 1e3 < float(weight.abs().sum()) <= 1.001 * MOST_OF_WEIGHTS
    shaken = near * (1 + 1e-15 * torch.randn(near.shape, generator=chance(3), dtype=torch.float64))
    torch.testing.assert_close(gaussians(shaken, near) @ weight + bias, gaussians(near, near) @ weight + bias, rtol=0, atol=1e-9)
    assert float((gaussians(near, near) @ weight + bias - target).square().mean().sqrt()) < 1e-3


@pytest.mark.parametrize("folds", [None, torch.arange(60) // 7, torch.arange(60) // 20], ids=["samples", "blocks", "thirds"])
def test_leaving_out_is_fitting_without(folds) -> None:
    points, target = samples()
    kernel, tried = gaussians(points, points), (0.3, 20.0, 2000.0)
    found = Dual(kernel, target, gammas(*tried)).left_out_errors(folds)
    numbers = torch.arange(60) if folds is None else folds
    for column, gamma in enumerate(tried):
        for fold in numbers.unique():
            out, rest = numbers == fold, numbers != fold
            weight, bias = exact_solve(points[rest], target[rest], gamma)
            torch.testing.assert_close(found[out, column], target[out] - kernel[out][:, rest] @ weight - bias, rtol=1e-8, atol=1e-9)


def test_landmarks_that_are_all_samples_give_the_exact_solution_and_few_come_close() -> None:
    points, target = samples(300)
    weight, bias = exact_solve(points, target, 100.0)
    unseen = torch.randn(200, 2, generator=chance(5), dtype=torch.float64)
    exact = gaussians(unseen, points) @ weight + bias

    def apart(count: int, seed: int) -> float:
        support = points[landmarks(points, count, chance(seed))]
        weight, bias = nystrom_solve(points, target, support, 100.0)
        return float((gaussians(unseen, support) @ weight + bias - exact).abs().max())

    few, more, half = (median(apart(count, seed) for seed in range(20)) for count in (20, 80, 150))
    assert few > 10 * more > 100 * half
    assert apart(300, 1) < 1e-5


def test_landmarks_are_apart_repeat_and_end_with_the_samples() -> None:
    points = torch.cat([torch.zeros(1000, 2), torch.linspace(1, 2, 5).unsqueeze(-1).expand(5, 2)]).double()
    assert sorted(landmarks(points, 6, chance()).tolist())[-5:] == [1000, 1001, 1002, 1003, 1004]
    assert len(landmarks(points, 50, chance())) == 6
    drawn, _ = samples(300)
    assert torch.equal(landmarks(drawn, 30, chance(3)), landmarks(drawn, 30, chance(3)))
    assert len(landmarks(drawn, 30, chance(3)).unique()) == 30


def left(model: LsSvm, run: Run) -> float:
    return float((run.block_mean(run.error) - predict_blocks(model, run)).square().mean().sqrt())


def truth(run: Run, bend: float) -> Tensor:
    model = LsSvm(FEATURES)
    features = block_features(model, run)
    return 0.3 + 0.02 * features[:, 0] - 0.15 * features[:, 1] + bend * run.block_mean(torch.tanh(run.temperature / 20))


def test_a_single_block_is_left_out_sample_by_sample() -> None:
    """All of it at once would leave nothing to fit."""
    assert _folds("block", [BLOCK]) is None
    assert _folds("block", [0, BLOCK - 1]) is None
    assert (found := _folds("block", [BLOCK, 2])) is not None
    assert len(found.unique()) == 2
    assert (found := _folds("block", [BLOCK + 1])) is not None
    assert len(found.unique()) == 2


@pytest.mark.parametrize("folds", ["sample", "block"])
def test_a_planted_function_comes_back_to_a_fraction_of_the_noise(make_run, folds: str) -> None:
    noise = 0.05  # of a sample; of a block mean 0.016
    runs = [make_run("a", noise=noise, bend=0.4), make_run("b", high=60.0, noise=noise, bend=0.4, seed=2)]
    check = make_run("check", low=-15.0, high=50.0, bend=0.4, seed=3)
    model = LsSvm(FEATURES)
    DualSolve(folds).fit(model, runs, chance())
    missed = truth(check, 0.4) - predict_blocks(model, check)
    assert float(missed.square().mean().sqrt()) < 0.7 * noise / 10**0.5


def test_the_order_of_the_runs_does_not_matter_and_a_fit_repeats(make_run) -> None:
    runs = [make_run("a", noise=0.05, bend=0.4), make_run("b", high=60.0, noise=0.05, bend=0.4, seed=2)]
    models = []
    for order in (runs, runs, runs[::-1]):
        models.append(LsSvm(FEATURES))
        DualSolve().fit(models[-1], order, chance())
    here = [predict_blocks(model, runs[0]) for model in models]
    assert torch.equal(here[0], here[1])
    torch.testing.assert_close(here[2], here[0], rtol=0, atol=1e-7)


def test_past_the_limit_few_support_points_do_the_same(make_run) -> None:
    runs = [make_run("a", noise=0.05, bend=0.4), make_run("b", high=60.0, noise=0.05, bend=0.4, seed=2)]
    whole, few, again = LsSvm(FEATURES), LsSvm(FEATURES), LsSvm(FEATURES)
    DualSolve().fit(whole, runs, chance())
    for model in (few, again):
        DualSolve(exact_to=200, landmarks=60).fit(model, runs, chance())
    assert len(whole.support) == sum(run.blocks for run in runs) == 216
    assert len(few.support) == 60
    for run in runs:
        assert float((predict_blocks(few, run) - predict_blocks(whole, run)).abs().max()) < 2e-3
        assert torch.equal(predict_blocks(few, run), predict_blocks(again, run))


def test_whole_runs_are_left_out_where_they_overlap(make_run) -> None:
    """Memory that the features do not hold goes with the run: by blocks each run is followed, by runs what they share."""
    runs = [make_run(f"run_{k}", noise=0.01) for k in range(3)]
    shifted = [replace(run, error=run.error + 0.1 * k) for k, run in enumerate(runs)]

    def chosen(folds: str, given: list[Run]) -> float:
        fit = DualSolve(folds)
        fit.fit(LsSvm(FEATURES), given, chance())
        assert fit.kernel is not None
        return fit.kernel.gamma

    assert chosen("auto", shifted) == chosen("run", shifted)
    apart = [make_run("cold", low=-40.0, high=-10.0), make_run("hot", low=30.0, high=60.0)]
    assert chosen("auto", apart) == chosen("block", apart)
    assert chosen("auto", runs[:1]) == chosen("block", runs[:1])


def test_train_writes_what_was_chosen(make_run, tmp_path) -> None:
    run = make_run(noise=0.05, bend=0.4)
    model = build("model", "ls_svm")
    metrics = train(model, [run], [make_run("check", bend=0.4)], optimizer=build("optimizer", "dual_solve"), out=tmp_path)
    assert set(metrics["physical"]["kernel"]) == {"gamma", "width_temperature", "width_temperature_rate"}
    assert metrics["rms"] == pytest.approx(left(model, run))
    assert metrics["rms_check"] < 0.02


def test_a_run_at_one_temperature_gives_its_mean(make_run) -> None:
    run = make_run(low=20.0, high=20.0)
    model = LsSvm(FEATURES)
    DualSolve().fit(model, [run], chance())
    torch.testing.assert_close(predict_blocks(model, run), torch.full((run.blocks,), 0.7, dtype=torch.float64), atol=1e-9, rtol=0)


def test_what_does_not_fit_together_is_named(make_run, tmp_path) -> None:
    run = make_run()
    with pytest.raises(InputError, match=r"fits model=ls_svm, not BP"):
        DualSolve().fit(BP(FEATURES), [run], chance())
    with pytest.raises(InputError, match=r"optimizer\.folds=run: at least 2 runs"):
        DualSolve("run").fit(LsSvm(FEATURES), [run], chance())
    with pytest.raises(InputError, match=r"optimizer\.folds=month: possible: auto, sample, block, run"):
        DualSolve("month")
    with pytest.raises(InputError, match=r"optimizer\.landmarks=0"):
        DualSolve(landmarks=0)
    for optimizer in (LeastSquares(), torch.optim.Adam):
        with pytest.raises(InputError, match="LsSvm has no weights to train; leave optimizer=auto"):
            train(LsSvm(FEATURES), [run], optimizer=optimizer, out=tmp_path)
