"""One case, judged: what the diagnosis says of it beside what is true."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from hidden_effects.case import Case, made
from hidden_effects.forms.form import decade
from hidden_effects.recipe import BASE, LARGEST, Recipe, recipe
from hidden_effects.visible import check_over_floor_told, left_beside, noise_rms, visible

from zoo.catalog import build, names
from zoo.diagnosis.refine import Refinement, refine
from zoo.effects.base import Effect

TRUE_OF_BASE = {"mohr": "coefficient", "static_bias": "slope"}
"""Parameters of the base that the simulator's plant has as well."""
KEPT = ("effect", "probability", "indistinguishable_from", "delta_bic")
DECIDED = 2.5, 14.0
"""Sizes z between which detection is decided: an ideal detector of some twenty effects finds 4.6 to 4.9 with 90 %."""
Row = dict[str, Any]


@cache
def catalogue() -> dict[str, Effect]:
    """Every effect there is today."""
    return {name: build("effects", name) for name in names("effects")}


def judged(seed: int) -> Row:
    """Make a case, diagnose it and compare; what goes wrong is in the row, so that one case costs no other its result."""
    return _timed(seed, recipe)


def judged_near(seed: int) -> Row:
    """The same of a case with one hidden effect whose amplitude is set to where its detection is decided."""
    return _timed(seed, near)


def near(seed: int) -> Recipe:
    """A case with one hidden effect of a size z drawn from `DECIDED`, or of the largest amplitude where even that is less.

    An amplitude drawn at large is, for most effects, never seen or never missed, and says little of where the limit lies.
    """
    one = recipe(seed)
    wanted = decade(one.chance(6), *DECIDED)
    size = max(visible(made(one), catalogue()).sizes[0], 1e-9)
    return replace(one, amplitudes=(min(one.amplitudes[0] * wanted / size, LARGEST),))


def _timed(seed: int, drawn: Callable[[int], Recipe]) -> Row:
    started = time.perf_counter()
    try:
        found = _judged(drawn(seed))
    except Exception as error:
        one = recipe(seed)
        found = {"kind": one.kind, "hidden": [], "failed": f"{type(error).__name__}: {error}"}
    return {"seed": seed, "catalogue": len(catalogue()), **found, "seconds": time.perf_counter() - started}


def _judged(one: Recipe) -> Row:
    case = made(one)
    *fitted, check = case.measured()
    started = time.perf_counter()
    refined = refine(fitted, [check], list(BASE), "auto", catalogue())
    seconds = time.perf_counter() - started
    said = _said(refined.diagnosis.record)
    return {
        **_truth(case),
        "blocks": sum(run.blocks for run in fitted),
        "rows": sum(run.rows for run in fitted),
        **said,
        "left_beside_named": left_beside(case, said["missing"], catalogue()) if case.recipe.kind == "outside" and said["missing"] else None,
        "check_over_floor_told": None if case.recipe.kind == "outside" else check_over_floor_told(case, catalogue()),
        "candidates_tried": len(refined.diagnosis.bench.available()) - len(BASE),
        "check_over_floor": refined.record["ladder"][-1]["rms_check"] / noise_rms(case.noise_blocks()[-1]),
        "parameters": list(_parameters(case, refined)),
        "seconds_refine": seconds,
    }


def _truth(case: Case) -> Row:
    one, seen = case.recipe, visible(case, catalogue())
    hidden = [
        {"name": part.name, "variant": part.form.variant, "amplitude": size, "z": z, "visible": rms / case.sigma_dph}
        for part, size, z, rms in zip(case.hidden, one.amplitudes, seen.sizes, seen.rms, strict=True)
    ]
    drawn = {key: getattr(one, key) for key in ("kind", "gyro", "heat", "turns", "gap", "spikes")}
    counts = {"runs": len(one.programs), "program": one.programs[0], "thermometers": len(one.thermometers)}
    return {**drawn, **counts, "hidden": hidden, "check_over_floor_without_hidden": seen.check_over_floor}


def _said(record: Mapping[str, Any]) -> Row:
    candidates = [{key: entry[key] for key in KEPT} for entry in record["candidates"]]
    rest = {key: record.get(key) for key in ("verdict", "missing", "posterior", "next_experiment", "unexplained", "rms", "rms_final", "noise_floor")}
    return {**rest, "candidates": candidates}


def _parameters(case: Case, refined: Refinement) -> Iterator[Row]:
    """Every parameter that truth and model share, with its estimate and error bar."""
    fitted = refined.record["parameters"]
    for owner, name, truth in _true_values(case):
        entry = fitted.get(owner, {}).get(name)
        if entry and entry["stderr"] is not None:
            yield {"effect": owner, "parameter": name, "truth": truth, "value": entry["value"], "stderr": entry["stderr"]}


def _true_values(case: Case) -> Iterator[tuple[str, str, float]]:
    for owner, name in TRUE_OF_BASE.items():
        yield owner, name, case.simulation.shares[owner].parameters()[name][0]
    for one in case.hidden:
        for name, value in one.form.amplitudes.items():
            yield one.name, name, one.scale * value
        for name, value in one.form.shapes.items():
            yield one.name, name, value
