"""Where each effect of the catalogue stands in a hold, round a cycle, between heating and cooling, to the true input: a new one has to say so."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, NamedTuple

import pytest
import torch
from torch import Tensor

from zoo.catalog import build, names
from zoo.effects.base import Effect, History
from zoo.effects.sum import Sum

NAMES = names("effects")
RAMP = ((0, 20), (1, 20), (2, 50), (9, 50))
"""An hour at 20 °C, an hour at 0.5 K/min, seven hours at 50 °C."""
CYCLE = ((0, 20), (1, 20), (6, 60), (16, -40), (22, 20), (60, 20))
"""A closed cycle from one isothermal state back to it, at 0.1 to 0.2 K/min, and more than a day for what relaxes slowly."""
MIRROR_C = 20.0


class Stand(NamedTuple):
    """What is expected of an effect at its default shape.

    Attributes:
        hold: what is left long after the last change, with all recorded inputs constant.
        angle: whether the integral over a closed cycle vanishes, as that of a function of state does; None where nothing is said.
        parity: of each column where the temperatures are mirrored about 20 °C, so that heating becomes cooling; 0 for neither.
        turned: what of the true input it follows.
        shape: values for the parity, where the default's is none.
    """

    hold: Literal["nothing", "constant", "goes on"]
    angle: bool | None
    parity: tuple[int, ...]
    turned: Literal["nothing", "sign", "value"] = "nothing"
    shape: tuple[float, ...] | None = None


STANDS = {
    "static_bias": Stand("constant", False, (1, -1, 1, -1)),
    "shupe": Stand("nothing", True, (-1,)),
    "mohr": Stand("nothing", True, (-1,)),
    "thermal_gradient": Stand("nothing", True, (-1, -1)),
    "sensor_lag": Stand("nothing", True, (-1,)),
    "rate_temperature_coupling": Stand("nothing", True, (1, -1)),
    "glass_transition": Stand("nothing", True, (0, -1), shape=(MIRROR_C, 8.0, 1.0)),
    "viscoelastic": Stand("nothing", True, (-1, -1), shape=(2.0, 0.0, 0.0, 0.0)),
    "hysteresis": Stand("constant", False, (-1,)),
    "polarization": Stand("constant", False, (1, -1, 1, -1, 1, -1)),
    "scale_factor": Stand("constant", False, (1, -1, 1), "value"),
    "scale_factor_nonlinearity": Stand("constant", False, (1, 1, -1, 1), "value"),
    "misalignment": Stand("constant", False, (1, -1, 1), "value"),
    "magnetic": Stand("constant", False, (1, -1)),
    "supply_voltage": Stand("constant", False, (1, 1)),
    "warm_up": Stand("goes on", False, (1, 1)),
    "aging": Stand("goes on", False, (1,)),
    "moisture": Stand("goes on", False, (0, 0)),
    "fixture_rotation": Stand("nothing", True, (-1, -1), "sign"),
    "chamber_cycling": Stand("goes on", None, (1,) * 8),
    "bias_step": Stand("constant", False, (1,)),
    "dead_band": Stand("constant", False, (1,), "value"),
}


@pytest.fixture(params=NAMES)
def effect(request) -> Effect:
    return build("effects", request.param)


def test_every_effect_has_a_stand() -> None:
    assert set(STANDS) == set(NAMES)
    assert all(len(stand.parity) == len(build("effects", name).amplitudes) for name, stand in STANDS.items())


def steadied(history: History) -> History:
    """The same temperatures with a true input and recorded inputs that never change."""
    inputs = {name: torch.full_like(value, float(value[0]) + 1.0) for name, value in history.inputs.items()}
    return replace(history, reference=torch.full_like(history.reference, 0.15), inputs=inputs)


def default_columns(effect: Effect, history: History) -> Tensor:
    return effect.columns(history, effect.shape_value.detach())


def test_long_after_the_last_change_is_left_what_is_said(effect, seen) -> None:
    history = steadied(seen(effect, knots=RAMP))
    columns = default_columns(effect, history)
    hold, size, settled = STANDS[effect.name].hold, float(columns.abs().max()), columns[history.time > 8 * 3600]
    if hold == "nothing":
        assert float(settled.abs().max()) < 1e-5 * size
        assert float(columns[history.time <= 3000].abs().max()) < 1e-12, "nor in the hold before, for the coil is soaked at the start"
    elif hold == "constant":
        assert spread_of(settled) < 1e-6 * size
        assert float(settled.abs().max()) > 1e-3 * size
    else:
        assert spread_of(columns[history.time > 3 * 3600]) > 1e-5 * size


def spread_of(columns: Tensor) -> float:
    return float((columns.amax(0) - columns.amin(0)).max())


def test_round_a_closed_cycle_functions_of_state_leave_no_angle(effect, seen) -> None:
    history = steadied(seen(effect, knots=CYCLE))
    columns = default_columns(effect, history)
    angle, path = (torch.trapezoid(one, history.time, dim=0) for one in (columns, columns.abs()))
    share = angle.abs() / path.clamp_min(1e-300)
    if STANDS[effect.name].angle:
        assert float(share.max()) < 1e-3
    elif STANDS[effect.name].angle is False:
        assert float(share.max()) > 0.02


def mirrored(history: History) -> History:
    """Every temperature as far below 20 °C as it was above."""
    opposite = {key: -getattr(history, key) for key in ("rate", "gradient")}
    return replace(history, temperature=2 * MIRROR_C - history.temperature, thermometer=2 * MIRROR_C - history.thermometer, **opposite)


def test_columns_are_even_or_odd_between_heating_and_cooling(effect, seen) -> None:
    stand, history = STANDS[effect.name], seen(effect)
    shape = effect.shape_value.detach() if stand.shape is None else torch.tensor(stand.shape, dtype=torch.float64)
    here, there = (effect.columns(one, shape) for one in (history, mirrored(history)))
    for sign, one, other in zip(stand.parity, here.T, there.T, strict=True):
        if sign:
            torch.testing.assert_close(other, sign * one, rtol=0, atol=1e-9 * float(one.abs().max()))
        else:
            assert min(float((other - s * one).abs().max()) for s in (1, -1)) > 0.01 * float(one.abs().max())


@pytest.mark.parametrize("name", ["mohr", "shupe", "rate_temperature_coupling", "glass_transition"])
def test_the_sign_flips_with_the_rate_at_the_same_temperatures(name, seen) -> None:
    effect = build("effects", name)
    history = seen(effect)
    flipped = replace(history, rate=-history.rate)
    assert torch.equal(default_columns(effect, flipped), -default_columns(effect, history))


def test_an_effect_of_the_true_input_says_so_and_is_nothing_at_rest(effect, seen) -> None:
    history, turned = seen(effect), STANDS[effect.name].turned
    at_rest, opposite = replace(history, reference=torch.zeros_like(history.reference)), replace(history, reference=-history.reference)
    turning, resting, turned_back = (default_columns(effect, one) for one in (history, at_rest, opposite))
    assert effect.needs_varied_reference == (turned == "value")
    assert torch.equal(turning, resting) == (turned == "nothing")
    assert not (turned == "value" and bool(resting.any()))
    if turned == "sign":
        moving = history.reference != 0
        assert torch.equal(turning[moving], -turned_back[moving])
        assert torch.equal(turning.abs(), resting.abs())


def test_a_sum_has_the_columns_of_its_terms_side_by_side(effect, places) -> None:
    """Additivity: no effect sees another, wherever it stands in a sum."""
    first, last = build("effects", "static_bias"), build("effects", "warm_up")
    terms = {"first": first, "middle": effect, "last": last}
    at = places(effect.needs)
    shape = torch.cat([one.shape_value.detach() for one in terms.values()]).expand(3, -1) * torch.tensor([[1.0], [1.01], [1.02]]).double()
    columns, start, beside = Sum(terms).columns(at, shape), 0, []
    for one in terms.values():
        own = shape[:, start : start + len(one.shape)]
        start += len(one.shape)
        beside.append(one.columns(at[one.place], own).expand(3, -1, -1))
    assert torch.equal(columns, torch.cat(beside, dim=-1))


def test_all_effects_together_are_the_sum_of_each_alone(places) -> None:
    effects = {name: build("effects", name) for name in NAMES}
    generator = torch.Generator().manual_seed(1)
    for one in effects.values():
        one.amplitude.data = torch.randn(len(one.amplitudes), generator=generator, dtype=torch.float64)
    at = places(sorted({column for one in effects.values() for column in one.needs}))
    alone = torch.stack([one(at[one.place]) for one in effects.values()]).detach()
    together = Sum(effects)(at).detach()
    torch.testing.assert_close(together, alone.sum(0), rtol=0, atol=1e-12 * float(alone.abs().max()))
    without = Sum(effects).without("mohr")(at).detach()
    torch.testing.assert_close(without + effects["mohr"](at["coil"]).detach(), together, rtol=0, atol=1e-12 * float(alone.abs().max()))
