"""Errors that are proportional to the true input: found where it changes, never where it does not."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import pytest
import torch
from torch import Tensor

from zoo.catalog import build, names
from zoo.diagnosis.diagnose import diagnose, open_bench
from zoo.diagnosis.preparation import reference_varies
from zoo.measurements.run import Run

OF_THE_INPUT = [name for name in names("effects") if build("effects", name).needs_varied_reference]
SIZES = {
    "scale_factor": (300.0, 20.0, 0.0),
    "scale_factor_nonlinearity": (0.0, -0.08, 0.0, 0.0),
    "misalignment": (0.05, 2e-3, 0.0),
    "dead_band": (40.0, 4.0, 0.1),
}
"""In ppm, ppm/K, …, with ppm/(°/h)² for the cubic: 800 ppm at 100 °/h; in °/h, °/h/K …; width, edge and depth, in °/h."""
RATE_DPH, TURN_S = 100.0, 1500.0


def turned(run: Run, rate: Tensor) -> Run:
    """The same error beside another true input (T,)."""
    table = run.table.clone()
    table[:, -1] = rate
    return replace(run, table=table)


def stepped(run: Run) -> Tensor:
    """(T,) seven rates, from one to the next every 25 min [°/h]."""
    places = torch.tensor([0.0, 1.0, -0.5, -1.0, 0.3, -0.7, 0.5], dtype=torch.float64)
    return RATE_DPH * places[((run.time - run.time[0]) / TURN_S).long() % len(places)]


def planted(run: Run, name: str) -> Run:
    """On a table that turns, with the effect at the temperature of the outer thermometer."""
    here = turned(run, stepped(run))
    sizes = torch.tensor(SIZES[name], dtype=torch.float64)
    theta, rate = here.select([run.thermometers[-1]]).squeeze(1) - 20.0, here.table[:, -1]
    columns = {
        "scale_factor": [rate, theta * rate, theta**2 * rate],
        "scale_factor_nonlinearity": [rate**2, rate**3, theta * rate**3, rate],
        "misalignment": [1e6 * rate.sign() * theta**power for power in range(3)],
        "dead_band": [0.0 * rate, 0.0 * rate, -1e6 * 4 * (rate / sizes[0]) / (3 + (rate / sizes[0]) ** 4)],
    }[name]
    return replace(here, error=here.error + 1e-6 * torch.stack(columns, dim=-1) @ sizes)


@pytest.mark.parametrize("rate", [0.0, 9.67])
def test_beside_a_constant_input_they_are_not_tried(runs, catalogue, base, rate) -> None:
    """Not a number of the verdict is another than without them in the catalogue."""
    found = [turned(run, torch.full_like(run.time, rate)) for run in runs()]
    record = diagnose(found, base, catalogue).record
    without = diagnose(found, base, {name: effect for name, effect in catalogue.items() if name not in OF_THE_INPUT}).record
    assert record["not_tried"] == {name: ["a reference that changes"] for name in OF_THE_INPUT}
    assert record | {"not_tried": {}} == without
    assert record["verdict"] == "complete"


@pytest.mark.parametrize("rate", [0.0, 9.67])
def test_in_the_model_they_do_no_harm_beside_a_constant_input(runs, catalogue, base, rate) -> None:
    found = [turned(run, torch.full_like(run.time, rate)) for run in runs()]
    record = json.loads(json.dumps(diagnose(found, [*base, *OF_THE_INPUT], catalogue).record, allow_nan=False))
    assert (record["verdict"], record["not_tried"]) == ("complete", {})
    if rate == 0:
        assert all(one["stderr"] is None for name in OF_THE_INPUT for one in record["parameters"][name].values())


def test_a_table_that_turns_is_no_fault(runs, catalogue, base) -> None:
    record = diagnose([turned(run, stepped(run)) for run in runs()], base, catalogue).record
    assert (record["verdict"], record["missing"], record["not_tried"]) == ("complete", [], {})


@pytest.mark.parametrize("name", OF_THE_INPUT)
def test_one_that_was_planted_is_named_with_its_numbers(runs, catalogue, base, name) -> None:
    record = diagnose([planted(run, name) for run in runs()], base, catalogue).record
    assert (record["verdict"], record["missing"]) == ("missing", [name])
    assert record["candidates"][0]["indistinguishable_from"] == []
    for entry, size in zip(record["parameters"][name].values(), SIZES[name], strict=True):
        assert abs(entry["value"] - size) < 4 * entry["stderr"]
        assert not size or entry["stderr"] < 0.1 * abs(size)


def curved(run: Run, line: float) -> Run:
    """With a cubic of the rate beside a share of the rate itself."""
    here = turned(run, stepped(run))
    rate = here.table[:, -1]
    return replace(here, error=here.error - 5e-8 * rate**3 + line * rate)


def test_a_cubic_beside_the_line_that_was_fitted_to_it_is_one_effect(runs, catalogue, base) -> None:
    """Over all runs, as it is where the scale factor comes from them; without it this would be a nonlinearity and a misalignment."""
    rate = torch.cat([stepped(run) for run in runs()])
    line = 5e-8 * float(rate.pow(4).sum() / rate.square().sum())
    record = diagnose([curved(run, line) for run in runs()], base, catalogue).record
    assert (record["verdict"], record["missing"]) == ("missing", ["scale_factor_nonlinearity"])
    found = record["parameters"]["scale_factor_nonlinearity"]
    for name, true in (("cubic", -0.05), ("line", 1e6 * line)):
        assert abs(found[name]["value"] - true) < 4 * found[name]["stderr"] < 0.4 * abs(true)


def test_a_line_by_itself_is_a_scale_factor_and_no_nonlinearity(runs, catalogue, base) -> None:
    found = [turned(run, stepped(run)) for run in runs()]
    record = diagnose([replace(run, error=run.error + 3e-4 * run.table[:, -1]) for run in found], base, catalogue).record
    assert (record["verdict"], record["missing"]) == ("missing", ["scale_factor"])
    (first,) = [one for one in record["candidates"] if one["effect"] == "scale_factor"]
    assert "scale_factor_nonlinearity" not in first["indistinguishable_from"]


def test_beside_a_scale_factor_the_line_is_its_own(runs, catalogue, base) -> None:
    both = ["scale_factor", "scale_factor_nonlinearity"]
    record = diagnose([curved(run, 3e-4) for run in runs()], [*base, *both], catalogue).record
    assert record["verdict"] == "complete"
    offset, line = record["parameters"]["scale_factor"]["offset"], record["parameters"]["scale_factor_nonlinearity"]["line"]
    assert abs(offset["value"] - 300.0) < 4 * offset["stderr"] < 200.0
    assert (line["value"], line["stderr"]) == (0.0, None)


def test_columns_alone_are_not_taken_for_those_beside_another(runs, catalogue, base) -> None:
    """Of one bench, which remembers columns for all of its models."""
    bench = open_bench([turned(run, stepped(run)) for run in runs()], base, catalogue)
    for effects, has_line in ((("scale_factor_nonlinearity",), True), (("scale_factor", "scale_factor_nonlinearity"), False)) * 2:
        design = bench.design(effects)
        assert bool(design.plain_columns(design.model.theta().unsqueeze(0))[..., -1].any()) is has_line


@pytest.mark.parametrize(("rates", "varies"), [((0, 0), False), ((9.67, 9.67), False), ((9.67, -9.67), True), ((0, 1), True), ((100, 100.5), False)])
def test_the_input_varies_or_not(runs, rates, varies) -> None:
    found = [turned(run, torch.full_like(run.time, rate)) for run, rate in zip(runs(), rates, strict=True)]
    assert reference_varies(found) == varies


def swept(run: Run, added: Callable[[Tensor], Tensor]) -> Run:
    """The same with a function of a rate that goes slowly to and fro [°/h]."""
    rate = 1.5 * torch.sin(2 * torch.pi * run.time / 9000.0)
    return replace(turned(run, rate), error=run.error + added(rate))


def test_a_dead_zone_with_hard_edges_is_a_dead_band(runs, catalogue, base, white) -> None:
    found = diagnose([swept(run, lambda rate: torch.where(rate.abs() < 0.5, -rate, 0.0)) for run in runs()], base, catalogue)
    assert (found.verdict, found.record["missing"]) == ("missing", ["dead_band"])
    assert found.search.final.rms < 1.1 * white


def test_what_goes_with_the_true_input_is_told_in_its_unit(runs, catalogue, base) -> None:
    without = {name: catalogue[name] for name in (*base, "polarization", "hysteresis", "rate_temperature_coupling", "chamber_cycling", "aging")}
    told = diagnose([swept(run, lambda rate: 0.1 * torch.sin(2.5 * rate)) for run in runs()], base, without).record["unexplained"][0]
    assert told["quantity"] == "the true input"
    assert "°/h" in told["words"]
    assert "unit" not in told["words"]
