"""Forms that an unknown effect may have: columns of a quantity, copied as they stand into the class that a user fills in.

The functions take the place of `Effect.columns`; `self.quantity(history)` is the quantity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

from zoo.diagnosis.free_functions import FreeFunction
from zoo.diagnosis.quantities import CLOCK, LASTING, RATE, SIZE, TEMPERATURE, Quantity
from zoo.effects.base import Effect, History, Parameter, spread
from zoo.physics.lag import lagged

PRIOR = "engineering prior"
EXPONENT = Parameter("exponent", 2.0, "1", 0.25, 4.0, "log", PRIOR, "p", grid=10)
MEMORY = Parameter("memory", 1800.0, "s", 300.0, 14400.0, "log", PRIOR, "τ", grid=6)
PERIOD_K = Parameter("period", 20.0, "K", 3.0, 40.0, "inverse", PRIOR, "P", grid=64)
SIZE_KEPT = Parameter("size", 0.1, "K/min", 0.01, 1.0, "log", PRIOR, "s", grid=10)
PLACE_C = Parameter("place", 20.0, "°C", -50.0, 80.0, "linear", PRIOR, "c", grid=27)
WIDTH_K = Parameter("width", 3.0, "K", 0.5, 20.0, "log", PRIOR, "w", grid=4)
ORDERS = (1, 2, 3, 6)
"""Of polynomials."""
LINES = 40
"""The shortest period looked for in time is this part of the longest run."""


def even_power(self: Any, history: History, shape: Tensor) -> Tensor:
    """The quantity's size to the power p, whatever its sign, see `Effect.columns`."""
    return self.quantity(history).abs().clamp_min(1e-9).pow(shape[..., 0:1]).unsqueeze(-1)


def odd_power(self: Any, history: History, shape: Tensor) -> Tensor:
    """The quantity's size to the power p, with its sign, see `Effect.columns`."""
    value = self.quantity(history)
    return (value.sign() * value.abs().clamp_min(1e-9).pow(shape[..., 0:1])).unsqueeze(-1)


def saturating(self: Any, history: History, shape: Tensor) -> Tensor:
    """What grows with the quantity up to a size s and no further, see `Effect.columns`."""
    return torch.tanh(self.quantity(history) / shape[..., 0:1]).unsqueeze(-1)


def even_power_by_temperature(self: Any, history: History, shape: Tensor) -> Tensor:
    """The quantity's size to the power p, and the same times (T − 20 °C)/50 K, see `Effect.columns`."""
    power = self.quantity(history).abs().clamp_min(1e-9).pow(shape[..., 0:1])
    return torch.stack(torch.broadcast_tensors(power, power * (history.temperature - 20) / 50), dim=-1)


def odd_power_by_temperature(self: Any, history: History, shape: Tensor) -> Tensor:
    """The quantity's size to the power p with its sign, and the same times (T − 20 °C)/50 K, see `Effect.columns`."""
    value = self.quantity(history)
    power = value.sign() * value.abs().clamp_min(1e-9).pow(shape[..., 0:1])
    return torch.stack(torch.broadcast_tensors(power, power * (history.temperature - 20) / 50), dim=-1)


def remembered_power(self: Any, history: History, shape: Tensor) -> Tensor:
    """The quantity's size to the power p, remembered for a time τ, see `Effect.columns`."""
    power = self.quantity(history).abs().clamp_min(1e-9).pow(shape[..., 0:1])
    return lagged(history.time, power, shape[..., 1]).unsqueeze(-1)


def bent(self: Any, history: History, shape: Tensor) -> Tensor:
    """What grows in proportion to the quantity above a place c and is nothing below it, going over within a width w, see `Effect.columns`."""
    place, width = shape[..., 0:1], shape[..., 1:2]
    return (width * torch.nn.functional.softplus((self.quantity(history) - place) / width)).unsqueeze(-1)


def stepped(self: Any, history: History, shape: Tensor) -> Tensor:
    """What is 0 well below a place c of the quantity and 1 well above it, going over within a width w, see `Effect.columns`."""
    return torch.sigmoid((self.quantity(history) - shape[..., 0:1]) / shape[..., 1:2]).unsqueeze(-1)


def polynomial(self: Any, history: History, shape: Tensor) -> Tensor:
    """Chebyshev polynomials of order 1 and up; beyond the range of the fitted runs they stay as they are there; see `Effect.columns`."""
    place = (2 * (self.quantity(history) - self.low) / (self.high - self.low) - 1).clamp(-1, 1)
    columns = [place]
    for order in range(2, len(self.amplitudes) + 1):
        columns.append(2 * place * columns[-1] - (columns[-2] if order > 2 else 1))
    return spread(torch.stack(columns, dim=-1), shape)


def polynomial_by_temperature(self: Any, history: History, shape: Tensor) -> Tensor:
    """Products x·θ, x·θ², x²·θ, … of the quantity and θ = (T − 20 °C)/50 K, each to the powers 1 to 3, see `Effect.columns`."""
    value, theta = self.quantity(history), (history.temperature - 20) / 50
    return spread(torch.stack([value**i * theta**j for i in (1, 2, 3) for j in (1, 2, 3)], dim=-1), shape)


def wave(self: Any, history: History, shape: Tensor) -> Tensor:
    """Cosine and sine of the quantity with period P, see `Effect.columns`."""
    phase = 2 * torch.pi * self.quantity(history) / shape[..., 0:1]
    return torch.stack([phase.cos(), phase.sin()], dim=-1)


@dataclass(frozen=True)
class Form:
    """One family of columns.

    Attributes:
        columns: takes the place of `Effect.columns`.
        formula: with `x` for the quantity.
        shape: nonlinear parameters.
        amplitudes: names of the linear ones, and their units with `x` for the quantity's unit.
    """

    columns: Callable[[Any, History, Tensor], Tensor]
    formula: str
    shape: tuple[Parameter, ...] = ()
    amplitudes: tuple[tuple[str, str], ...] = (("coefficient", "unit/(x)^p"),)

    def of(self, quantity: Quantity, span: tuple[float, float]) -> Effect:
        """The form as an effect that can be fitted.

        Args:
            quantity: what it depends on.
            span: smallest and largest value of that in the fitted runs.
        """
        declared: dict[str, Any] = {
            "name": f"{quantity.key}_{self.columns.__name__}_{len(self.amplitudes)}",
            "place": quantity.place,
            "runs_together": True,
            "needs": quantity.needs,
            "shape": self.shape,
            "amplitudes": tuple(Parameter(name, 0.0, unit.replace("x", quantity.unit), -1.0, 1.0, source=PRIOR) for name, unit in self.amplitudes),
            "formula": self.formula.replace("x", quantity.symbol),
        }
        methods = {"quantity": quantity.of, "columns": self.columns, "low": span[0], "high": span[1]}
        effect: Effect = type("Unexplained", (Effect,), {**declared, **methods})()
        return effect


BY_TEMPERATURE = (("coefficient", "unit/(x)^p"), ("slope", "unit/(x)^p"))
EVEN = Form(even_power, "A·|x|^p", (EXPONENT,))
SATURATING = Form(saturating, "A·tanh(x/s)", (SIZE_KEPT,), (("coefficient", "unit"),))
ODD = Form(odd_power, "A·sgn(x)·|x|^p", (EXPONENT,))
EVEN_BY_TEMPERATURE = Form(even_power_by_temperature, "(A + B·θ)·|x|^p,  θ = (T − 20 °C)/50 K", (EXPONENT,), BY_TEMPERATURE)
ODD_BY_TEMPERATURE = Form(odd_power_by_temperature, "(A + B·θ)·sgn(x)·|x|^p,  θ = (T − 20 °C)/50 K", (EXPONENT,), BY_TEMPERATURE)
REMEMBERED = Form(remembered_power, "A·lag_τ(|x|^p)", (EXPONENT, MEMORY))
BENT = Form(bent, "A·w·ln(1 + e^((x − c)/w))", (PLACE_C, WIDTH_K), (("slope", "unit/x"),))
STEPPED = Form(stepped, "A/(1 + e^(−(x − c)/w))", (PLACE_C, WIDTH_K), (("step", "unit"),))
SHARP = (BENT, STEPPED)
"""Which no polynomial follows."""
POLYNOMIALS = tuple(
    Form(polynomial, "Σ a_k·T_k(x), a Chebyshev series over the range of the runs", (), tuple((f"a{k}", "unit") for k in range(1, order + 1)))
    for order in ORDERS
)
PRODUCTS = Form(
    polynomial_by_temperature,
    "Σ a_ij·(x)^i·θ^j,  θ = (T − 20 °C)/50 K",
    (),
    tuple((f"a{i}{j}", f"unit/(x)^{i}") for i in (1, 2, 3) for j in (1, 2, 3)),
)
WAVE = Form(wave, "A·cos(2π·x/P) + B·sin(2π·x/P)", (PERIOD_K,), (("cosine", "unit"), ("sine", "unit")))


def forms_of(free: FreeFunction) -> list[tuple[Quantity, Form]]:
    """Forms that a free function may stand for, each with its quantity, the simplest first."""
    if free.beside is not None:
        return [(RATE, EVEN_BY_TEMPERATURE), (RATE, ODD_BY_TEMPERATURE), (RATE, PRODUCTS)]
    special = {
        SIZE: [(RATE, EVEN)],
        LASTING: [(RATE, REMEMBERED)],
        TEMPERATURE: [(TEMPERATURE, WAVE), (TEMPERATURE, BENT), (TEMPERATURE, STEPPED)],
        RATE: [(RATE, SATURATING)],
    }
    if free.of is CLOCK:
        special[CLOCK] = [(CLOCK, _wave_in_time(free.axis.high - free.axis.low))]
    plain = [EVEN, ODD, POLYNOMIALS[-1]] if free.of.signed else POLYNOMIALS
    return [*special.get(free.of, []), *((free.of, form) for form in plain)]


def _wave_in_time(hours: float) -> Form:
    """A wave whose period is at least a fortieth of the runs; periods are tried half a resolution apart."""
    period = Parameter("period", hours / 4, "h", hours / LINES, hours, "inverse", PRIOR, "P", grid=2 * LINES)
    return Form(wave, WAVE.formula, (period,), WAVE.amplitudes)
