"""Parameters of the effects a simulated gyro has, drawn so that a program shows them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.effects.base import Effect, Parameter, physical_value
from zoo.effects.chamber_cycling import RUNS
from zoo.effects.shupe import Shupe
from zoo.errors import InputError, nearest
from zoo.given import is_number
from zoo.simulator.gyros.device import Device
from zoo.simulator.streams import Span, sign, stream, uniform
from zoo.simulator.thermal.winding_weights import column_weight

# Leading amplitude, and how large the others may be relative to it. Engineering priors at 60 K from the reference; fringes of any phase.
RATIOS: dict[str, tuple[str, dict[str, float]]] = {
    "static_bias": ("slope", {"offset": 10.0, "curvature": 0.3 / 60, "cubic": 0.1 / 60**2}),
    "rate_temperature_coupling": ("slope", {"curvature": 0.3 / 60}),
    "glass_transition": ("jump", {"peak": 1.0}),
    "polarization": ("cosine", {"sine": 1.0, "cosine_2": 0.3, "sine_2": 0.3, "cosine_3": 0.1, "sine_3": 0.1}),
    "magnetic": ("sensitivity", {"slope": 0.0015}),
    "scale_factor": ("slope", {"offset": 20.0, "curvature": 0.3 / 60}),
    "scale_factor_nonlinearity": ("cubic", {"cubic_slope": 0.002}),
    "misalignment": ("slope", {"offset": 60.0, "curvature": 0.3 / 60}),
    "moisture": ("flux", {"strain": 0.3}),
    "warm_up": ("amplitude", {"early": 0.7}),
    "chamber_cycling": ("cosine_1", {f"{wave}_{run}": 1.0 for run in range(1, RUNS + 1) for wave in ("cosine", "sine")}),
}
# What parameters were called when their streams of chance were named, so that a seed keeps its gyro.
CALLED = {("aging", "bend"): "time"}
# Shapes that show within hours and within the tens of kelvins of a program; the effects' own bounds are wider.
VISIBLE = {
    ("aging", "bend"): Span(5.0, 200.0, "h"),  # the time of a logarithm
    ("polarization", "period"): Span(5.0, 40.0, "K"),
    ("polarization", "ratio_2"): Span(1.0, 3.0, "1"),
    ("polarization", "ratio_3"): Span(1.0, 3.0, "1"),
    ("warm_up", "time"): Span(600.0, 3600.0, "s"),
    ("hysteresis", "width"): Span(3.0, 12.0, "K"),
    ("hysteresis", "spread"): Span(15.0, 80.0, "K"),
    ("sensor_lag", "lag"): Span(200.0, 1800.0, "s"),
    ("glass_transition", "width"): Span(5.0, 15.0, "K"),
    ("viscoelastic", "time"): Span(0.3, 5.0, "h"),
    ("moisture", "time"): Span(3.0, 30.0, "h"),
    ("dead_band", "edge"): Span(3.0, 10.5, "1"),  # a zone with hard edges falls between the samples of a slow recording
    ("chamber_cycling", "period"): Span(240.0, 600.0, "s"),  # means over 100 s take a shorter one for a longer
}


@dataclass(frozen=True)
class Scene:
    """What limits a shape that should show.

    Attributes:
        runs: how many runs are fitted.
        seconds: length of the shortest [s].
        low_c: coldest temperature of the coil [°C].
        high_c: hottest one [°C].
        slow: one of the slowest true rates other than zero [°/h]; zero where nothing turns.
    """

    runs: int
    seconds: float
    low_c: float
    high_c: float
    slow: float


def shape_parameters(effect: Effect) -> tuple[Parameter, ...]:
    """The shapes a simulated gyro's effect has; Shupe's effect is computed from the layers and needs none."""
    return () if isinstance(effect, Shupe) else effect.shape


def draw_shape(name: str, effect: Effect, scene: Scene, seed: int) -> Tensor:
    """(S,) shape parameters, in their units; what most gyros have alike, or about, is as in most.

    Args:
        name: the effect's.
        effect: declares the shapes.
        scene: what limits them.
        seed: the user's.
    """
    called = {one.name: CALLED.get((name, one.name), one.name) for one in effect.shape}
    values = [
        one.default if one.usual or one.within else _visible(name, one, scene, stream(seed, "shape", name, called[one.name]))
        for one in shape_parameters(effect)
    ]
    return torch.tensor(values, dtype=torch.float64)


def _visible(name: str, parameter: Parameter, scene: Scene, generator: torch.Generator) -> float:
    key = (name, parameter.name)
    width = scene.high_c - scene.low_c
    if key == ("hysteresis", "centre"):
        return scene.low_c + (0.2 + 0.6 * uniform(generator)) * width
    if key == ("bias_step", "onset"):
        return (0.15 + 0.7 * uniform(generator)) * scene.seconds / 3600
    if key == ("dead_band", "width") and scene.slow > 0:
        return min(scene.slow * Span(0.5, 2.0, "1").draw(generator), parameter.high)
    if parameter.scale == "index":
        return float(math.floor(uniform(generator) * ((scene.runs if scene.runs > 1 else 0) + 1)))
    if parameter.scale == "share":
        return uniform(generator)
    value = VISIBLE[key].draw(generator) if key in VISIBLE else float(physical_value(torch.tensor(0.2 + 0.6 * uniform(generator)), parameter))
    value = -1.0 / value if key == ("aging", "bend") else value
    # A loop wider than the program would never close.
    return min(value, max(width / 6, parameter.low)) if key == ("hysteresis", "width") else value


def draw_amplitude(name: str, effect: Effect, device: Device) -> Tensor | None:
    """(K,) amplitudes [output's unit per unit of the column] from the spread of the gyro's class; Shupe's is that of the gyro's winding.

    Args:
        name: the effect's.
        effect: declares the amplitudes.
        device: the gyro.

    Returns:
        None where the class does not know the effect.
    """
    if isinstance(effect, Shupe) and name not in device.gyro.effects:
        return torch.tensor([column_weight(device)], dtype=torch.float64)
    if name not in device.gyro.effects:
        return None
    leading, ratios = RATIOS.get(name, (effect.amplitudes[0].name, {}))
    low, high = device.gyro.effects[name]
    generator = stream(device.seed, "amplitude", name)
    size = sign(generator) * Span(low, high, "").draw(generator)
    others = {one.name: size * ratios.get(one.name, 0.0) * (2 * uniform(generator) - 1) for one in effect.amplitudes}
    return torch.tensor([size if one.name == leading else others[one.name] for one in effect.amplitudes], dtype=torch.float64)


def draw_direction(name: str, columns_rms: Tensor, seed: int) -> Tensor:
    """(K,) amplitudes of an effect nobody has numbers for: random, with every column of equal weight.

    Args:
        name: the effect's.
        columns_rms: (K,) root mean square of each column.
        seed: the user's.
    """
    raw = torch.randn(len(columns_rms), generator=stream(seed, "amplitude", name), dtype=torch.float64)
    return raw / torch.where(columns_rms > 0, columns_rms, torch.ones_like(columns_rms))


def given_values(values: Tensor, declared: tuple[Parameter, ...], given: Mapping[str, float], name: str) -> Tensor:
    """Drawn values with the user's own in their place.

    Args:
        values: (P,) drawn.
        declared: P declarations.
        given: value by parameter; names that are not declared here are left alone.
        name: the effect's, for the message.

    Raises:
        InputError: a value that is not a number or out of the declared bounds.
    """
    for one, value in given.items():
        match = next((p for p in declared if p.name == one), None)
        if match and not (is_number(value) and match.low <= value <= match.high):
            raise InputError(f"parameters.{name}.{one}={value}: {match.low:g} to {match.high:g} {match.unit} is possible")
    return torch.tensor([float(given.get(p.name, old)) for p, old in zip(declared, values.tolist(), strict=True)], dtype=torch.float64)


def check_given(given: Mapping[str, Mapping[str, float]], effects: Mapping[str, Effect]) -> None:
    """Refuse the user's parameters of effects or with names that are not there.

    Raises:
        InputError: an unknown effect or parameter.
    """
    if not isinstance(given, Mapping):
        raise InputError(f"parameters={given}: effect: {{parameter: value}} is expected")
    for name, values in given.items():
        if name not in effects:
            raise InputError(f"parameters.{name}: the gyro does not have this effect; {nearest(name, effects)}")
        if not isinstance(values, Mapping):
            raise InputError(f"parameters.{name}={values}: parameter: value is expected")
        known = [one.name for one in (*shape_parameters(effects[name]), *effects[name].amplitudes)]
        unknown = [one for one in values if one not in known]
        if unknown:
            raise InputError(f"parameters.{name}.{unknown[0]}: {nearest(unknown[0], known)}")
