"""The page that tells the truth about a simulated gyro: what it draws adds up to the truth, and what it says is what truth.json holds."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from zoo.catalog import build
from zoo.physics.winding import CROSSOVER_FREE, PATTERNS, Coil, Winding, balancing_trim, shupe_weight, wind
from zoo.report.truth.effect_figure import COLORS, colors_of
from zoo.report.truth.effect_stack import MOST, OTHERS, Parts, effects_of, grouped, means, parts_of, ranked, stacked
from zoo.report.truth.effect_trace import FINEST, trace_of
from zoo.report.truth.moments import Moment, moments, motions
from zoo.report.truth.page import render, write_truth_page
from zoo.report.truth.tables import device_rows, said
from zoo.report.truth.winding_heat import over_fibre, snapshots, temperatures
from zoo.report.truth.winding_numbers import axial_weight, excess_turns, layer_weights, radial_weight, summed_weight, trimmed
from zoo.report.wording import significant
from zoo.simulator.gyros.gyro_class import GyroClass
from zoo.simulator.gyros.presets import gyro_class
from zoo.simulator.laboratory.chamber import Chamber
from zoo.simulator.laboratory.profiles import legs
from zoo.simulator.laboratory.program import Program
from zoo.simulator.simulate import simulate
from zoo.simulator.simulation import Simulation

SECTIONS = ["summary", "winding", "heat", "runs", "effects", "device", "recording"]
SHORT: list[list[float]] = [[20, 20, 1800], [20, 50, 1800], [50, 50, 1800], [50, 20, 1800], [20, 20, 1800]]
MANY = ("static_bias", "shupe", "mohr", "hysteresis", "polarization", "aging", "magnetic", "supply_voltage", "rate_temperature_coupling")
Visible = Callable[[str], str]


def simulated(
    effects: tuple[str, ...] = MANY[:3],
    program: list[list[float]] = SHORT,
    gyro: str = "tactical",
    changes: dict[str, Any] | None = None,
    **settings: Any,
) -> Simulation:
    chosen = {name: build("effects", name) for name in effects}
    hidden = {name: build("effects", name) for name in MANY}
    return simulate(gyro_class(gyro, **(changes or {})), legs(program), chosen, catalogue=hidden, **settings)


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return simulated(hidden="hysteresis", thermometers=["spool", "air"], changes={"trimmed": 0.8})


@pytest.fixture(scope="module")
def page(simulation: Simulation) -> str:
    return render(simulation)


# The page


def test_every_section_is_there(page: str) -> None:
    assert re.findall(r'<section[^>]*id="(\w+)"', page) == SECTIONS


def test_nothing_is_fetched_and_every_drawing_has_a_text(page: str) -> None:
    assert not re.search(r"https?://|@import|<script|url\((?!#)", page)
    assert not re.search(r"(?:src|href)=\"(?!data:image/png;base64,|#)", page)
    drawings = re.findall(r"<svg[^>]*>", page)
    assert len(drawings) == 2 + 4
    assert all(re.search(r'role="img" aria-label="[^"]{10,}"', drawing) for drawing in drawings)
    assert not re.search(r'="[^"]*\bnan\b', page)


def test_identifiers_are_unique_and_references_hold(page: str) -> None:
    names = re.findall(r'\sid="([^"]+)"', page)
    assert len(names) == len(set(names))
    assert set(re.findall(r'(?:href="#|url\(#)([^")]+)', page)) <= set(names)


def test_numbers_are_those_of_the_truth(simulation: Simulation, page: str, visible: Visible) -> None:
    truth, text = simulation.truth(), visible(page)
    assert f"C_w {significant(truth['winding']['shupe_weight']['value'])} (°/h)/(K/min)" in text
    for parameters in truth["parameters"].values():
        for name, one in parameters.items():
            assert re.search(rf"\b{name} {re.escape(significant(one['value'], 4))} ", text), name
    for key in ("diameter_m", "package_s", "fibre_m"):
        assert significant(truth["device"][key]["value"], 4) in text
    for one in truth["thermometers"]:
        assert f"{one['place']} {significant(one['time_constant']['value'])} {significant(one['offset']['value'])}" in text


def test_the_table_of_runs_is_computed_from_the_columns(simulation: Simulation, page: str, visible: Visible) -> None:
    text, check = visible(page), simulation.check
    order = ranked([parts_of(run) for run in (*simulation.runs, check)])
    sizes = [significant(float(effects_of(check)[name].std())) for name in order]
    rest = [significant(float(one.std(correction=0))) for one in (check.truth["sum_dph"], check.noise, check.error)]
    assert " ".join(["check 2.50 20.0 … 50.0", *sizes, *rest]) in text


def test_hidden_effects_are_named_only_with_a_warning_and_a_tag(page: str, visible: Visible) -> None:
    text = visible(page)
    assert "Effects: static_bias, shupe and mohr; hidden: hysteresis." in text
    assert "gives away what a diagnosis is asked to find" in text
    assert text.count("hidden") == 2


def test_it_says_where_the_truth_is(tmp_path: Path, simulation: Simulation, visible: Visible) -> None:
    path = write_truth_page(simulation, tmp_path / "new")
    assert path == tmp_path / "new" / "truth.html"
    assert [one.name for one in path.parent.iterdir()] == ["truth.html"]
    text = visible(path.read_text(encoding="utf-8"))
    assert "truth.json holds the gyro's numbers, and truth_1.csv, truth_2.csv, truth_3.csv and truth_check.csv what each effect adds" in text


def test_every_parameter_of_the_device_has_its_unit_meaning_and_source(simulation: Simulation) -> None:
    rows = {key: row for row in device_rows(simulation.device) for key in (row[1],)}
    assert set(rows) == set(simulation.device.values)
    assert rows["diameter_m"][0] == "mean diameter of the winding"
    assert rows["diameter_m"][3:] == ["m", "0.0300 … 0.0600", "with these turns, coils of 70 to 150 m"]
    assert rows["trimmed"][4:] == ["the same in all", "given"]
    assert rows["conductivity"][2] == significant(simulation.device.conductivity, 4)
    assert all(row[0] and row[5] for row in rows.values())


def test_what_docstrings_say_is_read_from_them() -> None:
    assert said(GyroClass)["gap"] == "between the winding's outer face and the housing, through the air"
    assert said(Chamber)["cycling_k"] == "amplitude of the limit cycle of compressor or heater"


def test_a_shupe_effect_that_is_not_its_windings_is_said_so(visible: Visible) -> None:
    done = simulated(runs=1, parameters={"shupe": {"weight": 7.5}})
    assert "was set to 7.50 (°/h)/(K/min)" in visible(render(done))
    assert "was set to" not in visible(render(simulated(runs=1)))


@pytest.mark.parametrize(
    "more",
    [
        {"program": [[20, 20, 7200]]},
        {"program": [[-15, 50, 7200]], "effects": ()},
        {"program": [[20, 20, 600], [60, 60, 600]], "effects": ("static_bias",)},
        {"program": [[20, 40, 20]]},
        {"program": [[20, 20, 3600]], "cold_start": True},
        {"changes": {"pattern": CROSSOVER_FREE, "winding_error_turns": 0}, "chamber": Chamber(120.0, 0.05, 0.3, 300.0, "in_motion", 0.1)},
        {"changes": {"layers": 3, "turns": 200}, "thermometers": 5},
        {"changes": {"layers": 60, "turns": 1, "winding_error_turns": 0}, "sample_s": 600},
        {"effects": MANY, "gyro": "navigation", "heat": "lumped"},
    ],
)
def test_any_simulation_makes_a_page(more: dict[str, Any], visible: Visible) -> None:
    assert visible(render(simulated(**{"runs": 1, **more})))


def test_of_many_runs_some_are_drawn_and_all_are_listed(visible: Visible) -> None:
    text = visible(render(simulated(runs=12, program=[[20, 20, 600], [20, 40, 600]])))
    assert "Not drawn: run_8, run_9, run_10, run_11, run_12." in text
    assert "truth_1.csv … truth_check.csv" in text


def test_drawing_is_quick(simulation: Simulation) -> None:
    start = time.process_time()
    render(simulation)
    assert time.process_time() - start < 6.0  # some 2 s on a free core


# Moments


def test_legs_in_one_direction_are_one_motion_and_a_jump_is_one_too() -> None:
    found = motions(Program(((0, 0, 10), (0, 5, 10), (5, 8, 20), (8, 2, 5), (2, 2, 10), (9, 9, 10))))
    assert [(one.start_s, one.end_s, one.change_k) for one in found] == [(10, 40, 8), (40, 45, -6), (55, 55, 7)]


def test_moments_lie_around_the_first_ramp_and_in_the_first_one_back() -> None:
    found = moments(Program(((20, 20, 3600), (20, 60, 4800), (60, 60, 3600), (60, 0, 6000), (0, 0, 3600))))
    assert found == [
        Moment(3600, "before heating"),
        Moment(4200, "10 min after its start"),
        Moment(6000, "mid-heating"),
        Moment(9000, "10 min after its end"),
        Moment(12000, "end of the hold"),
        Moment(15000, "mid-cooling"),
    ]


@pytest.mark.parametrize(
    ("legs", "cold", "times"),
    [
        (((20, 20, 3600),), False, [0]),
        (((20, 20, 3600),), True, [0, 120, 300, 900, 2700]),
        (((50, 10, 400),), False, [0, 100, 200, 400]),
        (((20, 20, 3600), (60, 60, 7200), (20, 20, 1200)), False, [3600, 4200, 10800, 11100]),
    ],
)
def test_moments_of_other_programs(legs: Any, cold: bool, times: list[float]) -> None:
    found = moments(Program(legs), cold)
    assert [one.time_s for one in found] == times
    assert len({one.label for one in found}) == len(found)


# Heat


@pytest.mark.parametrize(
    ("more", "tolerance_k"),
    [
        ({}, 1e-6),
        ({"heat": "radial"}, 0.05),
        # Here what jumps at the first row takes a step or two; the coil is a thousand times slower.
        ({"chamber": Chamber(120.0, 0.05, 0.3, 300.0)}, 2e-3),
        ({"cold_start": True}, 2e-3),
    ],
)
def test_the_mean_of_the_field_is_the_coils_temperature_in_the_run(more: dict[str, Any], tolerance_k: float) -> None:
    done = simulated(**{"runs": 1, "heat": "radial_axial", **more})
    samples = [0, 3, 90, 185, 300, 500, 900]
    found = temperatures(done, samples)
    assert found.shape == (len(samples), done.device.gyro.layers, done.device.gyro.turns)
    assert torch.allclose(over_fibre(done, found), done.runs[0].truth["temperature_coil_c"][samples], rtol=0, atol=tolerance_k)


def test_snapshots_are_of_rows_and_none_of_them_twice() -> None:
    done = simulated(runs=1, program=[[20, 20, 600], [20, 30, 600], [30, 30, 600]], sample_s=300)
    shown = snapshots(done)
    assert [one.time_s for one in shown.moments] == [600, 900, 1200, 1800]
    assert len(shown.field_c) == len(shown.mean_c) == 4


# Effects


def test_areas_add_up_to_the_sum_of_the_truth(simulation: Simulation) -> None:
    run = simulation.runs[1]
    parts = parts_of(run)
    areas = stacked(grouped(parts.change, ranked([parts])))
    tops, bottoms = ([pair[place][1] for pair in areas.values()][-1] for place in (0, 1))
    whole = tops + bottoms + sum(parts.constant.values())
    assert np.allclose(whole, run.truth["sum_dph"].numpy(), atol=1e-12)
    assert all((outer >= inner).all() for (inner, outer), _ in areas.values())
    assert all((outer <= inner).all() for _, (inner, outer) in areas.values())


def test_change_begins_at_rest(simulation: Simulation) -> None:
    run = simulation.runs[0]
    first, last = parts_of(run), parts_of(run, cold_start=True)
    assert all(values[0] == 0 for values in first.change.values())
    assert all(values[-1] == 0 for values in last.change.values())
    assert first.constant["hysteresis"] == float(run.truth["hysteresis_dph"][0])


def test_more_effects_than_colours_are_summed_and_nothing_is_lost() -> None:
    run = simulated(MANY, runs=1).runs[0]
    parts = parts_of(run)
    order = ranked([parts])
    together = grouped(parts.change, order)
    assert [*together] == [*order[: MOST - 1], OTHERS]
    assert np.allclose(sum(together.values()), sum(parts.change.values()))
    colors = colors_of(order)
    assert set(colors) == set(together)
    assert len(set(colors.values())) == len(colors)
    assert len(COLORS) == MOST


def test_effects_are_ranked_by_how_much_they_change() -> None:
    wave = np.sin(np.arange(100))
    assert ranked([Parts({}, {"a": wave, "b": 3 * wave}), Parts({}, {"a": wave, "c": 2 * wave})]) == ["b", "c", "a"]


def test_a_long_run_is_drawn_in_means() -> None:
    values = np.arange(10 * FINEST + 3, dtype=float)
    found = means(values, FINEST)
    assert len(found) <= FINEST
    assert found[:2].tolist() == [5.0, 16.0]
    assert means(values[:5], FINEST).tolist() == values[:5].tolist()


def test_a_trace_shows_the_thermometers_against_the_coil(simulation: Simulation) -> None:
    run, parts = simulation.runs[0], parts_of(simulation.runs[0])
    trace = trace_of(run, parts, ranked([parts]), simulation.settings.places)
    assert list(trace.thermometers_k) == ["spool", "air"]
    offset = run.table["temperature_c"].mean() - run.truth["temperature_coil_c"].mean()
    assert float(trace.thermometers_k["spool"].mean()) == pytest.approx(float(offset), abs=0.05)
    assert float(trace.total.mean()) == pytest.approx(float(run.truth["sum_dph"].mean()) - sum(parts.constant.values()), rel=0.02)


# The winding


def coil(pattern: str = "quadrupolar") -> Coil:
    return Coil(16, 20, 0.08, 0.0002, 0.00025, pattern)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_layers_add_up_to_the_coils_weight(pattern: str) -> None:
    winding = wind(coil(pattern))
    assert float(summed_weight(winding)[-1]) == pytest.approx(np.degrees(shupe_weight(winding)) * 3600, abs=1e-9)
    assert radial_weight(winding) == pytest.approx(float(summed_weight(winding)[-1]), abs=1e-9)
    assert float(layer_weights(winding).sum()) == pytest.approx(float(torch.rad2deg(winding.weights()).sum()) * 60, abs=1e-9)
    assert np.nanmax(np.abs(excess_turns(winding))) < 1e-12


def test_each_supply_has_the_layers_that_it_laid() -> None:
    quadrupolar, double = (layer_weights(wind(coil(pattern))) for pattern in ("quadrupolar", CROSSOVER_FREE))
    laid_by_a = np.array([True, False, False, True] * 4)
    assert ((quadrupolar[:, 0] != 0) == laid_by_a).all()
    assert ((quadrupolar[:, 1] != 0) == ~laid_by_a).all()
    assert (double[:, 0] > 0).all()
    assert (double[:, 1] < 0).all()


def test_a_crossover_free_coil_feels_heat_along_its_axis() -> None:
    assert abs(axial_weight(wind(coil(CROSSOVER_FREE)))) > 100 * abs(axial_weight(wind(coil())))


def test_winding_errors_and_trimming_are_found_again() -> None:
    errors = torch.randn(16, 2, generator=torch.Generator().manual_seed(3), dtype=torch.float64)
    exact: Winding = wind(coil(), errors)
    found = excess_turns(exact)
    laid = ~np.isnan(found)
    assert (laid.sum(1) == 1).all()
    assert found[laid] == pytest.approx(errors.numpy()[laid])
    assert trimmed(exact)[0] == 0
    length = balancing_trim(coil(), errors, 0.9)
    cut, end = trimmed(wind(coil(), errors, length))
    assert cut == pytest.approx(abs(length))
    assert end == ("A" if length > 0 else "B")
