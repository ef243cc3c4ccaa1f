"""What a residual may depend on: each quantity is a few lines on an effect's history, copied as they stand into the class that a user fills in.

The functions take the place of a method, so `self` is a `Quantity` here and the user's effect there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import torch
from torch import Tensor

from zoo.diagnosis.workbench import Workbench
from zoo.effects.base import Effect, History, Place
from zoo.physics.lag import behind, lagged
from zoo.units import symbol

FLAT = 1e-9
"""A quantity that varies less is a constant."""


def temperature(self: Any, history: History) -> Tensor:
    """The place's temperature [°C]."""
    return history.temperature


def rate(self: Any, history: History) -> Tensor:
    """The rate of the place's temperature [K/min]."""
    return history.rate


def size_of_rate(self: Any, history: History) -> Tensor:
    """The size of that rate, heating and cooling alike [K/min]."""
    return history.rate.abs()


def lasting_rate(self: Any, history: History) -> Tensor:
    """The size of that rate, remembered for half an hour [K/min]."""
    return lagged(history.time, history.rate.abs(), torch.full_like(history.rate[..., 0], 1800.0))


def bend(self: Any, history: History) -> Tensor:
    """How the rate has changed within five minutes [K/min]."""
    return behind(history.time, history.rate, torch.full_like(history.rate[..., 0], 300.0))


def gradient(self: Any, history: History) -> Tensor:
    """What drives heat into the coil [K]."""
    return history.gradient


def clock(self: Any, history: History) -> Tensor:
    """Hours since the run's start [h]."""
    return history.time / 3600


def since_turn(self: Any, history: History) -> Tensor:
    """Hours since heating turned into cooling or the other way round [h]; slower than 0.1 K/min is neither."""
    number = torch.arange(history.time.numel(), device=history.time.device).expand(history.rate.shape)
    moved = torch.where(history.rate.abs() > 0.1, number, 0).cummax(dim=-1).values
    way = history.rate.sign().gather(-1, moved)
    turned = torch.cat([torch.zeros_like(way[..., :1], dtype=torch.bool), way[..., 1:] != way[..., :-1]], dim=-1)
    return (history.time - history.time[torch.where(turned, number, 0).cummax(dim=-1).values]) / 3600


def highest_temperature(self: Any, history: History) -> Tensor:
    """The highest temperature since the run's start [°C]."""
    return torch.cummax(history.temperature, dim=-1).values


def lowest_temperature(self: Any, history: History) -> Tensor:
    """The lowest temperature since the run's start [°C]."""
    return torch.cummin(history.temperature, dim=-1).values


def summed_temperature(self: Any, history: History) -> Tensor:
    """The temperature above 20 °C, summed over time since the run's start [K h]."""
    return ((history.temperature - 20) * torch.diff(history.time, prepend=history.time[:1]) / 3600).cumsum(dim=-1)


def true_input(self: Any, history: History) -> Tensor:
    """The true input [output's unit]."""
    return history.reference


def recorded(self: Any, history: History) -> Tensor:
    """A recorded column, in the file's unit."""
    return history.inputs[self.needs[0]]


@dataclass(frozen=True)
class Quantity:
    """Something that changes during a run.

    Attributes:
        words: what it is called in a sentence.
        symbol: what it is called in a formula.
        unit: as usually written; ``"unit"`` is the output's.
        of: (..., T) its values, as a method of an effect.
        signed: whether its zero means something, so that the residual may be even or odd in it.
        place: where it is looked at.
        needs: recorded columns without which there is none.
    """

    words: str
    symbol: str
    unit: str
    of: Callable[[Any, History], Tensor]
    signed: bool = False
    place: Place = "coil"
    needs: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """An identifier."""
        return "_".join([self.place, self.of.__name__, *self.needs])

    def told_in(self, output: str) -> Quantity:
        """The same with its unit as usually written, where that is the output's, of which the suffix is given."""
        return replace(self, unit=self.unit.replace("unit", symbol(output)))


TEMPERATURE = Quantity("the coil's temperature", "T", "°C", temperature)
SIZE = Quantity("the size of the temperature rate, not its sign", "|dT/dt|", "K/min", size_of_rate)
RATE = Quantity("the coil's temperature rate", "dT/dt", "K/min", rate, signed=True)
CLOCK = Quantity("the time since the run's start", "t", "h", clock)
OUTER_RATE = Quantity("the outer thermometer's rate", "dT_outer/dt", "K/min", rate, signed=True, place="housing")
LASTING = Quantity("the size of the temperature rate of the last half hour", "lag(|dT/dt|)", "K/min", lasting_rate)
SAMPLES = 61
INPUT = Quantity("the true input", "Ω", "unit", true_input, signed=True)
AT_THE_COIL = (
    TEMPERATURE,
    SIZE,
    RATE,
    CLOCK,
    Quantity("the highest temperature so far", "max T", "°C", highest_temperature),
    Quantity("the lowest temperature so far", "min T", "°C", lowest_temperature),
    LASTING,
    Quantity("the change of the temperature rate", "Δ(dT/dt)", "K/min", bend, signed=True),
    Quantity("the temperature summed over time", "∫T dt", "K h", summed_temperature, signed=True),
    Quantity("the time since heating and cooling last changed places", "t_turn", "h", since_turn),
    INPUT,
)
"""The simplest first: of those that explain about as much, this order decides."""


def quantities(bench: Workbench) -> list[Quantity]:
    """What the runs allow to look at, the simplest first; constants included."""
    several = len(bench.runs[0].thermometers) > 1
    between = "between the thermometers" if several else "between thermometer and coil"
    difference = Quantity(f"the temperature difference {between}", "ΔT", "K", gradient, signed=True)
    asides = {name for name in bench.inputs if name.startswith("temperature_")} | {bench.inputs[0], bench.inputs[-1]}
    columns = [Quantity(column_in_words(name), name, _unit_of(name), recorded, needs=(name,)) for name in bench.inputs if name not in asides]
    return [*AT_THE_COIL, difference, *([OUTER_RATE] if several else []), *columns]


def column_in_words(name: str) -> str:
    """What a recorded column is called in a sentence."""
    return f"the column {name}"


def inputs_of(effect: Effect) -> set[str]:
    """In words, what an effect goes with beside temperature and time: recorded columns, the true input."""
    return {*map(column_in_words, effect.needs), *([INPUT.words] if _turns(effect) else [])}


def inputs_seen(bench: Workbench, effect: Effect) -> set[str]:
    """Those of them that change in these runs, as far as the effect sees it: one that looks at the input's sign alone sees no turn that keeps it."""
    columns = [name for name in effect.needs if float(_spread(bench, name).diff().abs().max()) > FLAT]
    here = replace(_samples(effect), reference=_spread(bench, bench.inputs[-1]))
    turned = bench.varied_reference and not _same(effect, here, replace(here, reference=here.reference[:1].expand(SAMPLES)))
    return {*map(column_in_words, columns), *([INPUT.words] if turned else [])}


def _spread(bench: Workbench, column: str) -> Tensor:
    """(61,) values of a recorded column from its least to its largest block mean, as often as they come."""
    values = torch.cat([run.block_mean(run.column(column)) for run in bench.runs]).cpu()
    return values.quantile(torch.linspace(0, 1, SAMPLES, dtype=values.dtype))


def by_the_clock(effect: Effect) -> bool:
    """Whether an effect's columns are the same whatever the temperature and the inputs do: lines and steps in time, drifts."""
    here = _samples(effect)
    other = replace(here, temperature=-here.temperature, rate=-here.rate, gradient=-here.gradient, thermometer=-here.thermometer)
    return not effect.needs and not _turns(effect) and _same(effect, here, other)


def momentary(effect: Effect) -> bool:
    """Whether an effect's columns do not know what was before: no memory of the temperature or of an input."""
    here = _samples(effect)
    sign = torch.where(torch.arange(SAMPLES) < SAMPLES // 2, -1.0, 1.0).to(here.time)
    other = replace(
        here,
        temperature=sign * here.temperature,
        rate=sign * here.rate,
        gradient=sign * here.gradient,
        thermometer=sign * here.thermometer,
        reference=sign * here.reference,
        inputs={name: sign * values for name, values in here.inputs.items()},
    )
    return _same(effect, here, other, SAMPLES // 2)


def _turns(effect: Effect) -> bool:
    """Whether an effect's columns are others where the true input is another."""
    up = _samples(effect)
    return not _same(effect, up, replace(up, reference=-up.reference))


def _samples(effect: Effect) -> History:
    """An hour in which everything that an effect may look at differs from nothing."""
    time = torch.arange(SAMPLES, dtype=torch.float64) * 60.0
    inputs, wave = dict.fromkeys(effect.needs, torch.ones_like(time)), (time / 900.0).sin()
    return History(time, 10 * wave, wave.flip(0), wave, 10 * wave, torch.ones_like(time), inputs, 1)


def _same(effect: Effect, one: History, other: History, since: int = 0) -> bool:
    """Whether an effect's columns are the same in both, from a sample on."""
    with torch.no_grad():
        return torch.equal(*(effect.columns(history, effect.shape_value)[since:] for history in (one, other)))


def _unit_of(column: str) -> str:
    """The unit in a column's name, as far as it is one of those that effects use."""
    return {"v": "V", "ut": "µT", "pct": "%", "kpa": "kPa"}.get(column.rsplit("_", 1)[-1], "")
