"""Predictions made elsewhere: a file with a time and a predicted error, on the blocks of the run that they were made for."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import torch
from torch import Tensor

from zoo import units
from zoo.errors import InputError
from zoo.measurements.recording import GAP_STEPS, Recording
from zoo.measurements.run import Run
from zoo.measurements.schema import Source, prediction_sources
from zoo.measurements.table import chunks, column_names

SAME = 1e-4
"""Blocks whose mean times differ by less than this share of their length hold the same rows."""


def read_prediction(path: Path, run: Run, time: str | None = None, skip: bool = False, time_unit: str | None = None) -> Tensor:
    """The predicted error of a run's blocks.

    Where the file has the rows of the run, they are averaged in the same blocks; else the predictions, or their means over a fifth of a block, are
    interpolated to the run's fine samples.

    Args:
        path: a file with ``time_s`` and ``predicted_error_<unit>``; other columns are not looked at.
        run: what it was predicted for.
        time: what the measurement files call the time, where it has that name here as well.
        skip: whether rows without a number are left out; else they are an error.
        time_unit: the unit of the time that is called as in the measurement files, where it was said.

    Returns:
        (N,) predicted error [output's unit].

    Raises:
        InputError: a column is missing, or the file does not reach over the run.
    """
    there = _averaged(path, run, prediction_sources(path, column_names(path), run.unit, time, time_unit), skip)
    own, given = run.block_mean(run.time).cpu(), there.block_mean(there.time)
    place = torch.searchsorted(given, own - SAME * run.average_s).clamp_max(max(len(given) - 1, 0))
    if len(given) and bool(((given[place] - own).abs() < SAME * run.average_s).all()):
        return there.block_mean(there.error)[place]
    return _interpolated(path, run, there)


def _averaged(path: Path, run: Run, sources: tuple[Source, Source], skip: bool) -> Run:
    """The file on the two grids of a run."""
    stream = chunks(path, [source.column for source in sources], skipped=(lambda _: None) if skip else None)
    first = next(stream)
    seconds = units.convert(first[:, 0], sources[0].given, sources[0].wanted)
    if len(seconds) < 2:
        raise InputError(f"{path}: has one row; predictions over a run are needed")
    step = float(np.median(np.diff(seconds)))
    recording = Recording(step, run.average_s, GAP_STEPS * step)
    for chunk in itertools.chain([first], stream):
        recording.push(np.column_stack([units.convert(chunk[:, i], source.given, source.wanted) for i, source in enumerate(sources)]))
    recording.close()
    fine, block, _ = recording.grids(run.average_s)
    mean = torch.from_numpy(fine.mean).T.contiguous()
    return Run(run.name, run.unit, run.average_s, ("time_s",), mean[0].unsqueeze(1), mean[1], torch.from_numpy(fine.count), torch.from_numpy(block))


def _interpolated(path: Path, run: Run, there: Run) -> Tensor:
    judged = run.time[run.block >= 0].cpu()
    begin, end, reach = float(there.time[0]), float(there.time[-1]), max(run.average_s, float(torch.diff(there.time).median()))
    if float(judged[0]) < begin - reach or float(judged[-1]) > end + reach:
        spans = f"{begin:g} to {end:g} s, the run {run.name} from {float(judged[0]):g} to {float(judged[-1]):g} s"
        raise InputError(f"{path}: reaches from {spans}; all of the run needs a prediction, on the same clock")
    clock = there.time.contiguous()
    after = torch.searchsorted(clock, judged).clamp(1, len(there.time) - 1)
    wide = (there.time[after] - there.time[after - 1] > GAP_STEPS * reach) & (judged > there.time[after - 1]) & (judged < there.time[after])
    if bool(wide.any()):
        lacking = float(judged[wide][0])
        raise InputError(f"{path}: has no prediction at {lacking:g} s, where the run {run.name} was recorded; all of the run needs one")
    value = np.interp(run.time.cpu().numpy(), there.time.numpy(), there.error.numpy())
    return run.block_mean(torch.from_numpy(value).to(run.time.device)).cpu()
