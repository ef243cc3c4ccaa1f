"""A dozen lines that fit, and that can be piped."""

from __future__ import annotations

import io
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
    assert "RMS 0.0710 deg/h" in printed(diagnosis, encoding="ascii")


def test_short_enough_to_stay_on_the_screen(diagnosis: Record) -> None:
    assert len(printed(diagnosis).splitlines()) <= 20


def test_names_are_no_markup(diagnosis: Record) -> None:
    diagnosis["candidates"][0]["effect"] = diagnosis["missing"][0] = "[red]x[/red]"
    assert "[red]x[/red]" in printed(diagnosis)


def test_an_empty_diagnosis(diagnosis: Record) -> None:
    text = printed(dict.fromkeys(diagnosis))
    assert "No verdict" in text
    assert "None" not in text


@pytest.mark.parametrize("width", [50, 80])
def test_the_ladder(refinement: Record, width: int) -> None:
    stream = io.StringIO()
    print_ladder(refinement, console=Console(file=stream, width=width, highlight=False))
    text = stream.getvalue()
    assert "The model is complete with hysteresis added" in text
    assert "+\u00a0hysteresis" in text
    assert "0.0088" in text
    assert max(map(len, text.splitlines())) <= width


def test_an_empty_ladder() -> None:
    stream = io.StringIO()
    print_ladder({"verdict": "unknown", "ladder": []}, console=Console(file=stream, width=80))
    assert "None" not in stream.getvalue()
