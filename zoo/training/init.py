"""What draws the weights that a training starts from."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

from lightning.pytorch import Callback, LightningModule, Trainer
from torch import Tensor

from zoo.training.module import Training
from zoo.training.problem import Problem

Log = Callable[[dict[str, float], int], None]
"""Takes scalars and the step that they belong to."""


class Init(Callback):
    """Abstract: initial weights, for training through Lightning as a callback and for anything else by `weights`.

    Attributes:
        seed: member k of an ensemble is drawn from the seed `seed` + k alone, so that it is what a training of its own would be.
        evaluations: of the model, for each member.
    """

    seed: int
    evaluations: int = 0

    def weights(self, problem: Problem, members: int, log: Log) -> Tensor:
        """Draw.

        Args:
            problem: whose loss should be low.
            members: E.
            log: takes the curve of a search.

        Returns:
            (E, D) weights.
        """
        raise NotImplementedError

    def of_member(self, k: int) -> Init:
        """The same for member k alone."""
        one = copy.copy(self)
        one.seed, one.evaluations = self.seed + k, 0
        return one

    def on_train_start(self, trainer: Trainer, pl_module: LightningModule) -> None:
        """Draw, unless training goes on from a checkpoint: the weights are back by then, and `on_train_start` is the first hook with data."""
        if trainer.global_step > 0:
            return
        assert isinstance(pl_module, Training)
        problem = Problem(pl_module.net, *trainer.datamodule.fitted)  # type: ignore[attr-defined]
        pl_module.start_from(self.weights(problem, pl_module.members, log_to(trainer.logger)))

    def state_dict(self) -> dict[str, Any]:
        """What a checkpoint keeps."""
        return {"evaluations": self.evaluations}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        """The inverse of `state_dict`."""
        self.evaluations = state_dict["evaluations"]


def log_to(logger: Any) -> Log:
    """A function that logs to one of Lightning's loggers, or to nobody."""

    def log(values: dict[str, float], step: int) -> None:
        if logger:
            logger.log_metrics(values, step)

    return log
