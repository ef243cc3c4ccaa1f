"""Three fitted runs and a check run of an invented gyro whose hysteresis the model lacks, and what a diagnosis would say of them."""

from __future__ import annotations

import re
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from zoo.report.trace import Trace

FLOOR, LOOP = 0.0081, 0.05


def _trace(run: str, role: str, blocks: int, seed: int) -> Trace:
    random = np.random.default_rng(seed)
    time = 100.0 * np.arange(blocks) + 50.0
    wave = np.clip(1.6 * np.sin(2 * np.pi * time / 36000.0 + seed), -1, 1)
    temperature, rate = 20.0 + 40.0 * wave, np.gradient(40.0 * wave, time) * 60
    kinds = np.where(rate > 0.05, "heating", np.where(rate < -0.05, "cooling", "hold"))
    kinds[::50] = "edge"
    known = 0.01 + 0.3 * rate - 0.002 * temperature
    loop = LOOP * np.convolve(np.sign(rate), np.ones(20) / 20, mode="same")
    noise = FLOOR * random.standard_normal(blocks)
    return Trace(run, role, time, temperature, rate, known + loop + noise, known, known + loop, [str(kind) for kind in kinds])


def _candidate(effect: str, probability: float, rms: float, delta_bic: float, **more: Any) -> dict[str, Any]:
    entry = {"effect": effect, "probability": probability, "rms": rms, "rms_cross_validated": 1.03 * rms, "delta_bic": delta_bic}
    return {**entry, "indistinguishable_from": [], "parameters": {}, **more}


@pytest.fixture(scope="session")
def traces() -> list[Trace]:
    return [_trace("run_1", "fit", 516, 1), _trace("run_2", "fit", 420, 2), _trace("run_3", "fit", 360, 3), _trace("check", "check", 301, 4)]


@pytest.fixture
def bare_traces(traces: list[Trace]) -> list[Trace]:
    return [replace(trace, refined=None) for trace in traces]


@pytest.fixture
def diagnosis(pristine: dict[str, Any]) -> dict[str, Any]:
    return deepcopy(pristine)


@pytest.fixture(scope="session")
def pristine() -> dict[str, Any]:
    width = {"width": {"value": 6.1, "stderr": 0.4, "unit": "K"}, "amplitude": {"value": 0.0497, "stderr": None, "unit": "dph"}}
    region = {"run": "run_2", "from_s": 0, "to_s": 3600, "stage": "hold", "temperature_c": [20, 20], "rms": 0.09, "excess": 11.2}
    return {
        "schema_version": 1,
        "effects": ["static_bias", "shupe", "mohr"],
        "unit": "dph",
        "average_s": 100,
        "runs": ["run_1", "run_2", "run_3"],
        "samples": 1296,
        "noise_floor": FLOOR,
        "rms": 0.071,
        "rms_final": 0.0083,
        "verdict": "missing",
        "missing": ["hysteresis"],
        "candidates": [
            _candidate("hysteresis", 0.983, 0.0083, -412.0, parameters=width, place="coil", formula="A·tanh((play(T) − c0)/s)", explanation="a loop"),
            _candidate("viscoelastic", 0.015, 0.04, -210.0, indistinguishable_from=["sensor_lag"], refitted=False),
            _candidate("aging", 0.0, 0.07, 8.0),
        ],
        "where": [region, {**region, "run": "run_1", "stage": "heating", "temperature_c": [20, 60], "excess": 4.0, "rms": 0.03}],
        "posterior": None,
        "effective_samples": None,
        "noise": None,
        "next_experiment": None,
        "notes": ["run_2: 3 spikes left out"],
        "undetermined": ["centre of hysteresis"],
        "not_tried": {"moisture": ["humidity_pct"]},
        "parameters": {"static_bias": {"c0": {"value": 0.01, "stderr": 1e-4, "unit": "dph/K"}}},
    }


@pytest.fixture
def refinement(diagnosis: dict[str, Any]) -> dict[str, Any]:
    first = {"added": None, "effects": diagnosis["effects"], "rms": 0.071, "rms_check": 0.074}
    second = {"added": "hysteresis", "effects": [*diagnosis["effects"], "hysteresis"], "rms": 0.0083, "rms_check": 0.0088}
    return {"unit": "dph", "ladder": [first, second], "noise_floor": FLOOR, "noise_floor_check": 0.0084, "verdict": "complete"}


class _Reader(HTMLParser):
    """Collects the visible text, and checks that elements are closed in order."""

    VOID = ("meta", "br", "link", "input")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.words: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        pass

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if not {"script", "style"} & set(self.open):
            self.words.append(data)


def _visible(page: str) -> str:
    reader = _Reader()
    reader.feed(page.replace("<wbr>", ""))
    assert reader.open == []
    text = " ".join(" ".join(reader.words).split())
    assert not re.search(r"\b(nan|NaN|None|inf|Infinity|null|Undefined)\b", text), text
    return text


@pytest.fixture(scope="session")
def visible() -> Callable[[str], str]:
    """The text of a page that somebody sees; in it nothing that is no number, and in the page no element that is left open."""
    return _visible
