"""What is fitted is what is judged: means of predictions, whichever way leads there."""

from dataclasses import replace
from functools import partial

import pytest
import torch

from zoo.errors import InputError
from zoo.models.base import FeatureModel
from zoo.models.bp import BP
from zoo.models.features import Features
from zoo.models.piecewise_polynomial import PiecewisePolynomial
from zoo.models.polynomial import Polynomial
from zoo.models.prediction import predict_blocks
from zoo.models.scaler import Scaler
from zoo.models.takagi_sugeno import TakagiSugeno
from zoo.models.wavelet import Wavelet
from zoo.physics.differentiator import temperature_rate
from zoo.swarm import pso
from zoo.training.ensemble import Ensemble
from zoo.training.files import CHECKPOINT
from zoo.training.fine_blocks import MOST, FineBlocks, rows_of, samples_of, seen
from zoo.training.least_squares import LeastSquares, solve
from zoo.training.levenberg_marquardt import LevenbergMarquardt
from zoo.training.module import Training
from zoo.training.population import Population
from zoo.training.problem import Problem
from zoo.training.run import train
from zoo.training.swarm_fit import SwarmFit
from zoo.training.weights import reset, set_weights, weight_vector

FEATURES = ["temperature", "temperature_rate"]
ADAM = partial(torch.optim.Adam, lr=0.01)
MODELS = [
    partial(BP, FEATURES),
    partial(Wavelet, FEATURES),
    partial(TakagiSugeno, FEATURES, rules=3),
    partial(Polynomial, FEATURES, 3, 4),
    partial(PiecewisePolynomial, FEATURES, [0.0, 20.0]),
]


@pytest.fixture
def ragged(make_run):
    """A run with a gap, a block left out, samples of several rows, and blocks of one to ten samples."""
    run = make_run(bend=0.5, noise=0.02)
    chance = torch.Generator().manual_seed(1)
    keep = torch.rand(len(run.time), generator=chance) > 0.4
    keep[300:360] = False
    block = torch.where(run.block == 7, -1, run.block)[keep]
    number = torch.unique(block[block >= 0], return_inverse=True)[1]
    block[block >= 0] = number
    count = torch.randint(1, 5, (int(keep.sum()),), generator=chance).double()
    return replace(run, table=run.table[keep], error=run.error[keep], count=count, block=block)


@pytest.mark.parametrize("make", MODELS)
def test_the_mean_of_the_samples_is_what_a_model_is_judged_by(ragged, make) -> None:
    model = make()
    whole, rows = FineBlocks(model, samples_of([ragged])), rows_of(model, samples_of([ragged]))(ragged)
    whole.standardise(rows, ragged.block_mean(ragged.error))
    reset(model, torch.Generator().manual_seed(2))
    torch.testing.assert_close(whole.head(rows), predict_blocks(model, ragged), rtol=1e-12, atol=1e-12)
    torch.testing.assert_close(whole.means(rows), rows_of(model, 1)(ragged), rtol=1e-12, atol=1e-12)
    assert torch.equal(weight_vector(whole), weight_vector(model))
    problem = Problem.of_runs(model, [ragged])
    left = ragged.block_mean(ragged.error) - predict_blocks(model, ragged)
    assert float(problem.losses(weight_vector(model))) == pytest.approx(float((left / problem.scale).square().mean()), rel=1e-9)


def test_blocks_of_one_sample_are_the_model_itself(make_run) -> None:
    run, model = make_run(average_s=10.0), BP(FEATURES)
    assert samples_of([run]) == 1
    assert seen(model, 1) is model
    assert Problem.of_runs(model, [run]).features.shape == (run.blocks, len(FEATURES))


def test_runs_with_less_in_a_block_are_fitted_beside_others(make_run, tmp_path) -> None:
    """A run to check on has no say in it."""
    coarse, fine = make_run(average_s=30.0, bend=0.5), make_run("run_2", average_s=80.0, bend=0.5)
    losses = []
    for check in ([], [fine]):
        losses.append(train(BP(FEATURES), [coarse], check, optimizer=ADAM, epochs=20, out=tmp_path)["rms"])
    assert losses[0] == losses[1]
    problem = Problem.of_runs(BP(FEATURES), [coarse, fine])
    assert problem.features.shape == (coarse.blocks + fine.blocks, 8 * (len(FEATURES) + 1))


def test_a_burst_costs_no_more_than_other_blocks(make_run) -> None:
    """Neighbours are taken together, whose predictions hardly differ."""
    run = make_run(step_s=1.0, bend=0.5, noise=0.02)
    keep = torch.ones(len(run.time), dtype=torch.bool)
    keep[200:] = torch.arange(200, len(keep)) % 50 == 0
    burst = replace(run, table=run.table[keep], error=run.error[keep], count=run.count[keep], block=run.block[keep])
    model = BP(FEATURES)
    problem = Problem.of_runs(model, [burst])
    assert problem.features.shape == (burst.blocks, MOST * (len(FEATURES) + 1))
    reset(model, torch.Generator().manual_seed(2))
    torch.testing.assert_close(problem.model.head(problem.features), predict_blocks(model, burst), rtol=0, atol=1e-4)


class FirstNode(FeatureModel):
    """One of a user's own, whose head takes a table and nothing else."""

    def __init__(self) -> None:
        super().__init__()
        self.extract, self.scaler = Features(FEATURES), Scaler(len(FEATURES))
        self.inputs, self.nodes = self.extract.inputs, torch.nn.Linear(2, 3, dtype=torch.float64)

    def features(self, x: torch.Tensor) -> torch.Tensor:
        return self.extract(x)

    def head(self, features: torch.Tensor) -> torch.Tensor:
        nodes = self.nodes(self.scaler(features))
        return self.scaler.restore(nodes[:, 0] + torch.tanh(nodes[:, 1:]).sum(1))

    def standardise(self, features: torch.Tensor, error: torch.Tensor) -> None:
        self.scaler.fit(features, error)


@pytest.mark.parametrize("seeds", [1, 2])
def test_a_head_that_takes_a_table_only_is_fitted_by_what_is_judged(make_run, tmp_path, seeds) -> None:
    run = make_run(bend=0.5, average_s=100.0)
    for optimizer in (ADAM, LevenbergMarquardt()):
        model = FirstNode()
        found = train(model, [run], optimizer=optimizer, epochs=30, seeds=seeds, out=tmp_path)
        left = float((run.block_mean(run.error) - predict_blocks(model, run)).square().mean().sqrt())
        assert found["rms"] == pytest.approx(left, rel=1e-9)
        assert found["loss"] == pytest.approx((left / Problem.of_runs(model, [run]).scale) ** 2, rel=1e-6)


def test_an_ensemble_is_loaded_as_its_training_says(make_run, tmp_path) -> None:
    run, model = make_run(bend=0.5), BP(FEATURES)
    train(model, [run], optimizer=ADAM, epochs=20, seeds=3, out=tmp_path)
    again = Training.load_from_checkpoint(tmp_path / CHECKPOINT, model=Ensemble(BP(FEATURES), 3), optimizer=ADAM, weights_only=True)
    problem = Problem.of_runs(again.model.net, [run])
    losses = again.loss(again(problem.features), problem.error)
    torch.testing.assert_close(losses, problem.losses(again.model.weights), rtol=1e-9, atol=0)


def test_training_does_not_go_on_from_other_measurements_as_if_nothing_had_changed(make_run, tmp_path) -> None:
    """A damped step takes over where the weights are, not what they left of another run; gradients refuse rows of another kind."""
    one, two = make_run(bend=0.5, noise=0.02), make_run("run_2", bend=-0.8, noise=0.02, seed=2)
    lm = LevenbergMarquardt()
    train(BP(FEATURES), [one], optimizer=lm, epochs=200, seeds=2, out=tmp_path)
    (tmp_path / "fresh").mkdir()
    fresh, onwards = BP(FEATURES), BP(FEATURES)
    best = train(fresh, [two], optimizer=lm, epochs=400, seeds=2, out=tmp_path / "fresh")["rms"]
    found = train(onwards, [two], optimizer=lm, epochs=600, seeds=2, resume=tmp_path / CHECKPOINT, out=tmp_path)["rms"]
    assert found < 2 * best
    train(BP(FEATURES), [make_run(average_s=10.0)], optimizer=ADAM, epochs=5, out=tmp_path)
    with pytest.raises(InputError, match="saw other samples of the blocks"):
        train(BP(FEATURES), [one], optimizer=ADAM, epochs=10, resume=tmp_path / CHECKPOINT, out=tmp_path)


@pytest.mark.parametrize(
    ("optimizer", "epochs", "seeds"),
    [
        (LevenbergMarquardt(), 50, 1),
        (SwarmFit(pso, particles=60, steps=300), 1, 1),
        (partial(torch.optim.LBFGS, max_iter=20, line_search_fn="strong_wolfe"), 100, 1),
        (partial(torch.optim.Adam, lr=0.02), 4000, 1),
        (partial(torch.optim.Adam, lr=0.02), 4000, 3),
    ],
    ids=["levenberg_marquardt", "pso", "lbfgs", "adam", "many seeds"],
)
def test_every_way_leads_to_least_squares(make_run, tmp_path, optimizer, epochs, seeds) -> None:
    """Of powers of a rate over blocks so long that the power of the mean is far from the mean of the power."""
    run, made = make_run(average_s=600.0, noise=0.05), partial(Polynomial, FEATURES, 1, 2)
    rate = temperature_rate(run.time, run.temperature)
    runs = [replace(run, error=run.error + 2.0 * rate**2)]
    solved, found = made(), made()
    best = train(solved, runs, optimizer=LeastSquares(), out=tmp_path)["rms"]
    assert train(found, runs, optimizer=optimizer, epochs=epochs, seeds=seeds, out=tmp_path)["rms"] < 1.001 * best
    features, error = rows_of(solved, 1)(runs[0]), runs[0].block_mean(runs[0].error)
    of_means = made()
    of_means.standardise(features, error)
    offset, columns = Population(of_means, features).affine()
    set_weights(of_means, solve(columns.T, error - offset))
    assert score(of_means, runs[0]) > 1.1 * best, "else nothing is tested here"


def score(model, run) -> float:
    return float((run.block_mean(run.error) - predict_blocks(model, run)).square().mean().sqrt())
