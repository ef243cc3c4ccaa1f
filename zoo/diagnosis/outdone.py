"""Whether a free function of one quantity does better than the effects that were named: a right form needs fewer parameters."""

from __future__ import annotations

import math

from zoo.diagnosis.form_search import FormBench
from zoo.diagnosis.forms import SHARP, WAVE
from zoo.diagnosis.free_functions import SIGNIFICANT, freed_of
from zoo.diagnosis.quantities import CLOCK, TEMPERATURE, by_the_clock, inputs_of
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench

OUTDONE, SEVERAL_OUTDONE = 1.07, 0.9
"""Evidence of a free function over that of a named effect above which that is not what it is; over that of several together, which have no reason to
add up to a function of one quantity."""
BELIEVED = 0.1
"""Share that is believed of a log Bayes factor between a free function and a named effect of the same quantity."""
CONTESTED, LEAST = 0.6, 20.0
"""Share of the evidence that is allowed, and log Bayes factor, from which a free function's forms are refitted: at a coil of a coarse grid a function
explains less than fitted together with all else, as the named effects were. With less evidence noise may stand for either."""
FORMS = 2
"""How many of its likeliest forms are."""
AT_A_GLANCE = "a bend or a step"
"""What the evidence of the sharp forms is remembered by."""


def outdone(bench: Workbench, final: Solved, base: Solved) -> float:
    """How far the best free function is ahead of the added effects, with what is allowed: 1 where it is just that; 0 where none were added.

    One of a column or of the true input does not count against an effect that goes with it: it is that effect, of any form. Nor does one of time of a
    low order against an effect of time alone, for a straight line is a form of ageing. Of several effects, one alone may stand for it, or all of them
    where they are of time alone, for then so is their sum.

    Args:
        bench: the runs.
        final: the model to judge.
        base: the model before anything was added.
    """
    added = [name for name in final.names if name not in base.names]
    if not added:
        return 0.0
    own = {words for name in added for words in inputs_of(bench.effects[name])}
    known = [bench.known((*base.names, name)) for name in added]
    alone = max((OUTDONE * bench.evidence(base, one) for one in known if one is not None), default=0.0)
    of_time = [by_the_clock(bench.effects[name]) for name in added]
    together = OUTDONE if all(of_time) else SEVERAL_OUTDONE
    allowed = max(0.0, alone, together * bench.evidence(base, final))  # what the runs speak against leaves as much as nothing added
    timed = {CLOCK.words} if any(of_time) else set()
    others = {words: one for words, one in freed_of(bench, base).items() if words not in own}
    best = max((one.whole if words in timed else one.evidence for words, one in others.items()), default=0.0)
    if best - SIGNIFICANT <= allowed:
        enough = {words: max(LEAST, CONTESTED * allowed) for words in others} | {TEMPERATURE.words: LEAST}
        seen = {words: one.evidence for words, one in others.items()}
        if TEMPERATURE.words in seen:
            seen[TEMPERATURE.words] = max(seen[TEMPERATURE.words], _sharp(bench, base))
        contested = [words for words, evidence in seen.items() if words not in timed and evidence > enough[words]]
        best = max([best, *_in_their_forms(bench, base, contested)])
    return math.exp(min(BELIEVED * (best - SIGNIFICANT - allowed), 5.0))


def _sharp(bench: Workbench, base: Solved) -> float:
    """Evidence of a bend or a step at a temperature, which no polynomial follows, at a glance beside a model; reckoned once."""
    if AT_A_GLANCE not in base.formed:
        forms = FormBench(bench, base)
        axis = next(free.axis for free in forms.frees if free.words == TEMPERATURE.words)
        base.formed[AT_A_GLANCE] = max(one.evidence for one in forms.glances([(axis, form) for form in SHARP]))
    return base.formed[AT_A_GLANCE]


def _in_their_forms(bench: Workbench, base: Solved, contested: list[str]) -> list[float]:
    """Evidence of the best of each free function's likeliest forms beside a model, everything refitted; reckoned once."""
    new = [words for words in contested if words not in base.formed]
    if new:
        forms = FormBench(bench, base)
        # A fringe in the catalogue has the waves.
        likely = {free.words: [one for one in forms.of(free) if one.form is not WAVE][:FORMS] for free in forms.frees if free.words in new}
        found = {one.effect.name: one.evidence for one in forms.refitted([one for each in likely.values() for one in each])}
        best = {words: [found[one.effect.name] for one in each] for words, each in likely.items()}
        base.formed.update({words: max(best.get(words, []), default=-math.inf) for words in new})
    return [base.formed[words] for words in contested]
