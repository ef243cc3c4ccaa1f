"""What an effect is: declared parameters and a few columns that are linear in its amplitudes."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, ClassVar, Literal

import torch
from torch import Tensor, nn

if TYPE_CHECKING:
    from zoo.effects.sum import Sum


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
            ``"index"`` for whole numbers.
        source: where the bounds come from.
        meaning: one line for a reader.
        grid: how many values a search should try.
    """

    name: str
    default: float
    unit: str
    low: float
    high: float
    scale: Literal["linear", "log", "inverse", "index"] = "linear"
    source: str = ""
    meaning: str = ""
    grid: int = 8


@dataclass(frozen=True, eq=False)
class History:
    """What an effect sees of one run: the state of the place where it lives.

    The temperature is the place's, not the thermometer's; it and everything derived from it may carry leading batch axes.

    Attributes:
        time: (T,) since the run's first sample [s].
        temperature: (..., T) at the place [°C].
        rate: (..., T) its derivative [K/min].
        gradient: (..., T) what drives heat into the place, minus the place's temperature [K].
        thermometer: (T,) the main thermometer as recorded [°C].
        reference: (T,) true input [output's unit].
        inputs: other recorded columns by name, such as ``"supply_v"``, each (T,).
        run: number of the run, counted from 1.
    """

    time: Tensor
    temperature: Tensor
    rate: Tensor
    gradient: Tensor
    thermometer: Tensor
    reference: Tensor
    inputs: dict[str, Tensor] = field(default_factory=dict)
    run: int = 1

    def take(self, index: Tensor) -> History:
        """The histories of a batch at the given places of its leading axis: index (B,) -> batch of B."""
        return replace(self, temperature=self.temperature[index], rate=self.rate[index], gradient=self.gradient[index])


class Effect(nn.Module):
    """Abstract: one physical contribution to the gyro's error.

    Subclasses are final. They declare class attributes and implement `columns`; everything else is done here, once.

    Class attributes:
        name: the catalogue's name, also the YAML's.
        place: where the effect lives, ``"coil"`` or ``"housing"``.
        shape: the parameters in which the columns are nonlinear (none to four).
        amplitudes: the parameters in which the error is linear, one a column.
        needs: recorded columns without which the effect cannot be computed.
        formula: plain-text formula.
        source: where it comes from.
        signature: how it looks in a residual.
        confused_with: effects that look alike, for the reader; what is inseparable is computed from the data, never from this list.
    """

    name: ClassVar[str]
    place: ClassVar[Literal["coil", "housing"]] = "coil"
    shape: ClassVar[tuple[Parameter, ...]] = ()
    amplitudes: ClassVar[tuple[Parameter, ...]]
    needs: ClassVar[tuple[str, ...]] = ()
    formula: ClassVar[str] = ""
    source: ClassVar[str] = ""
    signature: ClassVar[str] = ""
    confused_with: ClassVar[tuple[str, ...]] = ()

    def __init__(self) -> None:
        super().__init__()
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

    def shapes_to_try(self, span_s: float, runs: int) -> Tensor:
        """(G, S) physical shapes that a search should start from: the full grid between the bounds.

        Args:
            span_s: length of the longest run [s].
            runs: number of runs.
        """
        axes = [grid_values(parameter, runs) for parameter in self.shape]
        return torch.cartesian_prod(*axes).reshape(-1, len(axes)) if axes else torch.zeros(1, 0, dtype=torch.float64)

    def forward(self, history: History) -> Tensor:
        """(T,) the effect's share of the error [output's unit]: columns · amplitudes."""
        return self.columns(history, self.shape_value) @ self.amplitude


def spread(columns: Tensor, shape: Tensor) -> Tensor:
    """Columns that do not depend on the shape, repeated for a batch of shapes: (T, K) or (B, T, K), (B, S) -> (B, T, K)."""
    return columns.expand(*shape.shape[:-1], *columns.shape[-2:]) if columns.dim() == 2 else columns


def grid_values(parameter: Parameter, runs: int) -> Tensor:
    """(G,) values of one parameter, spread by its scale and off the bounds; whole numbers up to the number of runs for an index."""
    if parameter.scale == "index":
        return torch.arange(0, (runs if runs > 1 else 0) + 1, dtype=torch.float64)
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
