"""What ages, dries or slips goes on from run to run as it would have in one run."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from zoo.catalog import build
from zoo.effects.earlier import BINS, Before, Earlier, before_each, turns_of
from zoo.models.graybox import UNSEEN
from zoo.simulator.gyros.presets import gyro_class
from zoo.simulator.laboratory.profiles import campaign, tour
from zoo.simulator.simulate import simulate

SHAPES = {"aging": ((-0.5,), (0.0,), (0.6,)), "moisture": ((5.0, 30.0), (20.0, 80.0)), "hysteresis": ((6.0, 20.0, 40.0),)}
PROFILE = campaign([tour(20, [(60, 1.0, 3600), (20, 1.0, 3600)], 3600)], tour(20, [(0, 1.0, 3600)], 3600))
ANEW, ON = {"hysteresis": 1.0}, {"hysteresis": -1.0}
"""What the shape is, after those of `SHAPES`, where every run starts anew and where it goes on, if not 0 and 1."""
THEN = {"moisture": (1.0,)}
"""Shapes after that."""
REMEMBERED = Before(torch.rand(4, BINS, dtype=torch.float64), torch.rand(4, 7, dtype=torch.float64))
CUT = 300
"""Row at which one run of twelve hours is taken for two."""


def shape_of(*values: float) -> Tensor:
    return torch.tensor(values, dtype=torch.float64)


@pytest.fixture(params=[(name, shape) for name, shapes in SHAPES.items() for shape in shapes], ids=str)
def remembering(request):
    """An effect, and the shapes with which it starts anew and goes on."""
    name, shape = request.param
    return build("effects", name), *(shape_of(*shape, one.get(name, other), *THEN.get(name, ())) for one, other in ((ANEW, 0.0), (ON, 1.0)))


def later(history, run):
    """The second part of a run as a file of its own."""
    fields = {name: getattr(history, name)[CUT:] for name in ("temperature", "rate", "gradient", "thermometer", "reference")}
    return replace(history, time=history.time[CUT:] - history.time[CUT], run=run, **fields)


def test_a_run_cut_in_two_goes_on_as_if_it_had_not_been(remembering, seen) -> None:
    """But for the temperatures at which time is counted, 2 K apart."""
    effect, _, on = remembering
    whole = seen(effect)
    before = before_each([(whole.time[: CUT + 1], whole.temperature[: CUT + 1])])
    found, expected = effect.after(before).columns(later(whole, 2), on), effect.columns(whole, on)[CUT:]
    torch.testing.assert_close(found, expected, rtol=1e-2, atol=0)


def test_starting_anew_it_knows_of_nothing_before(remembering, seen) -> None:
    effect, anew, on = remembering
    history = seen(effect)
    told = effect.after(before_each([(history.time, history.temperature)] * 2))
    assert told is not effect
    torch.testing.assert_close(told.columns(replace(history, run=2), anew), effect.columns(history, anew), rtol=0, atol=0)
    torch.testing.assert_close(told.columns(history, on), effect.columns(history, anew), rtol=0, atol=0)  # nothing is before the first
    assert not torch.equal(told.columns(replace(history, run=2), on), told.columns(history, on))


def test_what_was_not_fitted_comes_after_all_that_was(remembering, seen) -> None:
    effect, _, on = remembering
    history = seen(effect)
    told = effect.after(before_each([(history.time, history.temperature)] * 2))
    torch.testing.assert_close(told.columns(replace(history, run=UNSEEN), on), told.columns(replace(history, run=3), on), rtol=0, atol=0)


def test_runs_together_are_what_each_is_alone(remembering, seen) -> None:
    effect, anew, on = remembering
    history, shapes = seen(effect), torch.stack([anew, on, on])
    told = effect.after(before_each([(history.time, history.temperature)] * 3))
    numbers = torch.tensor([1.0, 3.0], dtype=torch.float64).reshape(-1, 1, 1)
    fields = {name: getattr(history, name).expand(2, 1, -1) for name in ("temperature", "rate", "gradient", "thermometer", "reference")}
    together = told.columns(replace(history, run=numbers, **fields), shapes)
    for one, run in zip(together, (1, 3), strict=True):
        torch.testing.assert_close(one, told.columns(replace(history, run=run), shapes).expand_as(one), rtol=1e-12, atol=1e-14)


def test_time_is_shared_by_the_temperatures_beside_it() -> None:
    """Its sum is the run's length and its mean the run's; what is colder or hotter than any counts at the end."""
    time = torch.linspace(0, 36000, 1001, dtype=torch.float64) ** 1.01
    celsius = 20 + 55 * torch.sin(time / 5000)
    none, once, twice = before_each([(time, celsius), (time, celsius)]).dwell
    assert not bool(none.any())
    torch.testing.assert_close(twice, 2 * once)
    assert float(once.sum()) == pytest.approx(float(time[-1] - time[0]))
    assert float((once * Earlier().celsius).sum() / once.sum()) == pytest.approx(float(torch.trapezoid(celsius, time) / (time[-1] - time[0])))
    _, beyond = before_each([(time, celsius * 10)]).dwell
    assert float(beyond.sum()) == pytest.approx(float(once.sum()))


def test_a_saved_clock_is_loaded_with_as_many_runs_as_it_knows() -> None:
    known, other = build("effects", "aging").after(REMEMBERED), build("effects", "aging")
    other.load_state_dict(known.state_dict())
    torch.testing.assert_close(other.earlier.dwell, REMEMBERED.dwell, rtol=0, atol=0)
    torch.testing.assert_close(other.earlier.turns, REMEMBERED.turns, rtol=0, atol=0)


@pytest.mark.parametrize(
    ("way", "left"),
    [
        ([20, 60, -40, 50, 0, 40], [20, 60, -40, 50, 0, 40]),
        ([20, 60, -40, 50, 0, 70], [20, -40, 70]),
        ([20, 30, 25, 30, 10, 15], [20, 30, 10, 15]),
        ([20, 20, 20], [20, 20]),
        ([20, 30, 40], [20, 40]),
        ([40, 30, 20, 25, 20], [40, 20]),
    ],
)
def test_a_larger_swing_wipes_out_smaller_ones_before_it(way, left) -> None:
    assert turns_of(torch.tensor(way, dtype=torch.float64)).tolist() == left


@pytest.mark.parametrize("seed", range(5))
def test_any_play_is_where_the_whole_way_has_led_it(seed) -> None:
    """Whatever its width: the state of a play, and so of every relay, depends on the turns that are left alone."""
    way = 20.0 + torch.randn(2000, dtype=torch.float64, generator=torch.Generator().manual_seed(seed)).cumsum(0)
    turns = turns_of(way)
    assert len(turns) < 60
    for width in (0.3, 2.0, 7.0, 20.0, 200.0):
        ends = []
        for course in (way, turns):
            play = float(way[0])
            for celsius in course.tolist():
                play = min(max(play, celsius - width), celsius + width)
            ends.append(play)
        assert ends[0] == ends[1]


@pytest.mark.parametrize("name", SHAPES)
def test_one_run_has_nothing_to_go_on_from(name) -> None:
    effect, place = build("effects", name), len(SHAPES[name][0])
    assert set(effect.shapes_to_try(36000.0, 1)[:, place].tolist()) == {0.0}
    looked_at = effect.shapes_to_try(36000.0, 2)
    assert set(torch.cat([looked_at, effect.shapes_near(looked_at[0], 36000.0)])[:, place].tolist()) >= {0.0, ON.get(name, 1.0)}


@pytest.mark.parametrize("name", SHAPES)
def test_it_counts_where_the_run_is(name, seen) -> None:
    """On a device that holds no numbers, whatever the clock was told elsewhere."""
    effect, history = build("effects", name).after(REMEMBERED), seen(build("effects", name))
    away = {one: getattr(history, one).to("meta") for one in ("time", "temperature", "rate", "gradient", "thermometer", "reference")}
    assert (
        effect.columns(replace(history, **away), shape_of(*SHAPES[name][0], ON.get(name, 1.0), *THEN.get(name, ())).to("meta")).device.type == "meta"
    )


def test_a_simulated_gyro_goes_on_as_well() -> None:
    """As in the chamber: the check run comes after all the others."""
    given = {"aging": {"bend": -1.0, "goes_on": 1.0, "drift": 0.1}}
    first, second, check = simulated(given, "aging")
    for before, after in ((first, second), (second, check)):
        assert float(after[0]) == pytest.approx(float(before[-1]), rel=1e-3)
        assert bool((after.diff() > 0).all())


def test_a_simulated_loop_begins_where_the_chamber_has_led_it() -> None:
    first, second, check = simulated({"hysteresis": {"past": -1.0, "amplitude": 0.1}}, "hysteresis")
    assert float(second[0]) > float(first[0]) + 0.01, "it has been heated and cooled again, and lags"
    assert float(second[0]) == float(check[0]), "by the same program twice"


def simulated(given: dict[str, dict[str, float]], name: str) -> list[Tensor]:
    """What an effect does in two runs and the check run."""
    effects = {one: build("effects", one) for one in given}
    gyros = simulate(gyro_class("medium"), PROFILE, effects, parameters=given, runs=2, seed=1, sample_s=60.0)
    return [one.truth[f"{name}_dph"] for one in (*gyros.runs, gyros.check)]
