"""A model applied to a run."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.measurements.run import OUTPUT, Run
from zoo.models.base import FeatureModel, Model

LIKE = 0.85
"""Likeness of names above which one is taken for the other, mistyped (difflib's ratio)."""


def raw_columns(model: Model, run: Run) -> Tensor:
    """(T, C) the columns of a run that a model takes.

    Raises:
        InputError: the run lacks one of them.
    """
    missing = [name for name in model.inputs if name not in (*run.columns, OUTPUT)]
    if missing:
        left_out = [note for note in run.notes if note.split(" ", 1)[0] in missing]
        meant = [close for name in missing for close in difflib.get_close_matches(name, run.known, n=1, cutoff=LIKE)]
        has = f"he file has {', '.join(run.known)}"
        there = f"here {', '.join(left_out)}" if left_out else f"did you mean {', '.join(meant)}? T{has}" if meant else f"t{has}"
        raise InputError(f"{run.name}: the model needs the column {', '.join(missing)}; {there}")
    return run.select(model.inputs)


def block_features(model: FeatureModel, run: Run) -> Tensor:
    """(N, F) block means of a model's features; the features remember, so they are computed on the fine grid and averaged then."""
    with torch.no_grad():
        return run.block_mean_columns(model.features(raw_columns(model, run)))


def predict_blocks(model: Model, run: Run) -> Tensor:
    """(N,) block means of the error that a model predicts for a run [output's unit], on the CPU."""
    device = next((tensor.device for tensor in [*model.parameters(), *model.buffers()]), torch.device("cpu"))
    with torch.no_grad():
        return run.block_mean(model(raw_columns(model, run).to(device)).to(run.table.device)).cpu()


def predict_blocks_of_each(models: Sequence[Model], run: Run) -> Tensor:
    """(E, N) block means of what E models predict for a run [output's unit]; features that they share are computed once.

    Args:
        models: of one class and with the same settings, as trained from several seeds.
        run: any.
    """
    first = models[0]
    if not isinstance(first, FeatureModel):
        return torch.stack([predict_blocks(model, run) for model in models])
    with torch.no_grad():
        features = first.features(raw_columns(first, run))
        return torch.stack([run.block_mean(model.head(features)) for model in models if isinstance(model, FeatureModel)])


def usable_device(name: str) -> torch.device:
    """The device behind `torch_device=`.

    Raises:
        InputError: no such device here.
    """
    try:
        device = torch.device(name)
    except (RuntimeError, TypeError):
        device = None
    if device is None or device.type not in {"cpu", "cuda"}:
        raise InputError(f"torch_device={name}: possible: cpu, cuda, cuda:1")
    if device.type == "cuda" and (device.index or 0) >= torch.cuda.device_count():
        there = f"{torch.cuda.device_count()} CUDA device(s)" if torch.cuda.is_available() else "no CUDA device"
        raise InputError(f"torch_device={name}: this machine has {there} that torch can use; possible: cpu")
    return device
