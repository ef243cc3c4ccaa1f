"""An accelerometer's fit and the attitude that follows, from models whose predictions are known."""

from __future__ import annotations

from pathlib import Path

import pytest
import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.measurements.read import read_runs
from zoo.measurements.run import Run
from zoo.papers import hui2016
from zoo.papers.hui2016 import ATTITUDE, KNOWN, LINE, NETWORK, PRINTED, TRAINED, VARIANCE, accelerometers, levelled, units
from zoo.papers.study import Study
from zoo.simulator.accelerometer.alignment import AXES
from zoo.simulator.accelerometer.in_process import as_run
from zoo.simulator.accelerometer.runs import simulate_accelerometer
from zoo.simulator.files import write

UNITS = 30


def line(fitted: Run, run: Run) -> Tensor:
    """(N,) the line fitted to a run, at another."""
    powers = [torch.stack([torch.ones_like(one.temperature), one.temperature], 1) for one in (fitted, run)]
    return powers[1] @ torch.linalg.lstsq(powers[0], fitted.error.unsqueeze(1), driver="gelsd").solution.squeeze(1)


def exact(fitted: Run, run: Run) -> Tensor:
    """(N,) what was known at the same count."""
    return fitted.error


def of(fitted: Run, check: Run) -> Study:
    """A line, and networks that know every count."""
    models = {LINE: line, NETWORK: line, TRAINED: exact}
    return Study.of([fitted, check], 1, {name: [model(fitted, one).unsqueeze(0) for one in (fitted, check)] for name, model in models.items()})


@pytest.fixture(scope="module")
def study() -> Study:
    others = {name: of(fitted[0], check[0]) for name, (fitted, check) in accelerometers(UNITS).items()}
    done = simulate_accelerometer()
    one = of(*(as_run(recorded, recorded.name) for recorded in (done.runs[0], done.runs[0])))
    return Study(one.runs, 1, one.left, others)


def test_a_power_on_in_process_is_what_its_file_reads_as(tmp_path: Path) -> None:
    done = simulate_accelerometer(seed=3)
    write(done, tmp_path)
    (read,), made = read_runs([tmp_path / "run_1.csv"], average_s=None), as_run(done.runs[0], "run_1")
    assert (read.name, read.unit, read.average_s, read.columns, read.rows) == (made.name, made.unit, made.average_s, made.columns, made.rows)
    assert torch.allclose(read.table, made.table, rtol=1e-6, atol=0)
    assert torch.allclose(read.error, made.error, rtol=0, atol=1e-4)
    assert torch.equal(read.block, made.block)


def test_every_unit_has_three_accelerometers_of_its_own() -> None:
    made = accelerometers(2)
    assert len(made) == 2 * len(AXES)
    errors = torch.stack([fitted[0].error for fitted, _ in made.values()])
    assert len(torch.unique(errors[:, 0])) == len(errors)
    with pytest.raises(InputError, match=r"others.count=0"):
        accelerometers(0)


def test_the_line_is_the_papers(study: Study) -> None:
    rows = {(row.model, row.quantity, row.sample): row for row in hui2016.rows(study)}
    found = rows[LINE, VARIANCE, "fitted"]
    assert found.paper == PRINTED[LINE][1]
    assert found.ours == pytest.approx(PRINTED[LINE][1], rel=0.1)
    assert rows[LINE, ATTITUDE, "alignment"].low > hui2016.WANTED_DEG
    assert rows[KNOWN, ATTITUDE, "alignment"].ours < hui2016.WANTED_DEG


def test_a_network_that_knows_every_count_levels_like_a_model_that_does(study: Study) -> None:
    for mine, known in zip(levelled(study, TRAINED), levelled(study, KNOWN), strict=True):
        assert len(mine) == UNITS
        assert torch.allclose(mine, known, rtol=0, atol=1e-12)


def test_taking_off_all_but_the_turn_of_the_table_leaves_the_tables_angles(study: Study) -> None:
    """The attitude of a model that knew the error itself is that to which the table is really set."""
    true = {}
    for number, done in enumerate(units(UNITS), 1):
        for axis in AXES:
            second, other = done.recorded()[axis], study.others[f"unit {number} {axis}"]
            known = second.truth["sum_pulses"] - second.truth["fixture_rotation_pulses"]
            true[f"unit {number} {axis}"] = Study.of(other.runs, 1, {"truth": [known.unsqueeze(0)] * 2})
    _, angles = levelled(Study(study.runs, 1, study.left, true), "truth")
    expected = torch.tensor([done.set_deg["check"] for done in units(UNITS)], dtype=torch.float64)
    assert torch.allclose(angles.mean(-1), expected, rtol=0, atol=1e-6)


def test_what_is_claimed_follows_from_the_residuals(study: Study) -> None:
    claims = hui2016.claims(study, [1e-5, 1e-5])
    holds = {claim.text: claim.holds for claim in claims}
    assert not holds["trained as printed, the wavelet network's variance is at least 1000 times below the line's"]
    assert holds[f"the {TRAINED}'s variance is at least 1000 times below the line's"]
    assert holds[f"in one unit, the paper's case, all attitudes are within 0.005° with the {TRAINED}, and with the line not"]
    assert holds["with the line some attitudes are off by more than 0.005°"]
    assert holds["it misses in no more units than a model that knows every count of the first power-on"]
    assert not {claim.text: claim.holds for claim in hui2016.claims(study, [1.0, 1.0])}["noise alone is at least 1000 times below the line's"]
