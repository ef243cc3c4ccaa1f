"""What of an explanation the simulator takes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from zoo.effects.base import Effect, Parameter
from zoo.models.trained import Trained
from zoo.simulator.draws import shape_parameters
from zoo.simulator.inputs import NAMES
from zoo.units import convert_parameter

DIGITS = 6


def simulable(effect: Effect) -> bool:
    """Whether a simulated gyro can have an effect: one of the catalogue, not a trained model, and of columns that the simulator records."""
    return not isinstance(effect, Trained) and set(effect.needs) <= set(NAMES)


def simulated_values(effect: Effect, fitted: Mapping[str, float], unit: str) -> dict[str, float]:
    """What an effect was fitted to, rounded, without what the simulator refuses; whole numbers, which are of the runs at hand, are left out.

    Amplitudes are fitted without bounds and come together or not at all: what a sum of large ones of opposite sign makes, the rest of them does not.
    Where none is given, the simulator makes an effect of this shape visible; where some are, it draws the others from its class.

    Args:
        effect: declares the parameters.
        fitted: value by name [output's unit].
        unit: suffix of the output's unit, a rate.

    Returns:
        Value by name [°/h].
    """
    shapes = _within_bounds([one for one in shape_parameters(effect) if one.scale != "index"], fitted, unit)
    amplitudes = _within_bounds(effect.amplitudes, fitted, unit)
    return shapes | (amplitudes if len(amplitudes) == len(effect.amplitudes) else {})


def _within_bounds(declared: Sequence[Parameter], fitted: Mapping[str, float], unit: str) -> dict[str, float]:
    known = {one.name: convert_parameter(fitted[one.name], one.unit, unit, "dph") for one in declared}
    rounded = {name: float(f"{value:.{DIGITS}g}") for name, value in known.items()}
    return {one.name: rounded[one.name] for one in declared if one.low <= rounded[one.name] <= one.high}
