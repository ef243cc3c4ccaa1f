"""What the thermometers and the other columns of a run that was not taken yet would show."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch

from zoo.diagnosis.experiment.circumstances import Circumstances, thermometer
from zoo.diagnosis.experiment.family import Candidate
from zoo.measurements.recording import FINE_PER_BLOCK
from zoo.measurements.run import Run
from zoo.scoring.noise import Blocks, NoiseModel, Whitener
from zoo.simulator.laboratory.program import Program

MOST_BLOCKS = 200
"""Longer runs are predicted in longer blocks, whose noise is accordingly less."""


@dataclass(frozen=True, eq=False)
class Predicted:
    """A run as far as it is known before it is taken.

    Attributes:
        run: its columns; the error is zero, as nobody knows it.
        whitener: for its block means.
        program: chamber and true input, the latter in place of a rate [output's unit].
    """

    run: Run
    whitener: Whitener
    program: Program


def predicted(runs: list[Run], noise: NoiseModel, known: Circumstances, candidate: Candidate) -> Predicted:
    """The run that a candidate would give.

    Inputs other than temperature and reference are taken to go on as in the first run.

    Args:
        runs: those at hand.
        noise: of one of their block means.
        known: what they tell of the laboratory.
        candidate: the run to predict.
    """
    first = runs[0]
    longer = math.ceil(candidate.seconds / first.average_s / MOST_BLOCKS)
    average_s = longer * first.average_s
    fine = torch.arange(max(FINE_PER_BLOCK, int(candidate.seconds / average_s * FINE_PER_BLOCK)), dtype=torch.float64) * (average_s / FINE_PER_BLOCK)
    program = Program(candidate.legs, true_input(candidate, known))
    air = program.asked(fine)
    names, cold = list(first.columns), candidate.extra == "power_on"
    columns = {name: _again(first, name, len(fine)) for name in names}
    for name, lag, offset in zip(first.thermometers, known.lags_s, known.offsets_k, strict=True):
        columns[name] = thermometer(fine, air, lag, cold) + offset
    columns[names[0]] = fine
    columns[names[-1]] = program.rate(fine) if candidate.turns else torch.full_like(fine, known.usual)
    block = torch.arange(len(fine)) // FINE_PER_BLOCK
    block = torch.where(block < len(fine) // FINE_PER_BLOCK, block, -1)
    table = torch.stack([columns[name] for name in names], dim=1)
    run = Run(candidate.name, first.unit, average_s, tuple(names), table, torch.zeros_like(fine), torch.ones_like(block), block)
    run = run.to(first.table.device)
    times = run.block_mean(run.time)
    return Predicted(run, Whitener(noise, [Blocks(times, torch.full_like(times, float(longer)))]), program)


def true_input(candidate: Candidate, known: Circumstances) -> tuple[tuple[float, float], ...]:
    """True input and duration [output's unit, s], piece after piece, to the end of the run; empty where it stays as it was."""
    if not candidate.turns:
        return ()
    return tuple((factor * (known.reference or 0.0), seconds) for factor, seconds in candidate.turns)


def _again(run: Run, name: str, count: int) -> torch.Tensor:
    """(count,) a recorded column, over and over."""
    value = run.column(name).cpu()
    return value[torch.arange(count) % len(value)]
