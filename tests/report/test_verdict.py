"""What a refinement is worth on runs that were not fitted, in words."""

from __future__ import annotations

import pytest

from zoo.report.verdict import Record, verdict_of, worth_adding


def refined(checks: list[float | None], **more: object) -> Record:
    names = [None, "hysteresis", "polarization", "aging"][: len(checks)]
    rungs = [{"added": name, "effects": [], "rms": 0.1, "rms_check": check} for name, check in zip(names, checks, strict=True)]
    return {"ladder": rungs, "verdict": "unknown", "borne_out": False, **more}


@pytest.mark.parametrize(
    ("checks", "kept"),
    [
        ([0.2, 0.1, 0.05], None),  # falls to the end
        ([0.2, 0.1, 0.101], None),  # a rise too small to notice
        ([0.2, 0.1, 0.12, 0.15], ["hysteresis"]),
        ([0.2, 0.1, 0.08, 0.15], ["hysteresis", "polarization"]),
        ([0.2, 0.3], []),
        ([None, None], None),  # nothing was checked
        ([0.2], None),
    ],
)
def test_the_effects_that_the_check_runs_bear_out(checks, kept) -> None:
    assert worth_adding(refined(checks)) == kept


@pytest.mark.parametrize("more", [{}, {"borne_out": True}])
def test_the_reader_is_told_where_to_stop(more) -> None:
    said = verdict_of({}, refined([0.2, 0.1, 0.12], **more))
    assert said.kind == "unknown"
    assert any("best with hysteresis alone: stop there" in sentence for sentence in said.sentences)
    assert any("do without" in sentence for sentence in verdict_of({}, refined([0.2, 0.3], **more)).sentences)
    assert not any("stop" in sentence or "without" in sentence for sentence in verdict_of({}, refined([0.2, 0.1], **more)).sentences)
