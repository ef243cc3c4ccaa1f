"""Whether a checkpoint can be gone on from."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import torch

from zoo.errors import InputError
from zoo.training.module import OPTIMIZER, Training


def check_resumable(path: Path, module: Training, steps: int) -> None:
    """Compare a checkpoint with what is about to be trained.

    Args:
        path: the checkpoint.
        module: to be trained further.
        steps: optimizer steps in all, those of the checkpoint included.

    Raises:
        InputError: it is none, or of another model or optimizer, or as long trained already.
    """
    try:
        checkpoint: dict[str, Any] = torch.load(path, weights_only=True, map_location="cpu")
        state, done, optimizer = checkpoint["state_dict"], checkpoint["global_step"], checkpoint.get(OPTIMIZER)
    except (OSError, RuntimeError, KeyError, EOFError, pickle.UnpicklingError) as error:
        raise InputError(f"resume={path}: cannot be read as a checkpoint of a training ({type(error).__name__})") from error
    own = module.state_dict()
    if {name: tensor.shape for name, tensor in state.items()} != {name: tensor.shape for name, tensor in own.items()}:
        raise InputError(f"resume={path}: holds another model than this {type(module.model).__name__}; repeat that training's model settings")
    if optimizer != module.optimizer_name:
        found = optimizer or "no gradient descent"
        raise InputError(f"resume={path}: was trained by {found}, not by {module.optimizer_name}; choose the same optimizer")
    if done >= steps:
        raise InputError(f"resume={path}: has done {done} steps already, of {steps}; raise epochs")
