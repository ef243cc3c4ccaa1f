"""Table and figures of what was judged, written into the results' folder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from hidden_effects.acceptance import Line, Rows, lines, of, ratios_by_effect, share
from hidden_effects.figures import detection_figure, reliability_figure
from hidden_effects.verdicts import Row, exact, hidden_names, right, stated

EFFECT_HEAD = (
    "\n| one hidden | cases | right | plain exact | smallest z right | largest z wrong | found at 90 %, over ideal |\n|---|---|---|---|---|---|---|"
)
WORDS = (
    "σ₁₀: white noise of 10 s means; amplitude: half of peak to peak over the fitted runs; visible RMS: what the base leaves of the effect without "
    "noise, which `amplitude` of `fogzoo simulate` means. z: size of what the base cannot absorb of a hidden "
    "effect, in the true noise. Ideal detector: M matched filters, the largest beyond t, 1 − (1 − 2Q(t))^M = 0.02; it finds z = t + Q⁻¹(0.1) in 90 %."
)
HEAD = "| | target | measured | 90 % interval | n |\n|---|---|---|---|---|"


def report(rows: Rows, answers: Rows, out: Path, near: Rows = ()) -> str:
    """Write ``table.md`` and the figures; the table is returned as well.

    Args:
        rows: of the cases.
        answers: of the other methods to them.
        out: folder.
        near: of more cases with one hidden effect, of sizes about the limit; they tell where that is, and nothing else.
    """
    sound, failed = [row for row in rows if "failed" not in row], [row for row in (*rows, *near) if "failed" in row]
    single = [*of(sound, "one"), *(row for row in near if "failed" not in row)]
    text = "\n".join(
        [
            *_acceptance(sound, single),
            *_by_effect(single),
            *_by_peer(sound, answers),
            *_wrong(sound),
            *(f"failed: seed {row['seed']}: {row['failed']}" for row in failed),
        ]
    )
    (out / "table.md").write_text(text + "\n", encoding="utf-8")
    if sound:
        reliability_figure(sound, out / "reliability.png")
    if shown := [*single, *of(sound, "outside")]:
        detection_figure(shown, out / "detection.png")
    return text


def _acceptance(rows: Rows, single: Rows) -> Iterator[str]:
    more = len(single) - len(of(rows, "one"))
    extra = f" {more} more with one hidden effect, of sizes about the limit, count for the amplitude found and the table by effect." if more else ""
    yield f"{len(rows)} cases, {max((row['catalogue'] for row in rows), default=0)} effects in the catalogue. {WORDS}{extra}\n"
    yield HEAD
    for line in lines(rows, single):
        yield f"| {line.what} | {line.target} | {_number(line.value, line)} | {_interval(line)} | {line.count} |"


def _number(value: float | None, line: Line) -> str:
    if value is None:
        return "–"
    return f"{100 * value:.1f} %" if line.percent else f"{value:.3g}"


def _interval(line: Line) -> str:
    return "" if line.interval is None else " … ".join(_number(value, line) for value in line.interval)


def _by_effect(single: Rows) -> Iterator[str]:
    yield EFFECT_HEAD
    for name, ratio in ratios_by_effect(single, right).items():
        own = [row for row in single if hidden_names(row) == [name]]
        hits, wrong = ([row["hidden"][0]["z"] for row in own if right(row) == one] for one in (True, False))
        ends = (f"{min(hits):.1f}" if hits else "–", f"{max(wrong):.1f}" if wrong else "–")
        yield f"| {name} | {len(own)} | {len(hits)} | {sum(map(exact, own))} | {ends[0]} | {ends[1]} | {'–' if ratio is None else f'{ratio:.2f}'} |"


def _by_peer(rows: Rows, answers: Rows) -> Iterator[str]:
    """The other methods on the cases that they were asked about, and ours on the same."""
    by_seed = {row["seed"]: row for row in answers}
    asked = [row for row in rows if row["seed"] in by_seed]
    if not asked:
        return
    yield "\n| same cases | one hidden, ≥ σ₁₀ | two, both ≥ σ₁₀ | false alarm | `unknown` outside, ≥ σ₁₀ | s |\n|---|---|---|---|---|---|"
    yield _peer_line("fogzoo, plain exact", asked, {row["seed"]: {"named": row["missing"], "unknown": row["verdict"] == "unknown"} for row in asked})
    for name in [key for key in answers[0] if key != "seed"]:
        yield _peer_line(name, asked, {seed: answer[name] for seed, answer in by_seed.items()})


def _peer_line(method: str, rows: Rows, said: Mapping[int, Mapping[str, Any]]) -> str:
    """One method; those that cannot say that they know none never do."""

    def named(row: Row) -> bool:
        return sorted(said[row["seed"]]["named"]) == sorted(hidden_names(row)) and not unknown(row)

    def unknown(row: Row) -> bool:
        return bool(said[row["seed"]].get("unknown", False))

    def alarm(row: Row) -> bool:
        return bool(said[row["seed"]]["named"]) or unknown(row)

    cells = [share("", "", of(rows, kind, 1.0), named) for kind in ("one", "two")]
    cells += [share("", "", of(rows, "nothing"), alarm), share("", "", of(rows, "outside", 1.0), unknown)]
    seconds = np.median([said[row["seed"]].get("seconds", row["seconds_refine"]) for row in rows])
    return f"| {method} | " + " | ".join(f"{_number(cell.value, cell)} of {cell.count}" for cell in cells) + f" | {seconds:.1f} |"


def _wrong(rows: Rows) -> Iterator[str]:
    yield "\n| wrong | hidden (amplitude, z) | said | probability |\n|---|---|---|---|"
    for row in sorted((row for row in rows if not right(row)), key=_plainness, reverse=True):
        hidden = ", ".join(f"{one['name']}:{one['variant']} ({one['amplitude']:.2f}, {one['z']:.1f})" for one in row["hidden"])
        yield f"| {row['seed']} | {hidden or 'nothing'} | {row['verdict']} {', '.join(row['missing'])} | {stated(row):.2f} |"


def _plainness(row: Row) -> float:
    """How visible the least visible of what is hidden was."""
    sizes: Sequence[float] = [one["z"] for one in row["hidden"]]
    return float(np.min(sizes)) if sizes else np.inf
