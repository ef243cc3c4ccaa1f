"""Many seeds as one batch: every member ends where a training of its own ends."""

from __future__ import annotations

from functools import partial

import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from torch import Generator

from zoo.errors import InputError, WorkError
from zoo.models.bp import BP
from zoo.models.polynomial import Polynomial
from zoo.models.prediction import predict_blocks
from zoo.swarm import aco, pheromone, pso
from zoo.training.files import CHECKPOINT
from zoo.training.least_squares import LeastSquares
from zoo.training.levenberg_marquardt import LevenbergMarquardt
from zoo.training.members import read_members
from zoo.training.problem import Problem
from zoo.training.random_init import RandomInit
from zoo.training.run import train
from zoo.training.swarm_init import SwarmInit

FEATURES = ["temperature", "temperature_rate"]
ADAM = partial(torch.optim.Adam, lr=0.02)
OPTIMIZERS = {
    "adam": ADAM,
    "sgd": partial(torch.optim.SGD, lr=0.1, momentum=0.9),
    "lbfgs": partial(torch.optim.LBFGS, line_search_fn="strong_wolfe", max_iter=5),
}
SWARMS = {name: partial(SwarmInit, algorithm, 12, 10) for name, algorithm in (("pso", pso), ("aco", aco), ("aco_pheromone", pheromone))}
INITS = {"random": RandomInit} | SWARMS


def vector(state: dict[str, torch.Tensor]) -> torch.Tensor:
    return torch.cat([value.flatten() for name, value in sorted(state.items())])


CASES = [("adam", {}), ("adam", {"batch_size": 40}), ("adam", {"goal": 0.05}), ("sgd", {}), ("lbfgs", {"epochs": 4})]
NAMES = ["adam", "batches", "goal", "sgd", "lbfgs"]


@pytest.mark.parametrize(
    ("init", "optimizer", "settings"),
    [pytest.param(init, *case, id=f"{init}-{name}") for init in ("random", "pso") for case, name in zip(CASES, NAMES, strict=True)]
    + [pytest.param(init, "adam", {}, id=f"{init}-adam") for init in ("aco", "aco_pheromone")],
)
def test_a_member_is_the_training_with_its_seed(make_run, tmp_path, init, optimizer, settings) -> None:
    runs, check = [make_run(bend=0.5, noise=0.02), make_run("run_2", high=25.0, bend=0.5, noise=0.02, seed=2)], [make_run("check", low=0.0, bend=0.5)]
    settings = {"epochs": 40, "optimizer": OPTIMIZERS[optimizer]} | settings
    together = train(BP(FEATURES), runs, check, init=INITS[init](seed=7), seed=3, seeds=3, out=tmp_path, **settings)
    members = read_members(tmp_path)
    assert together["members"]["seeds"] == [member.seed for member in members] == [3, 4, 5]
    for k, member in enumerate(members):
        model = BP(FEATURES)
        alone = train(model, runs, check, init=INITS[init](seed=7 + k), seed=3 + k, out=tmp_path / "alone", **settings)
        torch.testing.assert_close(vector(member.state), vector(model.state_dict()), rtol=1e-7, atol=1e-9)
        assert together["members"]["rms"][k] == pytest.approx(alone["rms"], rel=1e-7)
        assert together["members"]["rms_check"][k] == pytest.approx(alone["rms_check"], rel=1e-7)
        if together["members"]["best_seed"] == member.seed:
            for key in ("epochs", "evaluations", "rms", "rms_check"):
                assert together[key] == pytest.approx(alone[key], rel=1e-7)


def test_members_stop_at_the_goal_each_for_itself(make_run, tmp_path) -> None:
    ends = {}
    for seed in (1, 2, 3):
        ends[seed] = train(BP(FEATURES), [make_run(bend=0.5)], optimizer=ADAM, goal=0.02, epochs=500, seed=seed, out=tmp_path)
    assert len({one["epochs"] for one in ends.values()}) == 3
    together = train(BP(FEATURES), [make_run(bend=0.5)], optimizer=ADAM, goal=0.02, epochs=500, seeds=3, out=tmp_path)
    assert together["members"]["rms"] == pytest.approx([one["rms"] for one in ends.values()], rel=1e-7)


def test_the_model_is_the_best_of_the_fit_and_the_spread_is_that_of_the_members(make_run, tmp_path) -> None:
    runs, check = [make_run(bend=0.5, noise=0.02)], [make_run("check", high=90.0, bend=0.5)]
    model = BP(FEATURES)
    metrics = train(model, runs, check, optimizer=ADAM, epochs=60, seeds=9, out=tmp_path)
    members = metrics["members"]
    place = members["seeds"].index(members["best_seed"])
    assert metrics["rms"] == pytest.approx(min(members["rms"]), rel=1e-12)
    assert metrics["rms_check"] == pytest.approx(members["rms_check"][place], rel=1e-12)
    assert members["rms_check_quantiles"]["median"] == sorted(members["rms_check"])[4]
    kept = read_members(tmp_path)[place]
    assert all(torch.equal(value, kept.state[name]) for name, value in model.state_dict().items())
    left = check[0].block_mean(check[0].error) - predict_blocks(model, check[0])
    assert members["rms_check"][place] == pytest.approx(float(left.square().mean().sqrt()), rel=1e-12)


def test_what_fits_by_itself_is_fitted_seed_by_seed(make_run, tmp_path) -> None:
    """A fit that draws differs from seed to seed, one that doesn't is the same nine times."""

    class Guess:
        def fit(self, model, runs, generator) -> None:
            if generator.initial_seed() == 5:
                raise WorkError("no luck")
            LeastSquares().fit(model, runs, generator)
            model.weight.data += torch.rand(len(model.weight), generator=generator, dtype=torch.float64)

    solved = train(Polynomial(FEATURES), [make_run(noise=0.1)], optimizer=LeastSquares(), seeds=3, out=tmp_path)["members"]
    assert solved["rms"][0] == solved["rms"][2] == solved["rms_quantiles"]["low"]
    guessed = train(Polynomial(FEATURES), [make_run(noise=0.1)], optimizer=Guess(), seed=4, seeds=3, out=tmp_path)["members"]
    assert (guessed["seeds"], guessed["failed_seeds"]) == ([4, 6], [5])
    assert guessed["rms"][0] != guessed["rms"][1]
    with pytest.raises(WorkError, match="no luck"):
        train(Polynomial(FEATURES), [make_run()], optimizer=Guess(), seed=5, out=tmp_path)


def test_one_that_diverges_is_left_out_and_told(make_run, tmp_path) -> None:
    class Uneven(RandomInit):
        def weights(self, problem, members, log):
            drawn = super().weights(problem, members, log)
            drawn[1] = float("inf")
            return drawn

    metrics = train(BP(FEATURES), [make_run(bend=0.5)], optimizer=ADAM, init=Uneven(1), epochs=5, seeds=3, out=tmp_path)
    assert (metrics["members"]["seeds"], metrics["members"]["failed_seeds"]) == ([1, 3], [2])
    with pytest.raises(WorkError, match=r"diverged.*optimizer\.lr"):
        train(BP(FEATURES), [make_run()], optimizer=partial(torch.optim.SGD, lr=1e200), epochs=300, seeds=2, out=tmp_path)


def test_an_ensemble_resumes_to_where_an_uninterrupted_one_ends(make_run, tmp_path) -> None:
    """Those that had reached the goal before the interruption stay where they were."""
    runs, ends = [make_run(bend=0.5)], {}
    begin = partial(train, runs=runs, optimizer=ADAM, goal=0.002, seeds=4)
    for name, epochs in (("whole", 90), ("part", 60)):
        begin(BP(FEATURES), epochs=epochs, out=tmp_path / name)
    metrics = begin(BP(FEATURES), epochs=90, resume=tmp_path / "part" / CHECKPOINT, out=tmp_path / "again")
    for name in ("whole", "part", "again"):
        ends[name] = torch.stack([vector(member.state) for member in read_members(tmp_path / name)])
    assert torch.equal(ends["again"], ends["whole"])
    same = [torch.equal(*pair) for pair in zip(ends["part"], ends["whole"], strict=True)]
    assert set(same) == {True, False}
    assert metrics["epochs"] < 90
    with pytest.raises(InputError, match="another model"):
        begin(BP(FEATURES), epochs=90, resume=tmp_path / "part" / CHECKPOINT, out=tmp_path / "again", seeds=3)


@pytest.mark.parametrize(("optimizer", "lower"), [(ADAM, 0.004), (LevenbergMarquardt(), 1e-5)], ids=["adam", "levenberg_marquardt"])
def test_who_has_reached_a_goal_goes_on_to_a_lower_one(make_run, tmp_path, optimizer, lower) -> None:
    model, run = BP(FEATURES), make_run(bend=0.5)
    begin = partial(train, model, [run], optimizer=optimizer, seeds=3)
    first = begin(goal=0.05, epochs=100, out=tmp_path / "first")
    again = begin(goal=lower, epochs=200, resume=tmp_path / "first" / CHECKPOINT, out=tmp_path / "again")
    scale = Problem.of_runs(model, [run]).scale
    losses = [[(rms / scale) ** 2 for rms in one["members"]["rms"]] for one in (first, again)]
    assert lower < min(losses[0]) <= max(losses[0]) < 0.05
    assert all(later < before for before, later in zip(*losses, strict=True))


def test_members_trained_one_after_another_leave_one_curve(make_run, tmp_path) -> None:
    lbfgs = partial(torch.optim.LBFGS, max_iter=5)
    train(BP(FEATURES), [make_run(bend=0.5)], optimizer=lbfgs, seeds=3, epochs=8, out=tmp_path)
    events = EventAccumulator(str(tmp_path / "tensorboard")).Reload()
    assert [point.step for point in events.Scalars("loss/fit")] == list(range(1, 9))


def test_losses_are_the_squared_error_over_the_variance_in_any_shape(make_run) -> None:
    model, run = BP(FEATURES), make_run(bend=0.5)
    problem = Problem.of_runs(model, [run])
    weights = torch.randn(300, problem.size, generator=Generator().manual_seed(1), dtype=torch.float64)
    losses = problem.losses(weights.view(3, 100, -1))
    error = run.block_mean(run.error)
    for k in (0, 117, 299):
        model.hidden.weight.data, model.hidden.bias.data = weights[k, :18].view(9, 2), weights[k, 18:27]
        model.output.weight.data, model.output.bias.data = weights[k, 27:36].view(1, 9), weights[k, 36:]
        left = error - predict_blocks(model, run)
        assert float(losses.view(-1)[k]) == pytest.approx(float(left.square().mean() / error.var(correction=0)), rel=1e-12)
