"""The simplest form that accounts for what nothing in the catalogue explains: tried on the bench like any candidate."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from zoo.diagnosis.forms import EVEN, EVEN_BY_TEMPERATURE, ODD, POLYNOMIALS, REMEMBERED, SHARP, Form, forms_of
from zoo.diagnosis.free_functions import Axis, FreeFunction, functions_of, weigh
from zoo.diagnosis.parameters import fitted_parameters
from zoo.diagnosis.quantities import CLOCK, RATE, TEMPERATURE, Quantity
from zoo.diagnosis.screening import Here, Screened
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Guess, Workbench
from zoo.effects.base import Effect
from zoo.fitting.parameters import Fitted
from zoo.fitting.variable_projection import Fit, fit
from zoo.side_by_side import side_by_side

LOOKED_AT = 5
"""How many quantities have their forms looked at; time is one of them, for no smooth function of it shows what recurs."""
REFITTED = 3
"""How many of the best forms are refitted together with the model."""
GLANCED = 8
"""How many of the best forms by projection have their evidence computed, to find these."""
SIMPLER, SIMPLER_SHARE = 5.0, 0.02
"""Log Bayes factor that a form may fall short of the best by and still be preferred for its simplicity; share of the best's, where that is more: what
is large beside the noise is followed best by what bends to the coil's errors as well."""

LIKELY_FORMS = ((RATE, EVEN), (RATE, ODD), (RATE, EVEN_BY_TEMPERATURE), (RATE, REMEMBERED), *((TEMPERATURE, form) for form in SHARP))
"""Refitted in any case: what goes with a power of the rate that nothing in the catalogue has bends the coil most; and no polynomial shows a bend or a
step."""


@dataclass(frozen=True, eq=False)
class Tried:
    """A form beside the model.

    Attributes:
        quantity: what it depends on.
        form: the family of columns.
        effect: both as an effect.
        screened: its best guess from projection.
        solved: the model with it.
        evidence: log Bayes factor over the model without it.
        refitted: whether the nonlinear parameters were fitted again.
    """

    quantity: Quantity
    form: Form
    effect: Effect
    screened: Screened
    solved: Solved
    evidence: float
    refitted: bool = False

    @property
    def freedom(self) -> int:
        """How many parameters it has."""
        return len(self.effect.shape) + len(self.effect.amplitudes)

    def parameters(self, unit: str) -> Fitted:
        """Value, standard error and unit of each of its parameters."""
        return fitted_parameters(self.solved, unit)[self.effect.name]


class FormBench:
    """Tries forms beside one model."""

    def __init__(self, bench: Workbench, base: Solved) -> None:
        """Keep the model.

        Args:
            bench: the runs.
            base: the model that leaves something unexplained.
        """
        self.base = self.at = base
        self.bench = Workbench(bench.runs, dict(bench.effects), bench.noise, bench.mixtures, bench.scatter)
        self.frees = functions_of(bench, base)
        self._refitted: dict[str, Tried] = {}

    def of(self, free: FreeFunction) -> list[Tried]:
        """The forms that a free function may stand for, the likeliest first, nothing refitted."""
        return self.glances(self._forms_of(free))

    def has(self, free: FreeFunction, name: str) -> bool:
        """Whether the effect of this name is one of the forms that a free function may stand for."""
        return any(form.of(axis.of, (axis.low, axis.high)).name == name for axis, form in self._forms_of(free))

    def _forms_of(self, free: FreeFunction) -> list[tuple[Axis, Form]]:
        axes = {one.of: one.axis for one in self.frees}
        return [(axes[quantity], form) for quantity, form in forms_of(free) if quantity in axes]

    def glances(self, given: list[tuple[Axis, Form]], most: int | None = None) -> list[Tried]:
        """Some forms, each at its best shape beside the model with nothing nonlinear refitted; the likeliest first.

        Args:
            given: the forms.
            most: how many of the best by projection are looked at; by default all.
        """
        made = [(axis, form, form.of(axis.of, (axis.low, axis.high))) for axis, form in given]
        self.bench.effects.update({effect.name: effect for _, _, effect in made})
        here = Here(self.bench, self.at)
        price = math.log(self.bench.effective_samples)
        screened = side_by_side(lambda one: here.screened(one[2].name), made)
        likely = sorted(zip(made, screened, strict=True), key=lambda each: each[1].freedom * price - each[1].gain)[:most]

        def glance(each: tuple[tuple[Axis, Form, Effect], Screened]) -> tuple[Fit, float]:
            solved = self.bench.peek(self.at, each[0][2].name, each[1].shape)
            return solved.fit, self.bench.evidence(self.base, solved)

        found = []
        for ((axis, form, effect), guess), (there, evidence) in zip(likely, side_by_side(glance, likely), strict=True):
            solved = self.bench.placed((*self.at.names, effect.name), there, self.at.likely.place)
            found.append(Tried(axis.of, form, effect, guess, solved, evidence))
        return sorted(found, key=lambda one: -one.evidence)

    def refitted(self, tried: list[Tried]) -> list[Tried]:
        """The same with everything refitted, from where they were glanced at or from elsewhere; each once."""
        new = list({one.effect.name: one for one in tried if one.effect.name not in self._refitted}.values())
        self.bench.effects.update({one.effect.name: one.effect for one in new})
        far = self.at is self.base
        guesses = [Guess(one.effect.name, one.screened.shape, far=far) for one in new]
        for one, found in zip(new, self.bench.extended(self.at, guesses), strict=True):
            solved = self.bench.taken((*self.at.names, one.effect.name), found, self.at.likely.place)
            evidence = self.bench.evidence(self.base, solved)
            self._refitted[one.effect.name] = Tried(one.quantity, one.form, one.effect, one.screened, solved, evidence, True)
        return [self._refitted[one.effect.name] for one in tried]

    def best(self) -> Tried:
        """The form that accounts best for the residual: the simplest of those that are about as likely, all refitted.

        A model that lacks an effect bends its coil to make up for it, and at a bent coil the true form may explain little. So some forms are refitted
        whatever they explain there; then the coil is put where the best of them has it, and all are looked at again.
        """
        axes = {axis.of: axis for axis in (free.axis for free in self.frees)}
        often = self.glances([(axes[quantity], form) for quantity, form in LIKELY_FORMS if quantity in axes])
        self._look_at(simplest(self.refitted([*self._leading(), *often])).solved)
        best = simplest([*self._refitted.values(), *self.refitted(self._leading())])
        self._look_at(best.solved)
        self.bench.effects[best.effect.name] = best.effect  # the look may have left the same form over another range there
        return replace(best, solved=self.bench.finish(best.solved))

    def _leading(self) -> list[Tried]:
        """The likeliest forms of the quantities whose free function explains most."""
        worths = side_by_side(lambda free: weigh(self.bench, self.at, free.columns)[0], self.frees)
        ranked = sorted(zip(self.frees, worths, strict=True), key=lambda each: (each[0].of is not CLOCK, -each[1]))
        return self.glances([form for free, _ in ranked[:LOOKED_AT] for form in self._forms_of(free)], GLANCED)[:REFITTED]

    def _look_at(self, fuller: Solved) -> None:
        """Put the model's coil and shapes where a fuller one has them."""
        design = self.bench.design(self.base.names)
        theta = fuller.fit.theta[: len(self.base.fit.theta)]
        found = fit(design.plain_columns, design.target, theta, iterations=0, weigh=self.bench.whitener)
        design.model.assign(found.theta, found.amplitudes)
        self.at = Solved(self.base.names, design.model, design, found, self.bench.mixtures, fuller.likely.place)
        self.frees = functions_of(self.bench, self.at)


def best_form(bench: Workbench, base: Solved) -> tuple[FormBench, Tried]:
    """The form that accounts best for what a model leaves, on the bench where it was found; looked for once."""
    if not base.described:
        forms = FormBench(bench, base)
        base.described.append((forms, forms.best()))
    return base.described[0]


def simplest(tried: list[Tried]) -> Tried:
    """The one with the fewest parameters among those that are about as likely as the likeliest; of equals the likelier.

    A bent polynomial comes last: it says nothing beyond the range of the runs.
    """
    top = max(one.evidence for one in tried)
    near = [one for one in tried if one.evidence > top - max(SIMPLER, SIMPLER_SHARE * top)]
    return min(near, key=lambda one: (one.freedom, one.form in POLYNOMIALS[1:], -one.evidence))
