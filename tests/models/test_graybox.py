"""The grey box: a sum whose parts, vectors and files agree with one another."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch
from omegaconf import OmegaConf
from torch import Generator, Tensor

from zoo.catalog import build, load, load_model, names, save_model
from zoo.effects.bounds import to_physical
from zoo.errors import InputError
from zoo.fitting.projection import project
from zoo.measurements.run import Run
from zoo.models.graybox import UNSEEN, GrayBox
from zoo.physics.lag import lagged
from zoo.training.variable_projection import VariableProjection

TWO = ["time_s", "temperature_c", "temperature_outer_c", "supply_v", "field_ut", "humidity_pct", "pressure_kpa", "reference_dph"]
ONE = [name for name in TWO if name != "temperature_outer_c"]
STEP_S, BLOCK = 20.0, 5


def graybox(effects: list[str], inputs: list[str] = TWO) -> GrayBox:
    return GrayBox({name: build("effects", name) for name in effects}, inputs)


@pytest.mark.parametrize(
    "inputs", [["time_s", "temperature_c"], ["temperature_c", "time_s", "reference_dph"], "time_s", ["time_s", "reference_dph", "temperature_c"]]
)
def test_columns_in_another_order_would_be_taken_for_each_other(inputs) -> None:
    with pytest.raises(InputError, match=r"model\.inputs=.*reference_UNIT"):
        GrayBox({}, inputs)


def config(effects: list[str], inputs: list[str] = TWO) -> dict[str, object]:
    plain = {name: OmegaConf.to_container(load("effects", name))[name] for name in effects}
    return {"_target_": "zoo.models.graybox.GrayBox", "effects": plain, "inputs": inputs}


def drawn(model: GrayBox, seed: int = 1) -> tuple[Tensor, Tensor]:
    """θ between the bounds and amplitudes."""
    chance = Generator().manual_seed(seed)
    theta = 0.1 + 0.8 * torch.rand(len(model.parameters_of_theta()), generator=chance, dtype=torch.float64)
    width = sum(len(effect.amplitudes) for _, effect in model.named_effects())
    return theta, torch.randn(width, generator=chance, dtype=torch.float64)


@pytest.fixture(params=[TWO, ONE], ids=["two thermometers", "one"])
def full(request) -> GrayBox:
    """Everything in the catalogue, with parameters drawn."""
    model = graybox(names("effects"), request.param)
    model.assign(*drawn(model))
    return model


def test_the_housing_is_where_its_thermometer_is_whichever_column_that_is() -> None:
    """With one in the air behind it, and one on the spool's other side before it."""
    more = [*TWO[:2], "temperature_flange_c", "temperature_outer_c", "temperature_air_c", *TWO[3:]]
    model = graybox(["misalignment"], more)
    x = torch.randn(50, len(more), generator=Generator().manual_seed(1), dtype=torch.float64)
    x[:, 0] = 10.0 * torch.arange(50)
    places = model.histories(x, model.coil_value)
    assert torch.equal(places["housing"].temperature, x[:, more.index("temperature_outer_c")])
    assert torch.equal(places["coil"].gradient, x[:, more.index("temperature_outer_c")] - x[:, 1])
    assert [one.name for one in model.coil_parameters] == ["lag", "weight_flange", "weight_air", "weight_outer", "lead"]


def test_assigned_is_what_theta_gives_back(full) -> None:
    theta, amplitudes = drawn(full, seed=2)
    full.assign(theta, amplitudes)
    near = [0.5 / (one.high - one.low) if one.scale == "index" else 1e-12 for _, one in full.parameters_of_theta()]  # whole numbers are rounded
    assert bool(((full.theta() - theta).abs() <= torch.tensor(near)).all())
    again = full.theta()
    full.assign(again, amplitudes)
    torch.testing.assert_close(full.theta(), again, rtol=0, atol=1e-12)
    torch.testing.assert_close(torch.cat([effect.amplitude for _, effect in full.named_effects()]).detach(), amplitudes, rtol=0, atol=0)
    physical = to_physical(theta, [p for _, p in full.parameters_of_theta()])
    owners = [owner for owner, _ in full.parameters_of_theta()]
    for name, effect in full.named_effects():
        own = torch.tensor([owner == name for owner in owners])
        torch.testing.assert_close(effect.shape_value.detach(), physical[own], rtol=1e-12, atol=0)
    torch.testing.assert_close(full.coil_value.detach(), physical[: len(full.coil_parameters)], rtol=1e-12, atol=0)


def test_the_shares_sum_to_the_prediction(full, raw) -> None:
    x = raw(full.inputs)
    shares = full.shares(x)
    assert list(shares) == names("effects")
    torch.testing.assert_close(sum(shares.values()), full(x), rtol=1e-12, atol=1e-12)
    assert full(x).shape == (len(x),)
    assert bool(torch.isfinite(full(x)).all())


def test_columns_times_amplitudes_are_the_prediction(full, raw) -> None:
    """The way that fits take and the way that predictions take are one."""
    x, (theta, amplitudes) = raw(full.inputs), drawn(full)
    columns = full.columns(x, theta.unsqueeze(0))
    assert columns.shape == (1, len(x), len(amplitudes))
    torch.testing.assert_close(columns[0] @ amplitudes, full(x).detach(), rtol=1e-9, atol=1e-9 * float(full(x).detach().abs().max()))


def test_a_batch_of_theta_is_each_by_itself(full, raw) -> None:
    x = raw(full.inputs, samples=150)
    batch = torch.stack([drawn(full, seed)[0] for seed in (3, 4, 5)])
    for alone, theta in zip(full.columns(x, batch), batch, strict=True):
        torch.testing.assert_close(alone, full.columns(x, theta.unsqueeze(0))[0], rtol=1e-9, atol=1e-9)


def test_an_effects_share_does_not_depend_on_the_others(raw) -> None:
    alone, both = graybox(["mohr"]), graybox(["static_bias", "mohr"])
    for model in (alone, both):
        dict(model.named_effects())["mohr"].amplitude.data += 0.2
    torch.testing.assert_close(alone(raw(TWO)), both(raw(TWO)))
    assert not bool(both.shares(raw(TWO))["static_bias"].any())


def test_what_happened_in_one_run_is_not_predicted_for_another(raw) -> None:
    model, x = graybox(["bias_step"]), raw(TWO)
    step = dict(model.named_effects())["bias_step"]
    step.amplitude.data += 1.0
    step.shape_value.data = torch.tensor([0.5, 2.0], dtype=torch.float64)
    with torch.no_grad():
        assert not bool(model(x).any())
        assert float(model.shares(x, run=2)["bias_step"][-1]) == 1
        assert not bool(model.shares(x, run=UNSEEN)["bias_step"].any())
        step.shape_value.data[1] = 0.0
        assert float(model(x)[-1]) == 1, "at that time in every run: in this one too"


@pytest.mark.parametrize(("effect", "lacks"), [("magnetic", "field_ut"), ("supply_voltage", "supply_v")])
def test_a_missing_column_is_named_with_what_is_there(effect, lacks) -> None:
    with pytest.raises(InputError, match=rf"'{effect}' needs the column {lacks}; the runs have time_s, temperature_c") as caught:
        graybox(["static_bias", effect], [name for name in TWO if name != lacks])
    assert len(str(caught.value).splitlines()) <= 2


def test_the_order_of_the_columns_is_the_models_own(raw) -> None:
    effects = ["static_bias", "mohr", "magnetic", "supply_voltage"]
    shuffled = ["time_s", "temperature_c", "field_ut", "temperature_outer_c", "pressure_kpa", "supply_v", "humidity_pct", "reference_dph"]
    first, second = graybox(effects), graybox(effects, shuffled)
    for model in (first, second):
        model.assign(*drawn(first))
    x = raw(TWO)
    torch.testing.assert_close(second(x[:, [TWO.index(name) for name in shuffled]]), first(x))


def test_saved_and_loaded_predicts_the_same(full, raw, tmp_path) -> None:
    save_model(tmp_path, config(names("effects"), full.inputs), full)
    loaded, x = load_model(tmp_path), raw(full.inputs)
    assert isinstance(loaded, GrayBox)
    assert not loaded.training
    assert torch.equal(loaded(x), full(x))
    torch.testing.assert_close(loaded.theta(), full.theta(), rtol=0, atol=0)


@pytest.mark.parametrize("kind", [str, Path])
def test_loading_from_nowhere_is_refused(tmp_path, kind) -> None:
    with pytest.raises(InputError, match="no saved model"):
        load_model(kind(tmp_path))


def recorded(x: Tensor, error: Tensor, inputs: list[str]) -> Run:
    count, block = torch.ones(len(x), dtype=torch.int64), torch.arange(len(x)) // BLOCK
    return Run("run_1", "dph", STEP_S * BLOCK, tuple(inputs), x, error, count, block)


@pytest.mark.parametrize(("lag", "weight"), [(1000.0, 0.8), (1500.0, 0.85), (2500.0, 0.2)])
def test_a_planted_lag_and_weight_are_found(lag, weight) -> None:
    """From a static bias at the coil's temperature and noise a twentieth of the drift."""
    inputs = ["time_s", "temperature_c", "temperature_outer_c", "reference_dph"]
    time = torch.arange(0, 40000, STEP_S, dtype=torch.float64)
    outer = 20 + 0.01 * ((time - 2000).clamp(0, 4000) - (time - 12000).clamp(0, 6000) + (time - 26000).clamp(0, 5000))
    spool = lagged(time, outer, torch.tensor(700.0, dtype=torch.float64))
    truth = lagged(time, spool + weight * (outer - spool), torch.tensor(lag, dtype=torch.float64))
    noise = 0.005 * torch.randn(len(time), generator=Generator().manual_seed(1), dtype=torch.float64)
    run = recorded(torch.stack([time, spool, outer, 0 * time], -1), 0.01 * (truth - 20) + 0.1 + noise, inputs)
    model = graybox(["static_bias"], inputs)
    VariableProjection().fit(model, [run], Generator())
    assert model.coil_value.tolist() == [pytest.approx(lag, rel=0.05), pytest.approx(weight, abs=0.05), pytest.approx(0.0, abs=30.0)]
    found = model.histories(run.table, model.coil_value)["coil"].temperature.detach()
    assert float((found - truth).abs().max()) < 0.1, "kelvin"


def test_one_thermometer_and_a_coil_ahead_of_it_are_found() -> None:
    """The thermometer lags the coil by 200 s; two poles and a lead undo it."""
    inputs = ["time_s", "temperature_c", "reference_dph"]
    time = torch.arange(0, 40000, STEP_S, dtype=torch.float64)
    truth = 20 + 15 * torch.sin(time / 2500) + 5 * torch.sin(time / 900)
    thermometer = lagged(time, truth, torch.tensor(200.0, dtype=torch.float64))
    noise = 0.002 * torch.randn(len(time), generator=Generator().manual_seed(1), dtype=torch.float64)
    run = recorded(torch.stack([time, thermometer, 0 * time], -1), 0.01 * (truth - 20) + noise, inputs)
    model = graybox(["static_bias"], inputs)
    VariableProjection().fit(model, [run], Generator())
    found = model.histories(run.table, model.coil_value)["coil"].temperature
    settled = time > 2000
    left, before = ((one.detach() - truth)[settled].square().mean().sqrt() for one in (found, thermometer))
    assert float(left) < 0.05 * float(before)


@pytest.mark.parametrize("period", [7.0, 30.0])
def test_fringes_far_from_the_period_that_is_declared_are_found(period) -> None:
    inputs = ["time_s", "temperature_c", "reference_dph"]
    time = torch.arange(0, 36000, STEP_S, dtype=torch.float64)
    temperature = -15 + 65 * time / time[-1]
    fringes = 0.01 * torch.sin(2 * torch.pi * (temperature - 20) / period)
    noise = 0.005 * torch.randn(len(time), generator=Generator().manual_seed(1), dtype=torch.float64)
    run = recorded(torch.stack([time, temperature, 0 * time], -1), -0.07 + 2e-4 * temperature + fringes + noise, inputs)
    model = graybox(["static_bias", "polarization"], inputs)
    VariableProjection().fit(model, [run], Generator())
    bias = torch.stack([(temperature / 50.0) ** power for power in range(4)], dim=-1)
    found, planted = (
        project(bias, one).residual for one in (model.shares(run.table)["polarization"].detach(), fringes)
    )  # the rest is a static bias as well
    assert float((found - planted).square().mean().sqrt()) < 0.25 * float(planted.square().mean().sqrt())


def test_a_word_for_no_is_no_switch() -> None:
    with pytest.raises(InputError, match=r"model\.in_motion=no: true or false"):
        GrayBox({}, ["time_s", "temperature_c", "reference_dph"], "no")  # type: ignore[arg-type]
