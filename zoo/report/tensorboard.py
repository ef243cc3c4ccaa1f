"""The diagnosis as TensorBoard events, to be compared with other runs side by side."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from zoo.report.canvas import png
from zoo.report.drawings import shades
from zoo.report.floors import Floors
from zoo.report.ladder_figure import ladder_figure
from zoo.report.page import scale_of
from zoo.report.palette import styled
from zoo.report.time_figure import time_figure
from zoo.report.trace import Trace, worst_first
from zoo.report.verdict import Record, ladder, verdict_of
from zoo.report.wording import DIAGNOSED, REFINED, finite

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from torch.utils.tensorboard import SummaryWriter

RUNS_DRAWN = 1
"""The worst: an image costs about 0.3 s, and the page has the others."""


def write_events(folder: str | Path, diagnosis: Record, traces: list[Trace], refinement: Record | None = None) -> None:
    """Write an event file.

    Scalars: ``rms/fit``, ``rms/check`` and ``rms/noise_floor`` in the output's unit, the rung of the ladder as the step;
    ``probability/<effect>``. Images: the ladder, and the worst run against time.

    Args:
        folder: where the event file goes.
        diagnosis: the contract's `diagnosis.json`.
        traces: the runs, fitted and checked.
        refinement: the contract's `refinement.json`, where effects were added.
    """
    from torch.utils.tensorboard import SummaryWriter

    with SummaryWriter(str(folder)) as writer:
        verdict = verdict_of(diagnosis, refinement)
        writer.add_text("verdict", "\n\n".join([f"**{verdict.headline}**", *verdict.sentences]))
        _add_scalars(writer, diagnosis, refinement)
        _add_figures(writer, diagnosis, traces, refinement)


def _add_scalars(writer: SummaryWriter, diagnosis: Record, refinement: Record | None) -> None:
    floor = Floors.read(diagnosis, refinement).fitted
    for step, rung in enumerate(ladder(diagnosis, refinement)):
        for tag, value in (("rms/fit", rung.rms), ("rms/check", rung.rms_check), ("rms/noise_floor", floor)):
            if value is not None:
                writer.add_scalar(tag, value, step)
    for entry in diagnosis.get("candidates") or []:
        chance = finite(entry.get("probability"))
        if chance is not None:
            writer.add_scalar(f"probability/{entry.get('effect')}", chance)


def _add_figures(writer: SummaryWriter, diagnosis: Record, traces: list[Trace], refinement: Record | None) -> None:
    scale, floors, rungs = scale_of(diagnosis, refinement), Floors.read(diagnosis, refinement), ladder(diagnosis, refinement)
    where, sides = diagnosis.get("where") or [], REFINED if refinement and len(rungs) > 1 else DIAGNOSED
    with styled():
        if rungs:
            add_image(writer, "ladder", ladder_figure(rungs, scale, floors))
        for trace in worst_first([trace for trace in traces if len(trace.time_s)])[:RUNS_DRAWN]:
            add_image(writer, f"runs/{trace.run}", time_figure(trace, shades(where, trace.run), scale, floors.of(trace.role, trace.run), sides))


def add_image(writer: SummaryWriter, tag: str, figure: Figure) -> None:
    """Put a figure into an event file."""
    # SummaryWriter.add_figure imports pyplot, and compresses through PIL what matplotlib has just drawn.
    from tensorboard.compat.proto.summary_pb2 import Summary

    width, height = (int(side) for side in figure.get_size_inches() * figure.dpi)
    image = Summary.Image(encoded_image_string=png(figure), colorspace=4, width=width, height=height)
    if writer.file_writer is not None:
        writer.file_writer.add_summary(Summary(value=[Summary.Value(tag=tag, image=image)]), 0)
