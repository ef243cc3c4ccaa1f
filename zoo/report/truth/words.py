"""What the page with the truth about a simulated gyro says in words and in single numbers."""

from __future__ import annotations

from collections.abc import Iterator

import torch

from zoo.report.truth.effect_stack import Parts
from zoo.report.truth.winding_numbers import WEIGHT, axial_weight, radial_weight, trimmed
from zoo.report.wording import joined, significant
from zoo.scoring.stages import rms
from zoo.simulator.recorded import Recorded
from zoo.simulator.simulated import truth_file
from zoo.simulator.simulation import Simulation
from zoo.simulator.thermal.winding_weights import column_weight

NOTHING = 1e-3
"""So little of the whole is not worth a word."""


def sentences(simulation: Simulation) -> Iterator[str]:
    """What it is made of, where the truth lies, and a warning."""
    hidden = f"; hidden: {joined(simulation.hidden)}" if simulation.hidden else ""
    yield f"Effects: {joined(simulation.present) or 'none'}{hidden}."
    runs = [*simulation.runs, simulation.check]
    files, data = (joined([name(run) for run in runs]) if len(runs) < 5 else f"{name(runs[0])} … {name(runs[-1])}" for name in (truth_file, _file))
    yield f"Beside this page, truth.json holds the gyro's numbers, and {files} what each effect adds, row by row of {data}."
    yield "The page gives away what a diagnosis is asked to find: to put one to the test, run it before reading on."


def _file(run: Recorded) -> str:
    return f"{run.name}.csv"


def tiles(simulation: Simulation) -> Iterator[tuple[str, str, str, str]]:
    """Label, value, unit, remark of the numbers to begin with."""
    device = simulation.device
    errors, noises = (
        torch.cat([one - one.mean() for one in each]) for each in ([run.error for run in simulation.runs], [run.noise for run in simulation.runs])
    )
    turns = f"{device.gyro.pattern.replace('_', '-')}, {device.gyro.layers} layers of {device.gyro.turns} turns"
    yield "Shupe's weight of the winding, C_w", significant(radial_weight(device.winding)), WEIGHT, turns
    yield "Fibre", significant(device.winding.fibre_m, 4), "m", f"on {significant(1e3 * device['diameter_m'])} mm of mean diameter"
    yield "Recorded error, RMS about the mean", significant(rms(errors)), "°/h", "of the fitted runs, row by row"
    yield "Noise in it", significant(rms(noises)), "°/h", f"in rows of {simulation.settings.sample_s:g} s"


def winding_text(simulation: Simulation) -> Iterator[str]:
    """How it is wound, how to read the picture, and what it makes of heat."""
    device = simulation.device
    winding, gyro, (cut, end) = device.winding, device.gyro, trimmed(device.winding)
    yield f"{gyro.pattern.replace('_', '-').capitalize()}: {gyro.layers} layers of {gyro.turns} turns, {significant(winding.fibre_m, 4)} m of fibre"
    yield f"after trimming {significant(cut)} m at the end of {end}." if cut > 0 else "that was not trimmed."
    yield "Orange turns lie between the middle of the fibre and the end of A, purple ones towards that of B; the darker, the"
    yield "farther out and the more they weigh. The band beside the section names the supply that laid them."
    yield f"Where the upper face warms faster than the lower one by 1 K/min, the error is {significant(axial_weight(winding))} °/h."
    share, own = simulation.shares.get("shupe"), column_weight(device)
    if share is not None and abs(float(share.amplitude[0]) - own) > NOTHING * abs(own):
        given = significant(float(share.amplitude[0]))
        yield f"The Shupe effect of this gyro was set to {given} {WEIGHT}; by its winding it would be {significant(own)}."


def at_rest(parts: Parts) -> str:
    """What the effects of a run are at rest, those that are worth saying."""
    largest = max((float(abs(values).max()) for values in parts.change.values()), default=0.0)
    told = [f"{name} {significant(value)} °/h" for name, value in parts.constant.items() if abs(value) > NOTHING * largest]
    if not any(parts.constant.values()):
        return "from zero"
    return f"at rest {joined(told)}" if told else "next to nothing at rest"
