"""The temperatures of the places where effects live, estimated from the thermometers."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.effects.base import History, Parameter
from zoo.physics.lag import lagged

SECONDS_PER_MINUTE = 60.0
LAG = Parameter("lag", 300.0, "s", 5.0, 7200.0, "log", "§3: coil 0.5–5 min, package 10–40 min", "time constant of the coil behind what heats it")
LEAD = Parameter("lead", 60.0, "s", 0.0, 3600.0, "linear", "§5: a thermometer may lag the coil by its structure", "time by which the coil leads the thermometer")
WEIGHT = Parameter("weight", 0.5, "1", 0.0, 1.0, "linear", "a coil between two thermometers", "share of this thermometer in what heats the coil")


def coil_parameters(thermometers: list[str]) -> tuple[Parameter, ...]:
    """What has to be fitted to know the coil's temperature.

    One thermometer: a two-pole lag and a lead. Several: a lag behind a weighted mean of them.

    Args:
        thermometers: columns, the main one first.
    """
    if len(thermometers) == 1:
        return LAG, LEAD
    extra = [Parameter(f"weight_{name.removeprefix('temperature_').removesuffix('_c')}", 0.5, "1", 0.0, 1.0, "linear", WEIGHT.source, WEIGHT.meaning)
             for name in thermometers[1:]]
    return (LAG, *extra)


def coil(time: Tensor, thermometers: Tensor, theta: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Temperature of the coil, its rate, and the difference that drives heat into it.

    Several thermometers u_j:  u = u_0 + Σ w_j (u_j − u_0),  x = lag_τ(u),  dx/dt = (u − x)/τ.
    One thermometer:  v = lag_τ(lag_τ(u)),  x = v + λ·dv/dt, rates from the differences between the stages: no sample is ever differenced,
    so a quantisation step is never amplified by more than λ/τ².

    Args:
        time: (T,) [s].
        thermometers: (T, M) [°C].
        theta: (..., P) physical values of `coil_parameters`.

    Returns:
        temperature (..., T) [°C], rate (..., T) [K/min], gradient (..., T) [K].
    """
    main, lag = thermometers[:, 0], theta[..., 0]
    if thermometers.shape[1] > 1:
        drive = main + theta[..., 1:] @ (thermometers[:, 1:] - main.unsqueeze(1)).mT
        temperature = lagged(time, drive, lag)
        gradient = drive - temperature
        return temperature, gradient / lag.unsqueeze(-1) * SECONDS_PER_MINUTE, gradient
    tau, lead = lag.unsqueeze(-1), theta[..., 1:2]
    first = lagged(time, main, lag)
    second = lagged(time, first, lag)
    slope = (first - second) / tau
    bend = ((main - first) / tau - slope) / tau
    temperature = second + lead * slope
    return temperature, (slope + lead * bend) * SECONDS_PER_MINUTE, main - temperature


def histories(time: Tensor, table: dict[str, Tensor], thermometers: Tensor, theta: Tensor, run: int) -> dict[str, History]:
    """The history at each place.

    The housing's temperature is that of the last thermometer named, which should be the one nearest to the chamber's air.

    Args:
        time: (T,) as recorded [s].
        table: other raw columns by name, each (T,); ``"reference"`` among them.
        thermometers: (T, M) [°C].
        theta: (..., P) the coil's parameters.
        run: number of the run, from 1.
    """
    clock = time - time[0]
    temperature, rate, gradient = coil(clock, thermometers, theta)
    rest = {name: value for name, value in table.items() if name != "reference"}
    here = History(clock, temperature, rate, gradient, thermometers[:, 0], table["reference"], rest, run)
    outer = thermometers[:, -1]
    smooth = lagged(clock, outer, torch.full((), SECONDS_PER_MINUTE, dtype=outer.dtype, device=outer.device))
    housing = History(clock, outer, outer - smooth, outer - smooth, thermometers[:, 0], table["reference"], rest, run)
    return {"coil": here, "housing": housing}
