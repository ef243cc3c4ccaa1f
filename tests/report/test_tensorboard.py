"""TensorBoard reads back what was found."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from zoo.report.tensorboard import write_events
from zoo.report.trace import Trace

Record = dict[str, Any]


def read(folder: Path) -> EventAccumulator:
    events = EventAccumulator(str(folder), size_guidance={"images": 0})
    events.Reload()
    return events


def test_ladder_and_probabilities(tmp_path: Path, diagnosis: Record, traces: list[Trace], refinement: Record) -> None:
    write_events(tmp_path, diagnosis, traces, refinement)
    events = read(tmp_path)
    assert [event.value for event in events.Scalars("rms/check")] == pytest.approx([0.074, 0.0088])
    assert [event.step for event in events.Scalars("rms/fit")] == [0, 1]
    assert events.Scalars("probability/hysteresis")[0].value == pytest.approx(0.983)
    assert {"ladder"} < set(events.Tags()["images"])
    assert events.Images("ladder")[0].encoded_image_string.startswith(b"\x89PNG")


def test_nothing_known(tmp_path: Path, diagnosis: Record) -> None:
    write_events(tmp_path, dict.fromkeys(diagnosis), [])
    assert read(tmp_path).Tags()["scalars"] == []
