"""Every drawing of the page, ready to be placed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from zoo.report.canvas import inline_svg
from zoo.report.floors import Floors, multiple
from zoo.report.ladder_figure import ladder_figure, program_figure
from zoo.report.palette import styled
from zoo.report.scatter_figure import residual_against_rate, residual_against_temperature
from zoo.report.tables import span
from zoo.report.time_figure import Shade, time_figure
from zoo.report.trace import Trace, rms, worst_first
from zoo.report.verdict import Rung
from zoo.report.wording import Scale, Sides, finite
from zoo.side_by_side import side_by_side
from zoo.units import convert

RUNS_DRAWN = 8
"""More runs make the page slow; the worst are drawn."""
SHADED = 6
WORTH_SHADING = 1.5
"""A region whose RMS is closer to the noise floor does not fail."""


@dataclass(frozen=True)
class RunDrawings:
    """The three drawings of one run, and its caption."""

    trace: Trace
    caption: str
    over_time: Markup
    over_temperature: Markup
    over_rate: Markup


def drawn(traces: list[Trace]) -> list[Trace]:
    """The runs that get drawings: all, or the worst of many, in the given order."""
    chosen = {id(trace) for trace in worst_first([trace for trace in traces if len(trace.time_s)])[:RUNS_DRAWN]}
    return [trace for trace in traces if id(trace) in chosen]


def shades(where: list[dict[str, Any]], run: str) -> list[Shade]:
    """The worst regions of one run, numbered as in the table of all."""
    found = []
    for rank, region in enumerate(where[:SHADED], 1):
        (start, end), ratio = span(region), finite(region.get("excess"))
        if region.get("run") == run and start is not None and end is not None and (ratio or 0.0) >= WORTH_SHADING:
            found.append(Shade(rank, convert(start, "s", "h"), convert(end, "s", "h")))
    return found


def run_drawings(traces: list[Trace], where: list[dict[str, Any]], scale: Scale, floors: Floors, sides: Sides) -> list[RunDrawings]:
    """Draw runs, one drawing beside the other.

    Args:
        traces: the runs.
        where: the diagnosis' regions, worst first.
        scale: how values are written.
        floors: the noise floors of all runs.
        sides: what the two models are called.
    """
    own = [floors.of(trace.role, trace.run) for trace in traces]
    captions = [_caption(trace, scale, floor, sides) for trace, floor in zip(traces, own, strict=True)]

    def drawing(item: tuple[str, int]) -> Markup:
        kind, i = item
        trace, look = traces[i], (scale, own[i], sides)
        with styled(f"r{i}{kind}"):
            if kind == "time":
                return inline_svg(time_figure(trace, shades(where, trace.run), *look), f"{trace.run} against time. {captions[i]}")
            against = residual_against_temperature if kind == "temperature" else residual_against_rate
            what = "temperature" if kind == "temperature" else "temperature rate"
            return inline_svg(against(trace, *look), f"{trace.run}: residual against {what}, by stage")

    longest_first = [(kind, i) for kind in ("time", "temperature", "rate") for i in range(len(traces))]
    drawn = dict(zip(longest_first, side_by_side(drawing, longest_first), strict=True))
    return [RunDrawings(trace, captions[i], drawn["time", i], drawn["temperature", i], drawn["rate", i]) for i, trace in enumerate(traces)]


def _caption(trace: Trace, scale: Scale, floor: float | None, sides: Sides) -> str:
    now, after = rms(trace.residual), rms(trace.residual_after)
    if after is None:
        return f"RMS of the residual {_written(now, scale, floor)}"
    return f"RMS of the residual {sides.stands} {_written(now, scale, floor)}; {sides.added} {_written(after, scale, floor)}"


def _written(value: float | None, scale: Scale, floor: float | None) -> str:
    return ", ".join(part for part in (scale.full(value), multiple(value, floor)) if part)


def ladder_drawing(rungs: list[Rung], scale: Scale, floors: Floors) -> Markup | None:
    """The ladder, or None where nothing is known."""
    if not rungs:
        return None
    steps = "; ".join(f"{rung.added or 'as it stands'}: {scale.full(rung.rms)}" for rung in rungs)
    with styled("ladder"):
        return inline_svg(ladder_figure(rungs, scale, floors), f"RMS as effects are added. {steps}; noise floor {scale.full(floors.fitted)}")


def program_drawing(profile: Any) -> Markup | None:
    """The chamber program of the next experiment, where it is given as legs."""
    legs = profile.get("legs") if isinstance(profile, dict) else None
    if not isinstance(legs, list) or not legs or not all(isinstance(leg, (list, tuple)) and len(leg) == 3 for leg in legs):
        return None
    with styled("program"):
        return inline_svg(program_figure(legs), f"Chamber program of {len(legs)} legs")
