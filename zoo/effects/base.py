"""What an effect is: declared parameters and a few columns that are linear in its amplitudes."""

from __future__ import annotations

import copy
import math
import reprlib
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from numbers import Real
from typing import TYPE_CHECKING, ClassVar, Literal, Self, get_args

import torch
from torch import Tensor, nn

from zoo.errors import InputError, nearest
from zoo.units import SECONDS_PER_HOUR

if TYPE_CHECKING:
    from zoo.effects.earlier import Before
    from zoo.effects.sum import Sum

RUN = "run"
"""Name of a parameter that is the number of a run."""
Scale = Literal["linear", "log", "inverse", "index", "share"]
Place = Literal["coil", "housing"]

REFERENCE_C = 20.0
"""Temperature at which what depends on temperature has its declared size [°C]."""
HALF_A_DAY_S = 43200.0
OF_PLACE = ("temperature", "rate", "gradient", "thermometer", "reference")
"""Signals of a history beside the time and the recorded columns."""


@dataclass(frozen=True)
class Parameter:
    """A number that may be fitted, declared so that it can be read without running anything.

    Attributes:
        name: identifier, unique within its effect.
        default: value before any fit.
        unit: physical unit, as usually written; ``"unit"`` stands for the output's unit in an amplitude.
        low: smallest plausible value.
        high: largest plausible value.
        scale: how values are spread between the bounds: ``"log"`` over decades, ``"inverse"`` for periods (evenly in 1/value),
            ``"index"`` for whole numbers, ``"share"`` for one whose ends and default are as likely as the rest.
        source: where the bounds come from.
        meaning: one line for a reader.
        grid: how many values a search should try.
        within: how far most gyros are from the default, as a standard deviation: a factor along a logarithm, else in the parameter's unit; 0 where
            every value between the bounds is as likely.
        usual: whether nearly every gyro has the default, so that a whole number counts as fitted only where it is another.
        spare: of an amplitude the name of an effect that has the same column: it makes no effect by itself, and is left out beside that one, see
            `Effect.beside`.
    """

    name: str
    default: float
    unit: str
    low: float
    high: float
    scale: Scale = "linear"
    source: str = ""
    meaning: str = ""
    grid: int = 8
    within: float = 0.0
    usual: bool = False
    spare: str = ""

    def __post_init__(self) -> None:
        """Raises InputError for what no search can go through, where it is written and not in the middle of a fit."""
        fault = _fault(self)
        if fault:
            raise InputError(f"parameter '{self.name}': {fault}")

    @property
    def ends_as_likely(self) -> bool:
        """Whether the bounds are values like all others, and not the ends of what is plausible."""
        return self.scale in {"index", "share"}


@dataclass(frozen=True, eq=False)
class History:
    """What an effect sees of one run: the state of the place where it lives.

    The temperature is the place's, not the thermometer's; it and everything derived from it may carry leading batch axes.

    Attributes:
        time: (T,) since the run's first sample [s].
        temperature: (..., T) at the place [°C].
        rate: (..., T) its derivative [K/min].
        gradient: (..., T) what drives heat into the place, minus the place's temperature or that of a thermometer beside it [K].
        thermometer: (T,) the main thermometer as recorded [°C].
        reference: (T,) true input [output's unit].
        inputs: other recorded columns by name, such as ``"supply_v"``, each (T,).
        run: number of the run, counted from 1.

    Runs that were recorded at the same times may come together to an effect that says so (`Effect.runs_together`), along a leading axis: then
    everything is (R, ..., T) but the time, and the run's number is (R, 1, 1).
    """

    time: Tensor
    temperature: Tensor
    rate: Tensor
    gradient: Tensor
    thermometer: Tensor
    reference: Tensor
    inputs: dict[str, Tensor] = field(default_factory=dict)
    run: int | Tensor = 1

    def take(self, index: Tensor) -> History:
        """The histories of a batch at the given places of its last axis before time: index (B,) -> batch of B."""
        if index.tolist() == list(range(self.temperature.shape[-2])):
            return self
        return replace(self, temperature=self.temperature[..., index, :], rate=self.rate[..., index, :], gradient=self.gradient[..., index, :])


class Effect(nn.Module):
    """Abstract: one physical contribution to the gyro's error.

    Subclasses are final. They declare class attributes and implement `columns`; everything else is done here, once.

    Class attributes:
        name: the catalogue's name, also the YAML's.
        place: where the effect lives, ``"coil"`` or ``"housing"``.
        shape: the parameters in which the columns are nonlinear (none to four); one effect may have narrower bounds than its class, see `seen_over`,
            `driven_to`.
        amplitudes: the parameters in which the error is linear, one a column.
        needs: recorded columns without which the effect cannot be computed.
        sharp: whether its columns change much within a few kelvins, without memory, so that a search has to look closely for where the place is.
        instant: whether its columns at one moment depend on that moment alone, so that a search through many shapes may take means for moments.
        runs_together: whether its columns are right for several runs at once, along a leading axis (see `History`); faster than one by one.
        again: whether it may happen several times, see `zoo.effects.repeated`.
        moments: which shapes are moments in a run, in hours, at which the columns jump.
        filters: whether it is the thermometers' readings behind a filter and nothing else, as which it also makes up for their scatter.
        left_out: names of the spare amplitudes that `columns` has to make nothing, see `beside`; empty of a class.
        needs_varied_reference: whether the effect cannot be told from a bias where the true input is always the same.
        formula: plain-text formula.
        source: where it comes from.
        signature: how it looks in a residual.
        confused_with: effects that look alike: beside one of them a small part of it is taken for its own form. What is inseparable is computed from
            the data, never from this list.
    """

    name: ClassVar[str]
    place: ClassVar[Place] = "coil"
    shape: tuple[Parameter, ...] = ()
    amplitudes: ClassVar[tuple[Parameter, ...]]
    needs: ClassVar[tuple[str, ...]] = ()
    sharp: ClassVar[bool] = False
    instant: ClassVar[bool] = False
    runs_together: ClassVar[bool] = False
    again: ClassVar[bool] = False
    moments: ClassVar[tuple[str, ...]] = ()
    filters: ClassVar[bool] = False
    needs_varied_reference: ClassVar[bool] = False
    left_out: tuple[str, ...] = ()
    formula: ClassVar[str] = ""
    source: ClassVar[str] = ""
    signature: ClassVar[str] = ""
    confused_with: ClassVar[tuple[str, ...]] = ()

    def __init__(self) -> None:
        """Raises InputError where the class does not declare what it must."""
        super().__init__()
        _check_declared(type(self))
        self.shape_value = nn.Parameter(torch.tensor([p.default for p in self.shape], dtype=torch.float64))
        self.amplitude = nn.Parameter(torch.zeros(len(self.amplitudes), dtype=torch.float64))

    def __add__(self, other: Effect) -> Sum:
        """Both together: ``StaticBias() + Mohr() + Shupe()``."""
        from zoo.effects.sum import Sum  # a sum is made of effects

        return Sum({self.name: self}) + other

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """The basis for given shapes.

        Args:
            history: the place's history, T samples.
            shape: (..., S) values of `self.shape`, in its units.

        Returns:
            (..., T, K) columns [output's unit per unit of amplitude].
        """
        raise NotImplementedError

    def distinct_columns(self, history: History, shape: Tensor, tried: Tensor) -> Tensor:
        """The columns without those that repeat another whatever shape is tried, for a search, which does not need them; by default all.

        Args:
            history: see `columns`.
            shape: (..., S) see there.
            tried: (G, S) all shapes of the search, among them these.
        """
        del tried
        return self.columns(history, shape)

    def seen_over(self, span_s: float) -> Self:
        """The effect with its shape as far as runs can show it; by default as it is. A copy where the bounds are narrower than its own.

        Args:
            span_s: length of the longest run [s].
        """
        del span_s
        return self

    def driven_to(self, largest: float) -> Self:
        """The effect with its shape as far as such true inputs can show it; by default as it is. A copy where the bounds are narrower than its own.

        Args:
            largest: size of the largest true input [output's unit].
        """
        del largest
        return self

    def beside(self, others: Collection[str]) -> Self:
        """The effect as it is fitted with others in one model: a copy without what one of them has as well, where there is that; else itself.

        Args:
            others: names of the effects in the model.
        """
        left_out = tuple(one.name for one in self.amplitudes if one.spare in others)
        if left_out == self.left_out:
            return self
        less = copy.deepcopy(self)
        less.left_out = left_out
        return less

    def after(self, before: Before) -> Self:
        """The effect told what the gyro went through before each run, for what goes on from run to run; by default as it is, else a copy.

        Args:
            before: R runs, see `zoo.effects.earlier.before_each`.
        """
        del before
        return self

    def bounded(self, place: int, low: float, high: float) -> Self:
        """The effect with one of its shapes within these bounds as well, a copy; itself where its own are no wider or would be left with nothing.

        Args:
            place: of the parameter in `shape`.
            low: physical.
            high: physical.
        """
        one = self.shape[place]
        low, high = max(low, one.low), min(high, one.high)
        if low >= high or (low, high) == (one.low, one.high):
            return self
        narrowed = copy.deepcopy(self)
        narrower = replace(one, low=low, high=high, default=min(max(one.default, low), high))
        narrowed.shape = (*self.shape[:place], narrower, *self.shape[place + 1 :])
        return narrowed

    def shapes_to_try(self, span_s: float, runs: int) -> Tensor:
        """(G, S) physical shapes that a search should start from: the full grid between the bounds.

        Args:
            span_s: length of the longest run [s].
            runs: number of runs.
        """
        axes = [grid_values(parameter, runs) for parameter in self.shape]
        return torch.cartesian_prod(*axes).reshape(-1, len(axes)) if axes else torch.zeros(1, 0, dtype=torch.float64)

    def choices(self, place: int, runs: int) -> int:
        """How many values of a whole number, at a place of the shape, a search through so many runs looks at."""
        return len(self.shapes_to_try(HALF_A_DAY_S, runs)[:, place].unique())

    def blocks_of_moments(self, average_s: float) -> Tensor:
        """(S,) how many blocks of a length [s] the whole range of each shape passes that is a moment; 0 of what is none."""
        passed = [(one.high - one.low) * SECONDS_PER_HOUR / average_s if one.name in self.moments else 0.0 for one in self.shape]
        return torch.tensor(passed, dtype=torch.float64)

    def shapes_near(self, shape: Tensor, span_s: float) -> Tensor:
        """(G, S) shapes around the best of those to try, where a fit would not find its way from there.

        By default the shape itself, or with its shares and its options at their defaults and at either end.

        Args:
            shape: (S,) physical.
            span_s: length of the longest run [s].
        """
        del span_s
        tried = [torch.tensor(_ends(one)).to(shape) if _ends(one) else shape[i : i + 1] for i, one in enumerate(self.shape)]
        return torch.cartesian_prod(*tried).reshape(-1, len(tried)) if any(map(_ends, self.shape)) else shape.unsqueeze(0)

    def frequencies(self, shape: Tensor) -> tuple[float, ...]:
        """Where in the spectrum over time its columns are lines [Hz], whose phase may wander a little in nature; by default nowhere.

        Args:
            shape: (S,) physical.
        """
        del shape
        return ()

    def forward(self, history: History) -> Tensor:
        """(T,) the effect's share of the error [output's unit]: columns · amplitudes."""
        return self.columns(history, self.shape_value) @ self.amplitude


def _fault(one: Parameter) -> str:
    """What is wrong with a parameter and what is possible; empty where nothing is."""
    if not all(isinstance(value, Real) for value in (one.default, one.low, one.high)):
        return f"default {one.default!r}, bounds {one.low!r} … {one.high!r}; numbers are needed, in the order name, default, unit, low, high"
    bounds = f"bounds {one.low:g} … {one.high:g}"
    if one.scale not in get_args(Scale):
        return f"scale={one.scale!r}; {nearest(str(one.scale), get_args(Scale))}"
    if not -math.inf < one.low < one.high < math.inf:
        return f"{bounds}; finite ones are needed, the lower first"
    if one.scale in {"log", "inverse"} and one.low <= 0:
        return f"{bounds} with scale='{one.scale}'; they must be above 0, or the scale 'linear'"
    if not one.low <= one.default <= one.high:
        return f"default {one.default:g}; it must be within its {bounds}"
    known = one.within == 0 or one.within > (1 if one.scale == "log" else 0)
    return "" if known else f"within={one.within:g}; a factor above 1 along a logarithm, else a width above 0; 0 where nothing is known"


def _ends(one: Parameter) -> list[float]:
    """Values between which no step leads, though a search has to look at each: of a share, or of an option that nearly all gyros have alike."""
    option = one.scale == "index" and one.usual and (one.low, one.high) == (0.0, 1.0)
    return sorted({one.low, one.default, one.high}) if option or one.scale == "share" else []


def _check_declared(effect: type[Effect]) -> None:
    """Raises InputError where a class attribute that the fits rely on is missing or of another kind."""
    own = effect.__name__
    if not isinstance(getattr(effect, "name", None), str):
        raise InputError(f"{own}.name is missing; the name in the catalogue is needed, as in its YAML")
    if effect.place not in get_args(Place):
        raise InputError(f"{own}.place = {effect.place!r}; {nearest(str(effect.place), get_args(Place))}")
    for attribute, kind in (("shape", Parameter), ("amplitudes", Parameter), ("needs", str)):
        given = getattr(effect, attribute, None)
        if not isinstance(given, tuple) or not all(isinstance(one, kind) for one in given):
            found = "is missing" if given is None else f"= {reprlib.repr(given)}"
            raise InputError(f"{own}.{attribute} {found}; a tuple of {kind.__name__} is needed (of one: with a comma before the bracket)")
    if not effect.amplitudes:
        raise InputError(f"{own}.amplitudes is empty; at least one is needed, one a column")


def spread(columns: Tensor, shape: Tensor) -> Tensor:
    """Columns that do not depend on the shape, repeated for a batch of shapes: (T, K) or (B, T, K), (B, S) -> (B, T, K)."""
    return columns.expand(*shape.shape[:-1], *columns.shape[-2:]) if columns.dim() == 2 else columns


def grid_values(parameter: Parameter, runs: int) -> Tensor:
    """(G,) values of one parameter, spread by its scale and off the bounds; of a share or an option the default, of an index up to the number of
    runs and to the upper bound."""
    if _ends(parameter):
        return torch.tensor([parameter.default], dtype=torch.float64)
    if parameter.scale == "index":
        return torch.arange(0, (min(runs, int(parameter.high)) if runs > 1 else 0) + 1, dtype=torch.float64)
    unit = (torch.arange(parameter.grid, dtype=torch.float64) + 0.5) / parameter.grid
    return physical_value(unit, parameter)


def physical_value(unit: Tensor, parameter: Parameter) -> Tensor:
    """Place 0…1 between the bounds -> physical value."""
    low, high = parameter.low, parameter.high
    if parameter.scale == "log":
        return low * torch.exp(unit * math.log(high / low))
    if parameter.scale == "inverse":
        return 1.0 / (1.0 / high + unit * (1.0 / low - 1.0 / high))
    value = low + unit * (high - low)
    return value.round() if parameter.scale == "index" else value


def unit_value(physical: Tensor, parameter: Parameter) -> Tensor:
    """The inverse of `physical_value`."""
    low, high = parameter.low, parameter.high
    if parameter.scale == "log":
        return torch.log(physical / low) / math.log(high / low)
    if parameter.scale == "inverse":
        return (1.0 / physical - 1.0 / high) / (1.0 / low - 1.0 / high)
    return (physical - low) / (high - low)
