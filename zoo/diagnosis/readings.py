"""What the scatter of the thermometers' readings makes of a model's output, and runs that are fitted without it.

A large coefficient of a rate or of a difference turns the steps of 1/16 K that a thermometer reads in into a noise of the model. It is none of the
gyro's, and no effect's; but a fit trades it for a longer lag, and a search finds an effect that smooths it. Drawn smooth, readings are off by a
quarter as much (errors in variables; Carroll et al. 2006, Measurement Error in Nonlinear Models).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import torch
from torch import Tensor

from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.design import Design
from zoo.measurements.run import Run
from zoo.measurements.steady import scatter, steadied
from zoo.models.graybox import GrayBox
from zoo.models.prediction import predict_blocks
from zoo.scoring.stages import rms
from zoo.units import symbol

MATTERS = 0.3
"""What readings' scatter makes of a model's output over the white noise of the runs, from which it matters: a tenth of the variance."""
SEED = 0


def without_scatter(bench: Workbench, models: Iterable[Solved]) -> Workbench:
    """The bench with its thermometers drawn smooth, what that leaves of their scatter being noise; itself where it matters in none of the models.

    Args:
        bench: the runs and their noise; is told what readings make of the first model's output.
        models: fitted to them.
    """
    if bench.steadied:
        return bench
    random = torch.Generator().manual_seed(SEED)
    stirred = _design(bench, [_stirred(run, random) for run in bench.runs])
    stirs = [(one, rms(_output(one, stirred) - (one.design.error - one.residual))) for one in models]
    bench.stirred = bench.stirred or next((made for _, made in stirs), 0.0)  # once, or two models would be judged by different prices
    troubled = [one for one, made in stirs if made > MATTERS * bench.mixtures.white]
    if not troubled:
        return bench
    steady = [steadied(run) for run in bench.runs]
    if all(torch.equal(one.table, run.table) for one, run in zip(steady, bench.runs, strict=True)):  # too few readings for a curve
        return bench
    true, again = _design(bench, steady), _design(bench, [steadied(_tossed(run, one, random)) for run, one in zip(bench.runs, steady, strict=True)])
    made = max(rms(one.design.error - one.residual - _output(one, true)) for one in troubled)
    left = max(rms(_output(one, again) - _output(one, true)) for one in troubled)
    noise = f"{made:.2g} {symbol(bench.runs[0].unit)}"
    told = f"the steps and the scatter of the thermometers' readings make a noise of {noise} in the model; they were drawn smooth for the diagnosis"
    steady = [replace(run, notes=(*run.notes, f"{run.name}: {told}")) for run in steady]
    return bench.with_runs(steady, math.hypot(bench.mixtures.white, left), left)


def as_flown(bench: Workbench, models: Sequence[Solved]) -> list[Solved]:
    """The same models fitted on to readings as they are, where they were drawn smooth: in flight there are no others.

    A model that was fitted to smooth readings makes more of the others' scatter than one that has seen it.
    """
    if not bench.steadied:
        return [*models]
    flown = bench.as_read()
    return [flown.solve(one.names, [one.fit.theta], one.likely.place) for one in models]


def scatter_in(model: GrayBox, runs: Sequence[Run]) -> float | None:
    """RMS of what the scatter of readings makes of a model's block means of some runs [unit]; None where there are none."""
    made = [predict_blocks(model, run.as_read) - predict_blocks(model, steadied(run.as_read)) for run in runs]
    return rms(torch.cat(made)) if made else None


def _design(bench: Workbench, runs: list[Run]) -> Design:
    """A bench's runs with other readings, of no effects."""
    return Design(GrayBox({}, bench.inputs, bench.in_motion), runs, bench.whitener)


def _output(solved: Solved, design: Design) -> Tensor:
    """(N,) block means of what a model, as it was fitted, makes of other readings [unit]."""
    return design.of(solved.model).plain_columns(solved.fit.theta.unsqueeze(0))[0] @ solved.fit.amplitudes


def _stirred(run: Run, random: torch.Generator) -> Run:
    """A run whose thermometers scatter once more as much."""
    table = run.table.clone()
    for place in map(run.columns.index, run.thermometers):
        table[:, place] += scatter(table[:, place]) * torch.randn(len(table), generator=random, dtype=table.dtype).to(table)
    return replace(run, table=table)


def _tossed(run: Run, curve: Run, random: torch.Generator) -> Run:
    """Its steadied thermometers with what each reading is off them, above or below as a coin falls (wild bootstrap; Wu 1986)."""
    sign = 2.0 * torch.randint(2, run.table.shape, generator=random).to(run.table) - 1.0
    return replace(run, table=curve.table + sign * (run.table - curve.table))
