"""The temperatures of the places where effects live, estimated from the thermometers."""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from zoo.effects.base import History, Parameter
from zoo.errors import WorkError
from zoo.physics.carry import at_start, left, resumed
from zoo.physics.lag import behind
from zoo.units import SECONDS_PER_MINUTE

LAG = Parameter(
    "lag",
    300.0,
    "s",
    5.0,
    7200.0,
    "log",
    "prior: coil 0.5–5 min, package 10–40 min",
    "time constant of the coil behind what heats it",
    within=3.0,
)
LEAD = Parameter(
    "lead",
    -300.0,
    "s",
    -3600.0,
    3600.0,
    "linear",
    "prior: package 10–40 min; a thermometer may lag the coil by its structure",
    "time by which the coil leads the thermometer in a steady ramp; negative where it lags",
    within=900.0,
)
HOUSING = ("temperature_outer_c", "temperature_housing_c", "temperature_case_c")
"""What the thermometer on the housing may be called."""
WEIGHT = Parameter("weight", 0.5, "1", 0.0, 1.0, "linear", "a coil between two thermometers", "share of this thermometer in what heats the coil")
SECOND = Parameter(
    "second",
    0.3,
    "1",
    0.05,
    1.0,
    "log",
    "prior: a thermometer is late by seconds to minutes",
    "second time constant of the coil over its lag",
    within=3.0,
)
STEADY_S = 30.0
"""Second time constant of a coil between several thermometers, for a rate that no reading makes jump."""
AHEAD = Parameter(
    "lead",
    0.0,
    "s",
    -STEADY_S,
    150.0,
    "linear",
    "prior: thermometers are late by 10–120 s",
    "time by which the coil leads what its lag makes of the thermometers, which are late themselves",
    within=60.0,
)


START = Parameter("start", 0.0, "1", -0.5, 1.5, "linear", "0 soaked, 1 a ramp long under way", "how far the first rate had gone on before the record")
STILL_K_PER_MIN = 0.3
FIRST_S = 60.0


def first_rates(time: Tensor, thermometers: Tensor) -> Tensor:
    """(M,) rate of each thermometer over the run's first minute [K/s]; zero where the run starts at rest (below 0.3 K/min).

    Args:
        time: (T,) from 0 [s].
        thermometers: (T, M) [°C].
    """
    early = max(2, int((time <= FIRST_S).sum()))
    clock, values = time[:early] - time[:early].mean(), thermometers[:early]
    slopes = (clock.unsqueeze(1) * (values - values.mean(dim=0))).sum(dim=0) / clock.square().sum().clamp_min(1e-12)
    return torch.where(slopes.abs() * SECONDS_PER_MINUTE > STILL_K_PER_MIN, slopes, 0.0)


def _kept(time: Tensor, rates: Tensor) -> Tensor:
    """(M,) first rates of the whole record, in whichever chunk of it.

    Raises:
        WorkError: the first chunk was too short to know them.
    """
    seen = torch.full_like(rates[:1], len(time))
    known = torch.cat([rates, seen])
    before = resumed(known)
    if before is not known and (bool(time[0] <= FIRST_S) or bool(before[-1] < 2)):
        raise WorkError(f"a model for records that start in motion needs their first {FIRST_S:g} s in one chunk, and two samples")
    return left(before.unsqueeze(-1), before)[:-1, 0]


def housing_last(names: list[str]) -> list[str]:
    """Columns of thermometers, the main one first: as they come, but the one on the housing last, where one is called so.

    The last one stands for the housing. One in the chamber's air would do so badly, for the housing follows the air by minutes.
    """
    return sorted(names, key=lambda name: name in HOUSING and name != names[0])


def coil_parameters(thermometers: list[str], in_motion: bool = False) -> tuple[Parameter, ...]:
    """What has to be fitted to know the coil's temperature.

    One thermometer: two lags, and the lead that is left in a steady ramp. Several: a lag behind a weighted mean of them, and a lead.

    Args:
        thermometers: columns, the main one first and the housing's last.
        in_motion: whether records start while the temperature moves, so that the coil's first temperature has to be fitted.
    """
    first = (START,) if in_motion else ()
    if len(thermometers) == 1:
        return LAG, LEAD, SECOND, *first
    extra = [replace(WEIGHT, name=f"weight_{name.removeprefix('temperature_').removesuffix('_c')}") for name in thermometers[1:]]
    return (LAG, *extra, AHEAD, *first)


def coil(time: Tensor, thermometers: Tensor, theta: Tensor, in_motion: bool = False) -> tuple[Tensor, Tensor, Tensor]:
    """Temperature of the coil, its rate, and the difference that drives heat into it.

    What heats the coil is u = u_0 + Σ w_j (u_j − u_0), with one thermometer u_0 itself.  v = lag_τ2(lag_τ1(u)),  x = v + λ·dv/dt, rates from the
    differences between the stages: no sample is ever differenced, so a quantisation step is never amplified by more than max(λ, τ2)/τ1τ2.
    One thermometer:  τ2 is a share of τ1, and λ = max(0, lead + τ1 + τ2). What a chamber run determines is the lead in a ramp and how the coil bends
    where ramps begin; λ and the τ by themselves hide behind each other. What drives heat into the coil is u − x.
    Several:  τ2 is short, and λ = lead + τ2: without a lead a lag alone, x = lag_τ1(u). The difference is measured, the last one less the main one:
    u − x would be the rate once more.
    A record that starts in motion:  each lag starts at u − κτ·du/dt of its own u instead of u.

    Args:
        time: (T,) from 0 [s].
        thermometers: (T, M), or (R, 1, T, M) of several runs [°C].
        theta: (..., P) physical values of `coil_parameters`.
        in_motion: as given to `coil_parameters`; not for several runs.

    Returns:
        temperature (..., T) [°C], rate (..., T) [K/min], gradient (..., T) [K].
    """
    main, drive, lag = thermometers[..., 0], thermometers[..., 0], theta[..., 0]
    several = thermometers.shape[-1] > 1
    before = _kept(time, first_rates(time, thermometers)) * theta[..., -1:] if in_motion else torch.zeros_like(thermometers[..., 0, :])
    slope = before[..., 0]
    if several:
        weights = theta[..., 1 : thermometers.shape[-1]]
        for j in range(weights.shape[-1]):
            drive = drive + weights[..., j : j + 1] * (thermometers[..., j + 1] - main)
        slope = slope + (weights * (before[..., 1:] - before[..., :1])).sum(dim=-1)
        second = torch.full_like(lag, STEADY_S)
        ahead = theta[..., thermometers.shape[-1]] + second
    else:
        second = theta[..., 2] * lag
        ahead = (theta[..., 1] + lag + second).clamp_min(0.0)
    late = behind(time, drive, lag, drive[..., 0] - lag * slope)
    once = drive - late
    later = behind(time, once, second, drive[..., 0] - (lag + second) * slope)
    lag, second, ahead = lag.unsqueeze(-1), second.unsqueeze(-1), ahead.unsqueeze(-1)
    rate = later / second
    bend = (late / lag - rate) / second
    temperature = once - later + ahead * rate
    gradient = (thermometers[..., -1] - main).expand_as(temperature) if several else main - temperature
    return temperature, (rate + ahead * bend) * SECONDS_PER_MINUTE, gradient


def in_words(thermometers: list[str]) -> dict[str, str]:
    """What the temperature of each place is, in words that a metadata file can hold; as `coil` and `histories` compute it.

    Args:
        thermometers: columns, the main one first and the housing's last.
    """
    main, *others = thermometers
    if others:
        mixed = " + ".join([main, *(f"weight_{name.removeprefix('temperature_').removesuffix('_c')}·({name} − {main})" for name in others)])
        coil = f"u = {mixed}; v = lag(lag(u; τ = lag); τ = {STEADY_S:g} s); T = v + (lead + {STEADY_S:g} s)·dv/dt; gradient = {others[-1]} − {main}"
    else:
        coil = f"u = {main}; v = lag(lag(u; τ1 = lag); τ2 = second·lag); T = v + max(0, lead + τ1 + τ2)·dv/dt; gradient = u − T"
    housing = f"T = {thermometers[-1]}; dT/dt [K/min] = gradient = T − lag(T; τ = {SECONDS_PER_MINUTE:g} s)"
    return {"coil": coil, "housing": housing}


def histories(
    time: Tensor,
    table: dict[str, Tensor],
    thermometers: Tensor,
    theta: Tensor,
    run: int | Tensor,
    in_motion: bool = False,
    housing: History | None = None,
) -> dict[str, History]:
    """The history at each place.

    The housing's temperature is that of the last thermometer, see `housing_last`.

    Args:
        time: (T,) as recorded [s].
        table: other raw columns by name, each (T,), or (R, 1, T) of several runs; ``"reference"`` among them.
        thermometers: (T, M), or (R, 1, T, M) [°C].
        theta: (..., P) the coil's parameters.
        run: number of the run, from 1, or (R, 1, 1).
        in_motion: as given to `coil_parameters`.
        housing: its history, where it is known already: it does not depend on the coil.
    """
    clock = time - at_start(time)
    temperature, rate, gradient = coil(clock, thermometers, theta, in_motion)
    rest = {name: value for name, value in table.items() if name != "reference"}
    here = History(clock, temperature, rate, gradient, thermometers[..., 0], table["reference"], rest, run)
    return {"coil": here, "housing": housing or _housing(here, thermometers[..., -1])}


def _housing(coil: History, outer: Tensor) -> History:
    late = behind(coil.time, outer, outer.new_full((), SECONDS_PER_MINUTE))
    return replace(coil, temperature=outer, rate=late, gradient=late)
