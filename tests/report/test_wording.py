"""Numbers are rounded to what is known."""

from __future__ import annotations

from typing import Any

import pytest

from zoo.report.wording import Scale, finite, fixed, joined, percent, significant, times, unit_symbol, with_error


@pytest.mark.parametrize("value", [None, float("nan"), float("inf"), "1", True])
def test_no_number_is_none(value: Any) -> None:
    assert finite(value) is None
    assert fixed(value, 2) == significant(value) == "–"


@pytest.mark.parametrize(("value", "text"), [(-0.001, "0.00"), (-1.256, "−1.26"), (0, "0.00"), (12, "12.00")])
def test_fixed(value: float, text: str) -> None:
    assert fixed(value, 2) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.012345, "0.0123"),
        (1234.5, "1230"),
        (-3.2e-7, "−3.20·10⁻⁷"),
        (0.0, "0"),
        (4.5e9, "4.50·10⁹"),
        (9.9996, "10.0"),
        (-99.97, "−100"),
        (9.9996e7, "1.00·10⁸"),
    ],
)
def test_significant(value: float, text: str) -> None:
    assert significant(value) == text


@pytest.mark.parametrize(
    ("value", "stderr", "text"),
    [
        (6.1, 0.4, "6.10 ± 0.40"),
        (5210, 640, "5210 ± 640"),
        (1.0, None, "1.00"),
        (-1.2e-5, 2.1e-6, "(−1.20 ± 0.21)·10⁻⁵"),
        (3.0, 0.0, "3.00"),
        (0.0, 0.5, "0.00 ± 0.50"),
    ],
)
def test_a_value_is_as_long_as_its_error_allows(value: float, stderr: float | None, text: str) -> None:
    assert with_error(value, stderr) == text


@pytest.mark.parametrize(("at_bound", "text"), [("low", "≤ 6.10"), ("high", "≥ 6.10"), (None, "6.10 ± 0.40")])
def test_a_value_on_its_bound_is_a_limit(at_bound: str | None, text: str) -> None:
    assert with_error(6.1, 0.4, at_bound) == text
    assert Scale.of("dph", 0.008, 0.07).parameter(6.1, 0.4, "K", at_bound) == (text, "K")


@pytest.mark.parametrize(("share", "text"), [(0.983, "98 %"), (1.0, "> 99 %"), (0.0, "< 1 %"), (None, "–")])
def test_nothing_is_certain(share: float | None, text: str) -> None:
    assert percent(share) == text


@pytest.mark.parametrize(("ratio", "text"), [(0.68, "0.7×"), (11.2, "11.2×"), (142.3, "142×"), (1e9, "> 999×"), (None, "–")])
def test_times(ratio: float | None, text: str) -> None:
    assert times(ratio) == text


@pytest.mark.parametrize(
    ("unit", "text"),
    [("dph", "°/h"), ("dph·min/K", "°/h·min/K"), ("K", "K"), (None, ""), ("m_per_s2/K", "m/s²/K"), ("dph/(K/min)/K^2", "°/h/(K/min)/K²")],
)
def test_units_as_written(unit: str | None, text: str) -> None:
    assert unit_symbol(unit) == text


@pytest.mark.parametrize(("names", "text"), [([], ""), (None, ""), (["a"], "a"), (["a", "b"], "a and b"), (["a", "b", "c"], "a, b and c")])
def test_joined(names: list[str] | None, text: str) -> None:
    assert joined(names) == text


@pytest.mark.parametrize(
    ("floor", "rms", "label", "text"),
    [
        (0.0081, 0.071, "°/h", "0.0710"),
        (3.9e-8, 3.4e-7, "10⁻⁹ °/h", "340"),
        (0.0, 0.071, "°/h", "0.0710"),
        (None, None, "°/h", "–"),
        (120.0, 900.0, "°/h", "900"),
    ],
)
def test_a_scale_writes_a_column(floor: float | None, rms: float | None, label: str, text: str) -> None:
    scale = Scale.of("dph", floor, rms)
    assert (scale.label, scale.text(rms)) == (label, text)


@pytest.mark.parametrize(
    ("unit", "given", "text"),
    [
        ("rad_per_s", "rad_per_s/K", ("2000 ± 100", "nrad/s/K")),
        ("rad_per_s", "rad_per_s", ("2000 ± 100", "nrad/s")),
        ("rad_per_s", "K", ("(2.00 ± 0.10)·10⁻⁶", "K")),
        ("dph", "dph/K^2", ("2000 ± 100", "10⁻⁹ °/h/K²")),
        ("m_per_s2", "m_per_s2", ("2000 ± 100", "nm/s²")),
        ("g", "gauss", ("(2.00 ± 0.10)·10⁻⁶", "gauss")),  # begins with the output's unit, and is another
    ],
)
def test_a_scale_writes_parameters(unit: str, given: str, text: tuple[str, str]) -> None:
    assert Scale.of(unit, 3.9e-8, 3.4e-7).parameter(2e-6, 1e-7, given) == text


def test_an_ordinary_scale_leaves_parameters_alone() -> None:
    assert Scale.of("dph", 0.008, 0.07).parameter(2e-6, 1e-7, "dph") == ("(2.00 ± 0.10)·10⁻⁶", "°/h")
