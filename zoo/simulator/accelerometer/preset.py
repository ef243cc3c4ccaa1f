"""Quartz vibrating-beam accelerometers: their numbers, and where these come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

from zoo.errors import InputError, nearest
from zoo.given import is_number
from zoo.simulator.streams import stream, uniform

FITTED = "fitted to the line's residual in hui2016"


@dataclass(frozen=True)
class Quantity:
    """A number of a preset.

    Attributes:
        value: of the preset itself.
        unit: physical unit.
        source: where it comes from; an engineering prior where nothing is said.
        spread: largest relative difference of another specimen from it.
    """

    value: float
    unit: str
    source: str = "prior"
    spread: float = 0.0


@dataclass(frozen=True)
class Accelerometer:
    """A quartz vibrating-beam accelerometer in an inertial unit.

    Attributes:
        name: of the preset.
        frequency: mean of the two beams at 0 g.
        offset: difference of the two at 0 g, which tells the sign of the input.
        scale: difference of frequency per g, at 25 °C.
        scale_drift: relative change of the scale with temperature, besides what the parabola makes of a load.
        parabola: β.
        turnover_1: T_01, where the pulled beam is fastest.
        turnover_2: T_02, of the pressed one.
        heating: by how much the beams end up warmer than the unit by what the accelerometer itself consumes.
        heating_time: time constant of that.
        gradient: by how much the pulled beam ends up warmer than the pressed one.
        unit_heating: by how much the whole unit ends up warmer than the chamber.
        unit_time: time constant of that.
        repeatability: standard deviation of the bias from power-on to power-on.
        random_walk: N, velocity random walk; a mean over τ seconds has the standard deviation N/√τ.
        count_step: fraction of a period of the difference frequency that the counter resolves.
        thermometer: standard deviation of a temperature, a mean over one count.
    """

    name: str
    frequency: Quantity
    offset: Quantity
    scale: Quantity
    scale_drift: Quantity
    parabola: Quantity
    turnover_1: Quantity
    turnover_2: Quantity
    heating: Quantity
    heating_time: Quantity
    gradient: Quantity
    unit_heating: Quantity
    unit_time: Quantity
    repeatability: Quantity
    random_walk: Quantity
    count_step: Quantity
    thermometer: Quantity

    def __getitem__(self, parameter: str) -> float:
        return float(getattr(self, parameter).value)


HUI2016 = Accelerometer(
    name="hui2016",
    frequency=Quantity(40e3, "Hz", "prior: double-ended tuning forks of 30 to 60 kHz"),
    offset=Quantity(1000.0, "Hz", spread=0.1),
    scale=Quantity(
        400.0, "Hz/g", "above 400 Hz/g in J. Chinese Inertial Technology 1998(4):44; with less the line would miss 0.005° nearly always", 0.03
    ),
    scale_drift=Quantity(3e-5, "1/K", spread=0.5),
    parabola=Quantity(-0.035e-6, "1/K^2", "tuning forks of quartz, data sheets: 0.03 to 0.04 ppm/K²"),
    turnover_1=Quantity(26.0, "°C", "prior: crystals are cut for 25 ± 5 °C", 0.04),
    turnover_2=Quantity(24.0, "°C", "prior: crystals are cut for 25 ± 5 °C", 0.04),
    heating=Quantity(2.0, "K", spread=0.2),
    heating_time=Quantity(57.2, "s", FITTED, 0.05),
    gradient=Quantity(1.693, "K", FITTED, 0.2),
    unit_heating=Quantity(25.0, "K", "prior: some 10 K in 8 min"),
    unit_time=Quantity(1200.0, "s"),
    repeatability=Quantity(18.5, "µg", "fitted to hui2016: in the check 27 % of the line's error are left"),
    random_walk=Quantity(0.008, "µg/√Hz", "fitted to hui2016: the network's variance of 2.8e-9 leaves no room for more"),
    count_step=Quantity(1e-5, "1", "prior: edges of 1 kHz timed to 10 ns"),
    thermometer=Quantity(3e-6, "K", "prior: the sum of the two frequencies, 4 pulses/K in 10 s, counted as finely"),
)
PRESETS: Mapping[str, Accelerometer] = {one.name: one for one in (HUI2016,)}
POSITIVE = ("frequency", "scale", "heating_time", "unit_time")
NOISES = ("repeatability", "random_walk", "thermometer", "count_step")
PARAMETERS = tuple(one.name for one in fields(Accelerometer) if one.name != "name")


def accelerometer(name: str = HUI2016.name, **changes: float | None) -> Accelerometer:
    """A preset with some of its numbers changed, as a YAML in conf/gyro writes it.

    Args:
        name: of the preset.
        **changes: numbers to change, in the preset's units; None leaves them.

    Raises:
        InputError: no such preset or parameter, or a number that cannot be.
    """
    if name not in PRESETS:
        raise InputError(f"gyro.name='{name}': {nearest(name, PRESETS)}")
    unknown = [key for key in changes if key not in PARAMETERS]
    if unknown:
        raise InputError(f"unknown key 'gyro.{unknown[0]}': {nearest(unknown[0], PARAMETERS)}")
    base = PRESETS[name]
    asked = {key: value for key, value in changes.items() if value is not None}
    return replace(base, **{key: replace(getattr(base, key), value=_checked(key, value), source="given", spread=0.0) for key, value in asked.items()})


def _checked(key: str, value: object) -> float:
    if not is_number(value):
        raise InputError(f"gyro.{key}={value}: a number is possible")
    if key in POSITIVE and value <= 0:
        raise InputError(f"gyro.{key}={value}: a number above 0 is possible")
    if key in NOISES and value < 0:
        raise InputError(f"gyro.{key}={value}: a number from 0 up is possible")
    return float(value)


def specimen(base: Accelerometer, seed: int, place: str) -> Accelerometer:
    """Another accelerometer of the same make.

    Args:
        base: the make.
        seed: the user's.
        place: where it sits, such as ``"east"``.
    """
    values = {key: getattr(base, key) for key in PARAMETERS}
    factors = {key: 1 + one.spread * (2 * uniform(stream(seed, "accelerometer", place, key)) - 1) for key, one in values.items()}
    return replace(base, **{key: replace(one, value=one.value * factors[key]) for key, one in values.items()})
