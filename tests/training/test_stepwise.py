"""Levenberg–Marquardt and swarms as fits: of one and of many, from any start, on and off."""

from __future__ import annotations

from functools import partial

import pytest
import torch
from torch import Generator

from zoo.errors import InputError, WorkError
from zoo.models.bp import BP
from zoo.models.piecewise_polynomial import PiecewisePolynomial
from zoo.models.polynomial import Polynomial
from zoo.swarm import aco, pheromone, pso
from zoo.training import problem as problems
from zoo.training import stepwise
from zoo.training.files import CHECKPOINT
from zoo.training.least_squares import LeastSquares
from zoo.training.levenberg_marquardt import LevenbergMarquardt
from zoo.training.members import read_members
from zoo.training.population import Population
from zoo.training.problem import Problem
from zoo.training.random_init import RandomInit
from zoo.training.run import train
from zoo.training.swarm_fit import SwarmFit
from zoo.training.swarm_init import SwarmInit
from zoo.training.weights import weight_vector

FEATURES = ["temperature", "temperature_rate"]
METHODS = {
    "levenberg_marquardt": LevenbergMarquardt(),
    "pso": SwarmFit(pso, particles=20, steps=30),
    "aco": SwarmFit(aco, particles=10, steps=60),
    "aco_pheromone": SwarmFit(pheromone, particles=10, steps=60),
}


@pytest.mark.parametrize("method", list(METHODS))
@pytest.mark.parametrize("goal", [None, 0.03])
def test_a_member_is_the_fit_with_its_seed(make_run, tmp_path, method, goal) -> None:
    runs = [make_run(bend=0.5, noise=0.05)]
    fit = partial(train, runs=runs, optimizer=METHODS[method], goal=goal, epochs=15)
    together = fit(BP(FEATURES), seed=3, seeds=3, out=tmp_path)
    for k, seed in enumerate((3, 4, 5)):
        alone = fit(BP(FEATURES), seed=seed, out=tmp_path / "alone")
        assert together["members"]["rms"][k] == pytest.approx(alone["rms"], rel=1e-5)
        if together["members"]["best_seed"] == seed:
            assert (together["epochs"], together["evaluations"]) == (alone["epochs"], alone["evaluations"])


def test_the_inits_count_for_levenberg_marquardt_and_not_for_a_swarm(make_run, tmp_path) -> None:
    runs = [make_run(bend=0.5, noise=0.05)]
    fit = partial(train, BP(FEATURES), runs, epochs=1, out=tmp_path)
    found = fit(optimizer=LevenbergMarquardt(), init=SwarmInit(pso, 20, 30))
    assert found["evaluations"] == 20 * 30 + 1 + 2
    assert found["loss"] < fit(optimizer=LevenbergMarquardt())["loss"]
    assert fit(optimizer=METHODS["pso"])["evaluations"] == 20 * 30


def test_levenberg_marquardt_ends_at_a_minimum_from_anywhere(make_run) -> None:
    """Where it rests, the residual is orthogonal to every derivative, as MINPACK measures it, and nothing near is lower."""
    problem, method = Problem.of_runs(BP(FEATURES, hidden=2), [make_run(bend=0.5, noise=0.05)]), LevenbergMarquardt(settled=1e-12)
    drawn = RandomInit(1).weights(problem, 12, lambda values, step: None)
    state = method.start(problem, drawn, range(12))
    costs = []
    for _ in range(400):
        state = method.step(problem, state)
        costs.append(state.losses)
    assert bool((torch.stack(costs).diff(dim=0) <= 0).all())
    torch.testing.assert_close(problem.losses(state.weights), state.losses, rtol=1e-9, atol=0)
    normal, slope = problem.normal_equations(state.weights)
    length = normal.diagonal(dim1=-2, dim2=-1).sqrt() * state.losses.sqrt().unsqueeze(-1)
    assert float((slope.abs() / length.clamp_min(1e-12)).max()) < 1e-5
    chance = Generator().manual_seed(1)
    near = state.weights.unsqueeze(1) + 1e-3 * torch.randn(12, 100, problem.size, generator=chance, dtype=torch.float64)
    assert float((problem.losses(near).amin(-1) - state.losses).min()) > -1e-9


def test_one_step_solves_what_is_linear(make_run) -> None:
    model = Polynomial(FEATURES, 3, 2)
    run = make_run(bend=0.5, noise=0.05, average_s=10.0)  # a block is a sample: both then fit the same
    problem, method = Problem.of_runs(model, [run]), LevenbergMarquardt()
    state = method.start(problem, weight_vector(model).unsqueeze(0), [1])
    state = method.step(problem, state._replace(damping=torch.full((1,), 1e-9, dtype=torch.float64)))
    LeastSquares().fit(model, [run], Generator().manual_seed(1))
    torch.testing.assert_close(state.weights[0], weight_vector(model), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"particles": 0}, "particles=0: a whole number from 1 up"),
        ({"particles": 2.5}, r"particles=2\.5: a whole number"),
        ({"steps": 0}, "steps=0: a whole number from 1 up"),
        ({"reach": "far"}, "reach=far: a number from"),
        ({"archive": 2.5}, r"archive=2\.5: a whole number from 2 up"),
        ({"locality": "abc"}, "locality=abc: a number"),
        ({"warmth": 1}, "warmth: no setting of this swarm"),
    ],
)
def test_settings_that_make_no_swarm_are_told_as_they_were_typed(make_run, tmp_path, settings, words) -> None:
    model, runs, given = BP(FEATURES), [make_run()], {"particles": 3, "steps": 2} | settings
    with pytest.raises(InputError, match=rf"^optimizer\.{words}"):
        train(model, runs, optimizer=SwarmFit(aco, **given), out=tmp_path)
    with pytest.raises(InputError, match=rf"^init\.{words}"):
        train(model, runs, optimizer=LevenbergMarquardt(), init=SwarmInit(aco, **given), out=tmp_path)


def test_a_swarm_comes_close_to_what_is_solved(make_run, tmp_path) -> None:
    runs = [make_run(noise=0.02)]
    solved = train(Polynomial(FEATURES, 2, 2), runs, optimizer=LeastSquares(), out=tmp_path)
    found = train(Polynomial(FEATURES, 2, 2), runs, optimizer=SwarmFit(pso, particles=40, steps=150), out=tmp_path)
    assert solved["rms"] <= found["rms"] < 1.01 * solved["rms"]


def test_segments_are_searched_side_by_side(make_run, tmp_path) -> None:
    """Twenty weights at once are too many for so small a swarm; four five times are not."""
    runs = [make_run(noise=0.02)]
    made = partial(PiecewisePolynomial, FEATURES, [-5.0, 5.0, 20.0, 30.0], order=2, rate_order=1)
    solved = train(made(), runs, optimizer=LeastSquares(), out=tmp_path)
    found = train(made(), runs, optimizer=SwarmFit(pso, particles=60, steps=200), out=tmp_path)
    assert solved["rms"] <= found["rms"] < 1.02 * solved["rms"]
    assert found["evaluations"] == 60 * 200


def test_losses_of_parts_add_up_to_the_loss(make_run, monkeypatch) -> None:
    model = PiecewisePolynomial(FEATURES, [0.0, 20.0])
    problem = Problem.of_runs(model, [make_run(bend=0.5, noise=0.05)])
    whole_blocks, problem = problem, problem.of_means
    weights = torch.randn(2, 7, problem.size, generator=Generator().manual_seed(1), dtype=torch.float64)
    grouped = weights[..., problem.places].movedim(-2, -3)
    torch.testing.assert_close(problem.losses_of_parts(grouped).sum(-2), problem.losses(weights), rtol=1e-12, atol=0)
    assert torch.equal(whole_blocks.losses_of_parts(grouped), problem.losses_of_parts(grouped))
    whole, predicted = problem.losses_of_parts(grouped), problem.population.outputs(weights[0])
    torch.testing.assert_close(predicted, Population(model, problem.features).outputs(weights[0]), rtol=1e-9, atol=1e-9)
    monkeypatch.setattr(problems, "ROWS_OF_COLUMNS", 31)
    torch.testing.assert_close(problem.losses_of_parts(grouped), whole, rtol=1e-12, atol=0)


def test_normal_equations_are_those_of_the_jacobian_in_pieces_or_not(make_run, monkeypatch) -> None:
    model = BP(FEATURES, hidden=4)
    problem = Problem.of_runs(model, [make_run(bend=0.5)])
    weights = torch.randn(3, problem.size, generator=Generator().manual_seed(1), dtype=torch.float64)
    whole = problem.normal_equations(weights)
    monkeypatch.setattr(problems, "ROWS_OF_COLUMNS", 31)
    for piece, one in zip(problem.normal_equations(weights), whole, strict=True):
        torch.testing.assert_close(piece, one, rtol=1e-9, atol=1e-12)
    step = 1e-6 * torch.eye(problem.size, dtype=torch.float64)
    slopes = (problem.losses(weights.unsqueeze(1) + step) - problem.losses(weights.unsqueeze(1) - step)) / 2e-6
    torch.testing.assert_close(-2 * whole[1], slopes, rtol=1e-5, atol=1e-7)


def test_levenberg_marquardt_resumes_to_where_an_uninterrupted_one_ends(make_run, tmp_path) -> None:
    fit = partial(train, runs=[make_run(bend=0.5, noise=0.05)], optimizer=LevenbergMarquardt(), seeds=3)
    told = fit(BP(FEATURES), epochs=20, init=SwarmInit(pso, 6, 5), out=tmp_path / "whole")
    fit(BP(FEATURES), epochs=8, init=SwarmInit(pso, 6, 5), out=tmp_path / "part")
    checkpoint = torch.load(tmp_path / "part" / CHECKPOINT, weights_only=True)
    torch.save(checkpoint | {"spent_s": checkpoint["spent_s"] + 100.0}, tmp_path / "part" / CHECKPOINT)
    again = fit(BP(FEATURES), epochs=20, init=SwarmInit(pso, 6, 5), resume=tmp_path / "part" / CHECKPOINT, out=tmp_path / "again")
    assert 100.0 < again["wall_time_s"] < 200.0, "both pieces"
    assert 100.0 < torch.load(tmp_path / "again" / CHECKPOINT, weights_only=True)["spent_s"] < 200.0
    assert again["evaluations"] == told["evaluations"] > 30, "those of the swarm, which was skipped, included"
    ends = {name: [list(one.state.values()) for one in read_members(tmp_path / name)] for name in ("whole", "part", "again")}
    for whole, again in zip(ends["whole"], ends["again"], strict=True):
        assert all(torch.equal(*pair) for pair in zip(whole, again, strict=True))
    resume = partial(fit, BP(FEATURES), resume=tmp_path / "part" / CHECKPOINT, out=tmp_path)
    with pytest.raises(InputError, match="8 steps already, of 8"):
        resume(epochs=8)
    with pytest.raises(InputError, match="another number of seeds"):
        resume(epochs=20, seeds=2)
    with pytest.raises(InputError, match="trained by LevenbergMarquardt, not by Adam"):
        resume(epochs=20, seeds=1, optimizer=torch.optim.Adam)


def test_what_cannot_be_is_said(make_run, tmp_path) -> None:
    run = make_run(bend=0.5)

    class Nowhere(RandomInit):
        def weights(self, problem, members, log):
            return super().weights(problem, members, log) * float("inf")

    with pytest.raises(WorkError, match="no weights with a finite loss"):
        train(BP(FEATURES), [run], optimizer=LevenbergMarquardt(), init=Nowhere(), out=tmp_path)
    with pytest.raises(InputError, match="batch_size=10"):
        train(BP(FEATURES), [run], optimizer=LevenbergMarquardt(), batch_size=10, out=tmp_path)
    with pytest.raises(InputError, match=r"optimizer\.settled=2"):
        LevenbergMarquardt(settled=2)


def test_checkpoints_on_the_way_are_gone_on_from(make_run, tmp_path, monkeypatch) -> None:
    """Stopped half-way by an error of the machine, with a checkpoint after every step."""
    monkeypatch.setattr(stepwise, "EVERY_S", -1.0)
    runs, method, calls = [make_run(bend=0.5, noise=0.05)], LevenbergMarquardt(), []
    whole, again = BP(FEATURES), BP(FEATURES)
    train(whole, runs, optimizer=method, epochs=12, out=tmp_path / "whole")

    class Broken(LevenbergMarquardt):
        def step(self, problem, state):
            calls.append(1)
            if len(calls) > 5:
                raise MemoryError
            return super().step(problem, state)

    Broken.__name__ = "LevenbergMarquardt"
    with pytest.raises(MemoryError):
        train(BP(FEATURES), runs, optimizer=Broken(), epochs=12, out=tmp_path / "part")
    train(again, runs, optimizer=method, epochs=12, resume=tmp_path / "part" / CHECKPOINT, out=tmp_path)
    assert torch.equal(weight_vector(again), weight_vector(whole))
