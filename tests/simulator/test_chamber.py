"""What the air does: lag, overshoot, cycling, and when the fan runs."""

from __future__ import annotations

import cmath
import math
from itertools import pairwise
from typing import Any

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from zoo.catalog import build, names
from zoo.errors import InputError
from zoo.physics.lag import lagged
from zoo.simulator.laboratory.chamber import WANDER_RAD, Chamber
from zoo.simulator.laboratory.profiles import legs, sine
from zoo.simulator.laboratory.program import Program
from zoo.simulator.streams import stream

LEGS = st.lists(st.tuples(st.floats(-60, 90), st.floats(-60, 90), st.floats(1, 1e4)), min_size=1, max_size=6)
OVERSHOOTS = [0.001, 0.02, 0.1, 0.3, 0.5]
HELD = Program(((20, 20, 1e6),))


def grid(seconds: float, step: float) -> torch.Tensor:
    return torch.arange(0, seconds + step / 2, step, dtype=torch.float64)


def air(chamber: Chamber, program: Program, time: torch.Tensor, seed: int = 1) -> torch.Tensor:
    return chamber.air(program, time, stream(seed, "chamber"))


def test_a_step_is_followed_by_an_exponential() -> None:
    time = grid(4000, 7.0)
    seen = air(Chamber(lag_s=120), Program(((20, 20, 500.3), (60, 60, 4000))), time)
    since = time - 500.3
    assert torch.allclose(seen, torch.where(since < 0, 20.0, 60 - 40 * torch.exp(-since / 120)), atol=1e-11)


@pytest.mark.parametrize("overshoot", OVERSHOOTS)
@pytest.mark.parametrize("to_c", [60.0, -40.0])
def test_a_step_is_overshot_by_the_fraction_asked_for_and_then_settles(overshoot: float, to_c: float) -> None:
    time = grid(20000, 0.5)
    seen = (air(Chamber(lag_s=120, overshoot=overshoot), Program(((20, 20, 100), (to_c, to_c, 20000))), time) - 20) / (to_c - 20)
    assert float(seen.max()) - 1 == pytest.approx(overshoot, rel=1e-4)
    assert float(seen.min()) >= -1e-12
    assert float(seen[-1]) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("overshoot", [0.0, *OVERSHOOTS])
def test_on_a_ramp_the_air_is_late_by_the_lag_and_afterwards_it_settles(overshoot: float) -> None:
    time = grid(60000, 10.0)
    seen = air(Chamber(lag_s=120, overshoot=overshoot), Program(((0, 0, 600), (0, 500, 30000), (500, 500, 29400))), time)
    assert float(seen[3060]) == pytest.approx(500 - 120 / 60, abs=1e-6)
    assert torch.equal(seen[:61], torch.zeros(61, dtype=torch.float64))
    assert float(seen[-1]) == pytest.approx(500, abs=1e-9)


@pytest.mark.parametrize("overshoot", [0.0, *OVERSHOOTS])
@pytest.mark.parametrize("period", [300.0, 1200.0, 6000.0])
def test_a_sine_comes_out_as_the_transfer_function_says(overshoot: float, period: float) -> None:
    lag, damping = 120.0, -math.log(overshoot) / math.hypot(math.pi, math.log(overshoot)) if overshoot else math.inf
    s = 2j * math.pi / period
    gain = 1 / (1 + lag * s + (lag * s / (2 * damping)) ** 2)
    program = sine(20, 10, period, cycles=40, start_s=0).of(1)
    time = grid(40 * period, period / 50)[-200:]
    wanted = 20 + 10 * abs(gain) * torch.sin(2 * math.pi * time / period + cmath.phase(gain))
    assert torch.allclose(air(Chamber(lag, overshoot), program, time), wanted, atol=10 * 6e-4 * max(1, abs(gain)))


@given(LEGS, st.floats(1, 1e4), st.sampled_from([0.0, *OVERSHOOTS]), st.integers(2, 400))
def test_the_air_does_not_know_how_often_it_is_sampled(rows: list[tuple[float, float, float]], lag: float, overshoot: float, count: int) -> None:
    program, chamber = Program(tuple(rows)), Chamber(lag, overshoot)
    time = torch.linspace(0, 1.2 * program.seconds, 400, dtype=torch.float64)
    assert torch.allclose(air(chamber, program, time)[-count:], air(chamber, program, time[-count:]), atol=1e-10)


@given(st.lists(st.tuples(st.floats(-60, 90), st.integers(1, 50)), min_size=2, max_size=6), st.floats(1, 1e4))
def test_without_overshoot_it_is_the_lag_of_a_thermometer(corners: list[tuple[float, int]], lag: float) -> None:
    rows = [(start, end, 10.0 * steps) for (start, _), (end, steps) in pairwise(corners)]
    program = Program(tuple(rows))
    time = grid(program.seconds, 10.0)
    wanted = lagged(time, program.asked(time), torch.tensor(lag, dtype=torch.float64))
    assert torch.allclose(air(Chamber(lag), program, time), wanted, atol=1e-9)


def test_an_ideal_chamber_does_what_it_is_asked() -> None:
    program, time = legs([[20, 20, 600], [20, 60, 2400], [10, 10, 600]]).of(1), grid(3600, 10.0)
    assert torch.equal(air(build("chamber", "ideal"), program, time), program.asked(time))


def test_a_plain_chamber_leaves_chance_alone() -> None:
    source = stream(1, "chamber")
    before = source.get_state()
    build("chamber", "plain").air(HELD, grid(600, 10.0), source)
    assert torch.equal(source.get_state(), before)


def cycling(step: float, rows: int = 200_000, seed: int = 1, **settings: float) -> torch.Tensor:
    chamber = Chamber(**{"cycling_k": 0.3, "cycling_s": 300.0, **settings})
    return chamber.cycling(torch.arange(rows, dtype=torch.float64) * step, stream(seed, "chamber"))


def test_cycling_is_a_sine_of_its_amplitude_around_the_set_point() -> None:
    seen = air(Chamber(cycling_k=0.3), HELD, grid(200_000, 5.0)) - 20
    assert float(seen.abs().max()) == pytest.approx(0.3, rel=1e-3)
    assert float(seen.square().mean().sqrt()) == pytest.approx(0.3 / 2**0.5, rel=0.02)
    assert abs(float(seen.mean())) < 0.01


def test_cycling_is_a_narrow_line_at_its_period() -> None:
    seen = cycling(10.0)
    power = torch.fft.rfft(seen).abs().square()
    frequency = torch.fft.rfftfreq(len(seen), 10.0, dtype=torch.float64)
    near = (frequency * 300 - 1).abs() < 0.1
    assert float(power[near].sum() / power.sum()) > 0.9


@pytest.mark.parametrize("period", [120.0, 600.0])
def test_its_phase_wanders_from_period_to_period(period: float) -> None:
    """A phase that walks at random by W within a period leaves exp(−W²n/2) of the correlation after n periods."""
    seen = cycling(period / 12, cycling_s=period) / 0.3
    for periods in (1, 5, 20):
        later = 12 * periods
        kept = 2 * float((seen[:-later] * seen[later:]).mean())
        assert kept == pytest.approx(math.exp(-(WANDER_RAD**2) * periods / 2), abs=0.04)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.8, 1.5])
def test_rows_show_of_the_cycling_what_their_mean_leaves(share: float) -> None:
    """Against means of a sampling a hundred times finer; the wandering is left out by looking at one row only."""
    steps = 100
    fine = cycling(300 * share / steps, rows=steps * 4000).reshape(-1, steps).mean(1)
    seen = cycling(300 * share, rows=20_000)
    assert float(seen.square().mean().sqrt()) == pytest.approx(float(fine.square().mean().sqrt()), rel=0.06)


def test_rows_of_one_period_show_no_cycling() -> None:
    assert float(cycling(300.0, rows=100).abs().max()) < 1e-12


def test_chance_comes_from_the_stream() -> None:
    assert torch.equal(cycling(10.0, 100), cycling(10.0, 100))
    assert not torch.allclose(cycling(10.0, 100), cycling(10.0, 100, seed=2), atol=0.01)


def test_the_fan_runs_while_the_set_point_moves() -> None:
    program = legs([[20, 20, 600], [20, 60, 1200], [60, 60, 600], [10, 10, 600], [10, 0, 300]]).of(1)
    time = grid(4000, 10.0)
    running = Chamber(fan="in_motion").fan_on(program, time)
    assert running.unique().tolist() == [0.0, 1.0]
    assert time[running > 0].tolist() == [*range(600, 1800, 10), *range(3000, 3300, 10)]
    assert Chamber(fan="always").fan_on(program, time).min() == 1.0
    assert Chamber(fan="never").fan_on(program, time).max() == 0.0


@pytest.mark.parametrize("name", names("chamber"))
def test_every_preset_keeps_a_hold_within_its_cycling(name: str) -> None:
    chamber = build("chamber", name)
    seen = air(chamber, HELD, grid(36000, 10.0))
    assert float((seen - 20).abs().max()) <= chamber.cycling_k + 1e-12


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"lag_s": -1}, "chamber.lag_s=-1"),
        ({"lag_s": math.nan}, "chamber.lag_s=nan"),
        ({"lag_s": "slow"}, "chamber.lag_s=slow"),
        ({"overshoot": 0.6}, "0 to 0.5"),
        ({"overshoot": True}, "chamber.overshoot=True"),
        ({"overshoot": 0.1, "lag_s": 0}, "without a lag"),
        ({"cycling_k": -0.1}, "chamber.cycling_k"),
        ({"cycling_s": 0}, "chamber.cycling_s"),
        ({"fan_dph": math.inf}, "chamber.fan_dph"),
        ({"fan": "alway"}, "did you mean always"),
        ({"fan": False}, "nown: always, in_motion, never"),
    ],
)
def test_absurd_chambers_are_refused(settings: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        Chamber(**settings)
