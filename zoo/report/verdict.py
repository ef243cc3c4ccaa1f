"""What was found, in plain words; the same on the page and on the terminal."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from zoo.report.floors import WORTH_TELLING, Floors, excess
from zoo.report.limits import beyond_plausible, of_single_runs, what_could_hide, what_walks
from zoo.report.trace import HELD_OUT, Trace, rms
from zoo.report.unknown_words import unexplained, unexplained_beside
from zoo.report.wording import finite, joined, names_in_model, percent, reached_beyond, significant, times, unit_symbol

Record = dict[str, Any]

NOTICEABLE = 0.02
"""Share by which the error on check runs must rise to be worth a word."""
NEAR = 1.5
"""Fitted runs within so many times their noise floor may have been fitted too closely; beyond, the model is merely wrong."""
DOUBTFUL = 0.3
"""Probability from which on what may be missing is worth a word, where it is likelier than nothing."""
LIKE_A_MISPLACED_COIL = ("sensor_lag", "thermal_gradient", "fixture_rotation", "shupe")
"""Effects that a coil which is not where the model has it looks like."""
SIMPLER = "a function of one quantity does as well with fewer parameters"
"""Said of effects that a free function outdoes: see `zoo.diagnosis.outdone`."""
NAMED = 2
"""More effects than so many that cannot be told from one are counted in the headline, and named below it."""


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
    first = candidate(diagnosis, names[0]) if names else {}
    alone = len(names) > 1 and set(first.get("beside") or effects) == set(effects)  # else its RMS is that with the others beside it
    if alone:
        steps.append({"added": names[0], "effects": [*effects, names[0]], "rms": first.get("rms")})
    if names:
        # The candidate's own RMS is of its first fit; later rounds may have refitted it.
        final = finite(diagnosis.get("rms_final")) or (candidate(diagnosis, names[0]).get("rms") if len(names) == 1 else None)
        steps.append({"added": joined(names[1:] if alone else names), "effects": [*effects, *names], "rms": final})
    return [step for step in steps if finite(step["rms"]) is not None]


def rms_after(diagnosis: Record, traces: list[Trace], refinement: Record | None = None) -> float | None:
    """RMS of the residual with everything added that was found [unit]; None where nothing was."""
    steps = ladder(diagnosis, refinement)
    if steps and steps[-1].added is not None and (refinement or set(missing(diagnosis)) <= set(steps[-1].effects)):
        return steps[-1].rms
    drawn = [rms(trace.residual_after) for trace in traces if trace.role == "fit" and trace.refined is not None]
    return finite(diagnosis.get("rms_final")) if len(drawn) != 1 else drawn[0]


def verdict_of(diagnosis: Record, refinement: Record | None = None) -> Verdict:
    """Headline and sentences of a diagnosis, or of a refinement where there is one; first of all what makes the recordings doubtful."""
    found = _verdict(diagnosis, refinement)
    of = refinement or diagnosis
    return replace(found, sentences=[*_hot(of), *_strangers(of), *found.sentences])


def _hot(record: Record) -> list[str]:
    """Runs whose temperatures are most likely in another unit."""
    hot = {str(name): value for name, value in (record.get("hot") or {}).items()}
    if not hot:
        return []
    reach = f"{joined(hot)} reach{'es' if len(hot) == 1 else ''} {max(hot.values()):.0f} °C"
    return [f"{reach}: if that is °F or K, say so first (data.temperature_unit=f or k, or by the column's name)."]


def _strangers(record: Record) -> list[str]:
    """Runs that the others do not predict at all."""
    listed = record.get("strangers") or []
    names, asked = [str(one.get("run")) for one in listed], "of the same gyro, in the same mounting and unit, with its true input?"
    if not names:
        return []
    fitted = {str(name) for name in record.get("runs") or []}
    if fitted and fitted <= set(names):
        return [f"These runs do not go together: none is predicted from the others better than without any model. Are they {asked}"]
    do, they, are = ("does", "it is", "Is it") if len(names) == 1 else ("do", "they are", "Are they")
    return [f"{joined(names)} {do} not go with the other runs: {they} predicted from these no better than without any model. {are} {asked}"]


def _verdict(diagnosis: Record, refinement: Record | None) -> Verdict:
    if refinement:
        return _refined(diagnosis, refinement)
    kind = diagnosis.get("verdict")
    if kind == "complete":
        left, doubt = _noise(excess(diagnosis.get("rms"), diagnosis.get("noise_floor"))), _in_doubt(diagnosis)
        headline = "The model may be complete" if doubt else "The model is complete"
        told = [f"What it leaves {left}", *what_walks(diagnosis), doubt or "No effect has to be added.", *what_could_hide(diagnosis)]
        return Verdict("complete", headline, told)
    if kind == "missing":
        return Verdict("missing", f"Missing: {joined(_named(diagnosis))}", _what_missing_means(diagnosis))
    if badly_trained(diagnosis):
        return _bad_training(diagnosis)
    if kind == "unknown":
        tried = "none of the candidates" if diagnosis.get("left_out") else "nothing in the catalogue"
        return Verdict("unknown", f"Unknown: {tried} explains this", _what_unknown_means(diagnosis))
    return Verdict("none", "No verdict", ["There is no diagnosis of this model."])


def badly_trained(diagnosis: Record) -> bool:
    """Whether a trained model could follow the runs with other weights, and as it was given does not."""
    return diagnosis.get("verdict") == "unknown" and diagnosis.get("verdict_refitted") == "complete"


def _bad_training(diagnosis: Record) -> Verdict:
    ratio = excess(diagnosis.get("rms"), diagnosis.get("noise_floor"))
    sentences = [f"It leaves {times(ratio)} the noise floor, which the same model with other weights would reach."] if ratio else []
    without = excess(diagnosis.get("rms"), diagnosis.get("rms_uncompensated"))
    if without and without > 1.0:
        sentences.append(f"That is {times(without)} the error without any model.")
    single = of_single_runs(diagnosis, diagnosis.get("effects") or [])
    sentences += single or ["Train it on these runs as well, with a larger network or for longer."]
    return Verdict("unknown", "No effect is missing, but the model does not fit these runs", sentences)


def _in_doubt(diagnosis: Record) -> str:
    """What is likelier to be missing than nothing at all, though the evidence is too little to add it; empty where nothing is."""
    listed = diagnosis.get("posterior") or []
    chances = {one.get("hypothesis"): finite(one.get("probability")) or 0.0 for one in listed if not one.get("effects")}
    nothing, unknown = max(chances.get("complete", 0.0), chances.get("faint", 0.0)), chances.get("unknown", 0.0)
    known = [(finite(entry.get("probability")) or 0.0, str(entry.get("effect"))) for entry in diagnosis.get("candidates") or []]
    likely, what = max([*known, (unknown, "something unknown")])
    if not listed or likely <= max(nothing, DOUBTFUL):
        return ""
    return f"But {what} may be missing ({percent(likely)}), on too little evidence to be sure: another run would tell."


def _noise(ratio: float | None) -> str:
    """The end of a sentence on what a complete model leaves: the test allows flicker and random walk, and so more than the floor."""
    if ratio is None or ratio <= WORTH_TELLING:
        return "is noise."
    return f"looks like noise, coloured more than white: RMS {times(ratio)} the floor."


def _twins(diagnosis: Record, name: str) -> list[str]:
    """What cannot be told from an effect; less what is missing beside it, as both are needed."""
    return [str(twin) for twin in candidate(diagnosis, name).get("indistinguishable_from") or [] if twin not in missing(diagnosis)]


def _named(diagnosis: Record) -> list[str]:
    """The missing effects, each with what cannot be told from it and with the probability that it is one of them."""
    return [
        f"{_or_its_twins(name, _twins(diagnosis, name))}{_often(diagnosis, name)}{_chance(diagnosis, [name, *_twins(diagnosis, name)])}"
        for name in missing(diagnosis)
    ]


def _often(diagnosis: Record, name: str) -> str:
    times = len(names_in_model(diagnosis, [name]))
    return f", {times} times" if times > 1 else ""


def _or_its_twins(name: str, twins: list[str]) -> str:
    return joined([name, *twins], "or") if len(twins) <= NAMED else f"{name} or one of {len(twins)} like it"


def _chance(diagnosis: Record, names: list[str]) -> str:
    known = [chance for name in names if (chance := finite(candidate(diagnosis, name).get("probability"))) is not None]
    return f" ({percent(min(sum(known), 1.0))})" if known else ""


def _what_missing_means(diagnosis: Record) -> list[str]:
    names = missing(diagnosis)
    left = _noise(excess(rms_after(diagnosis, []), diagnosis.get("noise_floor")))
    sentences = [f"With {'it' if len(names) == 1 else 'them'} added, what the model leaves {left}", *what_walks(diagnosis)]
    sentences += beyond_plausible(diagnosis, names)
    for name in names:
        twins = _twins(diagnosis, name)
        if twins:
            sentences.append(f"These runs cannot tell {name} from {joined(twins, 'or')}: {_what_to_do(diagnosis, name, twins)}")
    return sentences + _one_more(diagnosis) + _still_open(diagnosis) + _one_thermometer(diagnosis)


def _one_more(diagnosis: Record) -> list[str]:
    """That a set with one more in it is likelier than the one that is named, which had too little evidence to be added."""
    sets: dict[frozenset[str], float] = {}
    for one in diagnosis.get("posterior") or []:
        names = frozenset(map(str, one.get("effects") or []))
        sets[names] = sets.get(names, 0.0) + (finite(one.get("probability")) or 0.0)
    named = frozenset(missing(diagnosis))
    likeliest = max(sets, key=lambda names: sets[names], default=named)
    if not named < likeliest:
        return []
    odds = f"{percent(sets[likeliest])} against {percent(sets.get(named, 0.0))}"
    return [f"{joined(sorted(likeliest - named))} may be missing as well ({odds}), on little evidence: refine with and without it on a check run."]


def _one_thermometer(diagnosis: Record) -> list[str]:
    """Where what is missing may be no effect at all: one thermometer does not tell what heat comes to the coil from elsewhere."""
    suspects = [name for name in missing(diagnosis) if not {name, *_twins(diagnosis, name)}.isdisjoint(LIKE_A_MISPLACED_COIL)]
    what = "this" if diagnosis.get("verdict") == "unknown" else joined(suspects)
    if not what or len(diagnosis.get("thermometers") or ["", ""]) > 1:
        return []
    return [
        f"These runs have one thermometer, which the coil need not follow: {what} may be heat from elsewhere and no effect. "
        "Record the housing's temperature as well (temperature_outer_c) to know."
    ]


def _what_to_do(diagnosis: Record, name: str, twins: list[str]) -> str:
    """How to tell an effect from others: by the proposed run, as far as that does, else on a check run."""
    told = [twin for twin in twins if _separates(diagnosis, name, twin)]
    if told == twins:
        return f"the next experiment below would{' help' if (diagnosis.get('next_experiment') or {}).get('enough') is False else ''}."
    compare = f"compare {'both' if len(twins) == 1 else 'each'} on a check run."
    return f"the next experiment below would tell it from {joined(told, 'and')}; else {compare}" if told else compare


def _separates(diagnosis: Record, name: str, other: str) -> bool:
    """Whether the proposed run tells two effects apart."""
    experiment = diagnosis.get("next_experiment") or {}
    left = [{str(one) for one in pair} for pair in experiment.get("not_separated") or []]
    return {name, other} <= {str(one) for one in experiment.get("separates") or []} and {name, other} not in left


def _still_open(diagnosis: Record) -> list[str]:
    """What the proposed run is for where no twins were named: explanations that come second, or could not be tried."""
    for name in missing(diagnosis):
        others = [str(one) for one in (diagnosis.get("next_experiment") or {}).get("separates") or [] if _separates(diagnosis, name, str(one))]
        others = [one for one in others if one != name]
        if others and not _twins(diagnosis, name):
            return [f"It might yet be {joined(others, 'or')} in the place of {name}: see the next experiment below."]
    return []


def _what_unknown_means(diagnosis: Record) -> list[str]:
    sentences = []
    if missing(diagnosis):
        ratio = excess(diagnosis.get("rms_final"), diagnosis.get("noise_floor"))
        ending = f"what is left is still {times(ratio)} the noise floor." if ratio and ratio > WORTH_TELLING else "what is left is still not noise."
        ending = f"{SIMPLER}." if diagnosis.get("outdone") else ending
        sentences.append(f"Adding {joined(_named(diagnosis))} helps, but {ending}")
        told = unexplained_beside(diagnosis)
        if told:
            return [*sentences, *told, *_one_thermometer(diagnosis)]
    else:
        left_out = diagnosis.get("left_out") or ()
        some = f"no candidate makes it so; candidates leaves out {len(left_out)} of the catalogue's effects"
        sentences.append(f"The residual is not noise, and {some if left_out else 'no known effect makes it so'}.")
    return sentences + unexplained(diagnosis) + _one_thermometer(diagnosis)


def worth_adding(refinement: Record) -> list[str] | None:
    """The added effects up to the step that predicts the check runs best; None where that is the last step, or nothing was checked."""
    rungs = ladder({}, refinement)
    checks = [rung.rms_check for rung in rungs if rung.rms_check is not None]
    if not checks or len(checks) < len(rungs) or checks[-1] <= min(checks) * (1.0 + NOTICEABLE):
        return None
    return [rung.added for rung in rungs[1 : checks.index(min(checks)) + 1] if rung.added]


def unfitted(names: Any) -> str:
    """What the check runs are called: pieces of fitted runs, or runs of their own."""
    runs = [str(name) for name in names or []]
    return "held-out pieces" if runs and all(name.endswith(HELD_OUT) for name in runs) else "runs that were not fitted"


def _better_without(refinement: Record) -> list[str]:
    kept, them = worth_adding(refinement), unfitted(refinement.get("check_runs"))
    if kept is None:
        return []
    if not kept:
        return [f"No added effect lowers the error on the {them}: do without."]
    return [f"The {them} are predicted best with {joined(kept)} alone: stop there."]


def _refined(diagnosis: Record, refinement: Record) -> Verdict:
    rungs = ladder(diagnosis, refinement)
    added = [rung.added for rung in rungs if rung.added]
    done = f"with {joined(added)} added" if added else "as it stands"
    if refinement.get("verdict") == "complete":
        left = _noise(excess(rungs[-1].rms if rungs else None, refinement.get("noise_floor")))
        what = _of_readings(refinement) or [f"What it leaves {left}", *what_walks(refinement), *_checked(rungs, refinement)]
        doubts = [*beyond_plausible(refinement, added), *_no_lower(rungs), *_better_without(refinement)]
        return Verdict("complete", f"The model is complete {done}", [*what, *doubts])
    if refinement.get("borne_out") is False and (added or _near(rungs, refinement)):
        headline, sentences = _not_borne_out(rungs, refinement)
        sentences += [*of_single_runs(refinement, added), *_no_lower(rungs), *_better_without(refinement)]
        return Verdict("unknown", f"{headline} {done}", sentences)
    if added:
        left = f"It fits, but {SIMPLER}." if refinement.get("outdone") else "What is left is not noise."
        more = [*_no_lower(rungs), *_better_without(refinement), *unexplained(diagnosis, done=True)]
        return Verdict("unknown", f"Still incomplete {done}", [left, *more])
    if badly_trained(refinement):
        return _bad_training({**refinement, "rms": rungs[-1].rms if rungs else None})
    return verdict_of(diagnosis) if diagnosis.get("verdict") else Verdict("unknown", "Incomplete", ["What is left is not noise."])


def _of_readings(refinement: Record) -> list[str]:
    """What the thermometers add to the noise of a complete model; nothing where that does not matter."""
    read, unit = refinement.get("readings") or {}, unit_symbol(refinement.get("unit"))
    made, unseen = finite(read.get("fit")), finite(read.get("check"))
    if not made:
        return []
    of_check = f", {significant(unseen, 2)} {unit} on the {unfitted(refinement.get('check_runs'))}" if unseen else ""
    return [
        "What it leaves is noise, the gyro's and the thermometers': their steps and scatter make "
        f"{significant(made, 2)} {unit} of the error on the fitted runs{of_check}, which finer ones would save."
    ]


def _no_lower(rungs: list[Rung]) -> list[str]:
    """Where nothing was gained by what was added, at least not in what the ladder shows."""
    first, last = (rungs[0].rms, rungs[-1].rms) if len(rungs) > 1 else (None, None)
    if not first or not last or last < first * (1.0 - NOTICEABLE):
        return []
    rose = "; a fit counts slow noise for less than fast, so it can rise" if last > first * (1.0 + NOTICEABLE) else ""
    return [f"The RMS of the fitted runs is no lower with {joined([rung.added for rung in rungs if rung.added])} than without{rose}."]


def _checked(rungs: list[Rung], refinement: Record) -> list[str]:
    """How far from their noise what was not fitted is, where that is not close and yet borne out."""
    ratio = excess(rungs[-1].rms_check if rungs else None, Floors.read({}, refinement).checked)
    them = unfitted(refinement.get("check_runs"))
    return [f"On the {them} it leaves {times(ratio)} their floor, which may be noise."] if ratio and ratio > WORTH_TELLING else []


def _near(rungs: list[Rung], refinement: Record) -> bool:
    """Whether the fitted runs are near their floor, or nothing says that they are not."""
    fitted = excess(rungs[-1].rms if rungs else None, refinement.get("noise_floor"))
    return fitted is None or fitted <= NEAR


def _not_borne_out(rungs: list[Rung], refinement: Record) -> tuple[str, list[str]]:
    """Headline and sentences where what was not fitted is not predicted down to its noise: is it better at least, is the fit too close?"""
    floors, them = Floors.read({}, refinement), unfitted(refinement.get("check_runs"))
    first, last = (rungs[0].rms_check, rungs[-1].rms_check) if rungs else (None, None)
    better = first is not None and last is not None and last < first
    sentences = []
    if first and last and better:
        ratio = excess(last, floors.checked)
        ending = f": it is still {times(ratio)} the floor there." if ratio else "."
        sentences.append(f"On the {them} the RMS fell by {percent(1 - last / first)}, but not down to the noise{ending}")
    if _near(rungs, refinement) and (farther := reached_beyond(refinement.get("beyond") or {})):
        sentences.append(f"What it leaves is more than noise on the {them}, which go beyond what was fitted: {farther}. There it extrapolates.")
    elif _near(rungs, refinement):
        sentences.append(f"What it leaves is more than noise on the {them}, so it may have been fitted too closely.")
    else:
        whole = "what was fitted" if them.startswith("held") else "the fitted runs"
        sentences.append(f"What is left is not noise, neither on {whole} nor on the {them}.")
    return ("Not down to the noise" if better else "Not borne out"), sentences
