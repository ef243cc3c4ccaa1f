"""What an unexplained residual looks like, in sentences."""

from __future__ import annotations

from typing import Any

from zoo.report.floors import excess
from zoo.report.wording import joined, percent, times

Record = dict[str, Any]


def unexplained(diagnosis: Record, done: bool = False) -> list[str]:
    """What the unexplained residual looks like: in the diagnosis' own words, or one sentence a quantity; `done` where effects were added since."""
    words = _described(diagnosis)
    if words:
        return [f"What was unexplained before: {_continued(words)}"] if done else [f"{words}{_once_added(diagnosis)}"]
    facts = [fact for fact in diagnosis.get("unexplained") or [] if fact.get("depends_on")]
    parts = [(_enclosed(str(fact["depends_on"])), percent(fact.get("explains"))) for fact in facts]
    what = "have explained {} of the residual before." if done else "explain {} of the residual."
    return [f"A free smooth function of {words} would {what.format(share)}" for words, share in parts]


def unexplained_beside(diagnosis: Record) -> list[str]:
    """The same of a diagnosis in which some effects help, which its words may be of or not; nothing where it has no words."""
    words = _described(diagnosis)
    return [f"What the model leaves {_beside(diagnosis)}: {_continued(words)}{_once_added(diagnosis)}"] if words else []


def _described(diagnosis: Record) -> str:
    """The diagnosis' own words on what nothing explains; a value and its error stay on one line."""
    return str(diagnosis.get("unexplained_words") or "").replace(" ± ", "\u00a0±\u00a0")


def _once_added(diagnosis: Record) -> str:
    """What the form that the words are of would leave; nothing where none was found."""
    form = diagnosis.get("unexplained_form") or {}
    ratio = None if form.get("todo") else excess(form.get("rms"), diagnosis.get("noise_floor"))
    return f" Once that is added, {times(ratio)} the noise floor is left." if ratio else ""


def _beside(diagnosis: Record) -> str:
    """Which model the words are of."""
    form = diagnosis.get("unexplained_form") or {}
    added = [str(name) for name in form.get("effects") or [] if name not in (diagnosis.get("effects") or [])]
    return f"with {joined(added)} added" if added else "as it stands"


def _continued(sentence: str) -> str:
    """A sentence as it goes on after a colon."""
    return sentence[:1].lower() + sentence[1:]


def _enclosed(words: str) -> str:
    """An apposition ends with a comma where it began with one."""
    return f"{words}," if "," in words else words
