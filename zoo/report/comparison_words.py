"""What a comparison says, in sentences."""

from __future__ import annotations

from typing import Any

from zoo.report.floors import WORTH_TELLING
from zoo.report.wording import Scale, fixed, joined, percent, reached_beyond, times
from zoo.scoring.comparison import EVERYWHERE, UNCOMPENSATED, UNSEEN
from zoo.scoring.noise import CHECK_ALLOWED
from zoo.scoring.seeds import ENOUGH

Record = dict[str, Any]
COARSE = 2.0
"""Intervals wider than this are written without decimals, but where these tell on which side of nothing they end [%]."""
NEAR = 0.05
"""Ratios this close to one are written with a decimal more."""
NAMED = 3
"""More methods than this are counted, not named."""
BELOW = 0.8
"""RMS over the noise floor below which a prediction knows more than it should: a fit with a third as many weights as means leaves as much."""
WORTH_NAMING = 0.15
"""A smaller share of the residual is not told."""


def statement(pair: Record) -> str:
    """One pair: how much lower, how sure, in how many seeds."""
    first, second = pair["first"], pair["second"]
    if pair["verdict"] == "same":
        return f"{first} and {second} predict the same"
    if pair["verdict"] == "worse":  # over the seeds that both have
        first, second, pair = second, first, _turned(pair)
    if pair["verdict"] == "open":
        return f"{first} and {second} cannot be told apart: {_open_reason(pair)}"
    parts = [f"{first} is {_below(pair['ratio'])} below {second}{_sure(pair)}", *_seeds(pair), *_few(pair), *_other_times(pair)]
    return parts[0] + "".join(f", {part}" if i == 0 and pair["seeds"] else f"; {part}" for i, part in enumerate(parts[1:]))


def _turned(pair: Record) -> Record:
    wins = None if pair["seeds"] is None else pair["seeds"] - pair["wins"] - pair["ties"]
    flipped = {key: None if pair[key] is None else [1 / value for value in reversed(pair[key])] for key in ("interval", "interval_over_time")}
    return pair | flipped | {"ratio": 1 / pair["ratio"], "wins": wins, "verdict": "better"}


def _below(ratio: float) -> str:
    """``12 %``; with a decimal where it is close to all or to nothing."""
    share = 100 * (1 - ratio)
    return f"{fixed(share, 0 if 10 <= abs(share) < 98 else 1)} %"


def _between(interval: list[float]) -> str:
    low, high = (100 * (1 - value) for value in reversed(interval))
    decimals = 0 if high - low >= COARSE and high < 98 and abs(low) >= 1 else 1
    return f"{fixed(low, decimals)} to {fixed(high, decimals)} %"


def _sure(pair: Record) -> str:
    if pair["interval"] is None:
        return ""
    return f" (95 %{' over time' if pair['interval_over'] == 'time' else ''}: {_between(pair['interval'])})"


def _seeds(pair: Record) -> list[str]:
    if pair["seeds"] is None:
        return []
    them = "seeds" if pair["paired"] else "pairs of seeds"
    return [f"better in {pair['wins']} of {pair['seeds']} {them}{_tied(pair)}"]


def _tied(pair: Record) -> str:
    return f" and equal in {pair['ties']}" if pair["ties"] else ""


def _few(pair: Record) -> list[str]:
    if pair["seeds"] is None or pair["interval"] is not None:
        return []
    over = pair["interval_over_time"]
    known = "" if over is None else f", over time 95 %: {_between(over)}"
    return [f"too few seeds for an interval ({ENOUGH} at least{known})"]


def _other_times(pair: Record) -> list[str]:
    """Sure over seeds, and yet not over the time that was recorded."""
    over = pair["interval_over_time"]
    if pair["interval_over"] != "seeds" or over is None or over[1] < 1:
        return []
    return [f"other runs may turn it, as over time the difference is uncertain (95 %: {_between(over)})"]


def _open_reason(pair: Record) -> str:
    interval, over = pair["interval"] or pair["interval_over_time"], pair["interval_over_time"]
    if pair["seeds"] and pair["interval"] is None and over is not None and not over[0] <= 1 <= over[1]:
        seeds = f"{pair['first']} is {_seeds(pair)[0]}, and fewer than {ENOUGH} decide only if all agree"
        middle = f"ratio {fixed(pair['ratio'], 2)}, 95 % over time: {fixed(over[0], 2)} to {fixed(over[1], 2)}"
        return f"{seeds}; that the seeds in the middle differ ({middle}) says nothing of the others"
    decimals = 3 if interval is not None and max(abs(end - 1) for end in interval) < NEAR else 2
    low, high = (fixed(end, decimals) for end in interval or (None, None))
    known = "" if interval is None else f", 95 %{'' if pair['interval_over'] == 'seeds' else ' over time'}: {low} to {high}"
    parts = [f"ratio {fixed(pair['ratio'], decimals)}{known}"]
    if pair["seeds"]:
        parts.append(f"{pair['first']} {_seeds(pair)[0]}")
        parts += ["too few seeds for an interval"] if pair["interval"] is None else []
    elif interval is None:
        parts.append("the runs are too short for an interval")
    return "; ".join(parts)


def pair_of(document: Record, first: str, second: str) -> Record | None:
    """The record of two methods, whichever is named first."""
    return next((pair for pair in document["pairs"] if {pair["first"], pair["second"]} == {first, second}), None)


def leaders(document: Record) -> list[str]:
    """The best method and those that cannot be told from it, best first."""
    best = document["methods"][0]["name"]
    near = [one["name"] for one in document["methods"][1:] if (pair_of(document, best, one["name"]) or {}).get("verdict") != "better"]
    return [best, *near]


def headline(document: Record) -> str:
    """The answer in one line."""
    methods, ahead = document["methods"], leaders(document)
    best, alone = methods[0], len(methods) == 1
    if best["rms"]["median"] >= document["rms"][UNCOMPENSATED]:
        return f"No compensation is better than {best['name'] if alone else 'all of them'}"
    if alone:
        return f"{best['name']} removes {percent(best['removed'])} of the error"
    return _shared(document, ahead) if len(ahead) > 1 else _won(document)


def _won(document: Record) -> str:
    """One is ahead of all others."""
    best, second = (one["name"] for one in document["methods"][:2])
    pair = pair_of(document, best, second)
    if pair is None:
        return f"{best} is best"
    return f"{best} is best{' on these runs' if _other_times(pair) else ''}: {_below(pair['ratio'])} below {second}"


def _shared(document: Record, ahead: list[str]) -> str:
    """Several are ahead."""
    everyone = len(ahead) == len(document["methods"])
    pair = pair_of(document, ahead[0], ahead[1])
    if len(ahead) == 2 and pair is not None and pair["verdict"] == "same":
        return f"{ahead[0]} and {ahead[1]} predict the same{'' if everyone else ', better than the others'}"
    if everyone and len(ahead) > 2:
        return f"{ahead[0]} is ahead, but the other {len(ahead) - 1} cannot be told from it"
    named = joined(ahead) if len(ahead) <= NAMED else f"{ahead[0]} and {len(ahead) - 1} others"
    return f"{named} cannot be told apart" if everyone else f"{named} are best and cannot be told apart"


def sentences(document: Record, scale: Scale) -> list[str]:
    """The few that explain the headline."""
    best, methods = document["methods"][0], document["methods"]
    found = [f"{pair_statement}." for one in methods[1:3] if (pair_statement := _stated(document, best["name"], one["name"]))]
    found.append(distance(best, scale, whole_noise(document)))
    return [*found, *notes(document)]


def notes(document: Record) -> list[str]:
    """What limits what the comparison says: who is worse than nothing, who extrapolates, and who is judged by what it was fitted to."""
    return [*too_good(document), *useless(document), *extrapolations(document), *filter(None, [fitted_note(document)])]


def too_good(document: Record) -> list[str]:
    """Who leaves less than neighbouring means differ by, which is noise unless something fast is followed."""
    names = [one["name"] for one in document["methods"] if one["excess"] < BELOW]
    if not names:
        return []
    told = "it follows something fast, or it sees the gyro's output or was fitted to these very runs; make sure before you rely on it"
    return [f"Below the noise that neighbouring means differ by: {_who(names, document)}. Either {told}."]


def useless(document: Record) -> list[str]:
    """Who leaves more than there is without them, where not all do, which the headline says."""
    bare, methods = document["rms"][UNCOMPENSATED], document["methods"]
    worse = [one for one in methods if one["rms"]["median"] > bare]
    if not worse or len(worse) == len(methods):
        return []
    leaves = joined(times(one["rms"]["median"] / bare) for one in worse) if len(worse) <= NAMED else "more than"
    return [f"Worse than no compensation: {_who([one['name'] for one in worse], document)}, with {leaves} the uncompensated RMS."]


def extrapolations(document: Record) -> list[str]:
    """Where methods are asked for what they were never fitted to; a sentence for all that are so by the same."""
    said: dict[str, list[str]] = {}
    for one in document["methods"]:
        if one["beyond"]:
            said.setdefault(_farthest(one["beyond"]), []).append(one["name"])
    return [f"Extrapolated by {_who(names, document)}: {told}." for told, names in said.items()]


def _farthest(beyond: Record) -> str:
    """The runs that go beyond what was fitted, those in which it is for longest first."""
    shares = {run: max(one["share"] for one in found.values()) for run, found in beyond.items()}
    runs = sorted(shares, key=lambda run: -shares[run])
    told = [f"{run} in {percent(shares[run])} of its time ({reached_beyond(beyond[run])})" for run in runs[:NAMED]]
    return "; ".join([*told, *([f"and {len(runs) - NAMED} more"] if len(runs) > NAMED else [])])


def _who(names: list[str], document: Record) -> str:
    """Some of the methods in words."""
    if 1 < len(names) == len(document["methods"]):
        return "every model"
    return joined(names) if len(names) <= NAMED else f"{len(names)} of the models"


def whole_noise(document: Record) -> bool:
    """Whether the noise floor is all of the gyro's noise, as a refinement has found it, or its white noise alone."""
    return document["noise"] is not None


def judges(document: Record) -> str:
    """What the runs are called by which methods are ranked."""
    return UNSEEN if len(document["ranked_by"]) < len(document["runs"]) else EVERYWHERE


def fitted_note(document: Record) -> str | None:
    """Where runs judge models that were fitted to them; None where none does."""
    best, methods = document["methods"][0], document["methods"]
    if best["fitted_runs"] and len(best["fitted_runs"]) == len(document["runs"]):
        every = all(one["fitted_runs"] == best["fitted_runs"] for one in methods[1:]) and len(methods) > 1
        who = "every model" if every else best["name"]
        kept = {one["held_out"] for one in methods}
        held = f", or data.holdout={kept.pop():g}, which the fit left out" if len(kept) == 1 and min(kept) > 0 else ""
        return f"All of these runs were fitted by {who}, to go by their names and errors: runs that no model has seen are needed to judge{held}."
    names = [one["name"] for one in methods if one["fitted_runs"]]
    if not names:
        return None
    told = _fitted(document)
    if judges(document) == UNSEEN:
        return f"{told}. The order is that of the other runs, which no model has seen."
    return f"{told}; that flatters {'it' if len(names) == 1 else 'them'} there."


def _fitted(document: Record) -> str:
    """Which runs were fitted, and by whom."""
    by_runs: dict[tuple[str, ...], list[str]] = {}
    for one in document["methods"]:
        if one["fitted_runs"]:
            by_runs.setdefault(tuple(one["fitted_runs"]), []).append(one["name"])
    (first, names), *others = by_runs.items()
    if not others:
        return f"Fitted by {_who(names, document)}, to go by name and error: {joined(first)}"
    each = [f"{joined(runs)} by {_who(names, document)}" for runs, names in by_runs.items()]
    more = [f"others by {len(each) - NAMED} more"] if len(each) > NAMED else []
    return f"Fitted, to go by name and error: {'; '.join([*each[:NAMED], *more])}"


def _stated(document: Record, first: str, second: str) -> str | None:
    pair = pair_of(document, first, second)
    return None if pair is None else statement(pair)


def distance(method: Record, scale: Scale, whole: bool) -> str:
    """How far one method is from the noise: from all of it, or from its white part."""
    excess, removed = method["excess"], percent(method["removed"]) if method["removed"] > 0 else "none"
    what = f"{method['name']} leaves {scale.full(method['rms']['median'])} and removes {removed} of the error"
    if excess < BELOW:
        return f"{what}: less than the noise of these runs ({times(excess)} the floor)."
    if excess <= WORTH_TELLING:
        return f"{what}: what is left is noise ({times(excess)} the floor)."
    if whole and excess <= CHECK_ALLOWED:
        return f"{what}: what is left may be noise ({times(excess)} the floor)."
    if whole:
        return f"{what}: {times(excess)} the noise floor, so there is more to explain: fogzoo diagnose tells what."
    return f"{what}: {times(excess)} the white noise. The rest is flicker and random walk, or something to explain: fogzoo diagnose tells which."


def goes_with(method: Record) -> str:
    """What a method's residual goes with, in a line."""
    if method["excess"] < BELOW:
        return "What is left is less than the noise of these runs."
    if method["excess"] <= WORTH_TELLING:
        return "What is left is about noise."
    named = {"constant": "is a constant", "run": "differs from run to run"}
    found = [(name, share) for name, share in method["goes_with"].items() if share >= WORTH_NAMING][:3]
    words = [f"{percent(share)} {named.get(name, f'goes with {name}')}" for name, share in found]
    overlap = ", which overlap" if len(words) > 1 else ""
    return (
        f"Of the mean square that is left, {joined(words)}{overlap}."
        if words
        else "What is left goes with neither temperature, its rate nor time alone."
    )
