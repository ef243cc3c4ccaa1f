"""Every line of the acceptance table: target, measured value, cases, 90 % interval."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from hidden_effects.limits import calibration_by_chance, calibration_error, fitted, ideal, ideal_limit, quantile_interval, share_interval
from hidden_effects.verdicts import Row, exact, hidden_names, right, stated

DRAWS = 25
"""How often an ideal detector judges the cases, each time in other noise."""
HALF_OCTAVE = 2**0.5
VISIBLE = "visible RMS"
UNPREDICTABLE = {"chamber_cycling"}
"""Its phase in another run is nobody's to know."""
OVERLAPPING = {"hysteresis", "viscoelastic", "sensor_lag", "thermal_gradient", "fixture_rotation", "rate_temperature_coupling"}
"""What of them is a slope in temperature or goes with the rate is theirs in one form and the base's in another: no numbers to compare. A coupling
that vanishes at another temperature than 20 °C changes what goes with the rate there."""
Rows = Sequence[Row]


@dataclass(frozen=True)
class Line:
    """One line.

    Attributes:
        what: is measured.
        target: in words; empty where there is none.
        value: measured, None where nothing could be.
        count: cases, or what the value is a share or a median of.
        interval: 90 %.
        percent: whether the value is a share.
    """

    what: str
    target: str
    value: float | None
    count: int
    interval: tuple[float, float] | None = None
    percent: bool = True


def lines(rows: Rows, single: Rows) -> list[Line]:
    """The whole table, from rows that did not fail, and those with one hidden effect that tell where it begins to be found."""
    return [*_one(rows), *_two(rows), *_nothing(rows), *_outside(rows), *_check(rows), *_parameters(rows), *_limits(single), *_rest(rows)]


def share(what: str, target: str, rows: Rows, hit: Callable[[Row], bool]) -> Line:
    """A line for the share of some rows."""
    hits = sum(map(hit, rows))
    return Line(what, target, hits / len(rows) if rows else None, len(rows), share_interval(hits, len(rows)) if rows else None)


def quantile(what: str, target: str, values: Sequence[float], at: float) -> Line:
    """A line for a quantile of some values."""
    if not values:
        return Line(what, target, None, 0, None, False)
    return Line(what, target, float(np.quantile(values, at)), len(values), quantile_interval(values, at), False)


def of(rows: Rows, kind: str, low: float = 0.0, high: float = np.inf, size: str = "amplitude") -> list[Row]:
    """Rows of a kind all of whose hidden amplitudes, or what is visible of them, lie in a range [white noise of a mean over 10 s]."""
    return [row for row in rows if row["kind"] == kind and all(low <= one[size] <= high for one in row["hidden"])]


def visible(rows: Rows) -> list[Row]:
    """Rows whose hidden effects the ideal detector would all find with 90 %."""
    return [row for row in rows if all(one["z"] >= ideal_limit(row["candidates_tried"]) for one in row["hidden"])]


def _one(rows: Rows) -> Iterator[Line]:
    third = 1 / 3 / HALF_OCTAVE, 1 / 3 * HALF_OCTAVE
    yield share(f"one hidden, {VISIBLE} ≥ σ₁₀", "≥ 97 %", of(rows, "one", 1.0, size="visible"), right)
    yield share(f"one hidden, {VISIBLE} σ₁₀/3 (×/÷ √2)", "≥ 90 %", of(rows, "one", *third, size="visible"), right)
    large, small = of(rows, "one", 1.0), of(rows, "one", *third)
    for words, some, target in (("one hidden, ≥ σ₁₀", large, "≥ 97 %"), ("one hidden, σ₁₀/3 (×/÷ √2)", small, "≥ 90 %")):
        yield share(words, target, some, right)
        yield share(f"{words}, of those that an ideal detector sees with the base refitted", "", visible(some), right)
        yield share(f"{words}, plain exact", "", some, exact)
    yield share("one hidden, any amplitude", "", of(rows, "one"), right)


def _two(rows: Rows) -> Iterator[Line]:
    for words, least in (("σ₁₀", 1.0), ("σ₁₀/3", 1 / 3)):
        yield share(f"two hidden, {VISIBLE} ≥ {words} of both: the set", "≥ 88 %", of(rows, "two", least, size="visible"), right)
    both = of(rows, "two", 1.0)
    yield share("two hidden, both ≥ σ₁₀: the set", "≥ 88 %", both, right)
    yield share("two hidden, both ≥ σ₁₀, of those that an ideal detector sees with the base refitted", "", visible(both), right)
    yield share("two hidden, both ≥ σ₁₀, plain exact", "", both, exact)
    yield share("two hidden, both ≥ σ₁₀/3", "", of(rows, "two", 1 / 3), right)


def _nothing(rows: Rows) -> Iterator[Line]:
    yield share("nothing hidden: false alarm", "≤ 2 %", of(rows, "nothing"), lambda row: row["verdict"] != "complete")


def _outside(rows: Rows) -> Iterator[Line]:
    for words, least in (("σ₁₀", 1.0), ("σ₁₀/3", 1 / 3)):
        yield share(f"outside the catalogue, {VISIBLE} ≥ {words}: `unknown`", "≥ 90 %", of(rows, "outside", least, size="visible"), right)
    large = of(rows, "outside", 1.0)
    yield share("outside the catalogue, ≥ σ₁₀: `unknown`", "≥ 90 %", large, right)
    yield share("outside the catalogue, ≥ σ₁₀, of those that an ideal detector sees with the base refitted", "", visible(large), right)
    apart = [row for row in visible(large) if row["left_beside_named"] is None or row["left_beside_named"] >= ideal_limit(row["candidates_tried"])]
    yield share("outside the catalogue, ≥ σ₁₀, of those that besides nothing named does as well", "", apart, right)
    yield share("outside the catalogue, any amplitude", "", of(rows, "outside"), right)


def _check(rows: Rows) -> Iterator[Line]:
    known = [row for row in rows if row["kind"] != "outside" and UNPREDICTABLE.isdisjoint(hidden_names(row))]
    ratios = [row["check_over_floor"] for row in known]
    yield quantile("unseen run over its noise, median", "≤ 1.05", ratios, 0.5)
    yield quantile("unseen run over its noise, 95 %", "≤ 1.15", ratios, 0.95)
    least = [row["check_over_floor_without_hidden"] for row in known]
    for words, at in (("median", 0.5), ("95 %", 0.95)):
        yield quantile(f"the base alone where nothing is hidden, true noise known, {words}", "", least, at)
    told = [row["check_over_floor_told"] for row in known if row.get("check_over_floor_told") is not None]
    for words, at in (("median", 0.5), ("95 %", 0.95)):
        yield quantile(f"the base with the hidden effects told, true noise known, {words}", "", told, at)
    yield quantile("unseen run over its noise, 95 %, verdict right", "", [row["check_over_floor"] for row in known if right(row)], 0.95)


def _parameters(rows: Rows) -> Iterator[Line]:
    named = [row for row in rows if row["kind"] != "outside" and exact(row)]
    hidden = [one for row in named for one in row["parameters"] if one["effect"] in hidden_names(row)]
    apart = [row for row in named if OVERLAPPING.isdisjoint(hidden_names(row))]
    every = hidden + [one for row in apart for one in row["parameters"] if one["effect"] not in hidden_names(row)]
    for words, some, target in (("95 % intervals that cover, verdict exact", every, "90–98 %"), ("the same, hidden effects only", hidden, "")):
        yield share(words, target, some, lambda one: abs(one["value"] - one["truth"]) <= 1.96 * one["stderr"])


def _limits(single: Rows) -> Iterator[Line]:
    ratios = _known(ratios_by_effect(single, right))
    yield quantile("amplitude found with 90 % over the ideal detector's, median over effects", "≤ 1.5", ratios, 0.5)
    chance = np.random.default_rng(1)
    drawn = [np.median(found) for _ in range(DRAWS) if (found := _known(ratios_by_effect(single, lambda row: _seen_by_chance(row, chance))))]
    words = "the same if an ideal detector had judged these cases: what few of them make of 1"
    yield Line(words, "", float(np.median(drawn)) if drawn else None, len(ratios), None, False)


def _known(ratios: dict[str, float | None]) -> list[float]:
    return [one for one in ratios.values() if one is not None]


def _seen_by_chance(row: Row, chance: np.random.Generator) -> bool:
    """Whether an ideal detector would find the one hidden effect, in noise that is drawn."""
    return bool(chance.random() < ideal(row["hidden"][0]["z"], row["candidates_tried"]))


def ratios_by_effect(single: Rows, hit: Callable[[Row], bool]) -> dict[str, float | None]:
    """Size found with 90 %, in z, over what the ideal detector needs, by effect, from cases with one hidden; None where all are below that.

    Args:
        single: cases with one hidden effect.
        hit: whether it was found.
    """
    found: dict[str, float | None] = {}
    for name in sorted({hidden_names(row)[0] for row in single}):
        own = [row for row in single if hidden_names(row) == [name]]
        limit = ideal_limit(int(np.median([row["candidates_tried"] for row in own])))
        sizes = [row["hidden"][0]["z"] for row in own]
        curve = fitted(sizes, [hit(row) for row in own], limit) if max(sizes) >= limit else None
        found[name] = curve.at / limit if curve else None
    return found


def _rest(rows: Rows) -> Iterator[Line]:
    yield share("proposed experiment separates", "≥ 90 %", [row for row in rows if "separated" in row], lambda row: bool(row["separated"]))
    for words, some, target in (("", rows, "≤ 0.05"), (", of those that an ideal detector sees with the base refitted", visible(rows), "")):
        error = calibration_error([stated(row) for row in some], [right(row) for row in some]) if some else None
        yield Line(f"calibration error of the verdict's probability{words}", target, error, len(some), None, False)
        chance = calibration_by_chance([stated(row) for row in some]) if some else None
        yield Line("the same if all that is stated were true", "", chance, len(some), None, False)
    yield quantile("seconds to diagnose and refine, median", "", [row["seconds_refine"] for row in rows], 0.5)
    yield quantile("seconds to diagnose and refine, 95 %", "", [row["seconds_refine"] for row in rows], 0.95)
