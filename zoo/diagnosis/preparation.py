"""What must hold before anything is fitted, and the noise of the runs at hand."""

from __future__ import annotations

from dataclasses import replace

import torch

from zoo.effects.base import Effect
from zoo.errors import InputError
from zoo.fitting.noise import noise_of
from zoo.measurements.run import Run
from zoo.scoring.spikes import spikes

CONSTANT_K = 0.5
SMALLEST_SWING_K = 5.0
FEWEST_BLOCKS = 60


def check_swing(runs: list[Run], effects: dict[str, Effect]) -> None:
    """Refuse runs that cannot determine the effects asked for.

    Raises:
        InputError: constant temperature, too small a swing, too few blocks.
    """
    low = min(float(run.block_mean(run.temperature).min()) for run in runs)
    high = max(float(run.block_mean(run.temperature).max()) for run in runs)
    names = ", ".join(run.name for run in runs)
    moving = [name for name in effects if name not in {"warm_up", "aging", "bias_step", "magnetic", "supply_voltage"}]
    if high - low < CONSTANT_K:
        raise InputError(
            f"{names}: temperature_c is constant ({low:.2f} to {high:.2f} °C), so the effects of temperature and of its rate are undetermined "
            f"({', '.join(moving)}); record a run in which the chamber ramps by {SMALLEST_SWING_K:g} K or more"
        )
    if high - low < SMALLEST_SWING_K:
        raise InputError(
            f"{names}: temperature_c moves by {high - low:.2f} K only ({low:.2f} to {high:.2f} °C), too little to fit {', '.join(moving)}; "
            f"at least {SMALLEST_SWING_K:g} K are needed, 60 K or more are usual"
        )
    blocks = sum(run.blocks for run in runs)
    if blocks < FEWEST_BLOCKS:
        raise InputError(
            f"{names}: {blocks} block means of {runs[0].average_s:g} s are too few to fit (at least {FEWEST_BLOCKS}); set data.average_s smaller"
        )


def without_spikes(runs: list[Run]) -> list[Run]:
    """The runs without isolated blocks that are no drift, each noted."""
    sigma = noise_of(runs).white
    return [_without(run, spikes(run.block_mean(run.error), sigma)) for run in runs]


def _without(run: Run, bad: torch.Tensor) -> Run:
    if not bad.any() or int(bad.sum()) > run.blocks // 20:
        return run
    times = run.block_mean(run.time)[bad]
    number = torch.where(bad, -1, torch.cumsum((~bad).long(), 0) - 1)
    block = torch.where(run.block >= 0, number[run.block.clamp_min(0)], -1)
    listed = ", ".join(f"{float(time):g}" for time in times[:4]) + (", …" if len(times) > 4 else "")
    note = f"{run.name}: {int(bad.sum())} block(s) far off their neighbours left out, at t = {listed} s"
    return replace(run, block=block, notes=(*run.notes, note))
