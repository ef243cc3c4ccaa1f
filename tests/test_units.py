"""Numbers change unit in one place, and it is right."""

from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from zoo import units
from zoo.errors import InputError


@pytest.mark.parametrize(
    ("written", "suffix"),
    [
        ("deg/h", "dph"),
        ("dph", "dph"),
        ("°/h", "dph"),
        ("deg/hr", "dph"),
        ("deg / s", "dps"),
        ("°/s", "dps"),
        ("rad/s", "rad_per_s"),
        ("Rad/S", "rad_per_s"),
        ("m/s^2", "m_per_s2"),
        ("m/s²", "m_per_s2"),
        ("m/s2", "m_per_s2"),
        ("µg", "ug"),
        ("μg", "ug"),
        ("g", "g"),
        ("pulses", "pulses"),
        ("counts", "counts"),
    ],
)
def test_a_unit_is_known_by_its_suffix_and_its_usual_writings(written: str, suffix: str) -> None:
    assert units.parse_unit(written) == suffix


@pytest.mark.parametrize("suffix", list(units.UNITS))
def test_every_unit_is_known_by_its_own_symbol(suffix: str) -> None:
    quantity = units.UNITS[suffix].quantity
    assert units.parse_unit(units.symbol(suffix), quantity) == suffix
    assert units.parse_unit(suffix, quantity) == suffix


def test_an_unknown_unit_is_named_with_the_possible_ones() -> None:
    with pytest.raises(InputError, match=r"'furlong'.*dph.*rad_per_s.*m_per_s2.*pulses"):
        units.parse_unit("furlong")


def test_a_temperature_is_no_output() -> None:
    with pytest.raises(InputError, match="'°C'"):
        units.parse_unit("°C")


@pytest.mark.parametrize(
    ("value", "given", "wanted", "expected"),
    [
        (1.0, "rad_per_s", "dph", 206264.80624709636),  # 648000/π, the arc seconds in a radian
        (360.0, "dps", "rad_per_s", 2 * math.pi),
        (15.0, "dph", "dps", 15 / 3600),
        (1.0, "g", "m_per_s2", 9.80665),
        (1.0, "mg", "ug", 1000.0),
        (-40.0, "f", "c", -40.0),
        (212.0, "f", "c", 100.0),
        (0.0, "k", "c", -273.15),
        (25.0, "c", "k", 298.15),
        (1500.0, "ms", "s", 1.5),
        (2.0, "h", "min", 120.0),
    ],
)
def test_conversion_agrees_with_the_definitions(value: float, given: str, wanted: str, expected: float) -> None:
    assert units.convert(value, given, wanted) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert units.convert(np.array([value]), given, wanted) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert units.convert(torch.tensor([value], dtype=torch.float64), given, wanted).item() == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_there_and_back_is_the_same_number() -> None:
    for unit in units.UNITS.values():
        for other in units.suffixes(unit.quantity):
            assert units.convert(units.convert(12.5, unit.suffix, other), other, unit.suffix) == pytest.approx(12.5, rel=1e-9)


def test_quantities_do_not_convert_into_each_other() -> None:
    with pytest.raises(InputError, match=r"°/h.*µg"):
        units.convert(1.0, "dph", "ug")


@pytest.mark.parametrize(
    ("column", "suffix"),
    [
        ("gyro_x_rad_per_s", "rad_per_s"),
        ("rate_dph", "dph"),
        ("acc_m_per_s2", "m_per_s2"),
        ("accel_ug", "ug"),
        ("accel_g", "g"),
        ("pulses", "pulses"),
        ("gyro_counts", "counts"),
        ("gz", None),
        ("rate_dph_compensated", None),
        ("g", None),
        ("temperature_c", None),
    ],
)
def test_the_unit_is_read_from_a_columns_name(column: str, suffix: str | None) -> None:
    assert units.output_suffix(column) == suffix


@pytest.mark.parametrize(
    ("declared", "power"),
    [
        ("unit", 1),
        ("unit/K", 1),
        ("unit/(K/min)/K^2", 1),
        ("unit/µT/K", 1),
        ("ppm/(unit)", -1),
        ("ppm/(unit)^2", -2),
        ("ppm/(unit)^2/K", -2),
        ("ppm·unit⁻²", -2),
        ("1/(min·unit)", -1),
        ("K/(min/unit)", 1),
        ("unit²", 2),
        ("unit^-1", -1),
        ("(unit/K)^2", 2),
        ("unit/K^p", 1),
        ("s", 0),
        ("", 0),
    ],
)
def test_a_parameters_unit_has_the_outputs_to_some_power(declared: str, power: int) -> None:
    assert units.output_power(declared) == power
    assert units.convert_parameter(3.0, declared, "dps", "dph") == pytest.approx(3.0 * 3600.0**power)


def test_a_power_that_is_no_number_is_not_guessed() -> None:
    assert math.isnan(units.convert_parameter(3.0, "unit^p", "dps", "dph"))
