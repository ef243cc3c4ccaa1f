"""What a diagnosis is made of: the contract's JSON, where it fails, what was not tried, notes."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest
import torch

from zoo.diagnosis.diagnose import diagnose
from zoo.diagnosis.regions import regions
from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.simulator.noise import SILENT

KEYS = {
    "schema_version", "effects", "unit", "average_s", "runs", "samples", "noise_floor", "rms", "verdict", "missing", "candidates", "where",
    "next_experiment",
}  # fmt: skip
CANDIDATE_KEYS = {"effect", "probability", "rms", "rms_cross_validated", "delta_bic", "indistinguishable_from", "parameters"}
WHERE_KEYS = {"run", "start_s", "from_s", "to_s", "stage", "temperature_c", "rms", "excess"}


@pytest.fixture(params=["", "bias_step"], ids=["complete", "missing"])
def record(request, diagnosis) -> dict[str, Any]:
    return diagnosis(request.param).record


def strictly(record: dict[str, Any]) -> dict[str, Any]:
    """Through JSON and back, as any other language reads it."""
    return json.loads(json.dumps(record, allow_nan=False), parse_constant=lambda name: pytest.fail(f"{name} in the JSON"))


def without_inputs(run: Run, *names: str) -> Run:
    keep = [name for name in run.columns if name not in names]
    return replace(run, columns=tuple(keep), table=run.select(keep))


def test_it_is_strict_json_with_every_key_of_the_contract(record) -> None:
    assert strictly(record) == record
    assert set(record) >= KEYS
    assert all(set(one) >= CANDIDATE_KEYS for one in record["candidates"])
    assert all(set(one) >= WHERE_KEYS for one in record["where"])
    assert record["schema_version"] == 1
    assert record["effects"] == ["static_bias", "shupe", "mohr"]
    assert (record["unit"], record["average_s"], record["runs"]) == ("dph", 100.0, ["run_1", "run_2"])
    assert record["verdict"] in {"complete", "missing", "unknown"}
    assert (record["verdict"] == "complete") == (record["missing"] == [])


def test_candidates_are_all_that_could_be_tried_best_first(record, catalogue, base) -> None:
    tried = [one["effect"] for one in record["candidates"]]
    assert sorted(tried) == sorted(set(catalogue) - set(base) - set(record["not_tried"]))
    assert set(record["missing"]) <= set(tried)
    assert tried[: len(record["missing"])] == record["missing"]
    rest = [one["probability"] for one in record["candidates"][len(record["missing"]) :]]
    assert rest == sorted(rest, reverse=True)
    for one in record["candidates"]:
        assert 0 <= one["probability"] <= 1
        assert set(one["indistinguishable_from"]) <= set(catalogue) - {one["effect"]}
        assert one["rms"] <= record["rms"] * 1.01, "one more effect never fits worse, but for the weights of the fit"


def test_parameters_have_value_error_bar_and_unit(record, catalogue) -> None:
    for one in record["candidates"]:
        declared = {p.name: p for p in (*catalogue[one["effect"]].shape, *catalogue[one["effect"]].amplitudes)}
        assert set(one["parameters"]) == set(declared)
        for name, entry in one["parameters"].items():
            assert math.isfinite(entry["value"])
            assert entry["stderr"] is None or entry["stderr"] >= 0
            assert entry["unit"] == declared[name].unit.replace("unit", "dph")
    assert set(record["parameters"]) == {"coil", *record["effects"], *record["missing"]}


def test_a_named_effects_parameters_are_those_planted(diagnosis, simulation) -> None:
    found = diagnosis("bias_step").record["candidates"][0]["parameters"]
    planted = simulation("bias_step").shares["bias_step"].parameters()
    assert found["run"]["value"] == planted["run"][0]
    assert found["onset"]["value"] == pytest.approx(planted["onset"][0], abs=100 / 3600)
    assert abs(found["step"]["value"] - planted["step"][0]) < 4 * found["step"]["stderr"]
    assert found["step"]["stderr"] < 0.2 * abs(planted["step"][0])


# Where


def test_where_is_sorted_and_within_the_runs(record, runs) -> None:
    sizes = [one["rms"] for one in record["where"]]
    assert sizes == sorted(sizes, reverse=True)
    spans = {run.name: run.span_s for run in runs()}
    for one in record["where"]:
        low, high = spans[one["run"]]
        assert low - 1e-3 <= one["from_s"] < one["to_s"] <= high + 1e-3
        assert one["start_s"] == pytest.approx(low, abs=1e-3)
        assert one["stage"] in {"hold", "heating", "cooling", "edge"}
        assert one["temperature_c"][0] <= one["temperature_c"][1]
        assert one["excess"] == pytest.approx(one["rms"] / record["noise_floor"])
    assert record["noise_floor_by_run"] == dict.fromkeys(record["runs"], record["noise_floor"]), "which are equally noisy"


def test_where_covers_every_block_once(diagnosis, monkeypatch) -> None:
    monkeypatch.setattr("zoo.diagnosis.regions.SHOWN", 1000)
    found = diagnosis("bias_step")
    runs, residual = found.bench.runs, found.search.base.residual
    stages = regions(runs, residual, {run.name: 1.0 for run in runs})
    for run, part in zip(runs, residual.split([one.blocks for one in runs]), strict=True):
        own = sorted((one for one in stages if one["run"] == run.name), key=lambda one: one["from_s"])
        times = run.block_mean(run.time)
        counts = [int(((times > one["from_s"]) & (times < one["to_s"])).sum()) for one in own]
        assert sum(counts) == run.blocks
        assert all(before["to_s"] <= after["from_s"] + 1e-6 for before, after in pairwise(own))
        energy = sum(count * one["rms"] ** 2 for count, one in zip(counts, own, strict=True))
        assert energy == pytest.approx(float(part.square().sum()))


def test_the_worst_place_is_where_the_fault_is(diagnosis, simulation) -> None:
    """A step in one run: that run is worse than the other."""
    record, planted = diagnosis("bias_step").record, simulation("bias_step").shares["bias_step"].parameters()["run"][0]
    if planted:
        assert record["rms_by_run"][f"run_{planted:.0f}"] == max(record["rms_by_run"].values())
    squares = [record["rms_by_run"][run.name] ** 2 * run.blocks for run in diagnosis("bias_step").bench.runs]
    assert sum(squares) / record["samples"] == pytest.approx(record["rms"] ** 2)


# What was not tried, notes, chance


def test_effects_whose_columns_are_absent_are_listed(runs, catalogue, base) -> None:
    record = diagnose([without_inputs(run, "supply_v", "field_ut") for run in runs()], base, catalogue).record
    lacking = {name: list(effect.needs) for name, effect in catalogue.items() if set(effect.needs) & {"supply_v", "field_ut"}}
    assert lacking.items() <= record["not_tried"].items()
    assert not set(record["not_tried"]) & {one["effect"] for one in record["candidates"]}
    assert record["verdict"] == "complete"


def test_a_spike_is_left_out_and_noted(runs, white, catalogue, base) -> None:
    first, second = runs()
    error = second.error.clone()
    error[second.block == 120] += 60 * white
    record = diagnose([first, replace(second, error=error)], base, catalogue).record
    note = next(one for one in record["notes"] if one.startswith("run_2"))
    assert "1 block(s)" in note
    assert f"{float(second.block_mean(second.time)[120]):g}" in note
    assert record["samples"] == first.blocks + second.blocks - 1
    assert record["verdict"] == "complete"


def test_the_same_input_gives_the_same_diagnosis(diagnosis, runs, catalogue, base) -> None:
    again = diagnose(runs("bias_step"), base, catalogue).record
    assert json.dumps(again) == json.dumps(diagnosis("bias_step").record)


def test_it_works_on_one_thread(runs, catalogue, base) -> None:
    """On a busy machine two take up to twenty times as long, waiting for each other between small tensors."""
    before, threads = torch.get_num_threads(), set[int]()
    torch.set_num_threads(2)
    try:
        diagnose(runs(), base, {name: catalogue[name] for name in base}, lambda _: threads.add(torch.get_num_threads()))
        assert (threads, torch.get_num_threads()) == ({1}, 2)
    finally:
        torch.set_num_threads(before)


def test_the_input_is_left_as_it_was(runs, catalogue, base) -> None:
    given = runs()
    before = [(run.table.clone(), run.error.clone(), run.block.clone()) for run in given]
    shapes = {name: effect.shape_value.clone() for name, effect in catalogue.items()}
    diagnose(given, base, catalogue)
    for run, (table, error, block) in zip(given, before, strict=True):
        assert torch.equal(run.table, table)
        assert torch.equal(run.error, error)
        assert torch.equal(run.block, block)
    assert all(torch.equal(effect.shape_value, shapes[name]) for name, effect in catalogue.items())


def test_noiseless_data_make_finite_numbers(runs, catalogue, base) -> None:
    record = diagnose(runs("", 1, noise=SILENT), base, catalogue).record
    strictly(record)
    assert record["noise_floor"] > 0
    assert record["rms"] < 0.05 * record["rms_uncompensated"], "a simulated gyro's effects are the model's, to a few per cent"


# Refused


def flat(run: Run, swing: float) -> Run:
    table = run.table.clone()
    for name in run.thermometers:
        column = table[:, run.columns.index(name)]
        table[:, run.columns.index(name)] = 20 + swing * (column - column.min()) / (column.max() - column.min())
    return replace(run, table=table)


def refused(runs: list[Run], effects: list[str], catalogue: Any) -> str:
    with pytest.raises(InputError) as caught:
        diagnose(runs, effects, catalogue)
    assert len(str(caught.value).splitlines()) <= 2
    return str(caught.value)


def test_runs_that_cannot_tell_are_refused(runs, catalogue, base) -> None:
    constant = refused([flat(run, 0.2) for run in runs()], base, catalogue)
    assert "constant" in constant
    assert all(name in constant for name in base), "what is undetermined is named"
    assert "3.00 K only" in refused([flat(run, 3.0) for run in runs()], base, catalogue)
    short = [replace(run, block=torch.where((run.block >= 30) & (run.block < 50), run.block - 30, -1)) for run in runs()]
    assert "40 block means" in refused(short, base, catalogue)


def test_unknown_effects_and_effects_without_their_column_are_refused(runs, catalogue, base) -> None:
    assert "did you mean hysteresis" in refused(runs(), ["static_bias", "histeresis"], catalogue)
    lacking = [without_inputs(run, "field_ut") for run in runs()]
    assert "'magnetic' needs the column field_ut" in refused(lacking, [*base, "magnetic"], catalogue)
