"""Whether a checkpoint can be gone on from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.training.files import CHECKPOINT, UNREADABLE
from zoo.training.module import EVALUATIONS, FINISHED, OPTIMIZER, SETTINGS, SPENT, Training, lowered

STATE = "stepwise"
"""Key of the state that steps of no gradient descent go on from."""


def unfinished(folder: Path, settings: str) -> Path | None:
    """The checkpoint of a training that was killed in a folder, where it is the one that is about to begin there again.

    Args:
        folder: of the results.
        settings: all that decides the training, as text.
    """
    path = folder / CHECKPOINT
    if not path.is_file():
        return None
    try:
        checkpoint = _read(path)
    except InputError:
        return None
    return path if checkpoint.get(FINISHED) is False and checkpoint.get(SETTINGS) == settings else None


def stepwise_state(path: Path, stepper: str, shape: tuple[int, int], steps: int, goal: float | None) -> tuple[int, int, dict[str, Tensor]]:
    """Steps done, evaluations of the model before the first of them, and state of a training by steps.

    Args:
        path: the checkpoint.
        stepper: class of the optimizer.
        shape: (E, D) of the weights that are about to be trained.
        steps: in all, those of the checkpoint included.
        goal: loss below which a member is done.

    Raises:
        InputError: as `check_resumable`.
    """
    checkpoint = _read(path)
    _check_optimizer(path, checkpoint.get(OPTIMIZER), stepper)
    state, done = checkpoint[STATE], int(checkpoint["steps"])
    if state is None:
        raise InputError(f"resume={path}: {stepper} cannot go on from where it was; leave resume out")
    if tuple(state["weights"].shape) != shape:
        raise InputError(f"resume={path}: holds another model or another number of seeds; repeat that training's settings")
    if done >= steps:
        raise InputError(f"resume={path}: has done {done} steps already, of {steps}; raise epochs, or train in another folder")
    if lowered(checkpoint, goal):
        state["settled"] = torch.zeros_like(state["settled"])
    return done, int(checkpoint.get(EVALUATIONS, 0)), state


def spent_before_s(path: Path | None) -> float:
    """How long the training had taken that is gone on from, by its checkpoint [s]."""
    return 0.0 if path is None else float(_read(path).get(SPENT, 0.0))


def _read(path: Path) -> dict[str, Any]:
    try:
        checkpoint = torch.load(path, weights_only=True, map_location="cpu")
        return dict(checkpoint) | {name: checkpoint[name] for name in ("state_dict", "global_step")}
    except UNREADABLE as error:
        raise InputError(f"resume={path}: cannot be read as a checkpoint of a training ({type(error).__name__})") from error


def _check_optimizer(path: Path, found: str | None, wanted: str | None) -> None:
    if found != wanted:
        raise InputError(f"resume={path}: was trained by {found or 'no gradient descent'}, not by {wanted}; choose the same optimizer")


def check_resumable(path: Path, module: Training, steps: int) -> int:
    """Compare a checkpoint with what is about to be trained.

    Args:
        path: the checkpoint.
        module: to be trained further.
        steps: optimizer steps in all, those of the checkpoint included.

    Returns:
        Steps that are done.

    Raises:
        InputError: it is none, or of another model or optimizer, or as long trained already.
    """
    checkpoint = _read(path)
    state, done = checkpoint["state_dict"], checkpoint["global_step"]
    own = module.state_dict()
    if {name: tensor.shape for name, tensor in state.items()} != {name: tensor.shape for name, tensor in own.items()}:
        raise InputError(
            f"resume={path}: holds another model than this {type(module.model).__name__}; repeat that training's model settings and seeds"
        )
    _check_optimizer(path, checkpoint.get(OPTIMIZER), module.optimizer_name)
    if checkpoint.get("hyper_parameters", {}).get("samples", 1) != module.samples:
        raise InputError(f"resume={path}: saw other samples of the blocks, from other files or in an older fogzoo; leave resume out")
    if done >= steps:
        raise InputError(f"resume={path}: has done {done} steps already, of {steps}; raise epochs, or train in another folder")
    return int(done)
