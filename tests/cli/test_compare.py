"""`compare` on models, exported files and predictions made elsewhere, as a user types it."""

import csv
import json
import shutil
import warnings
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch

from zoo.catalog import load_model
from zoo.cli.application import run
from zoo.cli.given_predictions import files_of
from zoo.errors import InputError
from zoo.measurements.read import read_runs
from zoo.measurements.write import write_measurements
from zoo.models.base import Model
from zoo.simulator.noise import flicker

SEEDS = 6


@pytest.fixture(scope="module")
def recordings(tmp_path_factory) -> Path:
    """a.csv to fit, check.csv and later.csv on other programs."""
    folder = tmp_path_factory.mktemp("recordings")
    chance = torch.Generator().manual_seed(1)
    for name, high in (("a", 60.0), ("check", 40.0), ("later", 50.0)):
        time = torch.arange(10.0, 4 * 3600, 20.0, dtype=torch.float64)
        temperature = 20 + (high - 20) * ((time / 3600 - 1).clamp(0, 1) - (time / 3600 - 3).clamp(0, 1))
        rate = torch.gradient(temperature, spacing=(time / 60,))[0]
        error = 0.2 * torch.tanh((temperature - 35) / 8) - 0.1 * rate + 0.01 * torch.randn(len(time), generator=chance, dtype=torch.float64)
        write_measurements(folder / f"{name}.csv", {"time_s": time, "temperature_c": temperature, "rate_dph": error})
    return folder


@pytest.fixture(scope="module")
def sweep(recordings, tmp_path_factory) -> Path:
    """Six seeds of two networks and one line; one more job failed and one was killed."""
    out = tmp_path_factory.mktemp("sweep")
    fit = [f"data.files=[{recordings / 'a.csv'}]", "data.average_s=100"]
    assert run("train", ["-m", "model=bp", "model.hidden=2,9", f"seed=range(1,{SEEDS + 1})", "epochs=60", *fit, f"hydra.sweep.dir={out}"]) == 0
    assert run("train", ["model=polynomial", *fit, f"hydra.run.dir={out / 'line'}"]) == 0
    assert run("train", ["model=polynomial", "seed=2", *fit, f"hydra.run.dir={out / 'line_again'}"]) == 0
    for job, kept in (("failed", [".hydra"]), ("killed", [".hydra", "model.yaml", "weights.pt"])):
        for name in kept:
            there = out / "0" / name
            for file in [there] if there.is_file() else there.iterdir():
                copy = out / job / file.relative_to(out / "0")
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy.write_bytes(file.read_bytes())
    return out


def compare(out: Path, *arguments: str) -> dict:
    assert run("compare", [*arguments, f"hydra.run.dir={out}"]) == 0
    return json.loads((out / "comparison.json").read_text())


def rows(out: Path) -> list[dict[str, str]]:
    with (out / "comparison.csv").open() as file:
        return list(csv.DictReader(file))


def test_models_that_differ_by_their_seed_are_one_method(recordings, sweep, tmp_path, capsys) -> None:
    document = compare(tmp_path, f"runs=[{sweep}]", f"data.files=[{recordings / 'check.csv'}]")
    methods = {one["name"]: one for one in document["methods"]}
    assert set(methods) == {"bp_hidden2", "bp_hidden9", "polynomial"}
    for name in ("bp_hidden2", "bp_hidden9"):
        one = methods[name]
        assert one["seeds"] == list(range(1, SEEDS + 1))
        values = np.array([document["rms"][model] for model in one["models"]])
        assert one["by_seed"] == pytest.approx(list(values))
        assert one["rms"]["median"] == pytest.approx(np.median(values))
        assert (one["rms"]["low"], one["rms"]["high"]) == pytest.approx(tuple(np.quantile(values, [0.05, 0.95])))
        assert abs(document["rms"][one["typical"]] - np.median(values)) == pytest.approx(np.abs(values - np.median(values)).min())
        whole = next(row for row in one["rows"] if row["stage"] == "whole")
        assert whole["median"] == pytest.approx(one["rms"]["median"])
    assert methods["polynomial"]["distinct"] == 1  # solved: two seeds, one model
    assert methods["polynomial"]["interval_over"] == "time"
    said = capsys.readouterr()
    assert said.err.count("skipped") == 1
    assert document["skipped"] == [str(sweep / "failed"), str(sweep / "killed")]
    assert "bp_hidden2 (6 seeds)" in said.out
    page = (tmp_path / "comparison.html").read_text()
    assert document["statement"].replace("_", "_<wbr>") in page
    assert "http" not in page.replace("http://www.w3.org", "")  # nothing is fetched
    assert {"comparison.png", "seeds.png", "residual_check.png", "tensorboard"} <= {path.name for path in tmp_path.iterdir()}


def test_an_ensemble_is_its_single_trainings(recordings, sweep, tmp_path) -> None:
    """Six seeds trained at once and six trained alone are the same method, each seed against itself."""
    settings = ["model=bp", "model.hidden=9", "epochs=60", f"data.files=[{recordings / 'a.csv'}]", "data.average_s=100"]
    assert run("train", [*settings, f"seeds={SEEDS}", f"hydra.run.dir={tmp_path / 'together'}"]) == 0
    alone = ",".join(str(sweep / str(SEEDS + i)) for i in range(SEEDS))
    document = compare(tmp_path / "out", f"runs=[{tmp_path / 'together'},{alone}]", f"data.files=[{recordings / 'check.csv'}]")
    first, second = document["methods"]
    assert first["seeds"] == second["seeds"] == list(range(1, SEEDS + 1))
    assert first["by_seed"] == pytest.approx(second["by_seed"], rel=1e-6)


def test_the_noise_floor_is_that_of_the_recording(recordings, sweep, tmp_path) -> None:
    """White noise of 0.01 in rows of 20 s makes 0.01/√5 in means of 100 s; 144 blocks know it to a tenth."""
    document = compare(tmp_path, f"runs=[{sweep / 'line'}]", f"data.files=[{recordings / 'check.csv'}]")
    assert document["noise_floor"] == pytest.approx(0.01 / 5**0.5, rel=0.12)
    assert document["methods"][0]["excess"] == pytest.approx(document["rms"]["polynomial"] / document["noise_floor"])


@pytest.fixture(scope="module")
def flickering(tmp_path_factory) -> Path:
    """A gyro with a cubic in temperature, and as much flicker as white noise; a run to fit, one to check, and its refinement."""
    folder, chance = tmp_path_factory.mktemp("flickering"), torch.Generator().manual_seed(4)
    for name in ("a", "check"):
        time = torch.arange(25.0, 20 * 3600, 50.0, dtype=torch.float64)
        temperature = 35 - 15 * torch.cos(2 * torch.pi * time / (8 if name == "a" else 11) / 3600)
        noise = flicker(0.02, len(time), 50.0, chance) + 0.02 * torch.randn(len(time), generator=chance, dtype=torch.float64)
        write_measurements(folder / f"{name}.csv", {"time_s": time, "temperature_c": temperature, "rate_dph": 0.01 * (temperature - 20) + noise})
    given = [f"data.files=[{folder / 'a.csv'}]", f"data.check_files=[{folder / 'check.csv'}]", "data.average_s=100"]
    assert run("refine", ["effects=[static_bias]", "add=auto", *given, f"hydra.run.dir={folder / 'refined'}"]) == 0
    return folder


def test_the_noise_floor_is_all_of_the_noise_where_a_refinement_has_found_it(flickering, tmp_path) -> None:
    refined = json.loads((flickering / "refined" / "refinement.json").read_text())
    assert refined["verdict"] == "complete"
    assert refined["noise"]["flicker"] > 0.4 * refined["noise"]["white"]
    check = f"data.files=[{flickering / 'check.csv'}]"
    assert run("export", [f"run={flickering / 'refined'}", "program=false", f"hydra.run.dir={tmp_path / 'exported'}"]) == 0
    for place, model in enumerate((flickering / "refined", tmp_path / "exported")):
        document = compare(tmp_path / str(place), f"runs=[{model}]", check)
        assert document["noise_floor"] == pytest.approx(refined["noise_floor_check"], rel=1e-9)
        assert document["methods"][0]["excess"] == pytest.approx(refined["ladder"][-1]["rms_check"] / refined["noise_floor_check"], rel=1e-6)
    fitted = compare(tmp_path / "fitted", f"runs=[{flickering / 'refined'}]", f"data.files=[{flickering / 'a.csv'}]")
    assert fitted["noise_floor"] == pytest.approx(refined["noise_floor"], rel=1e-9)  # less what the fit has taken up
    assert fitted["methods"][0]["excess"] == pytest.approx(refined["ladder"][-1]["rms"] / refined["noise_floor"], rel=1e-6)
    longer = compare(tmp_path / "longer", f"runs=[{flickering / 'refined'}]", check, "data.average_s=400")
    assert longer["noise"] is None  # in means of another length, what is white cannot be told from the flicker
    shutil.copytree(flickering / "refined", tmp_path / "short")
    (tmp_path / "short" / "refinement.json").write_text(json.dumps(refined | {"verdict": "unknown"}))
    white = compare(tmp_path / "white", f"runs=[{tmp_path / 'short'}]", check)
    assert white["noise"] is None
    assert white["noise_floor"] < 0.9 * document["noise_floor"]


def test_a_louder_run_has_more_white_noise_and_the_gyros_own_flicker(flickering, tmp_path) -> None:
    loud = pd.read_csv(flickering / "check.csv")
    loud["rate_dph"] += 0.1 * np.random.default_rng(1).normal(size=len(loud))
    loud.to_csv(tmp_path / "loud.csv", index=False)
    found = [
        compare(tmp_path / "out", f"runs=[{flickering / 'refined'}]", f"data.files=[{path}]")
        for path in (flickering / "check.csv", tmp_path / "loud.csv")
    ]
    quiet, louder = (one["noise_floor"] ** 2 for one in found)
    assert louder - quiet == pytest.approx(0.1**2 / 2, rel=0.2)  # means of two rows


def test_a_refinement_that_is_not_borne_out_here_tells_nothing_of_the_noise(flickering, tmp_path) -> None:
    other = pd.read_csv(flickering / "check.csv")
    other["rate_dph"] += 0.2 * np.sin(other["time_s"] / 3600)
    other.to_csv(tmp_path / "other.csv", index=False)
    document = compare(tmp_path / "out", f"runs=[{flickering / 'refined'}]", f"data.files=[{tmp_path / 'other.csv'}]")
    assert document["noise"] is None
    assert document["methods"][0]["excess"] > 5


def test_another_gyros_run_of_the_same_name_was_not_fitted_and_a_copy_was(flickering, tmp_path) -> None:
    other = pd.read_csv(flickering / "a.csv")
    other["rate_dph"] *= 1.3
    other.to_csv(tmp_path / "a.csv", index=False)
    shutil.copy(flickering / "a.csv", tmp_path / "renamed.csv")
    for path, fitted in ((flickering / "a.csv", ["a"]), (tmp_path / "a.csv", []), (tmp_path / "renamed.csv", ["renamed"])):
        document = compare(tmp_path / "out", f"runs=[{flickering / 'refined'}]", f"data.files=[{path}]")
        assert document["methods"][0]["fitted_runs"] == fitted


def test_a_run_too_short_to_judge_is_refused(recordings, sweep, tmp_path, capsys) -> None:
    pd.read_csv(recordings / "check.csv").head(15).to_csv(tmp_path / "five.csv", index=False)
    assert (
        run("compare", [f"runs=[{sweep / 'line'}]", f"data.files=[{tmp_path / 'five.csv'}]", "data.average_s=100", f"hydra.run.dir={tmp_path}"]) == 2
    )
    assert "five: 3 means of 100 s are too few to tell noise from anything (4 at least)" in capsys.readouterr().err


def test_runs_of_unequal_noise_have_floors_of_their_own(recordings, sweep, tmp_path) -> None:
    """The second has five times the noise, which a filter has smoothed within each block."""
    chance = torch.Generator().manual_seed(2)
    time = torch.arange(10.0, 8 * 3600, 20.0, dtype=torch.float64)
    for name, size in (("quiet", 0.01), ("loud", 0.05)):
        blocks = size * torch.randn(len(time) // 5 + 1, generator=chance, dtype=torch.float64)
        noise = blocks.repeat_interleave(5)[: len(time)] + 0.1 * size * torch.randn(len(time), generator=chance, dtype=torch.float64)
        write_measurements(tmp_path / f"{name}.csv", {"time_s": time, "temperature_c": 30 + time / 3600, "rate_dph": noise})
    document = compare(tmp_path / "out", f"runs=[{sweep / 'line'}]", f"data.files=[{tmp_path}/quiet.csv,{tmp_path}/loud.csv]", "data.average_s=100")
    assert document["noise_floors"] == pytest.approx({"quiet": 0.01, "loud": 0.05}, rel=0.2)
    assert document["noise_floor"] == pytest.approx((0.5 * (0.01**2 + 0.05**2)) ** 0.5, rel=0.2)


def test_what_goes_beyond_the_training_is_told_of_models_and_of_exported_files(recordings, tmp_path, capsys) -> None:
    """Fitted up to 40 °C, and asked at 60."""
    narrow = f"data.files=[{recordings / 'check.csv'}]"
    model = ["model=polynomial", "model.features=[temperature,temperature_rate,time_s]", "model.smoothing_s=300"]
    assert run("train", [*model, narrow, f"hydra.run.dir={tmp_path / 'line'}"]) == 0
    assert run("export", [f"run={tmp_path / 'line'}", "program=false", f"hydra.run.dir={tmp_path / 'exported'}"]) == 0
    capsys.readouterr()
    document = compare(tmp_path / "out", f"runs=[{tmp_path / 'line'},{tmp_path / 'exported'}]", narrow)
    assert [one["beyond"] for one in document["methods"]] == [{}, {}]
    assert "Extrapolated" not in capsys.readouterr().out
    later = pd.read_csv(recordings / "a.csv")
    later["time_s"] += 7200
    later.to_csv(tmp_path / "later.csv", index=False)
    document = compare(tmp_path / "out", f"runs=[{tmp_path / 'line'},{tmp_path / 'exported'}]", f"data.files=[{tmp_path / 'later.csv'}]")
    one, other = (one["beyond"]["later"] for one in document["methods"])
    assert one == other
    assert set(one) == {"time_s", "temperature_c", "temperature_rate"}
    assert one["temperature_c"]["reached"][1] == pytest.approx(60, abs=0.1)
    assert one["temperature_c"]["fitted"][1] == pytest.approx(40, abs=0.1)
    assert "Extrapolated by every model: later in " in capsys.readouterr().out


def test_names_say_which_network_and_no_folder_and_blocks_in_seconds(recordings, tmp_path) -> None:
    """A network by its name and one setting by setting; `auto` blocks are as long as they came to be; runs that lie elsewhere are no other method."""
    shutil.copy(recordings / "a.csv", tmp_path / "moved.csv")
    files, hybrid = f"data.files=[{recordings / 'a.csv'}]", ["model=hybrid", "effects=[mohr]", "epochs=2"]
    trained = {
        "line": [*hybrid, "model.network=polynomial", files],
        "net": [*hybrid, files],
        "auto": ["model=polynomial", files],
        "long": ["model=polynomial", files, "data.average_s=200"],
        "there": ["model=polynomial", "data.average_s=200", f"data.files=[{tmp_path / 'moved.csv'}]"],
    }
    for name, settings in trained.items():
        assert run("train", [*settings, f"hydra.run.dir={tmp_path / name}"]) == 0
    block = json.loads((tmp_path / "auto" / "metrics.json").read_text())["average_s"]
    models = f"runs=[{','.join(str(tmp_path / name) for name in trained)}]"
    document = compare(tmp_path / "out", models, f"data.files=[{recordings / 'check.csv'}]")
    names = ["hybrid_polynomial", "hybrid_bp", f"polynomial_average_s{block:g}", "polynomial_average_s200", "polynomial_average_s200_2"]
    assert [one["name"] for one in document["models"]] == names


def test_order_does_not_matter(recordings, sweep, tmp_path) -> None:
    files = f"data.files=[{recordings / 'check.csv'},{recordings / 'later.csv'}]"
    jobs = [str(sweep / str(i)) for i in range(2 * SEEDS)]
    here = compare(tmp_path / "here", f"runs=[{','.join(jobs)}]", files)
    there = compare(tmp_path / "there", f"runs=[{','.join(reversed(jobs))}]", files)
    assert [one["name"] for one in here["methods"]] == [one["name"] for one in there["methods"]]
    assert here["pairs"] == there["pairs"]
    for one, other in zip(here["methods"], there["methods"], strict=True):
        assert (one["rms"], one["typical"], one["where"]) == (other["rms"], other["typical"], other["where"])


def test_predictions_equal_to_a_model_s_own_give_the_identical_row(recordings, sweep, tmp_path) -> None:
    model, given = load_model(sweep / "3"), tmp_path / "elsewhere"
    assert isinstance(model, Model)
    for name in ("check", "later"):
        one = read_runs(recordings / f"{name}.csv", average_s=None)[0]
        predicted = model(one.select(model.inputs)).detach()
        write_measurements(given / f"pred_{name}.csv", {"time_s": one.time, "predicted_error_dph": predicted})
        write_measurements(tmp_path / "rounded" / f"pred_{name}.csv", {"time_s": one.time, "predicted_error_dph": predicted * (1.0 + 1e-13)})
    files = f"data.files=[{recordings / 'check.csv'},{recordings / 'later.csv'}]"
    for setting, called in ((f"predictions={{mymodel: {given}/pred_*.csv}}", "mymodel"), (f"predictions=[{given}]", "elsewhere")):
        out = tmp_path / called
        document = compare(out, f"runs=[{sweep / '3'}]", setting, files)
        for row in rows(out):
            assert row["bp"] == row[called]
        assert [(pair["verdict"], pair["statement"]) for pair in document["pairs"]] == [("same", f"bp and {called} predict the same")]
        assert "predict the same" in document["statement"]
    document = compare(tmp_path / "out", f"runs=[{sweep / '3'}]", f"predictions=[{tmp_path / 'rounded'}]", files)
    assert [pair["verdict"] for pair in document["pairs"]] == ["same"], "up to rounding"


def test_seeds_of_another_machine_are_the_same_method_and_one_seed_is_no_constant(recordings, sweep, tmp_path) -> None:
    """Ten digits are alike; and one draw of a network beside six of another says nothing of its other draws, only of the two networks."""
    bp = [sweep / str(SEEDS + i) for i in range(SEEDS)]
    for job in bp:
        there = tmp_path / "there" / job.name
        shutil.copytree(job, there)
        weights = torch.load(there / "weights.pt", weights_only=True)
        torch.save({key: value * (1 + 1e-12) if value.is_floating_point() else value for key, value in weights.items()}, there / "weights.pt")
    files = f"data.files=[{recordings / 'check.csv'}]"
    document = compare(tmp_path / "alike", f"runs=[{','.join(map(str, bp))},{tmp_path / 'there'}]", files)
    assert [len(one["models"]) for one in document["methods"]] == [SEEDS, SEEDS]
    assert [pair["verdict"] for pair in document["pairs"]] == ["same"]
    lone = compare(tmp_path / "lone", f"runs=[{','.join(map(str, bp))},{sweep / '0'},{sweep / 'line'}]", files)
    over = {frozenset((pair["first"], pair["second"])): (pair["interval_over"], pair["wins"]) for pair in lone["pairs"]}
    assert over[frozenset(("bp_hidden2", "bp_hidden9"))] == ("time", None)
    assert over[frozenset(("polynomial", "bp_hidden9"))][0] == "seeds", "what is solved is all there is"


def test_predictions_alone_are_compared_as_well(recordings, tmp_path) -> None:
    one = read_runs(recordings / "check.csv", average_s=None)[0]
    write_measurements(tmp_path / "perfect.csv", {"time_s": one.time, "predicted_error_dph": one.error})
    document = compare(tmp_path / "out", f"predictions=[{tmp_path / 'perfect.csv'}]", f"data.files=[{recordings / 'check.csv'}]")
    assert document["rms"]["perfect"] == pytest.approx(0, abs=1e-12)


def test_an_exported_file_is_compared_like_the_model(recordings, sweep, tmp_path) -> None:
    folder = tmp_path / "firmware"
    folder.mkdir()
    model = load_model(sweep / "3")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        torch.jit.script(model).save(str(folder / "model.ts"))
    trained = {"runs": ["a"], "seed": 4, "average_s": 100.0}
    facts = {"inputs": list(model.inputs), "unit": "dph", "model": "bp", "trained_on": trained}  # type: ignore[arg-type]
    (folder / "metadata.json").write_text(json.dumps(facts))
    for given in (folder, folder / "model.ts"):
        out = tmp_path / f"out_{given.name}"
        document = compare(out, f"runs=[{sweep / '3'},{given}]", f"data.files=[{recordings / 'a.csv'}]")
        assert [one["fitted_runs"] for one in document["methods"]] == [["a"], ["a"]]
        for row in rows(out):
            assert row["bp"] == row["bp_exported"]
    for unit in ("m_per_s2", "furlongs"):
        (folder / "metadata.json").write_text(json.dumps(facts | {"unit": unit}))
        assert run("compare", [f"runs=[{folder}]", f"data.files=[{recordings / 'check.csv'}]", f"hydra.run.dir={tmp_path / 'wrong'}"]) == 2


def test_recordings_in_another_unit_are_compared_like_those_in_the_models_own(recordings, sweep, tmp_path) -> None:
    """Also by a model that takes the output and the true input, whose columns have the unit in their values and names."""
    shown, true = ["model=bp", "model.features=[temperature,output]", "epochs=3"], ["model=graybox", "effects=[mohr,scale_factor]"]
    for name, settings in (("shown", shown), ("true", true)):
        assert run("train", [*settings, f"data.files=[{recordings / 'a.csv'}]", "data.reference=2", f"hydra.run.dir={tmp_path / name}"]) == 0
    frame = pd.read_csv(recordings / "check.csv")
    (tmp_path / "dps").mkdir()
    frame.assign(rate_dps=frame.pop("rate_dph") / 3600).to_csv(tmp_path / "dps" / "check.csv", index=False)
    models = f"runs=[{sweep / '3'},{tmp_path / 'shown'},{tmp_path / 'true'}]"
    one = compare(tmp_path / "one", models, f"data.files=[{recordings / 'check.csv'}]", "data.reference=2", "data.average_s=100")
    other = compare(tmp_path / "other", models, f"data.files=[{tmp_path / 'dps' / 'check.csv'}]", f"data.reference={2 / 3600}", "data.average_s=100")
    assert (one["unit"], other["unit"]) == ("dph", "dps")
    assert len(one["rms"]) == 4
    for name, rms in one["rms"].items():
        assert other["rms"][name] == pytest.approx(rms / 3600, rel=1e-6)


def test_runs_that_were_fitted_do_not_rank(recordings, sweep, tmp_path, capsys) -> None:
    """The order, the intervals and the floor are those of the runs that no model was fitted to, as if these alone had been given."""
    models = f"runs=[{sweep / 'line'},{sweep / '3'}]"
    fitted, unseen = f"{recordings / 'a.csv'}", f"{recordings / 'check.csv'},{recordings / 'later.csv'}"
    alone = compare(tmp_path / "alone", models, f"data.files=[{unseen}]")
    capsys.readouterr()
    mixed = compare(tmp_path / "mixed", models, f"data.files=[{fitted},{unseen}]")
    assert [one["fitted_runs"] for one in mixed["methods"]] == [["a"], ["a"]]
    assert (mixed["ranked_by"], alone["ranked_by"]) == (["check", "later"],) * 2
    for key in ("rms", "noise_floor", "pairs", "statement"):
        assert mixed[key] == alone[key]
    kept = {"name", "rms", "by_seed", "excess", "removed", "where", "goes_with"}
    assert [{key: one[key] for key in kept} for one in mixed["methods"]] == [{key: one[key] for key in kept} for one in alone["methods"]]
    assert {row["run"] for row in mixed["rows"]} == {"a", "check", "later"}
    told = " ".join(capsys.readouterr().out.split())
    assert "unseen runs RMS × floor" in told
    assert "Fitted by every model, to go by name and error: a. The order is that of the other runs" in told
    assert "RMS over unseen runs" in (tmp_path / "mixed" / "comparison.html").read_text()


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ([], ["nothing to compare", "runs=", "predictions="]),
        (["predictions={m: nowhere_*.csv}"], ["predictions.m", "nowhere_*.csv"]),
        (["predictions={m: FOLDER/a.csv}"], ["predicted_error_dph", "rate_dph"]),
        (["predictions={m: [FOLDER/a.csv, FOLDER/later.csv]}"], ["none of the files (a.csv, later.csv)", "run check", "pred_check.csv"]),
        (["runs=[SWEEP/failed]"], ["failed", "no model"]),
        (["runs=[SWEEP/killed]"], ["killed", "no finished model"]),
    ],
)
def test_wrong_input_is_named_in_a_line(recordings, sweep, tmp_path, capsys, settings, words) -> None:
    told = [one.replace("FOLDER", str(recordings)).replace("SWEEP", str(sweep)) for one in settings]
    assert run("compare", [*told, f"data.files=[{recordings / 'check.csv'}]", f"hydra.run.dir={tmp_path / 'out'}"]) == 2
    message = capsys.readouterr().err
    assert "Traceback" not in message
    for word in words:
        assert word in message


def test_an_export_that_refuses_or_was_changed_is_told(recordings, sweep, tmp_path, capsys) -> None:
    refusing = tmp_path / "refusing"
    settings = [f"run={sweep / '3'}", "refuse_outside=true", "program=false", f"hydra.run.dir={refusing}"]
    assert run("export", settings) == 0
    hot = pd.read_csv(recordings / "check.csv")
    hot.assign(temperature_c=hot["temperature_c"] + 100).to_csv(tmp_path / "hot.csv", index=False)
    asked = [f"runs=[{refusing}]", f"data.files=[{tmp_path / 'hot.csv'}]", f"hydra.run.dir={tmp_path / 'out'}"]
    capsys.readouterr()
    assert run("compare", asked) == 2
    assert "exported with refuse_outside=true, and hot goes beyond what it was trained on" in capsys.readouterr().err
    shutil.copy(refusing / "metadata.json", tmp_path / "metadata.json")
    assert run("export", [f"run={sweep / '0'}", "program=false", f"hydra.run.dir={refusing}"]) == 0
    shutil.copy(tmp_path / "metadata.json", refusing / "metadata.json")
    capsys.readouterr()
    assert run("compare", asked) == 2
    assert "model.ts is not the file that metadata.json tells of" in capsys.readouterr().err


def test_what_compensate_left_empty_is_left_out_of_the_comparison_too(recordings, sweep, tmp_path, capsys) -> None:
    frame = pd.read_csv(recordings / "check.csv")
    frame.loc[200, "temperature_c"] = np.nan
    frame.to_csv(tmp_path / "holes.csv", index=False)
    files = [f"data.files=[{tmp_path / 'holes.csv'}]", "data.bad_rows=skip"]
    assert run("compensate", [f"run={sweep / '3'}", *files, f"hydra.run.dir={tmp_path / 'done'}"]) == 0
    document = compare(tmp_path / "out", f"runs=[{sweep / '3'}]", f"predictions={{mine: {tmp_path / 'done' / 'holes.csv'}}}", *files)
    assert document["rms"]["mine"] == pytest.approx(document["rms"]["bp"], rel=1e-6)
    capsys.readouterr()
    mine = [f"predictions={{mine: {tmp_path / 'done' / 'holes.csv'}}}", f"data.files=[{recordings / 'check.csv'}]"]
    assert run("compare", [*mine, f"hydra.run.dir={tmp_path / 'out'}"]) == 2
    assert "row 202, column predicted_error_dph: the cell is empty" in capsys.readouterr().err


def test_a_class_that_cannot_be_imported_is_what_is_told_of_its_models(recordings, sweep, tmp_path, capsys) -> None:
    for job in ("one", "two"):
        shutil.copytree(sweep / "3", tmp_path / "jobs" / job)
        settings = tmp_path / "jobs" / job / "model.yaml"
        settings.write_text(settings.read_text().replace("zoo.models.bp.BP", "elsewhere.models.Mine"))
    capsys.readouterr()
    assert run("compare", [f"runs=[{tmp_path / 'jobs'}]", f"data.files=[{recordings / 'check.csv'}]", f"hydra.run.dir={tmp_path / 'out'}"]) == 2
    told = capsys.readouterr().err
    assert "there is no module 'elsewhere'; is its folder on PYTHONPATH?" in told
    assert "no finished model" not in told


def test_exports_of_different_trainings_are_all_compared(recordings, tmp_path) -> None:
    """Of one model, seed and optimizer: an exported file does not say how long it was trained."""
    for epochs in (3, 40):
        out, files = tmp_path / str(epochs), f"data.files=[{recordings / 'a.csv'}]"
        assert run("train", ["model=bp", f"epochs={epochs}", files, f"hydra.run.dir={out}"]) == 0
        assert run("export", [f"run={out}", "program=false", f"hydra.run.dir={tmp_path / 'files' / str(epochs)}"]) == 0
    document = compare(tmp_path / "out", f"runs=[{tmp_path / 'files' / '*'}]", f"data.files=[{recordings / 'check.csv'}]")
    assert len(document["models"]) == 2


def test_a_file_of_predictions_is_for_one_run() -> None:
    """Runs in two folders may be called alike; then the folders of the predictions tell which is whose."""
    with pytest.raises(InputError, match=r"pred_run_1\.csv would be taken for the run A/run_1 and for B/run_1"):
        files_of(["A/run_1", "B/run_1"], "mine", [Path("pred_run_1.csv")])
    two = [Path("A/run_1.csv"), Path("B/run_1.csv")]
    assert files_of(["A/run_1", "B/run_1"], "mine", two) == {"A/run_1": two[0], "B/run_1": two[1]}
