"""The self-contained page that `compare` writes."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

from zoo import __version__
from zoo.artifacts import write_text
from zoo.report.canvas import inline_svg
from zoo.report.comparison_figure import seeds_figure, stages_figure
from zoo.report.comparison_words import Record, goes_with, headline, judges, leaders, pair_of, sentences, statement, too_good, whole_noise
from zoo.report.palette import styled
from zoo.report.run_figure import Curves, halves
from zoo.report.tables import region_rows
from zoo.report.template import filled
from zoo.report.wording import NONE, Scale, fixed, percent, times
from zoo.scoring.comparison import TOGETHER, UNCOMPENSATED

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RUNS_DRAWN, PANELS = 8, 8
METHODS_OPEN = 3
FEWEST_PAIRS, MOST_PAIRS = 3, 12
"""In words beside the drawing: as many as there are methods beside the best, which are as high as it; the others open below."""
WHOLE = "white noise of these runs, with as much flicker and random walk beside it as refine has found: what a complete model leaves"
WHITE = "white noise, read off these runs: a complete model leaves it, and the gyro's flicker and random walk"
"""What the noise floor is."""
FINER = 5.0
"""Methods differ by less than the noise floor's own digits show."""


def write_comparison(out: Path, document: Record, curves: list[Curves]) -> Path:
    """Write ``comparison.html``, whole or not at all.

    Args:
        out: folder of the results.
        document: `comparison.json`.
        curves: of every run.
    """
    return write_text(out / "comparison.html", filled("comparison.html.j2", _context(document, curves)))


def scale_of(document: Record) -> Scale:
    """How this comparison writes the output's values."""
    best = min(one["rms"]["median"] for one in document["methods"])
    return Scale.of(document["unit"], document["noise_floor"], best, FINER)


def seeds_drawn(document: Record, scale: Scale) -> Figure:
    """Every seed of every method."""
    return seeds_figure(document["methods"], document["rms"][UNCOMPENSATED], document["noise_floor"], scale, judges(document))


def stages_drawn(document: Record, scale: Scale, runs: list[str] | None = None) -> Figure:
    """By run and stage; of some runs, or of the first few."""
    chosen = runs or _runs(document)[:PANELS]
    rows = [row for run in chosen for row in stage_rows(document) if row["run"] == run]
    return stages_figure(rows, [one["name"] for one in document["methods"]], _floors(document), scale)


def _floors(document: Record) -> dict[str, float]:
    """By run, and of those that decide together."""
    return document["noise_floors"] | dict.fromkeys(TOGETHER, document["noise_floor"])


def _runs(document: Record) -> list[str]:
    """All that decide together first, where there are several."""
    runs = list(dict.fromkeys(row["run"] for row in document["methods"][0]["rows"]))
    return sorted(runs, key=lambda run: (run not in TOGETHER, run not in document["ranked_by"]))


def stage_rows(document: Record) -> list[Record]:
    """``{"run": ..., "stage": ..., "blocks": ..., NAME: (median, low, high)}``, the uncompensated error first."""
    by_place = {(row["run"], row["stage"]): row[UNCOMPENSATED] for row in document["rows"]}
    rows = []
    for i, row in enumerate(document["methods"][0]["rows"]):
        found: Record = {key: row[key] for key in ("run", "stage", "blocks")}
        bare = by_place.get((row["run"], row["stage"]), _pooled(document, row["stage"]))
        found[UNCOMPENSATED] = (bare, bare, bare)
        found |= {one["name"]: tuple(one["rows"][i][key] for key in ("median", "low", "high")) for one in document["methods"]}
        rows.append(found)
    return rows


def _pooled(document: Record, stage: str) -> float:
    """The uncompensated error, in one kind of stage, of the runs that decide."""
    chosen = [row for row in document["rows"] if row["stage"] == stage and row["run"] in document["ranked_by"]]
    squares = sum(row["blocks"] * row[UNCOMPENSATED] ** 2 for row in chosen)
    return float((squares / sum(row["blocks"] for row in chosen)) ** 0.5)


def _context(document: Record, curves: list[Curves]) -> dict[str, Any]:
    scale, methods = scale_of(document), document["methods"]
    with styled("seeds"):
        seeds = inline_svg(seeds_drawn(document, scale), "; ".join(f"{one['name']}: {scale.full(one['rms']['median'])}" for one in methods))
    return {
        "headline": headline(document),
        "state": _state(document),
        "judges": judges(document),
        "sentences": sentences(document, scale),
        "tiles": _tiles(document, scale),
        "unit": scale.label,
        "seeds": seeds,
        "stages": [_stages_drawing(i, run, document, scale) for i, run in enumerate(_runs(document)[:PANELS])],
        "ranking": [_ranking_row(document, one, scale) for one in methods],
        "several": any(one["distinct"] > 1 for one in methods),
        "pairs": [statement(pair) for pair in document["pairs"]],
        "pairs_shown": min(max(len(methods) - 1, FEWEST_PAIRS), MOST_PAIRS),
        "by_stage": _by_stage(document, scale),
        "runs": [_run_drawing(i, one, document, scale) for i, one in enumerate(curves[:RUNS_DRAWN])],
        "undrawn": [one.run for one in curves[RUNS_DRAWN:]],
        "where": [(one["name"], goes_with(one), region_rows(one["where"], scale), _typical(one)) for one in methods],
        "methods_open": METHODS_OPEN,
        "models": [(one["name"], one["folder"]) for one in document["models"]],
        "skipped": document["skipped"],
        "floors": [(run, scale.full(floor)) for run, floor in document["noise_floors"].items()],
        "average": f"{document['average_s']:g} s",
        "written": datetime.now().astimezone().strftime("%Y-%m-%d %H:%M %Z"),
        "version": __version__,
    }


def _state(document: Record) -> str:
    """Which colour the answer has: clear, or not."""
    if document["methods"][0]["rms"]["median"] >= document["rms"][UNCOMPENSATED]:
        return "none"
    return "complete" if len(leaders(document)) == 1 and not too_good(document) else "missing"


def _tiles(document: Record, scale: Scale) -> list[tuple[str, str, str]]:
    """Label, value, remark."""
    best, bare, floor = document["methods"][0], document["rms"][UNCOMPENSATED], document["noise_floor"]
    seeds = f", median of {best['distinct']} seeds" if best["distinct"] > 1 else ""
    return [
        ("Uncompensated", scale.text(bare), f"{times(bare / floor)} noise floor"),
        (f"Best: {best['name']}{seeds}", scale.text(best["rms"]["median"]), f"{times(best['excess'])} noise floor"),
        ("Noise floor", scale.text(floor), WHOLE if whole_noise(document) else WHITE),
    ]


def _ranking_row(document: Record, one: Record, scale: Scale) -> list[str]:
    best = document["methods"][0]["name"]
    pair = None if one["name"] == best else pair_of(document, best, one["name"])
    return [
        one["name"],
        _count(one),
        scale.text(one["rms"]["median"]),
        _range(one, scale),
        _sure(one, scale),
        times(one["excess"]),
        _removed(one),
        _against(pair),
    ]


def _count(one: Record) -> str:
    if one["distinct"] > 1:
        return str(one["distinct"])
    return f"{len(one['models'])}, all alike" if len(one["models"]) > 1 else "1"


def _range(one: Record, scale: Scale) -> str:
    return f"{scale.text(one['rms']['low'])} … {scale.text(one['rms']['high'])}" if one["distinct"] > 1 else NONE


def _sure(one: Record, scale: Scale) -> str:
    interval = one["rms"]["interval"]
    return NONE if interval is None else f"{scale.text(interval[0])} … {scale.text(interval[1])}{' t' if one['interval_over'] == 'time' else ''}"


def _removed(one: Record) -> str:
    return percent(one["removed"]) if one["removed"] > 0 else "none"


def _against(pair: Record | None) -> str:
    """What the best one has over this one."""
    if pair is None:
        return "best"
    if pair["verdict"] == "better":
        return f"{fixed(100 * (1 / pair['ratio'] - 1), 0)} % above the best"
    return "the same" if pair["verdict"] == "same" else "not separable from the best"


def _by_stage(document: Record, scale: Scale) -> list[tuple[str, list[str], list[tuple[str, list[tuple[str, str]]]]]]:
    """By run: its stages, and for each method and stage the median and its multiple of the noise floor."""
    found = []
    floors, names = _floors(document), [UNCOMPENSATED, *(one["name"] for one in document["methods"])]
    for run in _runs(document):
        rows = [row for row in stage_rows(document) if row["run"] == run]
        lines = [(name, [(scale.text(row[name][0]), times(row[name][0] / floors[run])) for row in rows]) for name in names]
        found.append((run, [row["stage"] for row in rows], lines))
    return found


def _stages_drawing(place: int, run: str, document: Record, scale: Scale) -> Markup:
    with styled(f"s{place}"):
        return inline_svg(stages_drawn(document, scale, [run]), f"{run}: RMS by stage")


def _run_drawing(place: int, one: Curves, document: Record, scale: Scale) -> tuple[str, list[Markup]]:
    drawn, told = [], (f"{one.run}: error before and after over time", f"{one.run}: what the best leave, over time")
    for part, words in enumerate(told):
        with styled(f"r{place}.{part}"):
            drawn.append(inline_svg(halves(one, document["noise_floors"][one.run], scale)[part], words))
    return one.run, drawn


def _typical(one: Record) -> str:
    return f"of {one['typical']}, the seed in the middle" if one["distinct"] > 1 else ""
