"""Training as a whole: what it writes, that it repeats, goes on, and gets better."""

import logging
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from zoo.errors import InputError, WorkError
from zoo.measurements.datamodule import Prebatched, RunsDataModule
from zoo.models.base import Model
from zoo.models.bp import BP
from zoo.models.polynomial import Polynomial
from zoo.models.prediction import block_features, usable_device
from zoo.swarm import pso
from zoo.training.files import CHECKPOINT
from zoo.training.least_squares import LeastSquares
from zoo.training.module import Training
from zoo.training.population import Population
from zoo.training.random_init import RandomInit
from zoo.training.run import train
from zoo.training.swarm_init import SwarmInit
from zoo.training.weights import reset, set_weights, weight_vector

FEATURES = ["temperature", "temperature_rate"]
ADAM = partial(torch.optim.Adam, lr=0.02)


def swarm(seed: int = 1) -> SwarmInit:
    return SwarmInit(pso, particles=20, steps=20, seed=seed)


def test_adam_learns_a_curve_that_no_polynomial_of_order_one_has(make_run, tmp_path) -> None:
    runs, check = [make_run(bend=0.5), make_run("run_2", high=30.0, bend=0.5)], [make_run("check", low=-10.0, bend=0.5)]
    line = train(Polynomial(FEATURES), runs, check, optimizer=LeastSquares(), out=tmp_path)
    net = train(BP(FEATURES), runs, check, optimizer=ADAM, epochs=600, out=tmp_path)
    assert net["rms"] < 0.1 * line["rms"] < 0.1 * line["rms_uncompensated"]
    assert net["rms_check"] < 0.2 * line["rms_check"]
    assert net["epochs"] == net["evaluations"] == 600
    assert [run["run"] for run in net["check_runs"]] == ["check"]
    assert {"hold", "heating", "cooling"} <= set(net["runs"][0]["stages"])


@pytest.mark.parametrize("init", [RandomInit, swarm])
def test_equal_seeds_give_equal_results_whatever_the_global_state(make_run, tmp_path, init) -> None:
    results = []
    for position, seed in enumerate((5, 5, 6)):
        torch.manual_seed(position)
        model = BP(FEATURES)
        metrics = train(model, [make_run(bend=0.5)], optimizer=ADAM, init=init(seed=seed), epochs=30, seed=seed, batch_size=40, out=tmp_path)
        results.append((metrics["rms"], weight_vector(model)))
    assert results[0][0] == results[1][0] != results[2][0]
    assert torch.equal(results[0][1], results[1][1])


def test_the_global_random_state_is_left_alone(make_run, tmp_path) -> None:
    model = BP(FEATURES)
    before = torch.get_rng_state()
    train(model, [make_run()], optimizer=ADAM, init=swarm(), epochs=3, out=tmp_path)
    assert torch.equal(torch.get_rng_state(), before)


@pytest.mark.parametrize("init", [RandomInit, swarm])
@pytest.mark.parametrize(("first", "batch_size"), [(50, None), (30, None), (50, 40), (30, 40)])
def test_a_checkpoint_resumes_to_where_an_uninterrupted_training_ends(make_run, tmp_path, init, first, batch_size) -> None:
    runs = [make_run(bend=0.5)]
    whole, part = BP(FEATURES), BP(FEATURES)
    train(whole, runs, optimizer=ADAM, init=init(), epochs=100, batch_size=batch_size, out=tmp_path)
    train(part, runs, optimizer=ADAM, init=init(), epochs=first, batch_size=batch_size, out=tmp_path)
    checkpoint = torch.load(tmp_path / CHECKPOINT, weights_only=True)
    checkpoint["spent_s"] += 100.0
    torch.save(checkpoint, tmp_path / CHECKPOINT)
    assert not torch.equal(weight_vector(part), weight_vector(whole))
    again, started = BP(FEATURES), time.perf_counter()
    metrics = train(again, runs, optimizer=ADAM, init=init(), epochs=100, batch_size=batch_size, resume=tmp_path / CHECKPOINT, out=tmp_path)
    assert metrics["epochs"] == 100
    assert checkpoint["spent_s"] < metrics["wall_time_s"] <= checkpoint["spent_s"] + time.perf_counter() - started, "both pieces, each once"
    torch.testing.assert_close(weight_vector(again), weight_vector(whole), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("model", "optimizer"), [(BP, ADAM), (Polynomial, LeastSquares())])
def test_a_checkpoint_reloads_by_weights_only(make_run, tmp_path, model, optimizer) -> None:
    trained, run = model(FEATURES), make_run(bend=0.5)
    train(trained, [run], optimizer=optimizer, epochs=5, out=tmp_path)
    reloaded = Training.load_from_checkpoint(tmp_path / CHECKPOINT, model=model(FEATURES), optimizer=None, weights_only=True)
    x = run.select(trained.inputs)
    assert torch.equal(reloaded.model(x), trained(x))


def test_a_checkpoint_that_does_not_fit_is_refused(make_run, tmp_path) -> None:
    runs = [make_run()]
    train(BP(FEATURES), runs, optimizer=ADAM, epochs=5, out=tmp_path)
    (tmp_path / "text").write_text("no checkpoint")
    again = partial(train, runs=runs, out=tmp_path, resume=tmp_path / CHECKPOINT)
    with pytest.raises(InputError, match="another model"):
        again(BP(FEATURES, hidden=5), optimizer=ADAM, epochs=10)
    with pytest.raises(InputError, match="trained by Adam, not by SGD"):
        again(BP(FEATURES), optimizer=partial(torch.optim.SGD, lr=0.1), epochs=10)
    with pytest.raises(InputError, match="5 steps already, of 5; raise epochs"):
        again(BP(FEATURES), optimizer=ADAM, epochs=5)
    with pytest.raises(InputError, match="cannot be read"):
        train(BP(FEATURES), runs, optimizer=ADAM, epochs=10, out=tmp_path, resume=tmp_path / "text")


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"goal": 1e-3, "batch_size": 5}, "goal=0.001 is of the loss over all blocks"),
        ({"seed": 2**70}, "seed=.*a whole number from 0 to 4294967295"),
        ({"epochs": 2.5}, r"epochs=2\.5: a whole number from 1 up"),
        ({"optimizer": LeastSquares(), "batch_size": 5}, "batch_size: LeastSquares solves in one go"),
        ({"optimizer": LeastSquares(), "resume": Path("last.ckpt")}, "resume: LeastSquares solves in one go"),
    ],
)
def test_settings_that_make_no_training_are_refused(make_run, tmp_path, settings, words) -> None:
    with pytest.raises(InputError, match=words):
        train(Polynomial(FEATURES), [make_run()], **{"optimizer": ADAM, **settings}, out=tmp_path)


@pytest.mark.parametrize("level", [0.0, 0.1, -3e5])
def test_an_error_that_never_changes_is_learnt(make_run, tmp_path, level) -> None:
    """Rounding makes a standard deviation of 1e-17 of it, which is no unit of a loss."""
    run = make_run()
    constant = replace(run, error=torch.full_like(run.error, level))
    metrics = train(BP(FEATURES), [constant], optimizer=ADAM, epochs=300, out=tmp_path)
    assert metrics["loss"] < 1e-3
    assert metrics["rms"] < 0.05


@pytest.mark.parametrize("name", ["tpu", "cpu:abc", "cuda:x", "cuda:99", ""])
def test_a_device_that_is_not_there_is_told(name) -> None:
    with pytest.raises(InputError, match=f"torch_device={name}: .*possible: cpu"):
        usable_device(name)


def test_the_number_of_threads_is_put_back(make_run, tmp_path) -> None:
    before = torch.get_num_threads()
    torch.set_num_threads(before + 1)
    try:
        train(BP(FEATURES), [make_run()], optimizer=ADAM, epochs=2, out=tmp_path)
        assert torch.get_num_threads() == before + 1
    finally:
        torch.set_num_threads(before)


def test_the_swarm_starts_lower_than_chance_and_is_counted(make_run, tmp_path) -> None:
    run = make_run(bend=0.5, noise=0.05)
    first = {}
    for name, init in (("random", RandomInit()), ("swarm", swarm())):
        metrics = train(BP(FEATURES), [run], optimizer=partial(torch.optim.SGD, lr=0.0), init=init, epochs=1, out=tmp_path / name)
        first[name] = metrics["loss"]
    assert first["swarm"] < 0.5 * first["random"]
    assert metrics["evaluations"] == 20 * 20 + 1


def test_events_hold_the_curves_of_swarm_and_training(make_run, tmp_path) -> None:
    train(BP(FEATURES), [make_run()], [make_run("check")], optimizer=ADAM, init=swarm(), epochs=100, out=tmp_path)
    events = EventAccumulator(str(tmp_path / "tensorboard"))
    events.Reload()
    curve = [event.value for event in events.Scalars("swarm/best")]
    assert len(curve) == 20
    assert curve == sorted(curve, reverse=True)
    assert len(events.Scalars("loss/fit")) == 100
    assert len(events.Scalars("loss/check")) == 2
    assert events.Scalars("loss/fit")[-1].value < curve[-1]


def test_training_stops_at_its_goal(make_run, tmp_path) -> None:
    metrics = train(BP(FEATURES), [make_run()], optimizer=ADAM, goal=1e-2, epochs=2000, out=tmp_path)
    assert metrics["loss"] < 1.1e-2
    assert 5 < metrics["epochs"] < 1000


def test_lbfgs_gets_further_than_adam_in_as_many_evaluations(make_run, tmp_path) -> None:
    run = make_run(bend=0.5)
    lbfgs = partial(torch.optim.LBFGS, line_search_fn="strong_wolfe", max_iter=20)
    one = train(BP(FEATURES), [run], optimizer=lbfgs, epochs=20, out=tmp_path)
    two = train(BP(FEATURES), [run], optimizer=ADAM, epochs=one["evaluations"], out=tmp_path)
    assert one["evaluations"] > 20
    assert one["rms"] < two["rms"]


def test_a_model_that_is_no_map_of_features_brings_its_own_fit(make_run, tmp_path) -> None:
    class Constant(Model):
        def __init__(self) -> None:
            super().__init__()
            self.inputs = ["time_s"]
            self.value = torch.nn.Parameter(torch.zeros((), dtype=torch.float64))

        def forward(self, x: torch.Tensor) -> torch.Tensor:
            return self.value.expand(len(x))

    class Mean:
        def fit(self, model, runs, generator) -> None:
            model.value.data.copy_(torch.cat([run.error for run in runs]).mean())

    run = make_run()
    metrics = train(Constant(), [run], optimizer=Mean(), out=tmp_path)
    assert metrics["rms"] == pytest.approx(float(run.block_mean(run.error).std(correction=0)), rel=1e-6)
    assert (tmp_path / CHECKPOINT).is_file()
    with pytest.raises(InputError, match="Constant is no map of features"):
        train(Constant(), [run], optimizer=ADAM, out=tmp_path)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"epochs": 0}, "epochs=0"),
        ({"epochs": "many"}, "epochs=many"),
        ({"goal": -1.0}, "goal=-1"),
        ({"batch_size": 2.5}, "batch_size=2.5"),
        ({"seed": None}, "seed=None"),
        ({"device": "tpu"}, "torch_device=tpu"),
        pytest.param({"device": "cuda"}, "torch_device=cuda", marks=pytest.mark.skipif(torch.cuda.is_available(), reason="has CUDA")),
    ],
)
def test_wrong_settings_are_named(make_run, tmp_path, settings, message) -> None:
    with pytest.raises(InputError, match=message):
        train(BP(FEATURES), [make_run()], optimizer=ADAM, out=tmp_path, **settings)


def test_nothing_to_train_on_is_an_input_error(tmp_path) -> None:
    with pytest.raises(InputError, match="no run"):
        train(BP(FEATURES), [], optimizer=ADAM, out=tmp_path)


def test_divergence_fails_and_says_what_to_do(make_run, tmp_path) -> None:
    with pytest.raises(WorkError, match=r"diverged.*optimizer\.lr"):
        train(BP(FEATURES), [make_run()], optimizer=partial(torch.optim.SGD, lr=1e200), epochs=300, out=tmp_path)


def test_a_missing_column_is_named(make_run, tmp_path) -> None:
    with pytest.raises(InputError, match=r"run_1.*temperature_outer_c.*temperature_c"):
        train(BP(["temperature_outer"]), [make_run()], optimizer=ADAM, out=tmp_path)


def test_a_population_is_evaluated_as_its_members_one_by_one(make_run) -> None:
    run, model = make_run(), BP(FEATURES)
    features = block_features(model, run)
    model.standardise(features, run.block_mean(run.error))
    weights = torch.randn(7, len(weight_vector(model)), generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    together = Population(model, features).outputs(weights)
    for row, expected in zip(weights, together, strict=True):
        set_weights(model, row)
        torch.testing.assert_close(model.head(features), expected)


def test_reset_depends_on_the_generator_alone() -> None:
    one, two = BP(FEATURES), BP(FEATURES)
    reset(one, torch.Generator().manual_seed(4))
    reset(two, torch.Generator().manual_seed(4))
    assert torch.equal(weight_vector(one), weight_vector(two))
    assert float(weight_vector(one).abs().max()) <= 1 / 2**0.5


def test_small_batches_cover_each_pass_once_in_a_new_order() -> None:
    batch = (torch.arange(10.0).unsqueeze(-1), torch.arange(10.0))
    loader = Prebatched(batch, passes=2, batch_size=4, generator=torch.Generator().manual_seed(1))
    seen = torch.cat([error for _, error in loader])
    assert len(loader) == 6
    assert sorted(seen[:10].tolist()) == sorted(seen[10:].tolist()) == batch[1].tolist()
    assert seen[:10].tolist() != seen[10:].tolist()


def test_check_runs_never_reach_the_fit(make_run) -> None:
    model = BP(FEATURES)
    data = RunsDataModule([make_run()], [make_run("check", high=80.0)], partial(block_features, model))
    data.setup("fit")
    assert float(data.fitted[0][:, 0].max()) < 41
    assert data.checked is not None
    assert float(data.checked[0][:, 0].max()) > 79


def test_lightning_is_quiet_and_its_loggers_are_put_back(make_run, tmp_path, capsys, recwarn) -> None:
    before = logging.getLogger("lightning.pytorch").level
    train(BP(FEATURES), [make_run()], optimizer=ADAM, epochs=2, out=tmp_path)
    captured = capsys.readouterr()
    assert captured.out == captured.err == ""
    assert not [str(one.message) for one in recwarn if "lightning" in str(one.filename)]
    assert logging.getLogger("lightning.pytorch").level == before
