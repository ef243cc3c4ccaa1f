"""Gyros of published papers: what the paper prints, and otherwise what its tables were fitted with."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from zoo.simulator.gyros.classes import MEDIUM, TACTICAL
from zoo.simulator.gyros.gyro_class import SPANS, GyroClass
from zoo.simulator.streams import Span


def at(value: float, unit: str, source: str) -> Span:
    """One value for all gyros of a class."""
    return Span(value, value, unit, log=False, source=source)


def typical(base: GyroClass, name: str, **own: Any) -> GyroClass:
    """One gyro: what a paper says or its tables ask for, and the middle of a class where they are silent.

    Args:
        base: the class.
        name: of the gyro.
        **own: fields of `GyroClass`.
    """
    middle: dict[str, Any] = {key: _middle(getattr(base, key)) for key in SPANS}
    return replace(base, name=name, **(middle | own))


def _middle(span: Span) -> Span:
    value = math.sqrt(span.low * span.high) if span.log and span.low > 0 else (span.low + span.high) / 2
    return at(value, span.unit, f"middle of the class: {span.source}")


ONE_LINE = {"cosine_2": 0.0, "sine_2": 0.0, "ratio_2": 2.0, "cosine_3": 0.0, "sine_3": 0.0, "ratio_3": 3.0}
"""Fringes of one period only."""
FIRST = "fitted to table 1 of qiu2023, and to what eq. 7 leaves in its table 2"
SECOND = "fitted to the mean and the standard deviation that tong2019 prints"

QIU2023 = typical(
    MEDIUM,
    "qiu2023",
    turns=64,
    package_s=at(1000.0, "s", FIRST + ": holds of 1 h that are quiet at their end"),
    sensor_s=at(60.0, "s", "prior"),
    winding_error_turns=at(0.2, "1", "prior: a coil wound with care"),
    random_walk=at(0.0014, "°/√h", FIRST + ": its holds"),
    flicker=at(0.0015, "°/h", FIRST + ": its holds"),
    rate_random_walk=at(0.0003, "°/h/√h", "prior"),
    fixed={
        "static_bias": {"offset": 0.02, "slope": 1.52e-3, "curvature": 1.71e-5, "cubic": -6.96e-7},
        "mohr": {"coefficient": 0.936},
        "rate_temperature_coupling": {"slope": -4.73e-3, "curvature": -1.775e-4},
    },
)
"""A quadrupolar coil of medium accuracy, 590 m (prior: 500 to 1000 m). The printed holds are far below the ramps, the ramps spread as much as the
whole run: that takes a bias that follows the rate (C_M 0.9 (°/h)/(K/min), 3e-6 /K more in the outermost layers than in the others) and is late by
a package of a quarter of an hour. What a polynomial of T and dT/dt leaves of the ramps, most at both ends of the range, takes a C_M that falls to
either side of 7 °C and a cubic bias; fringes are not needed. The stages are cut at the thermometer: a hold is where it moves at less than a tenth
of the ramps' rate."""

TONG2019 = typical(
    MEDIUM,
    "tong2019",
    self_heating_k=at(3.0, "K", "prior: a system that runs cool"),
    winding_error_turns=at(0.2, "1", "prior: a coil wound with care"),
    random_walk=at(0.0011, "°/√h", SECOND),
    flicker=at(0.0015, "°/h", SECOND),
    rate_random_walk=at(0.0001, "°/h/√h", "prior: of a navigation gyro"),
    fixed={
        "static_bias": {"offset": -0.0773, "slope": -4.4435e-4, "curvature": 2.5392e-5, "cubic": 1.6928e-6},
        "mohr": {"coefficient": 0.02},
        "polarization": {"period": 30.0, "cosine": -2.0230e-3, "sine": 8.9596e-3, **ONE_LINE},
    },
)
"""A gyro of an inertial system whose drift turns at 0, 15, 30 and 37 °C, as the segments of the paper say: a cubic in T with one fringe of 30 K has
its extrema there and nowhere else between −15 and 50 °C. The printed standard deviation is taken as one of 100 s means; at 200 Hz it would be the
noise's alone."""

LIU2010 = typical(
    TACTICAL,
    "liu2010",
    self_heating_k=at(1.0, "K", "prior: a small gyro on the open table of a chamber"),
    fixed={
        "static_bias": {"offset": 0.5, "slope": 0.0, "curvature": 0.0, "cubic": 0.0},
        "scale_factor": {"offset": -3500.0, "slope": -129.5, "curvature": 0.0},
        "scale_factor_nonlinearity": {"quadratic": 0.0, "cubic": -1.3797e-7, "cubic_slope": 1.145e-10},
    },
)
"""An open-loop gyro, V₀·sin(SΩ), with S = 0.188 s (L·D = 7.4 m² at 830 nm: 186 m on 40 mm), S falling by 350 ppm/K (an uncooled source, 0.3 nm/K) and
V₀ rising by 220 ppm/K; calibrated at small rates and 20 °C. What the paper's table calls the error's variance is taken as its standard deviation: of
two of the five methods it is larger than the square of the largest error."""
