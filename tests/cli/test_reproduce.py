"""`reproduce` and `train` with a paper's protocol, on shortened simulations."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from zoo.cli import run

SHORT = {
    "qiu2023": ["data.simulated.sample_s=20", "epochs=20", "init.steps=3"],
    "tong2019": ["data.simulated.sample_s=20", "optimizer.particles=20", "optimizer.steps=20"],
}
FIGURES = {
    "qiu2023": {"drift", "bias_stability", *(f"{kind}_run_{k}" for kind in ("fits", "compensated") for k in (1, 2, 3))},
    "tong2019": {"drift", "mean", "standard_deviation", *(f"{kind}_{name}" for kind in ("fits", "compensated") for name in ("run_1", "check"))},
}


@pytest.mark.parametrize("paper", list(SHORT))
def test_an_experiment_is_the_papers_own_method(paper: str, tmp_path: Path) -> None:
    assert run("train", [f"experiment={paper}", *SHORT[paper], f"data.folder={tmp_path / 'data'}", f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    assert (tmp_path / "out" / "metrics.json").is_file()


@pytest.mark.slow
@pytest.mark.parametrize("paper", list(SHORT))
def test_every_method_has_its_rows_and_the_figures_are_drawn(paper: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, common = tmp_path / "out", ["seeds=2", "epochs=20", "data.simulated.sample_s=20"]
    assert run("reproduce", [f"paper={paper}", *common, f"data.folder={tmp_path / 'data'}", f"hydra.run.dir={out}"]) == 0
    assert capsys.readouterr().out.strip().endswith("table.csv")
    table = pd.read_csv(out / "table.csv")
    assert list(table.columns) == ["quantity", "stage", "sample", "model", "paper", "ours", "ours_low", "ours_high", "unit"]
    assert table.ours.notna().all()
    assert {path.stem for path in (out / "figures").iterdir()} == FIGURES[paper]
    assert "| found |" in (out / "table.md").read_text()


PROTOCOL = "# @package _global_\ndefaults: [qiu2023]\nanswer: {}\n"


@pytest.mark.parametrize(
    "setting",
    [
        '+methods.mine=["model=polynomial","optimizer=least_squares"]',
        "+data.columns.airflow=air",
        "+model.activation=tanh",
        "+optimizer.momentum=0.5",
        "+init.ants=7",
        "++epochs=3",
        "+figures=zoo.report.rate_table_figures",
        "+answer.is=43",
    ],
)
def test_what_a_training_and_a_protocol_have_can_be_added_to(setting: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "conf" / "experiment").mkdir(parents=True)
    (tmp_path / "conf" / "experiment" / "mine.yaml").write_text(PROTOCOL)
    monkeypatch.setattr("zoo.cli.reproduce.run", lambda config, out: out)
    common = ["paper=mine", f"hydra.searchpath=[file://{tmp_path / 'conf'}]", f"hydra.run.dir={tmp_path / 'out'}"]
    assert run("reproduce", [*common, setting]) == 0


@pytest.mark.parametrize(
    ("setting", "found"),
    [
        ("~methods.BP", "the method 'BP' is missing"),
        ("data.check_files=[run_2.parquet]", "a run is missing"),
        ("model=polynomial", "'+methods.mine=[model=polynomial]'"),
        ("init.steps=2", "unknown key 'init.steps'"),
    ],
)
def test_what_would_leave_no_table_is_told_before_anything_is_trained(
    setting: str, found: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert run("reproduce", ["paper=qiu2023", "epochs=2", setting, f"hydra.run.dir={tmp_path / 'out'}"]) == 2
    assert found in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "out" / "methods").exists()


@pytest.mark.parametrize(("verb", "chosen"), [("reproduce", ["paper=qiu2023"]), ("train", ["data.files=[a.csv]"])])
def test_what_nothing_would_read_is_refused(verb: str, chosen: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    wrong = "+method.mine=[]" if verb == "reproduce" else "+methods.mine=[]"
    assert run(verb, [*chosen, wrong, f"hydra.run.dir={tmp_path / 'out'}"]) == 2
    told = capsys.readouterr().err
    assert f"there is no setting '{wrong[1:].partition('.')[0]}'" in told
    assert ("did you mean methods" in told) == (verb == "reproduce")
