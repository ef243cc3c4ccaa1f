"""What was found, in plain words; the same on the page and on the terminal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from zoo.report.trace import Trace, rms
from zoo.report.wording import finite, joined, percent, times

Record = dict[str, Any]

NOTICEABLE = 0.02
"""Share by which the error on check runs must rise to be worth a word."""


@dataclass(frozen=True)
class Verdict:
    """What a reader should know first.

    Attributes:
        kind: ``complete``, ``missing``, ``unknown`` or ``none``.
        headline: a few words.
        sentences: what it means.
    """

    kind: str
    headline: str
    sentences: list[str]


@dataclass(frozen=True)
class Rung:
    """One step of the ladder.

    Attributes:
        added: name of the effect; None for the model as it stands.
        effects: all effects of this step.
        rms: on the fitted runs [unit].
        rms_check: on the check runs [unit].
    """

    added: str | None
    effects: list[str]
    rms: float | None
    rms_check: float | None


def candidate(diagnosis: Record, effect: str) -> Record:
    """What the diagnosis says of one candidate; empty where it says nothing."""
    return next((entry for entry in diagnosis.get("candidates") or [] if entry.get("effect") == effect), {})


def missing(diagnosis: Record) -> list[str]:
    """Effects that the diagnosis would add."""
    return [str(name) for name in diagnosis.get("missing") or []]


def ladder(diagnosis: Record, refinement: Record | None = None) -> list[Rung]:
    """The RMS with each added effect, from the refinement, or else as far as the diagnosis knows it."""
    steps = (refinement or {}).get("ladder") or diagnosis.get("ladder") or _short_ladder(diagnosis)
    return [Rung(step.get("added"), step.get("effects") or [], finite(step.get("rms")), finite(step.get("rms_check"))) for step in steps]


def _short_ladder(diagnosis: Record) -> list[Record]:
    names, effects = missing(diagnosis), diagnosis.get("effects") or []
    steps: list[Record] = [{"added": None, "effects": effects, "rms": diagnosis.get("rms")}]
    if names:
        steps.append({"added": names[0], "effects": [*effects, names[0]], "rms": candidate(diagnosis, names[0]).get("rms")})
    if len(names) > 1:
        steps.append({"added": joined(names[1:]), "effects": [*effects, *names], "rms": diagnosis.get("rms_final")})
    return [step for step in steps if finite(step["rms"]) is not None]


def rms_after(diagnosis: Record, traces: list[Trace], refinement: Record | None = None) -> float | None:
    """RMS of the residual with everything added that was found [unit]; None where nothing was."""
    steps = ladder(diagnosis, refinement)
    if steps and steps[-1].added is not None and (refinement or set(missing(diagnosis)) <= set(steps[-1].effects)):
        return steps[-1].rms
    drawn = [rms(trace.residual_after) for trace in traces if trace.role == "fit" and trace.refined is not None]
    return finite(diagnosis.get("rms_final")) if len(drawn) != 1 else drawn[0]


def excess(value: Any, floor: Any) -> float | None:
    """A value as a multiple of the noise floor; None where either is unknown."""
    number, noise = finite(value), finite(floor)
    return number / noise if number is not None and noise else None


def verdict_of(diagnosis: Record, refinement: Record | None = None) -> Verdict:
    """Headline and sentences of a diagnosis, or of a refinement where there is one."""
    if refinement:
        return _refined(diagnosis, refinement)
    kind = diagnosis.get("verdict")
    if kind == "complete":
        return Verdict("complete", "The model is complete", ["What it leaves is noise; no effect has to be added."])
    if kind == "missing":
        return Verdict("missing", f"Missing: {joined(_named(diagnosis))}", _what_missing_means(diagnosis))
    if kind == "unknown":
        return Verdict("unknown", "Unknown: nothing in the catalogue explains this", _what_unknown_means(diagnosis))
    return Verdict("none", "No verdict", ["There is no diagnosis of this model."])


def _named(diagnosis: Record) -> list[str]:
    """The missing effects, each with what cannot be told from it and with its probability."""
    entries = [(name, candidate(diagnosis, name)) for name in missing(diagnosis)]
    return [f"{joined([name, *(entry.get('indistinguishable_from') or [])], 'or')}{_chance(entry)}" for name, entry in entries]


def _chance(entry: Record) -> str:
    return f" ({percent(entry['probability'])})" if finite(entry.get("probability")) is not None else ""


def _what_missing_means(diagnosis: Record) -> list[str]:
    names = missing(diagnosis)
    sentences = [f"With {'it' if len(names) == 1 else 'them'} added, what the model leaves is noise."]
    for name in names:
        twins = candidate(diagnosis, name).get("indistinguishable_from") or []
        if twins:
            each = "both" if len(twins) == 1 else "each"
            sentences.append(f"These runs cannot tell {name} from {joined(twins, 'or')}: compare {each} on a check run.")
    return sentences


def _what_unknown_means(diagnosis: Record) -> list[str]:
    sentences = []
    if missing(diagnosis):
        ratio = excess(diagnosis.get("rms_final"), diagnosis.get("noise_floor"))
        ending = f"what is left is still {times(ratio)} the noise floor." if ratio and ratio > 1.25 else "what is left is still not noise."
        sentences.append(f"Adding {joined(_named(diagnosis))} helps, but {ending}")
    else:
        sentences.append("The residual is not noise, and no known effect makes it so.")
    return sentences + unexplained(diagnosis)


def unexplained(diagnosis: Record) -> list[str]:
    """What the unexplained residual goes with, one sentence a quantity."""
    facts = [fact for fact in diagnosis.get("unexplained") or [] if fact.get("depends_on")]
    return [f"A free smooth function of {fact['depends_on']} would explain {percent(fact.get('explains'))} of it." for fact in facts]


def worth_adding(refinement: Record) -> list[str] | None:
    """The added effects up to the step that predicts the check runs best; None where that is the last step, or nothing was checked."""
    rungs = ladder({}, refinement)
    checks = [rung.rms_check for rung in rungs if rung.rms_check is not None]
    if not checks or len(checks) < len(rungs) or checks[-1] <= min(checks) * (1.0 + NOTICEABLE):
        return None
    return [rung.added for rung in rungs[1 : checks.index(min(checks)) + 1] if rung.added]


def _better_without(refinement: Record) -> list[str]:
    kept = worth_adding(refinement)
    if kept is None:
        return []
    if not kept:
        return ["No added effect lowers the error on the runs that were not fitted: do without."]
    return [f"The runs that were not fitted are predicted best with {joined(kept)} alone: stop there."]


def _refined(diagnosis: Record, refinement: Record) -> Verdict:
    added = [rung.added for rung in ladder(diagnosis, refinement) if rung.added]
    done = f"with {joined(added)} added" if added else "as it stands"
    if refinement.get("verdict") == "complete":
        return Verdict("complete", f"The model is complete {done}", ["What it leaves is noise."])
    if refinement.get("borne_out") is False:
        words = ["What it leaves is more than noise on the runs that were not fitted, so it may have been fitted too closely."]
        return Verdict("unknown", f"Not borne out {done}", words + _better_without(refinement))
    if added:
        return Verdict("unknown", f"Still incomplete {done}", ["What is left is not noise.", *_better_without(refinement), *unexplained(diagnosis)])
    return verdict_of(diagnosis) if diagnosis.get("verdict") else Verdict("unknown", "Incomplete", ["What is left is not noise."])
