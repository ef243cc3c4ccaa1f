"""What nothing in the catalogue explains, described: what it depends on, as a curve, in words, and as a form to start from."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import torch
from torch import Tensor

from zoo.diagnosis.curve import fitted
from zoo.diagnosis.form_search import FormBench, Tried, best_form
from zoo.diagnosis.form_words import sentence, shape_of
from zoo.diagnosis.forms import POLYNOMIALS, SHARP, wave
from zoo.diagnosis.free_functions import SIGNIFICANT, TOGETHER, FreeFunction, WithForm, functions_of, weigh
from zoo.diagnosis.quantities import CLOCK, RATE, SIZE
from zoo.diagnosis.regions import runs_rms
from zoo.diagnosis.restless import restless
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.structure import MATERIAL, leaves_noise
from zoo.diagnosis.workbench import Workbench
from zoo.effects.base import Parameter
from zoo.units import SECONDS_PER_HOUR

MOST = 3
"""How many dependences are described."""
SMOOTH = 0.3
"""Share of the residual's variance that a form must account for to be called what the residual is like (16 % in RMS)."""
FURTHER = 0.05
"""Share of the whole residual below which a further dependence is a correction to the first."""
AS_GOOD = 0.9
"""Part of the share explained from which another quantity does about as well."""
UNLIKE = 0.5
"""Part of the overall share explained below which a run is named as one that behaves otherwise."""
WIDE = 100.0
"""Bounds of an amplitude over its fitted size."""
NOTHING_SMOOTH = "No smooth function of temperature, rate, time or a recorded column explains it."


@dataclass(frozen=True, eq=False)
class Description:
    """What is known of an unexplained residual.

    Attributes:
        dependences: what it goes with, each ready for JSON, most explanatory first.
        form: the form to start from, ready for JSON.
        words: what it is like as a whole.
        best: the form, fitted with the model; None where nothing smooth explains much.
        complete: the model with it, where that leaves noise.
    """

    dependences: list[dict[str, Any]]
    form: dict[str, Any]
    words: str
    best: Tried | None
    complete: Solved | None = None

    def record(self) -> dict[str, Any]:
        """The fields of the diagnosis: `unexplained`, `unexplained_form` and `unexplained_words`."""
        return {"unexplained": self.dependences, "unexplained_form": self.form, "unexplained_words": self.words}


def describe(bench: Workbench, base: Solved) -> Description:
    """Describe what a model leaves.

    Args:
        bench: the runs.
        base: the model that leaves something unexplained.
    """
    forms, best = best_form(bench, base)
    complete = best.solved if leaves_noise(forms.bench, best.solved, best.solved) else None
    if share_of(best.solved, base) < SMOOTH and complete is None:  # else it is what was missing, however little a bent coil and flicker left of it
        return _nothing_smooth(bench, base)
    first = next(free for free in forms.frees if forms.has(free, best.effect.name))
    entries = [_entry(bench, forms.at, base, first, best, complete is not None)]
    entries[0]["as_good"] = _as_good(bench, forms, first)
    entries += _further(bench, best.solved, base, {first.words})
    return Description(entries, _form(bench, best, entries[0]["words"]), entries[0]["words"], best, complete)


def share_of(solved: Solved, base: Solved) -> float:
    """Share of the variance of what one model leaves that another takes away."""
    return 1.0 - (solved.rms / base.rms) ** 2


def _shares_by_run(bench: Workbench, solved: Solved, base: Solved) -> list[float]:
    """The same, run by run."""
    after, before = (runs_rms(bench.runs, one.residual) for one in (solved, base))
    return [1.0 - (after[run.name] / before[run.name]) ** 2 for run in bench.runs]


def _nothing_smooth(bench: Workbench, base: Solved) -> Description:
    words = f"{NOTHING_SMOOTH} {restless(bench, base)}"
    idle = FormBench(bench, base)
    size = next((free for free in idle.frees if free.of is SIZE), idle.frees[0])
    start = next(one for one in idle.of(size) if one.form is POLYNOMIALS[0] or len(one.effect.amplitudes) == 1)
    weak = [entry | {"words": ""} for entry in _further(bench, base, base, set())]
    return Description(weak, {**_form(bench, start, words), "todo": True}, words, None)


def _further(bench: Workbench, solved: Solved, base: Solved, known: set[str]) -> list[dict[str, Any]]:
    """What the rest goes with, one quantity after the other, each beside those before it."""
    entries: list[dict[str, Any]] = []
    beside: list[FreeFunction] = []
    part = (solved.rms / base.rms) ** 2
    while len(entries) + len(known) < MOST:
        left = [free for free in functions_of(bench, solved) if free.words not in known | {one.words for one in beside}]
        weighed = [(free, *weigh(bench, solved, free.columns, _together(beside))) for free in left]
        free, share, evidence = max(weighed, key=lambda one: one[2])
        if evidence <= SIGNIFICANT or share <= MATERIAL or share * part <= FURTHER:
            break
        beside.append(free)
        entries.append(_entry(bench, solved, base, free) | {"explains": share * part})
        part *= 1.0 - share
    return entries


def _together(frees: list[FreeFunction]) -> Tensor | None:
    return torch.cat([free.columns for free in frees], dim=1) if frees else None


def _entry(bench: Workbench, solved: Solved, base: Solved, free: FreeFunction, best: Tried | None = None, complete: bool = False) -> dict[str, Any]:
    """One dependence; the form that stands for it where there is one, and whether no run has more to say."""
    unit = bench.runs[0].unit
    drawn = fitted(bench, solved, free if best is None or best.form not in SHARP else _sharpened(free, best))
    curves = drawn.curves()
    shares = drawn.explained([run.blocks for run in bench.runs])
    share, evidence = weigh(bench, solved, free.columns)
    if best is not None:
        share, evidence, shares = share_of(best.solved, base), best.evidence, _shares_by_run(bench, best.solved, base)
    words = sentence(best, curves, unit) if best is not None else shape_of(free.words, free.of.told_in(unit).unit, curves[0])
    return {
        "depends_on": free.words if best is None else _depends_on(free, best, unit),
        "explains": share,
        "evidence": evidence,
        "words": words if complete else f"{words}{_unlike(bench, shares, share)}",
        "by_run": {run.name: one for run, one in zip(bench.runs, shares, strict=True)},
        "quantity": free.of.words,
        "unit": free.of.unit,
        "curves": curves,
        "as_good": [],
    }


def _sharpened(free: FreeFunction, best: Tried) -> FreeFunction:
    """The free function with the form beside it."""
    name = best.effect.name
    columns = torch.cat([free.columns, best.solved.plain_columns[:, best.solved.places()[name]]], dim=1)
    return WithForm(free.words, free.axis, None, columns, best.effect, best.solved.shape_of(name))


def _depends_on(free: FreeFunction, best: Tried, unit: str) -> str:
    """The quantity in words; of a wave in time, with its period."""
    if best.quantity is not CLOCK or best.form.columns is not wave:
        return free.words
    return f"time that recurs every {best.parameters(unit)['period']['value'] * SECONDS_PER_HOUR:.0f} s"


def _unlike(bench: Workbench, shares: list[float], share: float) -> str:
    """The runs that behave otherwise, if any, as a sentence."""
    others = [run.name for run, one in zip(bench.runs, shares, strict=True) if one < UNLIKE * share]
    return f" Not so in {', '.join(others)}." if others and len(others) < len(shares) else ""


def _as_good(bench: Workbench, forms: FormBench, first: FreeFunction) -> list[str]:
    """Other quantities whose free function would do about as well; not those that contain the first."""
    kin = {first.words, TOGETHER, *({RATE.words} if first.of is SIZE else set()), *({SIZE.words} if first.of is RATE else set())}
    shares = {free.words: weigh(bench, forms.at, free.columns)[0] for free in forms.frees}
    return [words for words, share in shares.items() if words not in kin and share > AS_GOOD * shares[first.words]]


def _form(bench: Workbench, best: Tried, words: str) -> dict[str, Any]:
    """All that is needed to write the form as a class, see `zoo.report.unknown_stub`."""
    values = best.parameters(bench.runs[0].unit)
    effect = best.effect
    return {
        "quantity": best.quantity.of.__name__,
        "columns": best.form.columns.__name__,
        "place": effect.place,
        "needs": list(effect.needs),
        "range": [float(f"{value:.5g}") for value in (effect.low, effect.high)],
        "shape": [_declared(one, values[one.name]["value"]) for one in effect.shape],
        "amplitudes": [_bounded(one, values[one.name]["value"]) for one in effect.amplitudes],
        "formula": effect.formula,
        "depends_on": best.quantity.words,
        "words": words,
        "parameters": values,
        "rms": best.solved.rms,
        "runs": [run.name for run in bench.runs],
        "effects": list(best.solved.names[:-1]),
        "todo": False,
    }


def _declared(parameter: Parameter, value: float) -> dict[str, Any]:
    """A nonlinear parameter with the fitted value for its default."""
    return {**asdict(parameter), "default": min(max(float(f"{value:.4g}"), parameter.low), parameter.high)}


def _bounded(parameter: Parameter, value: float) -> dict[str, Any]:
    """An amplitude with bounds far around its fitted size."""
    wide = float(f"{WIDE * abs(value) or 1.0:.1g}")
    return {**asdict(parameter), "low": -wide, "high": wide, "meaning": f"found to be {value:.3g}"}
