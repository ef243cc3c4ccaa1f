"""Rows of the page's tables, every number already written."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from zoo.report.floors import Floors, excess
from zoo.report.trace import Trace, rms
from zoo.report.verdict import Record, Rung, missing
from zoo.report.wording import NONE, Scale, finite, fixed, joined, percent, significant, times
from zoo.units import convert, own_time

LIKELY = 0.01
"""Candidates less probable than this are folded away."""


@dataclass(frozen=True)
class CandidateRow:
    """One candidate: what is shown at once, and what unfolds."""

    effect: str
    probability: str
    width: str
    rms: str
    rms_cross_validated: str
    delta_bic: str
    twins: list[str]
    parameters: list[tuple[str, str, str]]
    facts: list[tuple[str, str]]
    tag: str
    likely: bool

    @property
    def needed(self) -> bool:
        """Whether it belongs into the model."""
        return bool(self.tag)


def hours(seconds: Any) -> str:
    """Seconds as hours with two decimals."""
    number = finite(seconds)
    return NONE if number is None else fixed(convert(number, "s", "h"), 2)


def celsius(pair: Any) -> str:
    """``20.0`` or ``20.0 … 60.0``."""
    texts = [fixed(value, 1) for value in pair or []]
    return NONE if not texts else texts[0] if texts[0] == texts[-1] else f"{texts[0]} … {texts[-1]}"


def span(region: Record) -> tuple[float | None, float | None]:
    """Where a region begins and ends, as its run's reader counts [s]."""
    start = finite(region.get("start_s")) or 0.0
    begin, end = (None if time is None else float(own_time(time, start)) for time in (finite(region.get("from_s")), finite(region.get("to_s"))))
    return begin, end


def region_rows(where: list[Record], scale: Scale, floors: Floors | None = None) -> list[list[str]]:
    """Rank, run, stage, from [h], to [h], temperature [°C], rms, multiple of the noise floor: of these, or else of the diagnosis' own."""
    return [
        [
            str(rank),
            str(region.get("run") or NONE),
            str(region.get("stage") or NONE),
            *map(hours, span(region)),
            celsius(region.get("temperature_c")),
            scale.text(region.get("rms")),
            times(excess(region.get("rms"), floors.of("fit", str(region.get("run")))) if floors else region.get("excess")),
        ]
        for rank, region in enumerate(where, 1)
    ]


def parameter_rows(parameters: Any, scale: Scale) -> list[tuple[str, str, str]]:
    """Name, value ± standard error, unit."""
    found = parameters.items() if isinstance(parameters, dict) else ()
    asked = ("value", "stderr", "unit", "at_bound")
    return [(str(name), *scale.parameter(*map(p.get, asked))) for name, p in found if isinstance(p, dict)]


def candidate_rows(diagnosis: Record, scale: Scale, added: list[str] | None = None) -> list[CandidateRow]:
    """All candidates, best first; `added` are those that a refinement has put into the model."""
    tags = dict.fromkeys(missing(diagnosis), "helps" if diagnosis.get("verdict") == "unknown" else "to add")
    tags |= dict.fromkeys(added or [], "added")
    return [_candidate_row(entry, scale, tags.get(str(entry.get("effect")), "")) for entry in diagnosis.get("candidates") or []]


def _candidate_row(entry: Record, scale: Scale, tag: str) -> CandidateRow:
    chance = finite(entry.get("probability"))
    return CandidateRow(
        effect=str(entry.get("effect") or NONE),
        probability=percent(chance),
        width=f"{100 * min(max(chance or 0.0, 0.0), 1.0):.1f}%",
        rms=scale.text(entry.get("rms")),
        rms_cross_validated=scale.text(entry.get("rms_cross_validated")),
        delta_bic=_bic(entry.get("delta_bic")),
        twins=[str(name) for name in entry.get("indistinguishable_from") or []],
        parameters=parameter_rows(entry.get("parameters"), scale),
        facts=_facts(entry),
        tag=tag,
        likely=bool(tag) or (chance or 0.0) >= LIKELY,
    )


def _bic(value: Any) -> str:
    number = finite(value)
    return NONE if number is None else f"{'+' if round(number) > 0 else ''}{fixed(number, 0)}"


def _facts(entry: Record) -> list[tuple[str, str]]:
    columns = entry.get("columns")
    listed = joined(columns) if isinstance(columns, (list, tuple)) else columns
    facts = [("How it looks", entry.get("explanation")), ("Formula", entry.get("formula"))]
    facts += [("Where it acts", entry.get("place")), ("Columns", listed)]
    if entry.get("refitted") is False:
        facts.append(("Numbers", "from the screening, without refitting the rest of the model"))
    return [(label, str(text)) for label, text in facts if text]


def ladder_rows(rungs: list[Rung], scale: Scale, floors: Floors) -> list[list[str]]:
    """What was added, RMS and multiple of the noise floor on the fitted and on the check runs."""
    rows = []
    for rung in rungs:
        fitted = [scale.text(rung.rms), times(excess(rung.rms, floors.of("fit")))]
        checked = [scale.text(rung.rms_check), times(excess(rung.rms_check, floors.of("check")))]
        rows.append([f"+\u00a0{rung.added}" if rung.added else "as it stands", *fitted, *checked])
    return rows


def run_rows(traces: list[Trace], scale: Scale) -> list[list[str]]:
    """Name, role, blocks, hours, temperature [°C], fastest ramp [K/min], RMS of error, residual, residual after adding."""
    return [
        [
            trace.run,
            "fitted" if trace.role != "check" else "held out" if trace.held_out else "check",
            f"{len(trace.time_s)}",
            fixed(trace.hours[-1] - trace.hours[0], 1) if len(trace.time_s) else NONE,
            celsius(_range(trace.temperature_c)),
            significant(_largest(trace.rate_k_per_min), 2),
            scale.text(rms(trace.error)),
            scale.text(rms(trace.residual)),
            scale.text(rms(trace.residual_after)),
        ]
        for trace in traces
    ]


def _range(values: np.ndarray) -> list[float]:
    known = values[np.isfinite(values)]
    return [float(known.min()), float(known.max())] if known.size else []


def _largest(values: np.ndarray) -> float | None:
    known = np.abs(values[np.isfinite(values)])
    return float(known.max()) if known.size else None
