"""A dozen lines that fit, and that can be piped."""

from __future__ import annotations

import io
import re
from typing import Any

import pytest
from rich.console import Console

from zoo.report.terminal import print_diagnosis, print_ladder

COMMAND = "fogzoo refine effects=[static_bias,shupe,mohr] add=hysteresis data.files=[a_rather_long_folder/run_1.csv,a_rather_long_folder/run_2.csv]"
Record = dict[str, Any]


def printed(diagnosis: Record, width: int = 80, encoding: str = "utf-8", **keywords: Any) -> str:
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    print_diagnosis(diagnosis, [COMMAND], Console(file=stream, width=width, highlight=False, **keywords))
    stream.flush()
    return stream.buffer.getvalue().decode(encoding)  # type: ignore[attr-defined]


@pytest.mark.parametrize("width", [50, 72, 80, 120])
def test_nothing_but_commands_is_wider_than_the_terminal(diagnosis: Record, width: int) -> None:
    lines = printed(diagnosis, width).splitlines()
    assert [line for line in lines if len(line) > width] == [f"  {COMMAND}"]
    assert any("hysteresis" in line and "98 %" in line and "0.0083" in line for line in lines)


def test_plain_where_nobody_watches(diagnosis: Record) -> None:
    assert "\x1b" not in printed(diagnosis)
    assert "\x1b" in printed(diagnosis, force_terminal=True)


def test_a_terminal_that_knows_only_ascii(diagnosis: Record) -> None:
    assert "means 0.0710 deg/h" in printed(diagnosis, encoding="ascii")


def test_short_enough_to_stay_on_the_screen(diagnosis: Record) -> None:
    assert len(printed(diagnosis).splitlines()) <= 20


def test_how_large_what_is_missing_is_unless_it_is_not_what_it_is_called(diagnosis: Record) -> None:
    found = {"amplitude": {"value": 0.0612, "stderr": 0.0041, "unit": "dph"}, "order": {"value": 2.0, "stderr": None, "unit": "1"}}
    found |= {"goes_on": {"value": 0.0, "stderr": None, "unit": "1"}}
    known = diagnosis | {"parameters": {"hysteresis": found, "shupe": found}}
    lines = [line.strip() for line in printed(known).splitlines()]
    assert [line for line in lines if "amplitude" in line] == ["hysteresis: amplitude 0.0612 ± 0.0041 °/h, order 2.00"]
    outdone = known | {"verdict": "unknown", "outdone": True}
    assert "amplitude" not in printed(outdone)
    assert "Adding hysteresis (98 %) helps, but a function of one quantity does as well with fewer parameters." in " ".join(printed(outdone).split())


def test_what_the_runs_want_beyond_its_bounds_is_no_value_of_the_gyros(diagnosis: Record, refinement: Record) -> None:
    found = {"width": {"value": 20.0, "stderr": 0.24, "unit": "K", "at_bound": "high"}, "spread": {"value": 40.0, "stderr": 3.0, "unit": "K"}}
    words = "The runs ask more of hysteresis than is plausible (width ≥ 20.0 K): it may stand in for another effect"
    told = printed(diagnosis | {"parameters": {"hysteresis": found, "shupe": found}}, width=200)
    assert words in told
    assert "more of shupe" not in told
    assert "hysteresis: width ≥ 20.0 K, spread 40.0 ± 3.0 K" in told
    stream = io.StringIO()
    print_ladder(refinement | {"parameters": {"hysteresis": found}}, console=Console(file=stream, width=200, highlight=False))
    assert words in stream.getvalue()


def test_the_ladder_says_how_large_what_was_added_is(diagnosis: Record) -> None:
    steps = [{"added": name, "effects": [], "rms": rms, "rms_check": rms} for name, rms in ((None, 0.07), ("hysteresis", 0.01))]
    found = {"amplitude": {"value": 0.0612, "stderr": 0.0041, "unit": "dph"}}
    record = {"verdict": "unknown", "unit": "dph", "noise_floor": 0.01, "ladder": steps, "parameters": {"hysteresis": found}}
    for outdone, value, words in ((False, "amplitude 0.0612 ± 0.0041 °/h", "is not noise"), (True, "", "with fewer parameters")):
        stream = io.StringIO()
        print_ladder(record | {"outdone": outdone}, console=Console(file=stream, width=120, highlight=False))
        assert words in stream.getvalue()
        assert ("amplitude" in stream.getvalue()) is bool(value)
        assert value in stream.getvalue()


def test_names_are_no_markup(diagnosis: Record) -> None:
    diagnosis["candidates"][0]["effect"] = diagnosis["missing"][0] = "[red]x[/red]"
    assert "[red]x[/red]" in printed(diagnosis)


def test_what_reading_noticed_and_how_long_the_means_are(diagnosis: Record) -> None:
    diagnosis |= {"average_s": 50.0, "notes": [f"{len(diagnosis['runs'])} gap(s) in time", *(f"{run}: is hot" for run in diagnosis["runs"])]}
    text = " ".join(printed(diagnosis).split())
    assert "RMS of 50 s means 0.0710 °/h" in text
    assert "gap(s) in time" in text
    assert text.count("is hot") == 1, "the same of several runs is one note"


def test_what_was_asked_for_is_noticed_last(diagnosis: Record) -> None:
    routine = [f"{name} is converted from K to °C" for name in "abcdef"]
    text = " ".join(printed({**diagnosis, "notes": [*routine, "2 gaps in time"]}).split())
    assert text.index("2 gaps in time") < text.index("a is converted")
    assert "f is converted" not in text, "no more than a few"


def test_a_recorder_that_counts_from_an_epoch_is_read_from_the_runs_start(diagnosis: Record) -> None:
    plain = printed(diagnosis)
    for region in diagnosis["where"]:
        region |= {"from_s": region["from_s"] + 1.7e9, "to_s": region["to_s"] + 1.7e9, "start_s": 1.7e9}
    assert printed(diagnosis) == plain


def test_an_empty_diagnosis(diagnosis: Record) -> None:
    text = printed(dict.fromkeys(diagnosis))
    assert "No verdict" in text
    assert "None" not in text


def test_alternatives_where_the_first_is_in_doubt(diagnosis: Record) -> None:
    doubt = [("missing", ["hysteresis"], 0.55), ("missing", ["aging", "hysteresis"], 0.3), ("complete", [], 0.1), ("unknown", [], 0.04)]
    diagnosis["posterior"] = [{"hypothesis": kind, "effects": names, "probability": chance} for kind, names, chance in doubt]
    text = " ".join(printed(diagnosis).split())
    assert "missing: hysteresis 55 %; hysteresis and aging 30 %; nothing 10 %; something unknown 4 %" in text
    diagnosis["posterior"][0]["probability"] = 0.95
    assert "missing: hysteresis" not in printed(diagnosis)


@pytest.mark.parametrize("width", [50, 80])
def test_the_next_experiment_and_how_to_try_it(diagnosis: Record, width: int) -> None:
    command = f"fogzoo simulate hidden=aging 'profile.legs=[{','.join(['[20,60,3600]'] * 20)}]'"
    found: Record = {"separates": ["aging", "warm_up"], "name": "a day of rest", "duration_s": 86400.0, "expected_evidence": 12.0, "command": command}
    text = printed({**diagnosis, "next_experiment": found}, width)
    assert "next experiment, to separate aging and warm_up: a day of rest (24.0 h, log Bayes factor 12)" in " ".join(text.split())
    assert [line for line in text.splitlines() if len(line) > width] == [f"  {COMMAND}", f"  {command}"]
    assert "next experiment" not in printed(diagnosis, width)
    found["command"] = command * 10
    text = " ".join(printed({**diagnosis, "next_experiment": found}, width).split())
    assert "log Bayes factor 12); the command that tries it stands in the report" in text
    assert "fogzoo simulate" not in text


LONG = ["aging", "bias_step", "polarization", "rate_temperature_coupling", "sensor_lag", "warm_up"]


@pytest.mark.parametrize("width", [60, 72, 80, 100])
@pytest.mark.parametrize("verdict", ["missing", "unknown"])
def test_names_and_numbers_are_whole_however_many_cannot_be_told_apart(diagnosis: Record, width: int, verdict: str) -> None:
    diagnosis["verdict"] = verdict
    diagnosis["candidates"][1].update(effect="rate_temperature_coupling", probability=0.42)
    for entry in diagnosis["candidates"]:
        entry["indistinguishable_from"] = [name for name in LONG if name != entry["effect"]]
    lines = printed(diagnosis, width).splitlines()
    assert max(len(line) for line in lines if COMMAND not in line) <= width
    assert any(re.search(r"^  hysteresis .* 98 % +0\.0083", line) for line in lines)
    assert any(re.search(r"^  rate_temperature_coupling .* 42 % +0\.0400", line) for line in lines)
    assert "…" not in "".join(line for line in lines if "run_1" not in line)  # only the range of temperatures
    assert ("not told apart: rate_temperature_coupling from aging" in " ".join(lines)) == (verdict == "missing")
    assert ("not told apart: hysteresis from aging" in " ".join(lines)) == (verdict == "unknown")


def test_all_columns_where_there_is_room(diagnosis: Record) -> None:
    assert "cross-val." in printed(diagnosis, 80)
    assert "from [h]" in printed(diagnosis, 80)
    assert "cross-val." not in printed(diagnosis, 50)


def test_powers_and_prefixes_in_ascii(diagnosis: Record) -> None:
    diagnosis.update(unit="rad_per_s", rms=3.4e-5, noise_floor=3.9e-6)
    assert "means 34.0 urad/s" in printed(diagnosis, encoding="ascii")
    diagnosis.update(unit="dph", rms=3.4e-7, noise_floor=3.9e-8)
    assert "means 340 10-9 deg/h" in printed(diagnosis, encoding="ascii")


@pytest.mark.parametrize("width", [50, 80])
def test_the_ladder(refinement: Record, width: int) -> None:
    stream = io.StringIO()
    print_ladder(refinement, console=Console(file=stream, width=width, highlight=False))
    text = stream.getvalue()
    assert "The model is complete with hysteresis added" in text
    assert "+\u00a0hysteresis" in text
    assert "0.0088" in text
    assert "noise floor 0.0081 °/h, of the check runs 0.0084 °/h" in " ".join(text.split())
    assert max(map(len, text.splitlines())) <= width


def test_an_empty_ladder() -> None:
    stream = io.StringIO()
    print_ladder({"verdict": "unknown", "ladder": []}, console=Console(file=stream, width=80))
    assert "None" not in stream.getvalue()
