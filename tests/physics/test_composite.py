"""What glass in glue conducts: limits, bounds, and the values of potted windings."""

from __future__ import annotations

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st
from torch import Tensor

from zoo.physics.composite import GLASS_W_PER_M_K, longitudinal_conductivity, transverse_conductivity

CONDUCTS = st.floats(0.01, 100.0)
FRACTIONS = st.floats(0.0, 1.0)


def numbers(*values: float | list[float]) -> tuple[Tensor, ...]:
    return tuple(torch.tensor(value, dtype=torch.float64) for value in values)


@given(CONDUCTS, CONDUCTS)
def test_without_glass_it_is_the_glue_and_without_glue_the_glass(glass: float, glue: float) -> None:
    for conductivity in (transverse_conductivity, longitudinal_conductivity):
        assert float(conductivity(*numbers(glass, glue, 0.0))) == pytest.approx(glue, rel=1e-12)
        assert float(conductivity(*numbers(glass, glue, 1.0))) == pytest.approx(glass, rel=1e-9)


@given(CONDUCTS, FRACTIONS)
def test_of_one_material_it_is_that_material(one: float, fraction: float) -> None:
    for conductivity in (transverse_conductivity, longitudinal_conductivity):
        assert float(conductivity(*numbers(one, one, fraction))) == pytest.approx(one, rel=1e-12)


@given(CONDUCTS, CONDUCTS, FRACTIONS)
def test_across_it_lies_between_layers_in_series_and_in_parallel(glass: float, glue: float, fraction: float) -> None:
    """Wiener 1912; along the fibres they are in parallel."""
    across, along = (float(one(*numbers(glass, glue, fraction))) for one in (transverse_conductivity, longitudinal_conductivity))
    series = 1 / (fraction / glass + (1 - fraction) / glue)
    assert series * (1 - 1e-12) <= across <= along * (1 + 1e-12)


@given(CONDUCTS, CONDUCTS)
def test_thinly_spread_fibres_disturb_the_flow_by_what_a_cylinder_in_a_uniform_field_does(glass: float, glue: float) -> None:
    """Each has the dipole (k_f − k_m)/(k_f + k_m): k = k_m·(1 + 2φ·dipole) (Rayleigh 1892, Phil. Mag. 34:481)."""
    thin = 1e-7
    slope = (float(transverse_conductivity(*numbers(glass, glue, thin))) / glue - 1) / thin
    assert slope == pytest.approx(2 * (glass - glue) / (glass + glue), rel=1e-5, abs=1e-7)


@given(CONDUCTS, CONDUCTS, FRACTIONS)
def test_fibres_and_gaps_exchanged_conduct_the_reciprocal(glass: float, glue: float, fraction: float) -> None:
    """Keller 1964, J. Math. Phys. 5:548: in two dimensions k(k_f, k_m)·k(k_m, k_f) = k_f·k_m, where what is fibre stays fibre."""
    there, back = (float(transverse_conductivity(*numbers(*pair, fraction))) for pair in ((glass, glue), (glue, glass)))
    assert there * back == pytest.approx(glass * glue, rel=1e-9)


@given(CONDUCTS, st.floats(0.01, 0.99))
def test_more_of_the_better_conductor_conducts_better(glue: float, fraction: float) -> None:
    less, more = (transverse_conductivity(*numbers(2 * glue, glue, part)) for part in (fraction, fraction + 0.01))
    assert float(less) < float(more)


def test_potted_windings_conduct_0_28_to_0_32() -> None:
    """125 µm of glass in 250 µm, packed in hexagons, to 80 µm in 135 µm; acrylate and epoxy of 0.2 W/m/K."""
    found = transverse_conductivity(*numbers(GLASS_W_PER_M_K, 0.2, [0.22, 0.31]))
    assert found.tolist() == pytest.approx([0.28, 0.32], abs=0.002)


def test_devices_in_a_batch_are_each_by_themselves() -> None:
    glass, glue, fraction = numbers([1.38, 1.38, 1.0], [0.2, 0.17, 0.3], [0.22, 0.31, 0.5])
    for conductivity in (transverse_conductivity, longitudinal_conductivity):
        alone = [conductivity(*one) for one in zip(glass, glue, fraction, strict=True)]
        assert torch.equal(conductivity(glass, glue, fraction), torch.stack(alone))
