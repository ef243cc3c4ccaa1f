"""Rate-independent memory: what Preisach's operators must do."""

from __future__ import annotations

from itertools import pairwise

import pytest
import torch
from torch import Tensor

from zoo.catalog import build
from zoo.effects.hysteresis import WIDTHS, play

CYCLE = ((0, 20), (1, 20), (6, 60), (16, -40), (22, 20), (26, 20))
"""A closed cycle from one isothermal state back to it, at 0.1 to 0.2 K/min."""


def path(*turns: float, steps: int = 50) -> Tensor:
    """Straight from turn to turn."""
    parts = [torch.linspace(a, b, steps + 1, dtype=torch.float64)[1:] for a, b in pairwise(turns)]
    return torch.cat([torch.tensor([turns[0]], dtype=torch.float64), *parts])


def shape_of(*values: float) -> Tensor:
    return torch.tensor(values, dtype=torch.float64)


NO_PAST = (shape_of(0.0), shape_of(20.0))


def loop_of(temperature: Tensor, warped, seen, time: Tensor | None = None, shape: Tensor | None = None) -> Tensor:
    effect = build("effects", "hysteresis")
    time = torch.arange(len(temperature), dtype=torch.float64) * 60 if time is None else time
    return effect.columns(warped(seen(effect), time, temperature), shape_of(6.0, 20.0, 30.0, 0.0) if shape is None else shape)[:, 0]


def test_hysteresis_does_not_know_the_rate(warped, seen) -> None:
    """The same temperatures in the same order, taken a hundred times slower, faster and with rests in between: the same values."""
    course = path(20, 50, 10, 35, 0, 20)
    once = loop_of(course, warped, seen)
    chance = torch.rand(len(course), generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    assert torch.equal(loop_of(course, warped, seen, time=(chance * 6000 + 1).cumsum(0)), once)
    rests = 1 + (chance * 4).long()
    assert torch.equal(loop_of(course.repeat_interleave(rests), warped, seen), once.repeat_interleave(rests))


def test_hysteresis_passes_through_finer_steps_unchanged(warped, seen) -> None:
    coarse, fine = path(20, 50, 10, 35, 0, 20, steps=50), path(20, 50, 10, 35, 0, 20, steps=200)
    torch.testing.assert_close(loop_of(fine, warped, seen)[::4], loop_of(coarse, warped, seen), rtol=0, atol=1e-12)


def test_a_minor_loop_closes(warped, seen) -> None:
    """Return-point memory (Madelung's second rule): back at a turning point, the state is what it was there."""
    value = loop_of(path(20, 50, 30, 45, 30, 10), warped, seen)
    assert float(value[100] - value[200]) == pytest.approx(0, abs=1e-12)
    assert float(value[75] - value[175]) != pytest.approx(0, abs=1e-3), "it is a loop: at 40 °C, going down, then up again"


def test_a_larger_excursion_wipes_a_minor_loop_out(warped, seen) -> None:
    """Madelung's third rule: past the point where it began, the path goes on as if the loop had not been."""
    with_loop, without = loop_of(path(20, 50, 30, 45, 30, 10), warped, seen), loop_of(path(20, 50, 30, 10), warped, seen)
    assert torch.equal(with_loop[200:], without[100:])
    nested = loop_of(path(20, 50, 30, 45, 35, 42, 35, 45, 30, 10), warped, seen)
    assert torch.equal(nested[400:], without[100:])


def test_up_and_down_differ_at_every_temperature_and_stay_within_one(warped, seen) -> None:
    value = loop_of(path(-60, 100, -60, 100), warped, seen)
    down, up = value[50:101], value[100:151].flip(0)
    assert bool((down[6:-6] > up[6:-6]).all()), "it lags: higher on the way down"
    assert float(value.abs().max()) <= 1.0
    wide = loop_of(path(0, 1, 0), warped, seen)
    assert float((wide - wide[0]).abs().max()) < 1e-12, "an excursion smaller than the narrowest relay moves nothing"


def test_the_play_is_the_loop_of_the_textbook() -> None:
    moved = play(shape_of(0.0, 3.0, 5.0, 1.0, -4.0, 0.0), shape_of(2.0), *NO_PAST)
    assert moved.tolist() == [0.0, 1.0, 3.0, 3.0, -2.0, -2.0]
    soaked = play(shape_of(50.0, 51.0, 49.0), shape_of(2.0), *NO_PAST)
    assert soaked.tolist() == [50.0, 50.0, 50.0], "it starts where the first temperature puts it"


@pytest.mark.parametrize(("low", "high"), [(30.0, 45.0), (25.0, 45.0), (30.0, 33.0)])
def test_minor_loops_between_the_same_turns_are_congruent(low, high, warped, seen) -> None:
    """Preisach's property (Mayergoyz 1986, Phys. Rev. Lett. 56:1518): whatever came before, the loop is the same but for an offset."""
    settled = [loop_of(path(20, first, high, low, high, low), warped, seen)[150:] for first in (90, -60)]
    offset = settled[0] - settled[1]
    assert float((offset - offset[0]).abs().max()) < 1e-12
    assert float(offset[0].abs()) > 1e-3, "reached from above and from below"
    moves = float(settled[0].max() - settled[0].min())
    assert (moves > 1e-3) == (high - low > 2 * 3.0), "a loop narrower than the narrowest relay is none"


def test_a_wide_spread_is_a_mean_of_plain_plays(warped, seen) -> None:
    """s·tanh((w − c0)/s) → w − c0, with the error of the tangent, (w − c0)³/3s²."""
    course, spread = path(20, 50, 10, 35, 0, 20), 1e4
    loop = spread * loop_of(course, warped, seen, shape=shape_of(6.0, 20.0, spread, 0.0))
    plays = torch.stack([play(course, shape_of(factor * 6.0), *NO_PAST) for factor in WIDTHS]).mean(0) - 20.0
    torch.testing.assert_close(loop, plays, rtol=0, atol=30.0**3 / 3 / spread**2 + 1e-9)


def test_a_narrow_loop_is_a_function_of_the_temperature(warped, seen) -> None:
    course = path(20, 50, 10, 35, 0, 20)
    loop = loop_of(course, warped, seen, shape=shape_of(1e-6, 20.0, 30.0, 0.0))
    torch.testing.assert_close(loop, torch.tanh((course - 20.0) / 30.0), rtol=0, atol=1e-6)


def test_a_play_of_relays_is_the_sum_over_relays(warped, seen) -> None:
    """The effect's claim, against relays that are switched one by one: up at c + r, down at c − r, density sech²((c − c0)/s)/2s."""
    course = path(20, 50, 10, 35, 0, 20, steps=40)
    centres = torch.linspace(-220, 260, 4801, dtype=torch.float64)
    density = torch.cosh((centres - 20.0) / 30.0).pow(-2) / 30.0 / 2 * float(centres[1] - centres[0])
    total = torch.zeros_like(course)
    for factor in WIDTHS:
        state = torch.where(course[0] > centres, 1.0, -1.0).double()
        for k, now in enumerate(course):
            state = torch.where(now > centres + factor * 6.0, 1.0, torch.where(now < centres - factor * 6.0, -1.0, state)).double()
            total[k] += density @ state / len(WIDTHS)
    torch.testing.assert_close(loop_of(course, warped, seen), total, rtol=0, atol=2e-3)


def test_hysteresis_leaves_an_angle_round_a_cycle(seen) -> None:
    effect = build("effects", "hysteresis")
    history = seen(effect, knots=CYCLE)
    loop = effect.columns(history, shape_of(6.0, 20.0, 40.0, 0.0))[:, 0] - torch.tanh((history.temperature - 20.0) / 40.0)
    assert abs(float(torch.trapezoid(loop, history.time))) > 0.05 * float(torch.trapezoid(loop.abs(), history.time))


def test_widths_that_shapes_share_change_nothing() -> None:
    course = 30.0 * torch.sin(torch.linspace(0.0, 9.0, 80, dtype=torch.float64))
    widths = torch.tensor([[4.0], [2.0], [4.0], [9.0], [2.0]], dtype=torch.float64)
    pasts = torch.tensor([[0.0], [1.0], [-1.0], [0.5], [1.0]], dtype=torch.float64)
    turns = shape_of(20.0, 60.0, 1.0)
    one_by_one = [play(course, *one, turns) for one in zip(widths, pasts, strict=True)]
    torch.testing.assert_close(play(course, widths, pasts, turns), torch.stack(one_by_one), rtol=0, atol=0)


@pytest.mark.parametrize(("room", "there"), [(15.0, -36.0), (15.0, -1.0), (25.0, 60.0), (25.0, 26.0)])
def test_a_whole_past_is_the_way_from_room_temperature(room, there, warped, seen) -> None:
    """A record that begins in the cold goes on as one that was switched on in the laboratory does."""
    course = path(room, there, 50, 10)
    whole, later = loop_of(course, warped, seen), loop_of(course[50:], warped, seen, shape=shape_of(6.0, 20.0, 30.0, 1.0))
    torch.testing.assert_close(later, whole[50:], rtol=0, atol=1e-12)
    fresh = loop_of(course[50:], warped, seen)
    assert float((later - fresh)[0].abs()) > 1e-3
    assert torch.equal(later[-10:], fresh[-10:]), "wiped out"
    half = loop_of(course[50:], warped, seen, shape=shape_of(6.0, 20.0, 30.0, 0.5))
    assert bool(((half - fresh) * (later - half) >= 0).all())


def test_a_run_that_begins_at_room_temperature_has_no_other_past(warped, seen) -> None:
    course = path(20, 50, 10, 35, 0, 20)
    assert torch.equal(loop_of(course, warped, seen, shape=shape_of(6.0, 20.0, 30.0, 1.0)), loop_of(course, warped, seen))
