"""The page says everything, to everyone, without help from outside, and shows nothing that is no number."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from zoo.report.page import render, write_report
from zoo.report.trace import Trace, rms

FLOOR = 0.0081
SECTIONS = ("verdict", "ladder", "runs", "steadiness", "where", "candidates", "read", "effects")
Record = dict[str, Any]
Visible = Callable[[str], str]


@pytest.fixture(scope="module")
def page(pristine: Record, traces: list[Trace]) -> str:
    return render(pristine, traces, None, ["fogzoo refine add=hysteresis"])


def test_every_section_is_there(page: str) -> None:
    assert [section for section in re.findall(r'<section[^>]*id="(\w+)"', page) if section in SECTIONS] == list(SECTIONS)


def test_the_banner_says_what_is_missing_and_how_sure_that_is(page: str, visible: Visible) -> None:
    text = visible(page)
    assert "Missing: hysteresis (98 %)" in text
    assert "now 0.0710 °/h 8.8× noise floor RMS with hysteresis 0.0083 °/h 1.0× noise floor Noise floor 0.0081 °/h" in text
    assert "fogzoo refine add=hysteresis" in text


def test_every_drawing_has_a_text_for_those_who_do_not_see_it(page: str) -> None:
    drawings = re.findall(r"<svg[^>]*>", page)
    assert len(drawings) == 1 + 3 * 4 + 1
    assert all('role="img"' in drawing and re.search(r'aria-label="[^"]{10,}"', drawing) for drawing in drawings)


def test_candidates_show_their_evidence(page: str, visible: Visible) -> None:
    text = visible(page)
    for part in ("probability 98 % RMS with it 0.0083 cross-validated 0.0085 ΔBIC −412", "cannot be told from sensor_lag", "6.10 ± 0.40 K"):
        assert part in text
    for part in ("0.0497 °/h", "1 with a probability below 1 %", "°/h/K", "moisture (humidity_pct)"):
        assert part in text


def test_worst_regions_come_with_units(page: str, visible: Visible) -> None:
    assert "1 run_2 hold 0.00 1.00 20.0 0.0900 11.2× 2 run_1 heating 0.00 1.00 20.0 … 60.0 0.0300 4.0×" in visible(page)


def test_nothing_is_fetched(page: str) -> None:
    assert "http://" not in page
    assert "https://" not in page
    assert not re.search(r"(?:src|href)=\"(?!data:image/png;base64,|#)", page)
    assert "@import" not in page
    assert not re.search(r"url\((?!#)", page)


def test_identifiers_are_unique(page: str) -> None:
    names = re.findall(r'\sid="([^"]+)"', page)
    assert len(names) == len(set(names))


def test_references_between_elements_hold(page: str) -> None:
    names = set(re.findall(r'\sid="([^"]+)"', page))
    assert set(re.findall(r'(?:href="#|url\(#)([^")]+)', page)) <= names


def test_hostile_names_are_only_text(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    evil = '<script>alert("1")</script> & $x^2$ {{ 7 * 7 }}'
    diagnosis.update(runs=[evil], notes=[evil], effects=[evil], missing=[evil], not_tried={evil: [evil]}, undetermined=[evil])
    diagnosis["posterior"] = [{"hypothesis": "missing", "effects": [evil], "probability": 0.5}]
    diagnosis["next_experiment"] = {"separates": [evil], "why": evil, "name": evil, "command": evil, "alternatives": [{"name": evil}]}
    diagnosis["candidates"][0].update(effect=evil, formula=evil, indistinguishable_from=[evil], parameters={evil: {"value": 1.0, "unit": evil}})
    diagnosis["where"][0].update(run=evil)
    page = render(diagnosis, [replace(traces[0], run=evil)], None, [evil])
    assert page.count("<script>") == 1
    assert evil in visible(page)


def test_the_page_is_small_enough_for_four_long_runs(diagnosis: Record, traces: list[Trace]) -> None:
    long = [_repeated(trace, 1300) for trace in traces]
    assert len(render(diagnosis, long).encode()) < 1_500_000


def test_very_long_and_very_many_runs_stay_readable(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    many = [replace(_repeated(traces[i % 4], 20_000), run=f"run_{i}") for i in range(12)]
    page = render(diagnosis, many)
    assert len(page.encode()) < 4_000_000
    assert "Not drawn" in visible(page)


def _repeated(trace: Trace, blocks: int) -> Trace:
    again = {name: np.resize(getattr(trace, name), blocks) for name in ("temperature_c", "rate_k_per_min", "error", "model", "refined")}
    return replace(trace, time_s=100.0 * np.arange(blocks), stage=[trace.stage[i % len(trace.stage)] for i in range(blocks)], **again)


def test_drawing_is_quick(diagnosis: Record, traces: list[Trace]) -> None:
    render(diagnosis, traces[:1])
    start = time.process_time()
    render(diagnosis, traces)
    assert time.process_time() - start < 5.0  # 1 s on two free cores; twice the promise, for those that are not


def test_a_complete_model(diagnosis: Record, bare_traces: list[Trace], visible: Visible) -> None:
    diagnosis.update(verdict="complete", missing=[], rms=0.0082, where=[])
    text = visible(render(diagnosis, bare_traces))
    assert "The model is complete" in text
    assert "RMS with" not in text.split("Candidates")[0]


def test_an_unknown_cause(diagnosis: Record, bare_traces: list[Trace], visible: Visible) -> None:
    diagnosis.update(verdict="unknown", rms_final=0.03, unexplained=[{"depends_on": "time since the start", "explains": 0.42}])
    text = visible(render(diagnosis, bare_traces[:1]))
    assert "Unknown: nothing in the catalogue explains this" in text
    assert "Adding hysteresis (98 %) helps, but what is left is still 3.7× the noise floor." in text
    assert "A free smooth function of time since the start would explain 42 % of the residual." in text


def test_effects_that_cannot_be_told_apart(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    diagnosis["candidates"][0]["indistinguishable_from"] = ["polarization", "mine"]
    text = visible(render(diagnosis, traces[:1]))
    assert "Missing: hysteresis, polarization or mine (98 %)" in text
    assert "These runs cannot tell hysteresis from polarization or mine" in text


def test_a_refinement_shows_its_ladder_on_both_kinds_of_runs(diagnosis: Record, traces: list[Trace], refinement: Record, visible: Visible) -> None:
    text = visible(render(diagnosis, traces[:1], refinement))
    assert "The model is complete with hysteresis added" in text
    assert "as it stands 0.0710 8.8× 0.0740 8.8× + hysteresis 0.0083 1.0× 0.0088 1.0×" in text


def test_a_refinement_tells_before_from_after(diagnosis: Record, traces: list[Trace], refinement: Record, visible: Visible) -> None:
    text = visible(render(diagnosis, traces, refinement))
    assert "RMS before 0.0710 °/h 8.8× noise floor RMS after, with hysteresis 0.0083 °/h 1.0× noise floor" in text
    assert "hysteresis added probability" in text
    for word in ("to add", "missing effects", "as it stands leaves", "residual now"):
        assert word not in text, word
    assert text.count("Residual before [°/h]") == 2 * len(traces)  # two scatters a run, each with both residuals
    assert "Residual now [°/h]" in visible(render(diagnosis, traces))


def test_nothing_was_before_where_nothing_was_added(diagnosis: Record, bare_traces: list[Trace], refinement: Record, visible: Visible) -> None:
    refinement.update(ladder=refinement["ladder"][:1], verdict="unknown")
    diagnosis.update(verdict="unknown", missing=[], unexplained=[{"depends_on": "time", "explains": 0.4}])
    text = visible(render(diagnosis, bare_traces[:1], refinement))
    assert "RMS of the residual now 0.0710" in text
    assert "before" not in text
    assert "would explain 40 % of the residual." in text


def test_what_was_unexplained_before_is_said_so(diagnosis: Record, traces: list[Trace], refinement: Record, visible: Visible) -> None:
    diagnosis.update(unexplained=[{"depends_on": "time", "explains": 0.4}])
    text = visible(render(diagnosis, traces[:1], refinement))
    assert "What was unexplained A free smooth function of time would have explained 40 % of the residual before." in text


def test_one_residual_needs_no_name(diagnosis: Record, bare_traces: list[Trace], visible: Visible) -> None:
    text = visible(render(diagnosis, bare_traces[:1]))
    assert "Residual now" not in text
    assert text.count("Residual [°/h]") == 3


def test_check_runs_are_held_against_their_own_noise(diagnosis: Record, traces: list[Trace], refinement: Record, visible: Visible) -> None:
    refinement.update(noise_floor_check=2 * refinement["noise_floor"])
    text = visible(render(diagnosis, traces[2:], refinement))
    fit, check = (rms(trace.residual_after) for trace in traces[2:])
    assert f"after {fit:.4f} °/h, {fit / FLOOR:.1f}× noise floor" in text
    assert f"after {check:.4f} °/h, {check / FLOOR / 2:.1f}× noise floor" in text
    assert "RMS on check runs 0.0088 °/h 0.5× noise floor; before 0.0740" in text
    assert "+ hysteresis 0.0083 1.0× 0.0088 0.5×" in text


def test_pieces_of_a_fitted_run_are_called_so(diagnosis: Record, traces: list[Trace], refinement: Record, visible: Visible) -> None:
    refinement.update(check_runs=["run_1 (held out)"])
    text = visible(render(diagnosis, [traces[0], replace(traces[3], run="run_1 (held out)")], refinement))
    assert "RMS on held-out pieces" in text
    assert "run_1 (held out) held out" in text
    assert "check run, not fitted" not in text


def test_two_are_both(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    diagnosis["missing"] = ["hysteresis", "aging"]
    assert "RMS with both added" in visible(render(diagnosis, traces[:1]))


def test_parameters_are_in_the_scale_of_the_tables(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    slope = {"value": 1.2e-6, "stderr": 1e-7, "unit": "rad_per_s/K^2"}
    diagnosis.update(unit="rad_per_s", rms=3.4e-7, noise_floor=3.9e-8, parameters={"static_bias": {"c2": slope, "T0": {"value": 20.0, "unit": "K"}}})
    text = visible(render(diagnosis, traces[:1]))
    assert "c2 1200 ± 100 nrad/s/K²" in text
    assert "T0 20.0 K" in text


def test_equal_notes_are_said_once(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    diagnosis["notes"] = ["1 block is thin", "run_1: 2 gaps", "1 block is thin", "run_3: 2 gaps", "odd: this"]
    assert "Notes 1 block is thin (2 times) run_1 and run_3: 2 gaps odd: this" in visible(render(diagnosis, traces[:1]))


def test_edges_are_explained_once(page: str, visible: Visible) -> None:
    assert visible(page).count("edge: within five minutes") == 1


@pytest.mark.parametrize(("before", "kind"), [(0.02, "linear"), (0.5, "logarithmic")])
def test_the_ladder_says_what_its_axis_is(diagnosis: Record, traces: list[Trace], before: float, kind: str, visible: Visible) -> None:
    diagnosis["rms"] = before
    assert f"RMS [°/h], {kind} axis" in visible(render(diagnosis, traces[:1]))


def test_a_step_of_two_effects_is_written_in_full(diagnosis: Record, traces: list[Trace]) -> None:
    diagnosis["missing"] = ["aging", "hysteresis", "polarization"]
    drawing = re.search(r'<section id="ladder">.*?</svg>', render(diagnosis, traces[:1]), re.DOTALL)
    assert drawing is not None
    assert "+ hysteresis and" in drawing[0]
    assert ">polarization<" in drawing[0]


def test_a_refinement_without_a_diagnosis(traces: list[Trace], refinement: Record, visible: Visible) -> None:
    text = visible(render({}, traces[:1], refinement))
    assert "The model is complete with hysteresis added" in text
    assert "No candidate was tried." in text


def test_the_next_experiment(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    profile = {"legs": [[20, 20, 3600], [20, 60, 1200]], "name": "legs"}
    diagnosis["next_experiment"] = {"separates": ["mohr", "sensor_lag"], "why": "a fast ramp", "profile": profile}
    page = render(diagnosis, traces[:1])
    assert 'id="experiment"' in page
    assert "Separates mohr and sensor_lag. a fast ramp" in visible(page)
    assert "Chamber program of 2 legs" in page


def test_the_next_experiment_with_what_it_would_show(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    curves = {"compared": ["mohr", "aging"], "time_s": [0.0, 600.0], "temperature_c": [20.0, 30.0], "reference": [0.0, 0.0], "difference": [0.0, 0.1]}
    found = {"separates": ["mohr", "aging"], "name": "a cycle", "input": "power_on", "command": "fogzoo simulate hidden=mohr", "prediction": curves}
    diagnosis["next_experiment"] = {**found, "profile": {"legs": [[20, 30, 600]]}, "alternatives": [{"name": "a rest"}]}
    page = render(diagnosis, traces[:1])
    text = visible(page)
    assert "Output if it is mohr, less aging refitted [°/h]" in text
    assert "Needs besides a chamber a soak without power before it Alternative 1 a rest" in text
    assert 'data-copy="fogzoo simulate hidden=mohr"' in page
    assert "Chamber program of" not in page


def test_how_probable_each_hypothesis_is(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    sets = [("missing", ["hysteresis"], 0.83), ("complete", [], 0.12), ("unknown", [], 0.03), ("missing", ["aging", "hysteresis"], 0.003)]
    diagnosis["posterior"] = [{"hypothesis": kind, "effects": names, "probability": chance} for kind, names, chance in sets]
    page = render(diagnosis, traces[:1])
    assert "hysteresis verdict probability 83 % nothing probability 12 % something unknown probability 3 % All others together: 2 %." in visible(page)
    diagnosis["posterior"][1] = {"hypothesis": "faint", "effects": ["hysteresis"], "probability": 0.12}
    assert "hysteresis and one too small for these runs probability 12 %" in visible(render(diagnosis, traces[:1]))
    assert '<i style="--p: 83.0%"></i>' in page
    assert 'id="probable"' not in render({**diagnosis, "posterior": None}, traces[:1])


def test_what_the_runs_would_show(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    floor = diagnosis["noise_floor"]
    diagnosis["detection_limits"] = {
        "moisture": {"size": 10 * floor, "hidden": 0.7},
        "thermal_gradient": {"size": None, "hidden": 1.0},
        "magnetic": {"size": floor, "hidden": 0.3},
    }
    page = render(diagnosis, traces[:1])
    text = visible(page).split("What these runs would show")[1]
    assert text.index("magnetic") < text.index("moisture") < text.index("thermal_gradient in no size")
    assert "1.0× floor" in text.split("moisture")[0]
    assert [width for width in ("33.3%", "66.7%", "100%") if f'<i style="--p: {width}"></i>' in page] == ["33.3%", "66.7%", "100%"]
    assert 'id="limits"' not in render({**diagnosis, "detection_limits": None}, traces[:1])


def test_samples_and_noise(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    diagnosis.update(effective_samples=412.4, noise={"white": 0.0079, "flicker": 0.0021, "walk": 0.0})
    text = visible(render(diagnosis, traces[:1]))
    assert "Blocks 1296, worth 412 independent ones Noise white 0.0079 °/h, flicker B 0.0021 °/h" in text
    assert "random walk K" not in text.split("What was read")[1]


@pytest.mark.parametrize("keys", ["all", "some"])
def test_any_field_may_be_null(diagnosis: Record, bare_traces: list[Trace], keys: str, visible: Visible) -> None:
    empty: Record = dict.fromkeys(diagnosis)
    if keys == "some":
        hollow = [dict.fromkeys(entry) for entry in diagnosis["candidates"]]
        empty.update(candidates=hollow, where=[dict.fromkeys(diagnosis["where"][0])], verdict="missing", missing=["hysteresis"], effects=[])
    assert visible(render(empty, bare_traces[:1]))
    assert visible(render(empty, []))


def test_numbers_that_are_none_are_dashes(diagnosis: Record, traces: list[Trace], visible: Visible) -> None:
    diagnosis["candidates"][0].update(rms=float("nan"), delta_bic=float("inf"))
    broken = replace(traces[0], error=np.full_like(traces[0].error, np.nan))
    assert "–" in visible(render(diagnosis, [broken, traces[1]]))


@pytest.mark.parametrize("blocks", [0, 1, 2])
def test_hardly_any_blocks(diagnosis: Record, traces: list[Trace], blocks: int, visible: Visible) -> None:
    assert traces[0].run in visible(render(diagnosis, [_repeated(traces[0], blocks)]))


def test_very_long_names(diagnosis: Record, traces: list[Trace], refinement: Record, visible: Visible) -> None:
    name = "a_very_long_effect_name_" * 6
    refinement["ladder"][1]["added"] = name
    diagnosis["where"][0]["run"] = name
    page = render(diagnosis, [replace(traces[0], run=name)], refinement)
    assert name in visible(page)
    assert "a_very_long_effect_name_a…" in visible(page)


@pytest.mark.parametrize(("unit", "factor", "shown"), [("rad_per_s", 4.848e-6, "nrad/s"), ("ug", 500.0, "µg"), ("furlongs", 1.0, "furlongs")])
def test_other_units(diagnosis: Record, traces: list[Trace], unit: str, factor: float, shown: str, visible: Visible) -> None:
    diagnosis.update(unit=unit, rms=0.071 * factor, noise_floor=0.0081 * factor)
    scaled = [replace(trace, error=trace.error * factor, model=trace.model * factor, refined=None) for trace in traces[:1]]
    assert shown in visible(render(diagnosis, scaled))


def test_the_file_is_written_whole(tmp_path: Path, diagnosis: Record, traces: list[Trace]) -> None:
    target = tmp_path / "new" / "report.html"
    write_report(target, diagnosis, traces[:1])
    assert target.read_text(encoding="utf-8").rstrip().endswith("</html>")
    assert [path.name for path in target.parent.iterdir()] == ["report.html"]


def test_matplotlib_is_left_as_it_was(diagnosis: Record, traces: list[Trace]) -> None:
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    render(diagnosis, traces[:1])
    assert dict(mpl.rcParams) == before


def test_effects_that_lower_nothing_are_said_to(diagnosis: Record, traces: list[Trace], refinement: Record, visible: Visible) -> None:
    before = refinement["ladder"][0]["rms"]
    sentence = "The RMS of the fitted runs is no lower with hysteresis than without"
    assert sentence not in visible(render(diagnosis, traces[:1], refinement))
    for verdict, after, more in (
        ("complete", before, "."),
        ("complete", 1.1 * before, "; a fit counts slow noise for less"),
        ("unknown", before, "."),
    ):
        refinement["ladder"][-1]["rms"] = after
        refinement["verdict"] = verdict
        assert f"{sentence}{more}" in visible(render(diagnosis, traces[:1], refinement))
