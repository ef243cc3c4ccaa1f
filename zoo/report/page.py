"""The self-contained page that `diagnose` and `refine` write."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from zoo import __version__
from zoo.artifacts import write_text
from zoo.report import tables
from zoo.report.allan_figure import allan_drawing
from zoo.report.drawings import drawn, ladder_drawing, program_drawing, run_drawings, shades
from zoo.report.experiment import experiment_drawing, experiment_settings, separated
from zoo.report.floors import Floors, multiple
from zoo.report.limits import limit_rows
from zoo.report.notes import merged
from zoo.report.probable import hypothesis_rows, the_rest
from zoo.report.sampled import known_noise, sampled_facts
from zoo.report.template import filled
from zoo.report.trace import Trace, rms
from zoo.report.unknown_section import unknown_section
from zoo.report.unknown_words import unexplained
from zoo.report.verdict import Record, ladder, missing, rms_after, unfitted, verdict_of
from zoo.report.wording import DIAGNOSED, REFINED, Scale, finite, joined, names_in_model, significant

REGIONS_SHOWN = 8
REFINE = ("fogzoo", "refine")


def write_report(
    path: str | Path,
    diagnosis: Record,
    traces: list[Trace],
    refinement: Record | None = None,
    commands: Sequence[str] = (),
    refine: Sequence[str] = REFINE,
) -> None:
    """Write the page, whole or not at all.

    Args:
        path: of the page.
        diagnosis: the contract's `diagnosis.json`; any field may be null.
        traces: the runs, fitted and checked.
        refinement: the contract's `refinement.json`, where effects were added.
        commands: what to type next, best first.
        refine: the words of the command that refines, with the settings of the diagnosis, for the class that is written beside the page.
    """
    write_text(path, render(diagnosis, traces, refinement, commands, refine, Path(path).parent))


def render(
    diagnosis: Record,
    traces: list[Trace],
    refinement: Record | None = None,
    commands: Sequence[str] = (),
    refine: Sequence[str] = REFINE,
    folder: Path = Path(),
) -> str:
    """The page as text, see `write_report`; `folder` is where it will lie."""
    context = _context(diagnosis, traces, refinement, list(commands))
    unknown = unknown_section(diagnosis, scale_of(diagnosis, refinement), folder, refine, context["done"])
    return filled("template.html.j2", context | {"unknown": unknown})


def scale_of(diagnosis: Record, refinement: Record | None = None) -> Scale:
    """How this diagnosis writes the output's values."""
    unit = diagnosis.get("unit") or (refinement or {}).get("unit")
    return Scale.of(unit, Floors.read(diagnosis, refinement).fitted, diagnosis.get("rms"))


def _context(diagnosis: Record, traces: list[Trace], refinement: Record | None, commands: list[str]) -> dict[str, Any]:
    scale, floors = scale_of(diagnosis, refinement), Floors.read(diagnosis, refinement)
    where, pictured, done = diagnosis.get("where") or [], drawn(traces), bool(refinement and _added(diagnosis, refinement))
    sides = REFINED if done else DIAGNOSED
    return {
        "kind": "Refinement" if refinement else "Diagnosis",
        "done": done,
        "sides": sides,
        "verdict": verdict_of(diagnosis, refinement),
        "tiles": _tiles(diagnosis, traces, refinement, scale, floors),
        "commands": commands,
        "unit": scale.label,
        "runs": run_drawings(pictured, where, scale, floors, sides),
        "allan": allan_drawing(traces, known_noise(diagnosis), scale, sides),
        "undrawn": [trace.run for trace in traces if trace not in pictured],
        "regions": tables.region_rows(where, scale, floors if refinement and floors.fitted else None),
        "shaded": {str(shade.rank) for trace in pictured for shade in shades(where, trace.run)},
        "regions_shown": REGIONS_SHOWN,
        "hypotheses": hypothesis_rows(diagnosis),
        "the_rest": the_rest(diagnosis),
        "limits": limit_rows(diagnosis, scale),
        "candidates": tables.candidate_rows(diagnosis, scale, _added(diagnosis, refinement) if refinement else None),
        "effects": _effects(diagnosis, refinement, scale),
        "written": datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %Z"),
        "version": __version__,
        **_ladder_part(diagnosis, refinement, scale, floors),
        **_experiment_part(diagnosis, scale),
        **_read_part(diagnosis, traces, refinement, scale),
    }


def _added(diagnosis: Record, refinement: Record | None) -> list[str]:
    """Effects that were added, or else those that the diagnosis would add."""
    return [rung.added for rung in ladder(diagnosis, refinement) if rung.added] if refinement else missing(diagnosis)


def _tiles(diagnosis: Record, traces: list[Trace], refinement: Record | None, scale: Scale, floors: Floors) -> list[tuple[str, str, str]]:
    """Label, value, remark."""
    steps, added = ladder(diagnosis, refinement), _added(diagnosis, refinement)
    now = steps[0].rms if refinement and steps else finite(diagnosis.get("rms"))
    after = rms_after(diagnosis, traces, refinement)
    tiles = [("RMS before" if refinement and added else "RMS of the residual now", scale.text(now), multiple(now, floors.fitted))]
    if added:
        tiles.append((_with(added, bool(refinement)), scale.text(after), multiple(after, floors.fitted)))
    checked = [rung.rms_check for rung in steps if rung.rms_check is not None]
    if checked:
        before = f"before {scale.text(checked[0])}" if len(checked) > 1 else "never fitted"
        them = "held-out pieces" if unfitted((refinement or {}).get("check_runs")).startswith("held") else "check runs"
        remark = "; ".join(part for part in (multiple(checked[-1], floors.of("check")), before) if part)
        tiles.append((f"RMS on {them}", scale.text(checked[-1]), remark))
    return [*tiles, ("Noise floor", scale.text(floors.fitted), "what a complete model would leave")]


def _with(added: list[str], done: bool) -> str:
    """The label of the RMS with effects added."""
    what = added[0] if len(added) == 1 else "both added" if len(added) == 2 else f"all {len(added)} added"
    return f"RMS after, with {what}" if done else f"RMS with {what}"


def _ladder_part(diagnosis: Record, refinement: Record | None, scale: Scale, floors: Floors) -> dict[str, Any]:
    rungs = ladder(diagnosis, refinement)
    return {
        "ladder": ladder_drawing(rungs, scale, floors),
        "ladder_rows": tables.ladder_rows(rungs, scale, floors),
        "ladder_checked": any(rung.rms_check is not None for rung in rungs),
    }


def _experiment_part(diagnosis: Record, scale: Scale) -> dict[str, Any]:
    experiment = diagnosis.get("next_experiment") or {}
    return {
        "experiment": experiment,
        "separates": separated(experiment),
        "program": experiment_drawing(experiment, scale) or program_drawing(experiment.get("profile")),
        "settings": experiment_settings(experiment),
    }


def _read_part(diagnosis: Record, traces: list[Trace], refinement: Record | None, scale: Scale) -> dict[str, Any]:
    known = [trace.run for trace in traces]
    block = finite(diagnosis.get("average_s") or (refinement or {}).get("average_s"))
    return {
        "run_rows": tables.run_rows(traces, scale),
        "other_runs": [str(run) for run in diagnosis.get("runs") or [] if str(run) not in known],
        "refined": any(rms(trace.residual_after) is not None for trace in traces),
        "block": f"block means of {significant(block)} s" if block else "samples as recorded",
        "sampled": sampled_facts(diagnosis, scale),
        "notes": merged([str(note) for note in diagnosis.get("notes") or []], [*known, *(str(run) for run in diagnosis.get("runs") or [])]),
        "undetermined": [str(item) for item in diagnosis.get("undetermined") or []],
        "unexplained": unexplained(diagnosis, bool(refinement and _added(diagnosis, refinement))),
        "left_out": diagnosis.get("left_out"),
        "not_tried": [(str(name), joined(needs)) for name, needs in (diagnosis.get("not_tried") or {}).items()],
    }


def _effects(diagnosis: Record, refinement: Record | None, scale: Scale) -> list[tuple[str, bool, list[tuple[str, str, str]]]]:
    """Name, whether it was added, parameters; the coil's own come last."""
    steps, added = ladder(diagnosis, refinement), _added(diagnosis, refinement)
    now = [str(name) for name in diagnosis.get("effects") or (steps[0].effects if steps else [])]
    fitted = (refinement or {}).get("parameters") or diagnosis.get("parameters") or {}
    added = names_in_model(refinement or diagnosis, added)
    others = [name for name in fitted if name not in now and name not in added]
    return [(name, name in added and name not in now, tables.parameter_rows(fitted.get(name), scale)) for name in [*now, *added, *others]]
