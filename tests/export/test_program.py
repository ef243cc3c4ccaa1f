"""``model.pt2`` and ``step.pt2``: one graph for every length, and one sample with the state handed in and out."""

from __future__ import annotations

import pytest
import torch
from torch import nn

from zoo.catalog import names
from zoo.errors import WorkError
from zoo.export.carried import CHUNK
from zoo.export.program import SCANS, load_program, to_programs
from zoo.export.torchscript import load_torchscript, to_torchscript
from zoo.models.base import Model
from zoo.models.example import example
from zoo.models.hybrid import Hybrid
from zoo.models.ranges import Watched, outside

RICH = ["temperature", "temperature_rate", "temperature_outer_lag90", "supply_v", "time_s"]


def both(network, physics):
    model = Hybrid(network, dict(physics.named_effects()), physics.inputs)
    model.physics = physics
    return model


NEWER = pytest.mark.skipif(not SCANS, reason="this torch writes no loops down")


class Line(Model):
    """A model of a user's own: no network of features, and nothing to remember."""

    def __init__(self) -> None:
        super().__init__()
        self.inputs = ["time_s", "temperature_c"]
        self.slope = nn.Parameter(torch.tensor(0.01, dtype=torch.float64))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return self.slope * x[:, 1]


@pytest.fixture(
    scope="module", params=["network", "no memory", pytest.param("own, no memory", marks=NEWER), pytest.param("network and all effects", marks=NEWER)]
)
def programs(request, network, graybox):
    made = {
        "network": lambda: network("bp", features=RICH),
        "no memory": lambda: network("polynomial", features=["temperature"]),
        "own, no memory": Line,
        "network and all effects": lambda: both(network("bp"), graybox(names("effects"), ("temperature_c", "temperature_outer_c"))),
    }
    model = made[request.param]()
    return model, *loaded(to_programs(model, example(model.inputs, {}), {}))


def loaded(files: tuple[bytes, bytes]) -> tuple[nn.Module, nn.Module, torch.Tensor]:
    """The two programs as a user runs them, and the state before the first sample; loading takes seconds where there are many effects."""
    whole, step = (load_program(file) for file in files)
    return whole.module(), step.module(), torch.full(step.example_inputs[0][1].shape, torch.nan, dtype=torch.float64)


@pytest.mark.slow
@torch.no_grad()
def test_one_graph_for_runs_of_every_length(programs, record) -> None:
    model, program, _, _ = programs
    for samples in (1, 2, 3, 64, CHUNK, CHUNK + 1, CHUNK + 2, 1500):
        x = record(model.inputs, samples)
        torch.testing.assert_close(program(x), model(x), rtol=0, atol=1e-11 * float(model(x).abs().max()))


class Chooses(Model):
    """A model that decides by what it is given, which no graph can."""

    def __init__(self) -> None:
        super().__init__()
        self.inputs = ["time_s", "temperature_c"]
        self.gain = nn.Parameter(torch.ones((), dtype=torch.float64))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return self.gain * x[:, 1] if bool(x[0, 1] > -300) else x[:, 0]


@NEWER
def test_what_torch_export_does_not_take_is_told_in_a_line_or_two() -> None:
    with pytest.raises(WorkError, match=r"torch\.export does not take it") as told:
        to_programs(Chooses(), example(["time_s", "temperature_c"], {}), {})
    assert len(str(told.value).splitlines()) == 2
    assert "program=false" in str(told.value)


@pytest.mark.slow
@torch.no_grad()
def test_states_are_handed_on_and_two_records_do_not_meet(programs, record) -> None:
    model, _, step, fresh = programs
    records = [record(model.inputs, 60, seed) for seed in (1, 2)]
    states, found = [fresh, fresh], [[], []]
    for k in range(60):
        for one in (0, 1):
            predicted, states[one] = step(records[one][k], states[one])
            found[one].append(predicted)
    for one in (0, 1):
        wanted = model(records[one])
        torch.testing.assert_close(torch.stack(found[one]), wanted, rtol=0, atol=1e-11 * float(wanted.abs().max()))


def stained(x: torch.Tensor) -> torch.Tensor:
    """A record with what a recorder writes now and then: nothing, at the very first as well, a stamp twice, a stamp that went back."""
    x = x.clone()
    x[0, 1] = x[5, 1] = x[-1, -1] = torch.nan
    x[9, 0], x[20, 1] = torch.nan, torch.inf
    x[12, 0] = x[11, 0]
    x[30:33, 0] -= 500.0
    return x


@pytest.mark.slow
@torch.no_grad()
def test_rows_that_cannot_be_used_leave_no_trace_in_any_file(programs, record) -> None:
    model, whole, step, state = programs
    x = stained(record(model.inputs, 80))
    script = load_torchscript(to_torchscript(model, "dph", example(model.inputs, {}), {}))
    usable = script.usable(x)
    wanted = torch.full_like(x[:, 0], torch.nan)
    wanted[usable] = model(x[usable])
    assert int((~usable).sum()) == 9
    one = []
    for row in x:
        predicted, state = step(row, state)
        one.append(predicted)
    found = {"model.ts": script(x), "step": torch.stack([script.step(row) for row in x]), "model.pt2": whole(x)}
    for name, predicted in (found | {"step.pt2": torch.stack(one)}).items():
        torch.testing.assert_close(predicted, wanted, rtol=0, atol=1e-11 * float(wanted.nan_to_num().abs().max()), equal_nan=True, msg=name)
    assert whole(torch.full_like(x[:3], torch.nan)).isnan().all()


@torch.no_grad()
def test_a_thermometer_that_stood_still_in_training_is_inside_where_it_stands_still(network, record) -> None:
    """Its rate and its lag have ranges as wide as rounding."""
    model = network("bp", features=["temperature", "temperature_outer_rate", "temperature_outer_lag600"])
    x = record(model.inputs, 300)
    x[:, 2] = 23.37
    watched = Watched(model)
    ranges = {name: (float(one.min()), float(one.max())) for name, one in zip(watched.names, watched(x).T, strict=True) if name != "time_s"}
    whole, step, state = loaded(to_programs(model, example(model.inputs, ranges), ranges, refuse_outside=True))
    script = load_torchscript(to_torchscript(model, "dph", example(model.inputs, ranges), ranges, refuse_outside=True))
    for row in x:
        predicted, state = step(row, state)
        assert not bool(predicted.isnan())
        assert not bool(script.step(row).isnan())
    assert not bool(script(x).isnan().any() | whole(x).isnan().any())
    x[200:, 2] += 1.0
    assert bool(script(x)[200:].isnan().all())


@pytest.mark.slow
@torch.no_grad()
@pytest.mark.parametrize("kind", ["network", pytest.param("hybrid", marks=NEWER)])
def test_programs_refuse_what_lies_outside_where_that_is_asked(network, graybox, record, kind) -> None:
    """As `model.ts` does: NaN there, by a column or by a rate of it, and the row counts as past all the same."""
    model = network("bp", features=["temperature", "temperature_rate"])
    model = both(model, graybox(["mohr"])) if kind == "hybrid" else model
    x, ranges = record(model.inputs, 400), {"temperature_c": (-20.0, 40.0), "temperature_rate": (-2.0, 2.0)}
    whole, step, state = loaded(to_programs(model, example(model.inputs, {}), ranges, refuse_outside=True))
    script = load_torchscript(to_torchscript(model, "dph", example(model.inputs, {}), ranges, refuse_outside=True))
    wanted, watched = script(x), Watched(model)
    refused = {name: outside(watched(x), watched.names, {name: one}).any(1) for name, one in ranges.items()}
    by_column, by_rate = refused.values()
    assert min(int(rows.sum()) for rows in (by_column & ~by_rate, by_rate & ~by_column, ~by_column & ~by_rate)) > 0
    assert torch.equal(wanted.isnan(), by_column | by_rate)
    torch.testing.assert_close(whole(x), wanted, rtol=0, atol=1e-11, equal_nan=True)
    for row, one in zip(x, wanted, strict=True):
        predicted, state = step(row, state)
        torch.testing.assert_close(predicted, one, rtol=0, atol=1e-11, equal_nan=True)
