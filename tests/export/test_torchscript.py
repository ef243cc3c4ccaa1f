"""``model.ts``: whole runs and sample by sample say what the trained model says, and rows that cannot be used leave no trace."""

from __future__ import annotations

import math

import pytest
import torch

from zoo.catalog import load, names
from zoo.effects.base import Effect, History, Parameter
from zoo.errors import InputError, WorkError
from zoo.export.carried import CHUNK
from zoo.export.torchscript import Exported, load_torchscript, to_torchscript
from zoo.models.example import example
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.models.ranges import Watched

NETWORKS = [name for name in names("model") if "inputs" not in load("model", name)]
RICH = ["temperature", "temperature_rate", "temperature_outer_rate", "temperature_lag600", "temperature_outer_lag90", "supply_v", "time_s"]
RANGES = {"temperature_c": (-30.0, 55.0)}


def exported(model, refuse_outside=False):
    made_up = example(model.inputs, RANGES)
    return load_torchscript(to_torchscript(model, "dph", made_up, RANGES, refuse_outside))


def stepped(script, x):
    script.reset()
    return torch.stack([script.step(row) for row in x])


def check_close(found, wanted, tolerance=1e-11):
    torch.testing.assert_close(found, wanted, rtol=0, atol=tolerance * float(wanted.nan_to_num().abs().max()), equal_nan=True)


@pytest.fixture(scope="module", params=NETWORKS)
def of_the_catalogue(request, network):
    model = network(request.param)
    return model, exported(model)


@pytest.fixture(scope="module")
def bp(network):
    model = network("bp", features=RICH)
    return model, exported(model)


@pytest.fixture(scope="module")
def everything(graybox):
    """Every effect of the catalogue in one grey box."""
    model = graybox(names("effects"), ("temperature_c", "temperature_outer_c"))
    return model, exported(model)


@torch.no_grad()
def test_every_network_predicts_as_trained_whole_and_by_sample(of_the_catalogue, record) -> None:
    model, script = of_the_catalogue
    x = record(model.inputs)
    check_close(script(x), model(x), 1e-13)
    check_close(stepped(script, x), model(x))


@pytest.mark.filterwarnings("ignore::torch.jit.TracerWarning")
@torch.no_grad()
def test_no_effect_keeps_the_device_that_it_was_exported_on(everything, record) -> None:
    model, _ = everything
    scripted = torch.jit.script(Exported(model, "dph", example(model.inputs, RANGES), RANGES, refuse_outside=False))
    # A device without numbers: mixed with anything that is still on the CPU, it raises.
    core, x = scripted.core.to("meta"), record(model.inputs).to("meta")
    first, state = core.first(x[:1])
    following, state = core.following(x[1:2], state)
    chunk, state = core.chunk(x[2 : 2 + CHUNK], state)
    assert all(one.is_meta for one in (first, following, chunk, state))


@torch.no_grad()
def test_every_kind_of_feature_goes_by_sample(bp, record) -> None:
    model, script = bp
    x = record(model.inputs)
    check_close(stepped(script, x), model(x))
    assert list(script.inputs) == model.inputs
    assert script.unit == "dph"


@pytest.mark.slow
@torch.no_grad()
def test_steps_do_not_drift_away_over_many_samples(network, record) -> None:
    model = network("bp")
    script, x = exported(model), record(model.inputs, 50_000)
    x[:, 0] = 0.005 * torch.arange(len(x))  # 200 Hz: a share of 8e-5 of the rate's time constant a step
    check_close(stepped(script, x), script(x), 1e-9)


@pytest.mark.slow
@torch.no_grad()
@pytest.mark.parametrize("samples", [1, 2, CHUNK, CHUNK + 1, CHUNK + 2, 2 * CHUNK + 30])
def test_every_effect_goes_whole_and_by_sample(everything, record, samples) -> None:
    model, script = everything
    x = record(model.inputs, samples)
    check_close(script(x), model(x))
    check_close(stepped(script, x[:400]), model(x)[:400])


@torch.no_grad()
def test_a_network_and_effects_together_go(network, graybox, record) -> None:
    physics = graybox(["hysteresis", "mohr"])
    model = Hybrid(network("bp"), dict(physics.named_effects()), physics.inputs)
    model.physics = physics
    script, x = exported(model), record(model.inputs, 300)
    check_close(script(x), model(x))
    check_close(stepped(script, x), model(x))


@torch.no_grad()
def test_rows_that_cannot_be_used_leave_no_trace(bp, record) -> None:
    model, script = bp
    x = record(model.inputs, 300)
    wrong = x.clone()
    wrong[0, 1] = math.nan
    wrong[10, 2] = math.inf
    wrong[20, 0] = wrong[19, 0]
    wrong[30, 0] = wrong[5, 0]
    wrong[40, 0] = math.nan
    left_out = torch.zeros(len(x), dtype=torch.bool)
    left_out[[0, 10, 20, 30, 40]] = True
    for found in (script(wrong), stepped(script, wrong)):
        assert torch.equal(found.isnan(), left_out)
        check_close(found[~left_out], model(x[~left_out]))


@torch.no_grad()
def test_outside_of_the_trained_range_is_told_and_refused_only_if_asked(network, record) -> None:
    model = network("bp")
    x = record(model.inputs, 60)
    x[:, 1] = torch.linspace(-20, 80, 60, dtype=torch.float64)
    outside = x[:, 1] > 55 + 0.02 * 85  # the range and its room
    told, refusing = exported(model), exported(model, refuse_outside=True)
    flags = torch.stack([told.step_checked(row)[1] for row in x])
    assert torch.equal(flags[:, 1], ~outside)
    assert bool(flags[:, 0].all())
    told.reset()
    assert torch.equal(torch.stack([told.step_checked(row)[0] for row in x]), stepped(told, x))
    for found in (refusing(x), stepped(refusing, x)):
        assert torch.equal(found.isnan(), outside)
        check_close(found[~outside], model(x)[~outside])
    # What lies outside is not predicted, and remembered all the same: it is the gyro's past.
    back = torch.cat([x, x[:1]])
    back[-1, 0] = x[-1, 0] + 20
    check_close(stepped(refusing, back)[-1], model(back)[-1])


@torch.no_grad()
@pytest.mark.parametrize("kind", ["network", "hybrid"])
def test_a_ramp_steeper_than_any_in_training_is_told_by_its_column(network, graybox, record, kind) -> None:
    model = network("bp", features=["temperature", "temperature_rate", "temperature_lag600"])
    if kind == "hybrid":
        model = Hybrid(model, dict(graybox(["hysteresis"]).named_effects()), ["time_s", "temperature_c", "reference_dph"])
    slow = {"temperature_c": (-30.0, 55.0), "temperature_rate": (-1.0, 1.0)}
    x = record(model.inputs, 400)
    x[:, 0] = 10.0 * torch.arange(400)
    x[:, 1] = 20 + torch.cat([torch.zeros(100), torch.linspace(0, 10, 100), torch.full((100,), 10.0), torch.linspace(10, -25, 100)])  # .6, −2.1 K/min
    made = to_torchscript(model, "dph", example(model.inputs, slow), slow)
    script = load_torchscript(made)
    assert "temperature_rate" in list(script.features)
    flags = torch.stack([script.step_checked(row)[1] for row in x])
    steep = Watched(model)(x)[:, Watched(model).names.index("temperature_rate")] < -1.0 - 0.02 * 2
    assert torch.equal(~flags[:, 1], steep)
    assert 60 < int(steep.sum()) < 100
    assert bool(flags[:, 0].all())
    assert not script(x).isnan().any()


def test_a_clock_that_stands_still_is_told(bp, record) -> None:
    _, script = bp
    first, second = record(list(script.inputs), 2)
    script.reset()
    assert script.step_checked(first)[1].tolist() == [True] * len(first)
    predicted, flags = script.step_checked(first)
    assert flags.tolist() == [False] + [True] * (len(first) - 1)
    assert bool(predicted.isnan())
    second[1] = math.nan
    assert script.step_checked(second)[1].tolist() == [True, False] + [True] * (len(first) - 2)


@torch.no_grad()
def test_reset_forgets_and_a_whole_run_in_between_changes_nothing(bp, everything, record) -> None:
    for _, script in (bp, everything):
        x = record(list(script.inputs), 40)
        once = stepped(script, x)
        script.reset()
        again = [script.step(row) for row in x[:20]]
        script(record(list(script.inputs), 300, seed=8))
        again += [script.step(row) for row in x[20:]]
        assert torch.equal(torch.stack(again), once)


def test_other_shapes_are_refused_in_words(bp) -> None:
    _, script = bp
    with pytest.raises(Exception, match="forward takes"):
        script(torch.zeros(3, 2, dtype=torch.float64))
    with pytest.raises(Exception, match="step takes"):
        script.step(torch.zeros(1, 5, dtype=torch.float64))
    assert script(torch.zeros(0, len(script.inputs), dtype=torch.float64)).shape == (0,)


class Highest(Effect):
    """One that remembers by itself the highest temperature so far."""

    name = "highest"
    amplitudes = (Parameter("a", 1.0, "unit", -1.0, 1.0),)

    def columns(self, history: History, shape: torch.Tensor) -> torch.Tensor:
        return history.temperature.cummax(-1).values.unsqueeze(-1)


def test_what_cannot_go_by_sample_is_refused_and_says_why(graybox) -> None:
    model = GrayBox({"highest": Highest()}, ["time_s", "temperature_c", "reference_dph"])
    model.assign(model.theta(), torch.ones(1, dtype=torch.float64))
    with pytest.raises(WorkError, match="effect 'highest'"):
        exported(model)
    with pytest.raises(InputError, match="in_motion"):
        exported(graybox(["mohr"], in_motion=True))
