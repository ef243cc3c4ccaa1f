"""The winding's weights: ideal coils against published figures, conservation, symmetry, winding errors, trimming."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import pytest
import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.physics.winding import CROSSOVER_FREE, PATTERNS, Coil, Winding, balancing_trim, shupe_weight, wind
from zoo.units import convert

MEDIUM = Coil(layers=32, turns=48, diameter_m=0.1, layer_pitch_m=0.22e-3, turn_pitch_m=0.22e-3)
TABLE = {"cylindrical": 37.7, "dipolar": 1.85, "quadrupolar": 0.126, "octupolar": 0.0039, "hexadecapolar": 0.0001}
"""(°/h)/(K/min) between the faces; from two independent computations."""


def dph(rad_per_s: float) -> float:
    return convert(rad_per_s, "rad_per_s", "dph")


def coil(pattern: str) -> Coil:
    return replace(MEDIUM, pattern=pattern)


def axial_weight(winding: Winding) -> float:
    """Error for a rate that grows by 1 K/min from one flange to the other [°/h]."""
    turns = winding.coil.turns
    profile = (torch.arange(turns, dtype=torch.float64) + 0.5) / turns - 0.5
    return dph(float((winding.weights().sum(0) * profile).sum())) / 60


@pytest.mark.parametrize("pattern", TABLE)
def test_ideal_coils_have_the_weights_of_the_table(pattern) -> None:
    """To 5 %; the last is given with one digit."""
    assert abs(dph(shupe_weight(wind(coil(pattern))))) == pytest.approx(TABLE[pattern], rel=0.05, abs=5e-5)


@pytest.mark.parametrize("size", [{"layers": 48, "turns": 60}, {"layers": 32, "turns": 32, "diameter_m": 0.05}])
def test_each_step_of_symmetry_gains_more_than_tenfold(size) -> None:
    weights = [abs(shupe_weight(wind(replace(coil(pattern), **size)))) for pattern in TABLE]
    assert all(more < less / 10 for less, more in pairwise(weights))


def test_a_helix_is_the_integral_of_a_straight_line() -> None:
    """A rate that grows linearly along the fibre: Ω = −n·n_T·L/(6D)·Ṫ, for a thin winding."""
    thin = wind(replace(coil("cylindrical"), layer_pitch_m=1e-7))
    expected = MEDIUM.index * MEDIUM.thermo_optic_per_k * thin.fibre_m / (6 * MEDIUM.diameter_m) / 60
    assert abs(shupe_weight(thin)) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_the_weights_are_the_shupe_integral(pattern) -> None:
    """Against a sum over a million places along the fibre, each asked which turn it lies in."""
    winding = wind(replace(coil(pattern), layers=16, turns=12), torch.linspace(-1, 1, 16, dtype=torch.float64))
    rate = torch.randn(16, 12, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    order = winding.start.flatten().argsort()
    begins = winding.start.flatten()[order]
    count, length = 1_000_000, winding.fibre_m
    place = (torch.arange(count, dtype=torch.float64) + 0.5) * length / count
    turn = order[torch.searchsorted(begins.contiguous(), place, right=True) - 1]
    integral = float((rate.flatten()[turn] * (length - 2 * place)).sum()) * length / count
    expected = MEDIUM.index * MEDIUM.thermo_optic_per_k / (MEDIUM.diameter_m * length) * integral
    assert float((winding.weights() * rate).sum()) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_uniform_rate_gives_nothing(pattern) -> None:
    """∫(L − 2s) ds = 0, whatever the winding, its errors and its trim."""
    errors = torch.randn(32, 2, generator=torch.Generator().manual_seed(2), dtype=torch.float64)
    weights = wind(coil(pattern), errors, trimmed_m=0.7).weights()
    assert abs(float(weights.sum())) < 1e-12 * float(weights.abs().sum())


@pytest.mark.parametrize("pattern", PATTERNS)
def test_the_turns_cover_the_fibre_once(pattern) -> None:
    winding = wind(coil(pattern))
    order = winding.start.flatten().argsort()
    begin, end = winding.start.flatten()[order], (winding.start + winding.length).flatten()[order]
    torch.testing.assert_close(end[:-1], begin[1:], rtol=0, atol=1e-9)
    assert (float(begin[0]), float(end[-1])) == (0.0, pytest.approx(winding.fibre_m))
    assert winding.fibre_m == pytest.approx(math.pi * MEDIUM.diameter_m * 32 * 48)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_exchanging_the_ends_flips_the_sign(pattern) -> None:
    winding = wind(coil(pattern))
    torch.testing.assert_close(winding.reversed().weights(), -winding.weights(), rtol=1e-9, atol=1e-18)


@pytest.mark.parametrize("pattern", ["quadrupolar", "octupolar", "hexadecapolar", CROSSOVER_FREE])
def test_both_supplies_lay_half_of_the_fibre(pattern) -> None:
    winding = wind(coil(pattern))
    assert float(winding.length[winding.supply == 0].sum()) == pytest.approx(winding.fibre_m / 2, rel=1e-12)


def test_neighbours_along_the_fibre_are_neighbours_in_the_coil() -> None:
    """Within a layer a turn away; a pair of layers returns to the flange it came from."""
    winding = wind(coil("quadrupolar"))
    mine = winding.supply[:, 0] == 1
    starts = winding.start[mine]
    forward = starts[:, -1] > starts[:, 0]
    assert forward.tolist() == [True, False] * 8
    steps = torch.diff(starts, dim=1).abs()
    torch.testing.assert_close(steps, winding.length[mine][:, 1:], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_the_middle_of_the_fibre_is_one_place_in_the_coil(pattern) -> None:
    """What A and what B lays first are neighbours: in one layer, or at the same flange in the next."""
    winding = wind(coil(pattern))
    if pattern == "cylindrical":
        assert int(winding.supply.sum()) == 0, "A lays it all"
        return
    middle = float((winding.start + winding.length)[winding.supply == 0].max())
    (last,) = torch.nonzero((winding.supply == 0) & ((winding.start + winding.length - middle).abs() < 1e-9)).tolist()
    (first,) = torch.nonzero((winding.supply == 1) & ((winding.start - middle).abs() < 1e-9)).tolist()
    assert sorted((abs(last[0] - first[0]), abs(last[1] - first[1]))) == [0, 1]


def test_the_halves_of_the_crossover_free_coil_mirror_each_other() -> None:
    """So that whatever is the same above and below makes nothing."""
    weights = wind(coil(CROSSOVER_FREE)).weights()
    torch.testing.assert_close(weights.flip(1), -weights, rtol=0, atol=1e-12 * float(weights.abs().max()))


def test_the_crossover_free_coil_is_fragile_along_its_axis_alone() -> None:
    free, quad = wind(coil(CROSSOVER_FREE)), wind(coil("quadrupolar"))
    assert abs(dph(shupe_weight(free))) < 1e-6
    assert abs(axial_weight(free)) > 1000 * abs(axial_weight(quad))
    assert abs(axial_weight(quad)) == pytest.approx(0.005, rel=0.1)


@pytest.mark.parametrize("turns", [1.0, 2.0])
def test_winding_errors_leave_every_coil_with_a_weight_of_its_own(turns) -> None:
    """Some 0.2 (°/h)/(K/min) for one turn a layer: beyond the quadrupolar pattern its name hardly matters."""
    spread = {}
    for pattern in ("quadrupolar", "octupolar"):
        draws = [turns * torch.randn(32, generator=torch.Generator().manual_seed(seed), dtype=torch.float64) for seed in range(200)]
        found = torch.tensor([dph(shupe_weight(wind(coil(pattern), errors))) for errors in draws])
        spread[pattern] = float(found.std())
        assert float(found.mean()) == pytest.approx(dph(shupe_weight(wind(coil(pattern)))), abs=4 * spread[pattern] / math.sqrt(200))
    assert spread["quadrupolar"] == pytest.approx(0.2 * turns, rel=0.2)
    assert spread["octupolar"] == pytest.approx(spread["quadrupolar"], rel=0.25)


@pytest.mark.parametrize("share", [0.3, 0.7, 0.95, 1.0])
@pytest.mark.parametrize("pattern", ["dipolar", "quadrupolar", "octupolar"])
def test_a_trim_takes_away_the_share_that_is_asked_for(pattern, share) -> None:
    """Where the errors are small enough for one layer to make up for them."""
    for seed in range(10):
        errors = 0.3 * torch.randn(32, 2, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)
        before = shupe_weight(wind(coil(pattern), errors))
        trim = balancing_trim(coil(pattern), errors, share)
        assert shupe_weight(wind(coil(pattern), errors, trim)) == pytest.approx((1 - share) * before, abs=1e-3 * abs(before))
        assert abs(trim) < math.pi * MEDIUM.diameter_m * MEDIUM.turns


@pytest.mark.parametrize("pattern", ["cylindrical", "dipolar", "quadrupolar", CROSSOVER_FREE])
def test_a_coil_beyond_trimming_is_trimmed_by_no_more_than_a_layer(pattern) -> None:
    errors = 10 * torch.randn(32, 2, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    trim = balancing_trim(coil(pattern), errors)
    longest = 2 * math.pi * float(MEDIUM.radii[-1]) * MEDIUM.turns
    assert abs(trim) < longest
    trimmed = wind(coil(pattern), errors, trim)
    assert abs(shupe_weight(trimmed)) < abs(shupe_weight(wind(coil(pattern), errors)))
    assert trimmed.fibre_m == pytest.approx(wind(coil(pattern), errors).fibre_m - abs(trim))


def test_a_trim_of_nothing_is_none() -> None:
    assert balancing_trim(MEDIUM, None, 0.0) == pytest.approx(0.0, abs=1e-9)


def test_trimming_cures_it() -> None:
    """Cutting an end moves the optical middle: some length of fibre nulls the weight of a badly wound coil."""
    errors = torch.randn(32, generator=torch.Generator().manual_seed(4), dtype=torch.float64)
    lengths = torch.linspace(-12, 12, 61).tolist()
    found = torch.tensor([dph(shupe_weight(wind(coil("dipolar"), errors, trimmed_m=length))) for length in lengths])
    assert float(found.abs().min()) < 0.1 * abs(float(found[30]))
    assert bool((torch.diff(found) != 0).all())


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"layers": 0}, r"layers=0: a whole number from 1 up"),
        ({"turns": 2.5}, r"turns=2.5"),
        ({"diameter_m": -0.1}, r"diameter_m=-0.1: a number above 0"),
        ({"layer_pitch_m": 0.01}, r"do not fit into a mean diameter"),
        ({"pattern": "quadrupole"}, r"did you mean quadrupolar"),
        ({"index": math.nan}, r"index=nan"),
    ],
)
def test_absurd_coils_are_refused(given, words) -> None:
    with pytest.raises(InputError, match=words):
        replace(MEDIUM, **given)


def test_absurd_windings_are_refused() -> None:
    wrong: Tensor = torch.zeros(5)
    with pytest.raises(InputError, match=r"shape \(5,\); one a layer is needed \(32\)"):
        wind(MEDIUM, wrong)
    with pytest.raises(InputError, match="-50 turns in a layer of 48"):
        wind(MEDIUM, torch.full((32,), -50.0))
    with pytest.raises(InputError, match="more than a layer"):
        wind(MEDIUM, trimmed_m=100.0)


@pytest.mark.parametrize("pattern", ["dipolar", "quadrupolar", CROSSOVER_FREE])
@pytest.mark.parametrize("trimmed_m", [0.0, 0.2])
def test_gradients_with_respect_to_winding_errors_are_those_of_finite_differences(pattern, trimmed_m) -> None:
    errors = 0.1 * torch.randn(6, 2, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    coil = Coil(6, 4, 0.1, 0.2e-3, 0.25e-3, pattern)
    assert torch.autograd.gradcheck(lambda value: wind(coil, value, trimmed_m).weights() * 1e8, (errors.requires_grad_(),), rtol=1e-6, eps=1e-4)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_single_layer_has_nothing_to_trim(pattern) -> None:
    assert balancing_trim(Coil(1, 8, 0.1, 0.2e-3, 0.25e-3, pattern), None) == 0.0
