"""Laws that every effect of the catalogue obeys from the day it is added."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
import torch
from torch import Tensor

from zoo.catalog import build, load, names
from zoo.effects.base import Effect, Parameter, grid_values, physical_value, unit_value
from zoo.effects.bounds import to_physical, to_unit

NAMES = names("effects")
PARAMETERS = [(name, one) for name in NAMES for one in build("effects", name).shape]
PLACES = ("coil", "housing")
COLUMN_SUFFIXES = ("_v", "_ut", "_pct", "_kpa")
INTERIOR = (0.3, 0.45, 0.62)
"""Places between the bounds, away from either."""
CONTINUOUS = [name for name in NAMES if any(one.scale != "index" for one in build("effects", name).shape)]
SEEN = ("temperature", "rate", "gradient", "thermometer", "reference")
STEEP = {"bias_step"}
"""Effects whose columns jump: two sampling grids see the jump's one sample differently."""
SHOWN = {("bias_step", "onset"): (0.0, 14.0), ("dead_band", "width"): (0.3, 30.0)}
"""Where shapes must lie to show in the run at hand: of 12 h, turned at up to 9.66 a unit."""
BY_VALUE = {"polarization"}
"""Effects whose shapes nearby depend on what the shape is."""
FROM_THE_COLD = ((0, -20), (1, -20), (3, 55), (4, 55), (5, 10), (6, 10), (7, -30), (8, -30), (9, 0), (9.5, -15), (12, 20))
"""Knots [h, °C] of a run that does not begin at room temperature."""
OF_ONE_RUN = {"chamber_cycling": (1, 2, 3, 4)}
"""Effects with columns of their own in each of these runs; those of all others are in the run that is looked at, run 1."""


@pytest.fixture(params=NAMES)
def effect(request) -> Effect:
    return build("effects", request.param)


def shape_at(effect: Effect, place: float) -> Tensor:
    """(S,) a physical shape from a place between the bounds, or where it shows; an index is 1, since run 1 is looked at."""
    declared = [replace(one, low=low, high=high, default=low) for one in effect.shape for low, high in [shown(effect, one)]]
    shape = to_physical(torch.full((len(declared),), place, dtype=torch.float64), declared)
    return torch.stack([torch.ones_like(v) if p.scale == "index" else v for v, p in zip(shape, declared, strict=True)]) if declared else shape


def shown(effect: Effect, one: Parameter) -> tuple[float, float]:
    return SHOWN.get((effect.name, one.name), (one.low, one.high))


def shapes(effect: Effect) -> list[Tensor]:
    """The default, and some others."""
    return [effect.shape_value.detach(), *(shape_at(effect, place) for place in INTERIOR)]


def runs_of(effect: Effect) -> tuple[int, ...]:
    return OF_ONE_RUN.get(effect.name, (1,))


# What an effect declares


def test_it_says_what_it_is(effect) -> None:
    name = next(iter(load("effects", type(effect).name)))
    assert effect.name == name
    assert effect.place in PLACES
    assert all(text.strip() for text in (effect.formula, effect.source, effect.signature, type(effect).__doc__))
    assert all(column.endswith(COLUMN_SUFFIXES) for column in effect.needs)
    assert effect.name not in effect.confused_with
    assert set(effect.confused_with) <= set(NAMES)
    assert 0 <= len(effect.shape) <= 4
    assert len(effect.amplitudes) >= 1


def test_its_parameters_are_declared_in_full(effect) -> None:
    declared = [*effect.shape, *effect.amplitudes]
    assert len({one.name for one in declared}) == len(declared)
    for one in declared:
        assert one.name.isidentifier()
        assert one.unit.strip()
        assert one.source.strip(), one.name
        assert one.meaning.strip(), one.name
        assert math.isfinite(one.low)
        assert math.isfinite(one.high)
        assert one.low < one.high
        assert one.low <= one.default <= one.high
        assert one.grid >= 1
        if one.scale in {"log", "inverse"}:
            assert one.low > 0, f"{one.name}: no logarithm or inverse of 0"
    assert all(one.default == 0 and one.low == -one.high for one in effect.amplitudes), "off by default, of either sign"
    assert all("unit" in one.unit or "ppm" in one.unit for one in effect.amplitudes), "an amplitude carries the output's unit or is a share of it"
    assert effect.shape_value.tolist() == [one.default for one in effect.shape]
    assert effect.amplitude.tolist() == [0.0] * len(effect.amplitudes)


def test_a_spare_amplitude_is_one_of_the_effect_that_it_names(effect, seen) -> None:
    own = effect.columns(seen(effect), shapes(effect)[0])
    for place, one in enumerate(effect.amplitudes):
        if one.spare:
            other = build("effects", one.spare)
            theirs = other.columns(seen(other), shapes(other)[0])
            assert any(torch.equal(own[:, place], theirs[:, there]) for there in range(theirs.shape[1]))
            assert one.spare in effect.confused_with
    assert not all(one.spare for one in effect.amplitudes), "an effect is something by itself"


def test_beside_what_it_would_repeat_a_spare_amplitude_is_nothing(effect, seen) -> None:
    shape, spare = shapes(effect)[0], [place for place, one in enumerate(effect.amplitudes) if one.spare]
    alone, less = effect.beside([effect.name]), effect.beside(NAMES)
    assert alone is effect
    assert (less is effect) is not bool(spare)
    expected = effect.columns(seen(effect), shape)
    expected[:, spare] = 0.0
    assert torch.equal(less.columns(seen(effect), shape), expected)
    assert less.beside([effect.name]).left_out == ()


@pytest.mark.parametrize(("name", "one"), PARAMETERS, ids=[f"{name}.{one.name}" for name, one in PARAMETERS])
def test_unit_and_physical_value_are_inverses(name, one) -> None:
    unit = torch.linspace(0, 1, 41, dtype=torch.float64)
    if one.scale == "index":
        unit = torch.linspace(0, 1, int(one.high - one.low) + 1, dtype=torch.float64)
    physical = physical_value(unit, one)
    torch.testing.assert_close(unit_value(physical, one), unit, rtol=0, atol=1e-12)
    assert sorted(physical[[0, -1]].tolist()) == pytest.approx([one.low, one.high])
    assert bool((torch.diff(physical) > 0).all()) or bool((torch.diff(physical) < 0).all())


@pytest.mark.parametrize("scale", ["linear", "log", "inverse", "index", "share"])
def test_scales_spread_as_they_say(scale) -> None:
    one = Parameter("p", 2.0, "s", 1.0, 8.0, scale)
    middle = {"linear": 4.5, "share": 4.5, "index": 4.0, "log": math.sqrt(8.0), "inverse": 2 / (1 + 1 / 8)}[scale]
    assert float(physical_value(torch.tensor(0.5, dtype=torch.float64), one)) == pytest.approx(middle)
    assert float(unit_value(torch.tensor(middle, dtype=torch.float64), one)) == pytest.approx(3 / 7 if scale == "index" else 0.5)
    assert float(to_unit(torch.tensor([99.0]), [one])) == (0.0 if scale == "inverse" else 1.0), "clipped to the bounds"


def test_a_grid_is_off_the_bounds_and_an_index_counts_the_runs() -> None:
    assert grid_values(Parameter("p", 1.0, "1", 0.0, 8.0, grid=4), 3).tolist() == [1.0, 3.0, 5.0, 7.0]
    assert grid_values(Parameter("p", 1.0, "1", 0.0, 1.0, "share", grid=3), 3).tolist() == [1.0], "a share is tried at its ends near the best"
    run = Parameter("run", 0.0, "1", 0.0, 100.0, "index")
    assert grid_values(run, 3).tolist() == [0.0, 1.0, 2.0, 3.0]
    assert grid_values(run, 1).tolist() == [0.0], "one run is all runs"


@pytest.mark.parametrize(("span_h", "runs"), [(0.5, 1), (12.0, 3), (60.0, 2), (1.0, 120)])
def test_shapes_to_try_are_within_the_bounds(effect, span_h, runs) -> None:
    tried = effect.shapes_to_try(span_h * 3600, runs)
    assert tried.shape[1] == len(effect.shape)
    assert len(tried) >= 1
    for i, one in enumerate(effect.shape):
        assert float(tried[:, i].min()) >= one.low, one.name
        assert float(tried[:, i].max()) <= one.high, one.name
    back = to_physical(to_unit(tried, effect.shape), effect.shape)
    torch.testing.assert_close(back, tried, rtol=1e-9, atol=1e-9)


def test_shapes_nearby_are_looked_at_where_the_shape_is(effect) -> None:
    """On a device that holds no numbers, so that whatever was made elsewhere cannot be mixed in."""
    if effect.name in BY_VALUE or not effect.shape:
        pytest.skip("looks at the values, or has none")
    assert effect.shapes_near(effect.shape_value.detach().to("meta"), 36_000.0).device.type == "meta"


def test_a_share_is_looked_at_from_all_ends_and_the_rest_of_the_shape_stays() -> None:
    near = build("effects", "hysteresis").shapes_near(torch.tensor([6.0, 20.0, 40.0, 0.3], dtype=torch.float64), 36_000.0)
    assert near.tolist() == [[6.0, 20.0, 40.0, past] for past in (-1.0, 0.0, 1.0)]


# What columns are


def test_columns_are_finite_and_of_the_declared_number(effect, seen) -> None:
    history = seen(effect)
    for shape in shapes(effect):
        columns = effect.columns(history, shape)
        assert columns.shape == (len(history.time), len(effect.amplitudes))
        assert columns.dtype == torch.float64
        assert bool(torch.isfinite(columns).all())
        in_all_runs = torch.cat([effect.columns(seen(effect, run=run), shape) for run in runs_of(effect)])
        assert bool((in_all_runs.abs().sum(0) > 0).all()), "a column of zeros explains nothing"


def test_a_batch_of_shapes_is_each_by_itself(effect, seen) -> None:
    history, batch = seen(effect), torch.stack(shapes(effect))
    columns = effect.columns(history, batch)
    assert columns.shape == (len(batch), len(history.time), len(effect.amplitudes))
    for shape, alone in zip(batch, columns, strict=True):
        torch.testing.assert_close(alone, effect.columns(history, shape), rtol=1e-12, atol=1e-12)


def test_a_batch_of_histories_is_each_by_itself(effect, seen) -> None:
    coils, batch = [(100.0, 0.1, 0.0), (300.0, 0.4, 60.0), (900.0, 0.9, -20.0), (2000.0, 0.5, 0.0)], torch.stack(shapes(effect))
    columns = effect.columns(seen(effect, coil=coils), batch)
    for i, coil in enumerate(coils):
        alone = effect.columns(seen(effect, coil=coil), batch[i])
        torch.testing.assert_close(columns[i], alone, rtol=1e-12, atol=1e-12 * max(1.0, float(alone.abs().max())))


def test_forward_is_columns_times_amplitudes_and_linear_in_them(effect, seen) -> None:
    history = seen(effect)
    first, second = torch.randn(2, len(effect.amplitudes), generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    columns = effect.columns(history, effect.shape_value)
    outputs = []
    for amplitude in (first, second, 2 * first - 3 * second):
        effect.amplitude.data = amplitude
        outputs.append(effect(history).detach())
        torch.testing.assert_close(outputs[-1], (columns @ amplitude).detach(), rtol=1e-12, atol=1e-12)
    size = sum(float(one.abs().max()) for one in outputs)
    torch.testing.assert_close(outputs[2], 2 * outputs[0] - 3 * outputs[1], rtol=0, atol=1e-12 * size)
    assert outputs[0].shape == history.time.shape


def test_without_amplitude_there_is_no_effect(effect, seen) -> None:
    assert float(effect(seen(effect)).detach().abs().max()) == 0


def test_finer_sampling_of_the_same_temperatures_changes_nothing(effect, seen) -> None:
    """Lags are exact for straight lines; what is left is the rate's bend within a step of 20 s: 0.5 % of a column."""
    for shape in shapes(effect):
        coarse, fine = (effect.columns(seen(effect, step_s=step), shape) for step in (20.0, 10.0))
        off = (fine[::2] - coarse).abs()
        if effect.name in STEEP:
            assert int((off > 1e-9).sum()) <= 1
            continue
        assert bool((off.amax(0) <= 5e-3 * coarse.abs().amax(0)).all())
        assert bool((off.square().mean(0).sqrt() <= 5e-3 * coarse.square().mean(0).sqrt()).all())


def test_the_clock_may_start_anywhere(effect, seen) -> None:
    for shape in shapes(effect):
        assert torch.equal(effect.columns(seen(effect, start_s=1e6), shape), effect.columns(seen(effect), shape))


def test_the_future_changes_nothing(effect, seen) -> None:
    history = seen(effect)
    later = history.time > 6 * 3600
    changed = replace(
        history,
        **{key: torch.where(later, getattr(history, key) + 7.0, getattr(history, key)) for key in SEEN},
        inputs={key: torch.where(later, value + 1.0, value) for key, value in history.inputs.items()},
    )
    for shape in shapes(effect):
        before, after = effect.columns(history, shape), effect.columns(changed, shape)
        torch.testing.assert_close(after[~later], before[~later], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", CONTINUOUS)
def test_gradients_to_the_shape_are_those_of_finite_differences(name, seen) -> None:
    """In every sample but the few in which a kink (a relay, a clamp) lies within the step."""
    effect = build("effects", name)
    history = seen(effect, knots=FROM_THE_COLD)
    for shape in shapes(effect)[1:]:
        for i, one in enumerate(effect.shape):
            if one.scale == "index":
                continue
            direction = torch.zeros_like(shape)
            direction[i] = 1.0
            _, slope = torch.func.jvp(lambda s: effect.columns(history, s), (shape,), (direction,))
            step = 1e-6 * float(shape[i].abs()) + 1e-7
            above, below = (effect.columns(history, shape + sign * step * direction) for sign in (1, -1))
            expected = (above - below) / (2 * step)
            size = float(expected.abs().max())
            assert size > 0, f"{one.name} changes nothing"
            wrong = (slope - expected).abs() > 1e-5 * size + 1e-9 / step * 1e-6
            assert float(wrong.double().mean()) < 0.005, one.name


def test_gradients_reach_shape_and_amplitude(effect, seen) -> None:
    effect.amplitude.data += 0.3
    torch.cat([effect(seen(effect, knots=FROM_THE_COLD, run=run)) for run in runs_of(effect)]).square().sum().backward()
    assert bool((effect.amplitude.grad != 0).all())
    for i, one in enumerate(effect.shape):
        if one.scale != "index":
            assert float(effect.shape_value.grad[i]) != 0, one.name
