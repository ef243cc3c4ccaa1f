"""The comparison as images and as TensorBoard events."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from zoo.report.canvas import write_png
from zoo.report.comparison_page import scale_of, seeds_drawn, stages_drawn
from zoo.report.comparison_words import notes
from zoo.report.palette import styled
from zoo.report.run_figure import Curves, run_figure
from zoo.report.tensorboard import add_image

if TYPE_CHECKING:
    from torch.utils.tensorboard import SummaryWriter

HYPERPARAMETERS = ("init", "optimizer")
IMAGES = 12
"""Runs drawn at most, the first ones: an image takes a quarter of a second."""


def write_comparison_events(out: Path, document: dict[str, Any], curves: list[Curves]) -> None:
    """Write ``comparison.png``, ``seeds.png``, ``residual_RUN.png`` and an event file in ``tensorboard/``.

    Scalars: ``rms/MODEL``, ``method/NAME`` with its floor; hyperparameters: one trial a method. Images as the files.

    Args:
        out: folder of the results.
        document: `comparison.json`.
        curves: of every run.
    """
    from torch.utils.tensorboard import SummaryWriter

    scale = scale_of(document)
    with styled(), SummaryWriter(str(out / "tensorboard")) as board:
        figures = {"comparison": stages_drawn(document, scale), "seeds": seeds_drawn(document, scale)}
        for one in curves[:IMAGES]:
            figures[f"residual_{one.run}"] = run_figure(one, document["noise_floors"][one.run], scale)
        for name, figure in figures.items():
            write_png(out / f"{name.replace('/', '_')}.png", figure)
            add_image(board, name, figure)
        for name, value in document["rms"].items():
            board.add_scalar(f"rms/{name}", value)
        board.add_scalar("rms/noise_floor", document["noise_floor"])
        _add_trials(board, document)


def _add_trials(board: SummaryWriter, document: dict[str, Any]) -> None:
    """One trial a method, so that the table of hyperparameters sorts them."""
    facts = {model["name"]: model for model in document["models"]}
    for one in document["methods"]:
        of = facts[one["models"][0]]
        known = {key: str(of[key]) for key in HYPERPARAMETERS if of.get(key) is not None}
        numbers = {"rms/median": one["rms"]["median"], "rms/low": one["rms"]["low"], "rms/high": one["rms"]["high"], "rms/times_floor": one["excess"]}
        board.add_hparams({"method": one["name"], "seeds": one["distinct"]} | known, numbers, run_name=f"methods/{one['name'].replace('/', '_')}")
    board.add_text("comparison", "\n\n".join([f"**{document['statement']}**", *(pair["statement"] for pair in document["pairs"]), *notes(document)]))
