"""What must hold before anything is fitted, and the noise of the runs at hand."""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from zoo.effects.base import Effect, History
from zoo.errors import InputError
from zoo.fitting.noise import levels_of, noise_of
from zoo.measurements.run import Run
from zoo.scoring.spikes import off_neighbours, scatter, spikes
from zoo.units import own_time

CONSTANT_K = 0.5
SMALLEST_SWING_K = 5.0
FEWEST_BLOCKS, MOST_BLOCKS = 60, 50_000
SAMPLES = 61
MANY_SAMPLES = 0.05
"""Share of a run's samples above which what is far off its neighbours is no fault of recording."""
FEW_OUTLIERS = 4
"""More isolated blocks in one run than so many that a model leaves far off are what it lacks."""
FAR_FROM_MODEL = 3.0
"""Sigma, beyond six times the local median deviation, at which a block is far off where a model has explained the rest: of white noise 2 in
100 000, of blocks that are eight off more than half."""
ALONE = 1 / 3
"""Most that the blocks beside an outlier may be off, of what it is itself: a burst that dies away is none."""
VARIED = 0.01
"""Range of the reference over its largest value above which it varies; below, what is proportional to it is a bias to 1 %."""


def check_swing(runs: list[Run], effects: dict[str, Effect]) -> None:
    """Refuse runs that cannot determine the effects asked for, where one of them has to do with temperature.

    Raises:
        InputError: constant temperature, too small a swing, too few blocks or rows, or so many that they do not fit into memory.
    """
    low = min(float(run.block_mean(run.temperature).min()) for run in runs)
    high = max(float(run.block_mean(run.temperature).max()) for run in runs)
    names = ", ".join(run.name for run in runs)
    moving = [name for name, effect in effects.items() if _goes_with_temperature(effect)]
    if moving and high - low < CONSTANT_K:
        raise InputError(
            f"{names}: temperature_c is constant ({low:.2f} to {high:.2f} °C), so the effects of temperature and of its rate are undetermined "
            f"({', '.join(moving)}); record a run in which the chamber ramps by {SMALLEST_SWING_K:g} K or more"
        )
    if moving and high - low < SMALLEST_SWING_K:
        raise InputError(
            f"{names}: temperature_c moves by {high - low:.2f} K only ({low:.2f} to {high:.2f} °C), too little to fit {', '.join(moving)}; "
            f"at least {SMALLEST_SWING_K:g} K are needed, 60 K or more are usual"
        )
    blocks = sum(run.blocks for run in runs)
    if blocks > MOST_BLOCKS:
        many = f"{blocks} block means of {runs[0].average_s:g} s are more than can be weighed (at most {MOST_BLOCKS})"
        raise InputError(f"{names}: {many}; data.average_s=auto takes longer ones, unless the time is in another unit (data.time_unit=ms)")
    if blocks < FEWEST_BLOCKS:
        rows = int(sum(run.count.sum() for run in runs))
        few = f"{blocks} block means of {runs[0].average_s:g} s are too few to fit (at least {FEWEST_BLOCKS})"
        none = f"no data.average_s helps, there are only {rows} rows: give more runs, or record longer or more often"
        raise InputError(f"{names}: {few}; {'set data.average_s smaller' if rows >= FEWEST_BLOCKS else none}")


def _goes_with_temperature(effect: Effect) -> bool:
    """Whether an effect's columns are others in a ramp than in a hold."""
    time = torch.arange(SAMPLES, dtype=torch.float64) * 60.0
    still, input_value = torch.zeros_like(time), torch.linspace(0.0, 1.0, SAMPLES, dtype=torch.float64)
    inputs = dict.fromkeys(effect.needs, input_value)
    ramp = 0.01 * (time - time.mean()).clamp_min(0.0)
    hold = History(time, still, still, still, still, input_value, inputs, 1)
    moved = replace(hold, temperature=ramp, rate=torch.where(ramp > 0, 0.6, 0.0).to(time), gradient=torch.full_like(time, 2.0), thermometer=ramp)
    with torch.no_grad():
        return not torch.equal(*(effect.columns(one, effect.shape_value) for one in (hold, moved)))


def reference_varies(runs: list[Run]) -> bool:
    """Whether the true input differs between the blocks of these runs, so that what is proportional to it can be told from a bias."""
    values = torch.cat([run.block_mean(run.table[:, -1]) for run in runs])
    return bool(values.max() - values.min() > VARIED * values.abs().max())


def without_spikes(runs: list[Run]) -> list[Run]:
    """The runs without isolated samples and isolated blocks that are no drift, each noted."""
    runs = [_without_samples(run, spikes(run.error, scatter(run.error))) for run in runs]
    sigma = noise_of(runs).white
    return [_without(run, spikes(run.block_mean(run.error), level * sigma)) for run, level in zip(runs, levels_of(runs), strict=True)]


def without_outliers(runs: list[Run], residuals: list[Tensor], sigma: float) -> list[Run]:
    """The runs without the few isolated blocks that a model which explains the rest leaves far off, each noted; the same list where there are none.

    What moves fast, as a field that is switched or a chamber that cycles, hides them in the error itself.

    Args:
        runs: R runs.
        residuals: R of (N_r,) block means that the model leaves [unit].
        sigma: white noise of one block mean [unit].
    """
    even = [residual * run.block_share().sqrt() for run, residual in zip(runs, residuals, strict=True)]  # the last of a run is a piece of a block
    each = zip(even, levels_of(runs), strict=True)
    found = [_alone(spikes(residual, level * sigma, FAR_FROM_MODEL), residual) for residual, level in each]
    few = [bad if int(bad.sum()) <= FEW_OUTLIERS else torch.zeros_like(bad) for bad in found]
    return [_without(run, bad) for run, bad in zip(runs, few, strict=True)] if any(bool(bad.any()) for bad in few) else runs


def _alone(far: Tensor, values: Tensor) -> Tensor:
    """Those of the values (N,) far off that have nothing like them beside them, for what lasts is no outlier; at a run's ends one side is enough."""
    if not far.any():
        return far
    off = off_neighbours(values)[0].abs()
    beside = torch.nn.functional.pad(off, (1, 1))
    return far & (torch.maximum(beside[:-2], beside[2:]) < ALONE * off)


def _without_samples(run: Run, bad: Tensor) -> Run:
    """One lost sample spoils a mean over a hundred seconds; the others of its block are as good as ever."""
    bad = bad & (run.block >= 0)
    if not bad.any() or int(bad.sum()) > MANY_SAMPLES * len(bad):
        return run
    kept = torch.where(bad, -1, run.block)
    left, number = torch.unique(kept, return_inverse=True)
    block = number - int(bool(left[0] < 0))  # blocks of nothing else are gone
    times = own_time(run.time, float(run.time[0]))[bad]
    note = f"{run.name}: {int(bad.sum())} sample(s) far off their neighbours left out, at t = {_listed(times)} s"
    return replace(run, block=block, notes=(*run.notes, note))


def _listed(times: Tensor) -> str:
    return ", ".join(f"{float(time):g}" for time in times[:4]) + (", …" if len(times) > 4 else "")


def _without(run: Run, bad: Tensor) -> Run:
    if not bad.any() or int(bad.sum()) > run.blocks // 20:
        return run
    times = own_time(run.block_mean(run.time), float(run.time[0]))[bad]
    note = f"{run.name}: {int(bad.sum())} block(s) far off their neighbours left out, at t = {_listed(times)} s"
    return replace(run.with_blocks(~bad, run.name), notes=(*run.notes, note))
