"""`train` and `compare` as a user types them: files, exit codes, messages."""

import csv
import json
import shlex
from pathlib import Path

import pytest
import torch
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator
from tensorboard.plugins.hparams.plugin_data_pb2 import HParamsPluginData

from zoo.catalog import load_model
from zoo.cli.application import run
from zoo.cli.entrants import find_entrants, named
from zoo.cli.export import _about
from zoo.cli.next_commands import FITTED
from zoo.cli.saved_models import load_saved

STEP_S = 20


@pytest.fixture(scope="module")
def recordings(tmp_path_factory) -> Path:
    """a.csv and b.csv to fit, check.csv on another program, other.csv of another quantity."""
    folder = tmp_path_factory.mktemp("recordings")
    chance = torch.Generator().manual_seed(1)
    for name, high, unit in (("a", 60.0, "dph"), ("b", 50.0, "dph"), ("check", 40.0, "dph"), ("other", 40.0, "m_per_s2")):
        time = torch.arange(STEP_S / 2, 4 * 3600, STEP_S, dtype=torch.float64)
        temperature = 20 + (high - 20) * ((time / 3600 - 1).clamp(0, 1) - (time / 3600 - 3).clamp(0, 1))
        rate = torch.gradient(temperature, spacing=(time / 60,))[0]
        error = 0.2 * torch.tanh((temperature - 35) / 8) - 0.1 * rate + 0.01 * torch.randn(len(time), generator=chance, dtype=torch.float64)
        rows = [f"{t:.1f},{u:.4f},{e:.6f}" for t, u, e in zip(time.tolist(), temperature.tolist(), error.tolist(), strict=True)]
        (folder / f"{name}.csv").write_text("\n".join([f"time_s,temperature_c,{'rate' if unit == 'dph' else 'accel'}_{unit}", *rows]) + "\n")
    return folder


def train(recordings: Path, out: Path, *more: str) -> int:
    files = [f"data.files=[{recordings / 'a.csv'},{recordings / 'b.csv'}]", f"data.check_files=[{recordings / 'check.csv'}]", "data.average_s=100"]
    return run("train", [*more, *files, f"hydra.run.dir={out}"])


def test_a_polynomial_is_solved_without_being_told_how(recordings, tmp_path, capsys) -> None:
    assert train(recordings, tmp_path, "model=polynomial") == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(tmp_path / "metrics.json")
    metrics = json.loads((tmp_path / "metrics.json").read_text())
    assert (metrics["model"], metrics["init"], metrics["optimizer"], metrics["seed"]) == ("polynomial", None, "least_squares", 1)
    assert 0 < metrics["rms"] < metrics["rms_uncompensated"]
    assert [one["run"] for one in metrics["check_runs"]] == ["check"]
    assert {"hold", "heating", "cooling", "edge"} == set(metrics["runs"][0]["stages"])
    assert {"torch", "python", "fogzoo"} <= set(metrics["versions"])
    assert {"last.ckpt", "model.yaml", "weights.pt", "prediction.png", "tensorboard", ".hydra"} <= {path.name for path in tmp_path.iterdir()}


def test_samples_that_a_recorder_spoilt_are_told_and_judge_nobody(recordings, tmp_path, capsys) -> None:
    """Neither in a run that is fitted nor in one that is checked on, of a training, a comparison and a refinement."""
    for name in ("a", "b", "check"):
        lines = (recordings / f"{name}.csv").read_text().splitlines()
        for row in range(100, 700, 100):
            lines[row] = ",".join([*lines[row].split(",")[:2], "80" if row % 200 else "-80"])
        (tmp_path / f"{name}.csv").write_text("\n".join(lines) + "\n")
    found = {}
    for name, folder in (("clean", recordings), ("spoilt", tmp_path)):
        assert train(folder, tmp_path / name, "model=polynomial", "model.order=3") == 0
        found[name] = json.loads((tmp_path / name / "metrics.json").read_text())
    told = " ".join(capsys.readouterr().err.split())
    assert "check: 6 sample(s) far off their neighbours left out" in told
    for key in ("rms", "rms_check"):
        assert found["spoilt"][key] == pytest.approx(found["clean"][key], rel=0.05)
    files = [f"data.files=[{tmp_path / 'check.csv'}]", f"hydra.run.dir={tmp_path / 'compared'}"]
    assert run("compare", [f"runs=[{tmp_path / 'clean'}]", *files]) == 0
    document = json.loads((tmp_path / "compared" / "comparison.json").read_text())
    whole = next(row for row in document["rows"] if row["stage"] == "whole")
    assert whole["polynomial"] == pytest.approx(found["clean"]["rms_check"], rel=0.05)
    both = [f"data.files=[{tmp_path / 'a.csv'},{tmp_path / 'b.csv'}]", f"data.check_files=[{tmp_path / 'check.csv'}]", "data.average_s=100"]
    assert run("refine", ["add=[]", "candidates=[aging]", *both, f"hydra.run.dir={tmp_path / 'refined'}"]) == 0
    assert json.loads((tmp_path / "refined" / "refinement.json").read_text())["ladder"][0]["rms_check"] < 1.0


def test_seeds_decide_and_a_network_beats_the_line(recordings, tmp_path) -> None:
    results = {}
    for name, seed in (("one", 1), ("again", 1), ("two", 2)):
        assert train(recordings, tmp_path / name, "model=bp", "init=pso", "init.steps=20", "epochs=200", f"seed={seed}") == 0
        results[name] = json.loads((tmp_path / name / "metrics.json").read_text())
    assert results["one"]["rms"] == results["again"]["rms"] != results["two"]["rms"]
    assert results["one"]["evaluations"] == 30 * 20 + 200
    assert train(recordings, tmp_path / "line", "model=polynomial") == 0
    assert results["one"]["rms"] < json.loads((tmp_path / "line" / "metrics.json").read_text())["rms"]


def test_a_sweep_is_compared_by_run_and_stage(recordings, tmp_path, capsys) -> None:
    sweep = ["-m", "model=polynomial,bp", "seed=1,2", "epochs=20", f"hydra.sweep.dir={tmp_path / 'sweep'}"]
    assert train(recordings, tmp_path / "unused", *sweep) == 0
    files = f"data.files=[{recordings / 'a.csv'},{recordings / 'check.csv'}]"
    assert run("compare", [f"runs=[{tmp_path / 'sweep'}]", files, f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    printed = capsys.readouterr().out
    assert printed.splitlines()[-1] == str(tmp_path / "out" / "comparison.csv")
    first = next(part for part in printed.split("\n\n") if part.startswith("a "))
    names = [line.split("  ")[0] for line in first.splitlines()]
    assert names[:3] == ["a", "blocks", "uncompensated"]
    assert set(names[3:]) == {"polynomial (2 ×)", "bp (2 seeds)"}
    with (tmp_path / "out" / "comparison.csv").open() as file:
        rows = list(csv.DictReader(file))
    models = ["polynomial", "polynomial_2", "bp_seed1", "bp_seed2"]
    assert list(rows[0]) == ["run", "stage", "blocks", "uncompensated", *models]
    assert [(row["run"], row["stage"]) for row in rows] == [
        (one, stage) for one in ("a", "check") for stage in ("hold", "heating", "cooling", "edge", "whole")
    ]
    metrics = json.loads((tmp_path / "sweep" / "0" / "metrics.json").read_text())
    assert float(rows[4]["polynomial"]) == pytest.approx(metrics["runs"][0]["rms"], rel=1e-4)
    document = json.loads((tmp_path / "out" / "comparison.json").read_text())
    assert document["average_s"] == 100  # as trained
    assert [model["name"] for model in document["models"]] == models
    assert document["rms"]["polynomial"] == document["rms"]["polynomial_2"] < document["rms"]["uncompensated"]
    assert document["runs"][0]["stages"][0]["stage"] == "hold"
    assert {"comparison.png", "residual_a.png", "residual_check.png", "tensorboard"} <= {path.name for path in (tmp_path / "out").iterdir()}


def test_training_goes_on_from_a_folder(recordings, tmp_path) -> None:
    assert train(recordings, tmp_path / "first", "epochs=50") == 0
    assert train(recordings, tmp_path / "second", "epochs=100", f"resume={tmp_path / 'first'}") == 0
    assert train(recordings, tmp_path / "whole", "epochs=100") == 0
    resumed, whole = (load_model(tmp_path / name).state_dict() for name in ("second", "whole"))
    for key, value in whole.items():
        torch.testing.assert_close(resumed[key], value, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["model=bpp"], ["unknown model 'bpp'", "bp"]),
        (["model=bp", "optimizer=least_squares"], ["BP", "not linear"]),
        (["model=polynomial", "optimizer.lr=0.1"], ["optimizer.lr", "least_squares"]),
        (["model=bp", "epochs=many"], ["epochs=many"]),
        (["model=bp", "model.features=[temperature_outer]"], ["a:", "temperature_outer_c"]),
        (["model=bp", "resume=nowhere"], ["resume=nowhere"]),
        (["model=bp", "torch_device=abacus"], ["torch_device=abacus", "cpu"]),
    ],
)
def test_wrong_input_is_named_in_a_line(recordings, tmp_path, capsys, more, words) -> None:
    assert train(recordings, tmp_path, *more) == 2
    message = capsys.readouterr().err
    assert "Traceback" not in message
    for word in words:
        assert word in message
    assert not {"metrics.json", "last.ckpt", "prediction.png"} & {path.name for path in tmp_path.iterdir()}


def test_divergence_is_a_failure_and_no_input_error(recordings, tmp_path, capsys) -> None:
    assert train(recordings, tmp_path, "optimizer=sgd", "optimizer.lr=1e200") == 1
    assert "optimizer.lr" in capsys.readouterr().err


def test_comparing_nothing_or_another_quantity_is_an_input_error(recordings, tmp_path, capsys) -> None:
    out = f"hydra.run.dir={tmp_path / 'out'}"
    assert run("compare", ["runs=[nowhere]", f"data.files=[{recordings / 'a.csv'}]", out]) == 2
    assert "nowhere" in capsys.readouterr().err
    assert train(recordings, tmp_path / "model", "model=polynomial") == 0
    assert run("compare", [f"runs={tmp_path / 'model'}", f"data.files={recordings / 'other.csv'}", out]) == 2
    message = capsys.readouterr().err
    assert "trained on errors in °/h" in message
    assert "other is in m/s²" in message


def pasted(out: str) -> list[str]:
    """The arguments of the compare command that was printed."""
    line = next(line.strip() for line in out.splitlines() if line.strip().startswith("fogzoo compare"))
    return shlex.split(line)[2:]


def test_what_refine_prints_as_next_can_be_pasted(recordings, tmp_path, capsys) -> None:
    """It compares the refined model on the check runs, averaged as they were; without any on the fitted runs, and says so."""
    files, check = f"data.files=[{recordings / 'a.csv'},{recordings / 'b.csv'}]", f"data.check_files=[{recordings / 'check.csv'}]"
    for more, names in (([check, "data.average_s=200"], {"check"}), ([], {"a", "b"})):
        out = tmp_path / f"refined ({len(more)})"
        assert run("refine", ["add=warm_up", "candidates=[warm_up]", files, *more, f'hydra.run.dir="{out}"']) == 0
        told = capsys.readouterr().out
        assert (f"  {FITTED}" in told.splitlines()) == (not more)
        assert FITTED.startswith("#"), "for the shell a comment"
        command = pasted(told)
        assert run("compare", [*command, f'hydra.run.dir="{out}/compared"']) == 0
        assert ("All of these runs were fitted" in capsys.readouterr().out) == (not more)
        document = json.loads((out / "compared" / "comparison.json").read_text())
        assert {one["run"] for one in document["runs"]} == names
        refinement = json.loads((out / "refinement.json").read_text())
        assert document["average_s"] == (200 if more else refinement["average_s"])
        kept = _about(load_saved(out), [])["trained_on"]
        assert {key: kept[key] for key in ("rms", "rms_check")} == {key: refinement["ladder"][-1][key] for key in ("rms", "rms_check")}


@pytest.mark.parametrize("check", [False, True])
def test_what_was_held_out_is_all_that_the_next_command_judges(recordings, tmp_path, capsys, check) -> None:
    """The RMS is that of refine's own check; pieces of another size were fitted, and so were those of a model that saw all of the run."""
    out, files = tmp_path / "refined", [f"data.files=[{recordings / 'a.csv'}]", "data.holdout=0.3"]
    files += [f"data.check_files=[{recordings / 'check.csv'}]"] if check else []
    assert run("refine", ["add=warm_up", "candidates=[warm_up]", *files, f"hydra.run.dir={out}"]) == 0
    told = capsys.readouterr().out
    assert FITTED not in told
    command = pasted(told)
    assert run("compare", [*command, f"hydra.run.dir={out}/compared"]) == 0
    document = json.loads((out / "compared" / "comparison.json").read_text())
    assert [one["run"] for one in document["runs"]] == ["a (held out)", *(["check"] if check else [])]
    assert document["methods"][0]["fitted_runs"] == []
    assert document["methods"][0]["rms"]["median"] == pytest.approx(
        json.loads((out / "refinement.json").read_text())["ladder"][-1]["rms_check"], rel=1e-6
    )
    for share, fitted in (("0.3", []), ("0.5", ["a (held out)"])):
        asked = [f"runs=[{out}]", f"data.files=[{recordings / 'a.csv'}]", f"data.holdout={share}", f"hydra.run.dir={tmp_path / share}"]
        assert run("compare", asked) == 0
        assert json.loads((tmp_path / share / "comparison.json").read_text())["methods"][0]["fitted_runs"] == fitted
    capsys.readouterr()
    assert run("compare", [f"runs=[{out}]", f"data.files=[{recordings / 'a.csv'}]", f"hydra.run.dir={tmp_path / 'whole'}"]) == 0
    assert "or data.holdout=0.3, which the fit left out" in " ".join(capsys.readouterr().out.split())


def test_a_folder_used_again_holds_nothing_of_the_model_before(recordings, tmp_path) -> None:
    assert train(recordings, tmp_path, "model=bp", "seeds=2", "epochs=5") == 0
    assert run("export", [f"run={tmp_path}", f"hydra.run.dir={tmp_path}"]) == 0
    exported = {"model.ts", "model.pt2", "step.pt2", "metadata.json"}
    assert exported | {"members.pt", "metrics.json"} <= {path.name for path in tmp_path.iterdir()}
    assert train(recordings, tmp_path, "model=polynomial") == 0
    assert not (exported | {"members.pt"}) & {path.name for path in tmp_path.iterdir()}
    (only,) = find_entrants([str(tmp_path)])[0]
    assert only.kind == "polynomial"
    files = [f"data.files=[{recordings / 'a.csv'},{recordings / 'b.csv'}]", "data.average_s=100"]
    assert run("refine", [*files, "effects=[static_bias]", "add=[mohr]", "candidates=[mohr]", f"hydra.run.dir={tmp_path}"]) == 0
    assert not {"metrics.json", "last.ckpt", "prediction.png"} & {path.name for path in tmp_path.iterdir()}
    assert load_saved(tmp_path).facts["ladder"][-1]["added"] == "mohr"
    assert train(recordings, tmp_path, "model=polynomial") == 0
    assert not (tmp_path / "refinement.json").exists()
    assert {"last.ckpt", "prediction.png"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.parametrize("continuous", ["true", "false"])
def test_segments_of_temperature_alone_are_trained_by_any_route_and_exported(recordings, tmp_path, continuous) -> None:
    model = ["model=piecewise_polynomial", "model.features=[temperature]", "model.segments=3", f"model.continuous={continuous}"]
    assert train(recordings, tmp_path / "lm", *model, "optimizer=levenberg_marquardt", "epochs=5") == 0
    assert train(recordings, tmp_path / "own", *model) == 0
    assert run("export", [f"run={tmp_path / 'own'}", f"hydra.run.dir={tmp_path / 'out'}"]) == 0


def test_a_fit_of_mean_features_that_bends_within_blocks_is_told(recordings, tmp_path, capsys) -> None:
    """A dual solution knows a block by its mean features alone; all others know its samples."""
    files = [f"data.files=[{recordings / 'a.csv'},{recordings / 'b.csv'}]", "data.average_s=1200"]
    by_steps, powers = ["optimizer=levenberg_marquardt", "epochs=200"], ["model.order=12", "model.rate_order=12", "data.average_s=600"]
    for model in ("ls_svm", "takagi_sugeno", "polynomial", "bp"):
        capsys.readouterr()
        extra = {"bp": by_steps, "polynomial": [*by_steps, *powers]}.get(model, [])
        assert run("train", [f"model={model}", *files, *extra, f"hydra.run.dir={tmp_path / model}"]) == 0
        assert ("bends within blocks" in capsys.readouterr().err) is (model == "ls_svm"), model


def test_check_runs_beyond_what_was_fitted_and_models_that_are_worse_than_none_are_told(recordings, tmp_path, capsys) -> None:
    assert train(recordings, tmp_path / "within", "model=polynomial") == 0
    assert capsys.readouterr().err == ""
    assert json.loads((tmp_path / "within" / "metrics.json").read_text())["beyond"] == {}

    files = [f"data.files=[{recordings / 'check.csv'}]", f"data.check_files=[{recordings / 'a.csv'}]", "data.average_s=100"]
    assert run("train", ["model=polynomial", "model.order=6", *files, f"hydra.run.dir={tmp_path / 'farther'}"]) == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "temperature_c is 20.0 … 60.0 there, 20.0 … 40.0 in the fitted runs; temperature_rate is " in told
    assert "; there the model extrapolates" in told
    assert "on the check runs the model leaves" in told, "a power of six at twice the range"
    found = json.loads((tmp_path / "farther" / "metrics.json").read_text())["beyond"]
    assert list(found) == ["temperature_c", "temperature_rate"]
    assert 0.48 < found["temperature_c"]["share"] < 0.5, "above 40 °C from 1.5 to 3.5 h of 4"

    assert train(recordings, tmp_path / "wild", "model=bp", "epochs=20", "optimizer.lr=1e3") == 0
    assert "on the fitted runs the model leaves > 999× the RMS of no model at all; a smaller step" in " ".join(capsys.readouterr().err.split())


def test_programs_of_an_earlier_export_do_not_stay_beside_another_models_script(recordings, tmp_path) -> None:
    assert train(recordings, tmp_path / "line", "model=polynomial") == 0
    for program in ("true", "false"):
        assert run("export", [f"run={tmp_path / 'line'}", f"program={program}", f"hydra.run.dir={tmp_path / 'out'}"]) == 0
        assert (tmp_path / "out" / "model.pt2").exists() == (tmp_path / "out" / "step.pt2").exists() == (program == "true")


def test_a_later_command_in_a_models_folder_does_not_pass_for_the_one_that_made_it(recordings, tmp_path) -> None:
    for name, lr in (("a", ["optimizer.lr=0.1"]), ("b", ["optimizer.lr=0.2"]), ("c", [])):
        assert train(recordings, tmp_path / name, "model=bp", "epochs=5", *lr) == 0
    assert {one.name for one in named(find_entrants([str(tmp_path / "*")])[0])} == {"bp_lr0.1", "bp_lr0.2", "bp"}
    files = f"data.files=[{recordings / 'check.csv'}]"
    assert run("compensate", [f"run={tmp_path / 'a'}", files, f"hydra.run.dir={tmp_path / 'a'}"]) == 0
    settings = next(iter(find_entrants([str(tmp_path / "a")])[0])).settings
    assert settings["_target_"] == "zoo.models.bp.BP", "the model's own, no settings of compensate"
    assert "run" not in settings
    assert run("export", [f"run={tmp_path / 'a'}", f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    assert set(json.loads((tmp_path / "out" / "metadata.json").read_text())["parity"]["runs"]) == {"a made-up run"}, "check.csv trained nothing"


def test_a_model_that_takes_the_output_where_the_input_never_changes_is_told(recordings, tmp_path, capsys) -> None:
    assert train(recordings, tmp_path, "model=polynomial", "model.features=[temperature,output]", "epochs=7") == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "the true input never changes in the fitted runs" in told
    assert "epochs was of no use: optimizer=least_squares ends by itself" in told


def test_a_swarm_that_fits_by_itself_says_what_is_of_no_use(recordings, tmp_path, capsys) -> None:
    settings = ["model=polynomial", "optimizer=pso", "optimizer.steps=3", "optimizer.particles=5"]
    assert train(recordings, tmp_path, *settings, "epochs=7", "init=aco") == 0
    told = " ".join(capsys.readouterr().err.split())
    assert "epochs was of no use: optimizer=pso goes by optimizer.steps" in told
    assert "init was of no use: optimizer=pso needs no start" in told
    assert train(recordings, tmp_path, *settings) == 0
    assert "of no use" not in capsys.readouterr().err


def test_as_many_weights_as_blocks_fit_anything_and_that_is_said(recordings, tmp_path, capsys) -> None:
    for hidden, doubted in ((100, True), (9, False)):
        assert train(recordings, tmp_path, "model=bp", f"model.hidden={hidden}", "epochs=1") == 0
        assert ("weights were fitted to 288 block means" in " ".join(capsys.readouterr().err.split())) == doubted


def test_seeds_that_change_nothing_are_all_alike(recordings, tmp_path, capsys) -> None:
    assert train(recordings, tmp_path, "model=polynomial", "seeds=2") == 0
    assert "2 seeds, all alike" in " ".join(capsys.readouterr().out.split())


def test_tensorboard_tells_trainings_apart_by_their_settings(recordings, tmp_path) -> None:
    assert train(recordings, tmp_path, "model=bp", "model.hidden=3", "epochs=4", "seeds=2", "optimizer.lr=0.02") == 0
    events = EventAccumulator(str(tmp_path / "tensorboard"))
    events.Reload()
    kept = events.summary_metadata["_hparams_/session_start_info"].plugin_data.content
    told = HParamsPluginData.FromString(kept).session_start_info.hparams
    best = json.loads((tmp_path / "metrics.json").read_text())["members"]["best_seed"]
    found = {key: told[key].number_value for key in ("model.hidden", "epochs", "seeds", "optimizer.lr", "seed")}
    assert found == {"model.hidden": 3, "epochs": 4, "seeds": 2, "optimizer.lr": 0.02, "seed": best}
    assert "loss/fit" in events.Tags()["scalars"]
    assert "epoch" not in events.Tags()["scalars"], "Lightning's, of many steps each"


def test_a_recording_without_any_error_is_no_reason_to_fail(recordings, tmp_path) -> None:
    """Its RMS is 0, by which nothing can be divided."""
    header, *rows = (recordings / "check.csv").read_text().splitlines()
    perfect = [f"{row},{row.rpartition(',')[2]}" for row in rows]
    (tmp_path / "perfect.csv").write_text("\n".join([f"{header},reference_dph", *perfect]) + "\n")
    files = [f"data.files=[{recordings / 'a.csv'}]", f"data.check_files=[{tmp_path / 'perfect.csv'}]", "data.average_s=100", "data.reference=0"]
    assert run("train", ["model=polynomial", *files, f"hydra.run.dir={tmp_path / 'line'}"]) == 0
    asked = [f"run={tmp_path / 'line'}", f"data.files=[{tmp_path / 'perfect.csv'}]", f"hydra.run.dir={tmp_path / 'out'}"]
    assert run("compensate", asked) == 0
    assert (tmp_path / "out" / "compensation.json").is_file()


def test_runs_at_different_constant_inputs_tell_the_output_from_the_error(recordings, tmp_path, capsys) -> None:
    files = []
    for name, rate in (("a", 0.0), ("b", 100.0)):
        header, *rows = (recordings / f"{name}.csv").read_text().splitlines()
        turned = [f"{row.rpartition(',')[0]},{float(row.rpartition(',')[2]) + rate:.6f},{rate}" for row in rows]
        (tmp_path / f"{name}.csv").write_text("\n".join([f"{header},reference_dph", *turned]) + "\n")
        files.append(str(tmp_path / f"{name}.csv"))
    asked = ["model=polynomial", "model.features=[temperature,output]", f"data.files=[{','.join(files)}]", "data.average_s=100"]
    assert run("train", [*asked, f"hydra.run.dir={tmp_path / 'out'}"]) == 0
    assert "never changes" not in capsys.readouterr().err
