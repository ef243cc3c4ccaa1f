"""How probable each hypothesis is that a diagnosis compared: nothing missing, each set of effects, one too small to be seen, something unknown."""

from __future__ import annotations

from dataclasses import dataclass

from zoo.report.verdict import Record, missing
from zoo.report.wording import finite, joined, percent

LIKELY = 0.01
"""Hypotheses less probable than this are only counted."""
SURE = 0.9
"""From here on the terminal does not name the alternatives."""
NAMED = 4
"""How many of them it names."""
NOTHING, SOMETHING, FAINT = "nothing", "something unknown", "one too small for these runs"


@dataclass(frozen=True)
class HypothesisRow:
    """One hypothesis.

    Attributes:
        words: what the model lacks.
        probability: written.
        width: of its bar, in percent.
        found: whether it is what the verdict says.
    """

    words: str
    probability: str
    width: str
    found: bool


def hypothesis_rows(diagnosis: Record) -> list[HypothesisRow]:
    """The hypotheses worth a line, likeliest first; none where the diagnosis weighed none."""
    return [_row(entry, diagnosis) for entry in _listed(diagnosis) if _chance(entry) >= LIKELY]


def the_rest(diagnosis: Record) -> str:
    """What the hypotheses that are not worth a line amount to; empty where that is nothing."""
    shown = [_chance(entry) for entry in _listed(diagnosis) if _chance(entry) >= LIKELY]
    left = 1.0 - sum(shown)
    return f"All others together: {percent(left)}." if shown and left > 5e-4 else ""


def probable_line(diagnosis: Record) -> str | None:
    """The likeliest hypotheses in one line; None where the first is beyond doubt."""
    rows = hypothesis_rows(diagnosis)
    if not rows or _chance(_listed(diagnosis)[0]) >= SURE:
        return None
    return f"missing: {'; '.join(f'{row.words} {row.probability}' for row in rows[:NAMED])}"


def _row(entry: Record, diagnosis: Record) -> HypothesisRow:
    chance = _chance(entry)
    return HypothesisRow(_words(entry, missing(diagnosis)), percent(chance), f"{100 * min(chance, 1.0):.1f}%", _is_found(entry, diagnosis))


def _listed(diagnosis: Record) -> list[Record]:
    return sorted(diagnosis.get("posterior") or [], key=_chance, reverse=True)


def _chance(entry: Record) -> float:
    return max(finite(entry.get("probability")) or 0.0, 0.0)


def _words(entry: Record, found: list[str]) -> str:
    """The effects as the verdict orders them, then the others."""
    kind, effects = entry.get("hypothesis"), [str(name) for name in entry.get("effects") or []]
    named = sorted(effects, key=lambda name: _rank(name, found))
    return NOTHING if kind == "complete" else SOMETHING if kind == "unknown" else joined([*named, *([FAINT] if kind == "faint" else [])])


def _rank(name: str, found: list[str]) -> int:
    return found.index(name) if name in found else len(found)


def _is_found(entry: Record, diagnosis: Record) -> bool:
    named = {str(name) for name in entry.get("effects") or []}
    return entry.get("hypothesis") == diagnosis.get("verdict") and (entry.get("hypothesis") != "missing" or named == set(missing(diagnosis)))
