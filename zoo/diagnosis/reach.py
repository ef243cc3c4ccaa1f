"""Whether it is worth looking for more effects: not where one function of one quantity leaves nothing by which others might be ahead of it."""

from __future__ import annotations

from zoo.diagnosis.form_search import best_form
from zoo.diagnosis.free_functions import SIGNIFICANT, freed_of
from zoo.diagnosis.outdone import SEVERAL_OUTDONE, outdone
from zoo.diagnosis.quantities import CLOCK, inputs_of
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.structure import leaves_noise
from zoo.diagnosis.workbench import Workbench


def out_of_reach(bench: Workbench, final: Solved, base: Solved) -> bool:
    """Whether a free form outdoes what was found, and would outdo any two effects as well: it leaves noise, and had they all of what it leaves beyond
    the white noise, that were too little.

    Not of time: two effects that go with it are held against it otherwise, see `zoo.diagnosis.outdone`. Nor of a column or the true input, where an
    effect that goes with it is yet to be added.

    Args:
        bench: the runs.
        final: where a search has come to.
        base: the model before anything was added.
    """
    if set(final.names) == set(base.names):  # nothing was added that could be outdone
        return False
    frees = freed_of(bench, base)
    yet_to_come = {words for name in bench.available() if name not in final.names for words in inputs_of(bench.effects[name])}
    if max(frees, key=lambda words: frees[words].evidence, default=None) in yet_to_come or outdone(bench, final, base) <= 1.0:
        return False
    _, best = best_form(bench, base)
    left = best.solved.likely.cost / max(bench.blocks - best.solved.freedom, 1) - 1.0
    most = best.evidence + 0.5 * max(left, 0.0) * bench.blocks
    ahead = best.evidence - SIGNIFICANT > SEVERAL_OUTDONE * most
    return ahead and best.quantity is not CLOCK and leaves_noise(bench, best.solved, best.solved)
