"""Heat in a packaged gyro, and what its winding makes of it: Shupe's and Mohr's effects as integrals over the fibre."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
import torch
from torch import Tensor

from zoo.physics.conduction import FIDELITIES
from zoo.physics.system import field
from zoo.physics.winding import CROSSOVER_FREE, PATTERNS, shupe_weight
from zoo.simulator.gyros.device import Device, draw
from zoo.simulator.gyros.paper_gyros import typical
from zoo.simulator.gyros.presets import MEDIUM, gyro_class
from zoo.simulator.laboratory.chamber import Chamber
from zoo.simulator.laboratory.program import Program
from zoo.simulator.streams import stream
from zoo.simulator.thermal.heat import Heat, heat, system
from zoo.simulator.thermal.winding_weights import coil_weight, column_weight, strain_per_k
from zoo.units import convert

F64 = torch.float64
CLASSES = ("medium", "tactical", "navigation")
FINE = ("radial", "radial_axial")
UP = ((20.0, 20.0, 1200.0), (20.0, 60.0, 2400.0), (60.0, 60.0, 20000.0))
DOWN = tuple((80 - begin, 80 - end, seconds) for begin, end, seconds in UP)
OUTSIDE_IN = {"gap": 80.0, "contact": 20.0, "mount_s": 20000.0}
"""A coil that is warmed through its outer face, on a spool that hangs free."""


def gyro(seed: int = 1, **changes: Any) -> Device:
    """In the middle of the medium class, in a package of a quarter of an hour as published ones have, with winding errors of its own."""
    return draw(typical(gyro_class("medium", **{"package_s": 900, **changes}), "typical"), seed)


def chamber(*legs: tuple[float, float, float], step_s: float = 10.0, lag_s: float = 120.0) -> tuple[Tensor, Tensor]:
    program = Program(legs)
    time = torch.arange(0, program.seconds + step_s / 2, step_s, dtype=F64)
    return time, Chamber(lag_s=lag_s).air(program, time, stream(1))


def ramp(devices: list[Device], k_per_min: float = 1.0, minutes: float = 100.0, fidelity: str = "radial") -> Heat:
    """Air that was at −30 °C for ever and then rises; changes since the beginning."""
    time = torch.linspace(0, 60 * minutes, 601, dtype=F64)
    found = heat(devices, time, -30 + k_per_min / 60 * time, fidelity=fidelity)
    since = {name: getattr(found, name) - getattr(found, name)[..., :1] for name in ("air", "housing", "spool", "coil", "inner", "outer")}
    return replace(found, **since)


def error(device: Device, time: Tensor, air: Tensor, fidelity: str = "radial", **more: Any) -> Tensor:
    """(T,) Shupe's effect [°/h]."""
    return column_weight(device) * heat([device], time, air, fidelity=fidelity, **more).shupe[0]


def with_ends_exchanged(device: Device) -> Device:
    other = replace(device)
    vars(other)["winding"] = device.winding.reversed()
    return other


# The package


@pytest.mark.parametrize("fidelity", FINE)
def test_temperatures_are_those_of_packaged_gyros(fidelity) -> None:
    """At 1 K/min the coil lags the chamber by 13 to 18 K and the housing by 2 to 3.3 K, with 0.36 to 0.75 K across the winding."""
    found = ramp([gyro()], fidelity=fidelity)
    assert 13 < float(found.air[-1] - found.coil[0, -1]) < 18
    assert 2.0 < float(found.housing[0, -1] - found.coil[0, -1]) < 3.3
    assert 0.36 < float(found.inner[0, -1] - found.outer[0, -1]) < 0.75, "the spool warms the inside first"


def test_a_class_spreads_about_twice_as_wide() -> None:
    found = ramp([draw(MEDIUM, seed) for seed in range(50)])
    behind, across = (found.housing - found.coil)[:, -1], (found.inner - found.outer)[:, -1].abs()
    assert 1.0 < float(behind.min()) < 2.0 < float(behind.median()) < 3.3 < float(behind.max()) < 6.6
    assert float(across.min()) < 0.36 < float(across.median()) < 0.75 < float(across.max()) < 1.5


@pytest.mark.parametrize("fidelity", FIDELITIES)
@pytest.mark.parametrize("name", CLASSES)
def test_in_a_steady_ramp_the_housing_is_late_by_the_time_constant_of_the_package(name, fidelity) -> None:
    """All the heat passes from the air to the housing, C·dT/dt through C/τ, whatever is inside; everything warms at the ramp's rate."""
    devices = [draw(gyro_class(name, package_s=700), seed) for seed in range(3)]
    found = ramp(devices, minutes=500, fidelity=fidelity)
    assert (found.air[-1] - found.housing[:, -1]).tolist() == pytest.approx([700 / 60] * 3, abs=1e-7)
    assert bool((found.housing[:, -1] > found.spool[:, -1]).all())
    for rate in (found.housing_rate, found.coil_rate, found.mohr):
        assert rate[:, -1].tolist() == pytest.approx([1.0] * 3, abs=1e-9)


@pytest.mark.parametrize("name", CLASSES)
def test_nothing_is_slower_than_the_latest_part_and_the_slowest_mode_than_the_package(name) -> None:
    """Bounds of the smallest eigenvalue of C⁻¹G, which has a positive inverse: Rayleigh's from above, the largest row sum's from below."""
    for seed in range(5):
        device = draw(gyro_class(name), seed)
        one = system([device], "radial", torch.zeros(1, dtype=F64))
        slowest = 1 / float(torch.linalg.eigvalsh(one.stiffness[0])[0])
        late = torch.linalg.solve(one.stiffness[0], torch.linalg.solve(one.stiffness[0], one.drive[0, :, 0]))
        latest = max(float((part @ late).max()) for part in (one.lumps[0], one.winding[0]))
        assert device["package_s"] < slowest < latest


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_soaked_means_self_heated_and_at_rest(fidelity) -> None:
    device = gyro()
    time, air = chamber((20, 20, 3000))
    found = heat([device], time, air, fidelity=fidelity)
    for part in (found.housing, found.spool, found.coil, found.inner, found.outer):
        assert part[0].tolist() == pytest.approx([20 + device["self_heating_k"]] * len(time), abs=1e-9)
    assert max(float(rate.abs().max()) for rate in (found.housing_rate, found.coil_rate, found.shupe, found.mohr)) < 1e-9


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_a_cold_start_begins_at_the_air_and_ends_self_heated(fidelity) -> None:
    time, air = chamber(*UP)
    cold, warm = (heat([gyro()], time, air, cold_start=cold, fidelity=fidelity) for cold in (True, False))
    for name in ("housing", "spool", "coil", "inner", "outer"):
        assert float(getattr(cold, name)[0, 0]) == pytest.approx(20.0, abs=3e-5)
        assert float(getattr(cold, name)[0, -1]) == pytest.approx(float(getattr(warm, name)[0, -1]), abs=1e-6)
        gain = getattr(warm, name) - getattr(cold, name)
        assert float(torch.diff(gain[0]).max()) <= 1e-12, "the lack of heat only shrinks"


def test_the_rates_are_those_of_the_temperatures() -> None:
    time, air = chamber(*UP, step_s=2.0)
    found = heat([gyro()], time, air)
    for temperature, rate in ((found.housing, found.housing_rate), (found.coil, found.coil_rate)):
        central = (temperature[0, 2:] - temperature[0, :-2]) / 4 * 60
        assert float((central - rate[0, 1:-1]).abs().max()) < 1e-3


# Shupe's effect


@pytest.mark.parametrize("fidelity", FINE)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_between_isothermal_states_and_over_a_closed_cycle_it_integrates_to_nothing(pattern, fidelity) -> None:
    """And Mohr's to what the coil has warmed, which is nothing over a cycle."""
    device = gyro(pattern=pattern)
    time, air = chamber(*UP, *DOWN)
    found = heat([device], time, air, fidelity=fidelity)
    half = time <= sum(seconds for _, _, seconds in UP)
    for part, warmed in ((half, 40.0), (half | True, 0.0)):
        total = float(torch.trapezoid(found.shupe[0, part], time[part]))
        assert abs(total) < 1e-7 * float(torch.trapezoid(found.shupe[0, part].abs(), time[part]))
        assert float(torch.trapezoid(found.mohr[0, part], time[part])) / 60 == pytest.approx(warmed, abs=1e-6)


@pytest.mark.parametrize("fidelity", FINE)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_uniform_rate_gives_nothing(pattern, fidelity) -> None:
    """But for the last digits of the weights, which count where C_w is small against the weights themselves."""
    device = gyro(pattern=pattern)
    found = ramp([device], minutes=500, fidelity=fidelity)
    digits = 1e-13 * float(device.winding.weights().abs().sum()) / abs(60 * shupe_weight(device.winding))
    assert float(found.shupe[0, -120:].abs().max()) < max(1e-9 * float(found.shupe.abs().max()), digits)


@pytest.mark.parametrize("fidelity", FINE)
def test_it_is_the_sum_over_the_turns_of_weight_times_rate(fidelity) -> None:
    """From the temperature of every turn two seconds before and after, without the column that the simulator goes by."""
    device, step = gyro(top_contact=1000), 2.0
    time, air = chamber(*UP[:2], step_s=step)
    samples = torch.arange(610, 1500, 40)
    around = [field(system([device], fidelity, time), step, torch.stack([air, torch.ones_like(air)]), samples + shift)[0] for shift in (-1, 1)]
    weights = device.winding.weights()
    rate = ((around[1] - around[0]) / (2 * step)).expand(-1, *weights.shape)
    wanted = convert((weights * rate).sum((1, 2)), "rad_per_s", "dph")
    found = error(device, time, air, fidelity)[samples]
    assert float((found - wanted).abs().max()) < 5e-3 * float(wanted.abs().max())


@pytest.mark.parametrize("fidelity", FINE)
def test_edges_scale_with_the_rate(fidelity) -> None:
    device = gyro()
    one, two = (error(device, *chamber((20, 20, 600), (20, to, 3000), lag_s=0), fidelity) for to in (45, 70))
    assert float((two - 2 * one).abs().max()) < 1e-9 * float(two.abs().max())
    time, quick = chamber((20, 20, 600), (20, 45, 1500), (45, 45, 1500), lag_s=0)
    quick = error(device, time, quick, fidelity)
    assert float(quick.abs()[time < 2100].max()) == pytest.approx(2 * float(one.abs()[time < 2100].max()), rel=1e-9)


@pytest.mark.parametrize("fidelity", FINE)
def test_heating_and_cooling_have_opposite_signs_and_so_have_the_edges_of_a_ramp(fidelity) -> None:
    device = gyro(pattern="cylindrical")
    (time, up), (_, down) = chamber(*UP), chamber(*DOWN)
    first, second = error(device, time, up, fidelity), error(device, time, down, fidelity)
    assert float((first + second).abs().max()) < 1e-9 * float(first.abs().max())
    begin, end = first[(time > 1200) & (time < 3600)], first[time > 3600]
    assert float(begin[begin.abs().argmax()] * end[end.abs().argmax()]) < 0


@pytest.mark.parametrize("fidelity", FINE)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_exchanging_the_ends_of_the_coil_flips_it(pattern, fidelity) -> None:
    """Mohr's too: the same strain makes the opposite effect."""
    device = gyro(pattern=pattern)
    other, (time, air) = with_ends_exchanged(device), chamber(*UP[:2])
    there, back = error(device, time, air, fidelity), error(other, time, air, fidelity)
    assert float((there + back).abs().max()) < 1e-7 * float(there.abs().max())
    strains = [strain_per_k(one, 0.1) for one in (device, other)]
    assert strains == [None, None] if pattern == CROSSOVER_FREE else strains[0] == pytest.approx(-strains[1], rel=1e-7)
    mohr = [heat([one], time, air, fidelity=fidelity).mohr for one in (device, other)]
    assert float((mohr[0] - mohr[1]).abs().max()) < 1e-7


@pytest.mark.parametrize("fidelity", FINE)
def test_warmed_from_inside_the_edge_has_the_other_sign_than_in_a_chamber(fidelity) -> None:
    """A coil that warms through its outer face; electronics inside its spool, as against electronics in the housing, which do as the chamber does."""
    time, air = chamber((20, 120, 3000), lag_s=0, step_s=5.0)
    housing, spool = (gyro(pattern="cylindrical", power_at_spool=share, **OUTSIDE_IN) for share in (0.0, 1.0))
    switched_on = (heat([device], time, torch.full_like(time, 20.0), cold_start=True, fidelity=fidelity) for device in (housing, spool))
    outside, inside, heated = *switched_on, heat([housing], time, air, fidelity=fidelity)
    for seen in (lambda found: (found.outer - found.inner)[0], lambda found: found.shupe[0]):
        first = [float(one[one[:240].abs().argmax()]) for one in (seen(found) for found in (outside, inside, heated))]
        assert first[0] * first[2] > 0
        assert first[1] * first[2] < 0


@pytest.mark.parametrize("fidelity", FINE)
def test_the_face_that_is_in_touch_decides_the_sign(fidelity) -> None:
    time, air = chamber((20, 20, 600), (20, 40, 1200), lag_s=0)
    signs = []
    for films in (OUTSIDE_IN, {"gap": 5.0, "contact": 300.0}):
        device = gyro(pattern="cylindrical", **films)
        edge = error(device, time, air, fidelity)
        signs.append(float(edge[edge.abs().argmax()]) * coil_weight(device))
    assert signs[0] > 0 > signs[1]


@pytest.mark.parametrize(("pattern", "peak"), [("cylindrical", 1.1), ("dipolar", 0.018), ("quadrupolar", 0.004)])
@pytest.mark.parametrize("fidelity", FINE)
def test_ideal_coils_in_a_package_have_the_peaks_of_published_ones(pattern, peak, fidelity) -> None:
    """Within a factor of two, at 1 K/min [°/h]."""
    device = gyro(pattern=pattern, winding_error_turns=0)
    assert peak / 2 < float(ramp([device], fidelity=fidelity).shupe.abs().max()) * abs(coil_weight(device)) < 2 * peak


def test_the_fidelities_agree_on_a_coil_that_is_held_by_its_spool() -> None:
    device = gyro()
    time, air = chamber(*UP)
    lumped, radial, both = (error(device, time, air, fidelity) for fidelity in FIDELITIES)
    assert float((radial - both).abs().max()) < 0.05 * float(both.abs().max())
    assert float(lumped.abs().max()) < 1e-9 * float(both.abs().max())


def test_a_coil_that_is_blind_to_radial_flow_sees_the_axial_one() -> None:
    """Two half coils that mirror each other, on a spool with one flange that holds better than the other."""
    time, air = chamber(*UP[:2])
    level, tilted = (gyro(pattern=CROSSOVER_FREE, winding_error_turns=0, top_contact=top) for top in (0, 2000))
    quadrupolar = error(gyro(winding_error_turns=0), time, air, "radial_axial")
    assert float(error(tilted, time, air, "radial").abs().max()) < 1e-9 * float(quadrupolar.abs().max())
    assert float(error(level, time, air, "radial_axial").abs().max()) < 1e-6 * float(quadrupolar.abs().max())
    assert float(error(tilted, time, air, "radial_axial").abs().max()) > float(quadrupolar.abs().max())


@pytest.mark.parametrize("size", [{"layers": 1}, {"turns": 1}, {"layers": 1, "turns": 1}, {"layers": 2, "turns": 2}])
def test_the_smallest_coils_conduct_as_well(size) -> None:
    """A single layer has no inside and no outside."""
    device = gyro(winding_error_turns=0, **size)
    for fidelity in FIDELITIES:
        found = ramp([device], minutes=300, fidelity=fidelity)
        assert found.coil_rate[0, -1].item() == pytest.approx(1.0, abs=1e-6)
        assert bool(found.shupe.isfinite().all())
        assert float(found.housing[0, -1]) > float(found.coil[0, -1])
    assert device.coil.layers > 1 or abs(coil_weight(device)) < 1e-12
    assert coil_weight(device) == pytest.approx(convert(shupe_weight(device.winding), "rad_per_s", "dph"))


@pytest.mark.parametrize("seed", range(6))
def test_mohrs_effect_of_a_balanced_winding_is_no_larger_than_the_rate(seed) -> None:
    """In a crossover-free coil only winding errors are left of the outermost layers' weights; dividing by them would blow the effect up."""
    time, air = chamber(*UP)
    device = draw(gyro_class("medium", pattern=CROSSOVER_FREE, top_contact=60), seed)
    found = heat([device], time, air, fidelity="radial_axial")
    assert float(found.mohr.abs().max()) < 1.5 * float(found.coil_rate.abs().max())


@pytest.mark.parametrize("fidelity", FIDELITIES)
def test_a_longer_lead_feels_how_much_faster_than_the_coil_it_warms(fidelity) -> None:
    """n·n_T·ℓ/D·(Ṫ_housing − Ṫ_coil), 0.47 °/h for 1 m on 100 mm and 1 K/min; nothing in a long ramp."""
    time, air = chamber((20, 20, 1200), (20, 320, 60000))
    plain, longer = gyro(diameter_m=0.1), gyro(diameter_m=0.1, lead_asymmetry_m=1.0)
    found = heat([plain], time, air, fidelity=fidelity)
    added = error(longer, time, air, fidelity) - error(plain, time, air, fidelity)
    assert added.tolist() == pytest.approx((0.47 * (found.housing_rate - found.coil_rate)[0]).tolist(), rel=0.01, abs=1e-5)
    assert float(added[-1].abs()) < 1e-6 * float(added.abs().max())
