"""The LightningModule around a model of the zoo, or many of them: the loss and nothing else."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any, cast

import torch
from lightning.pytorch import LightningModule
from torch import Tensor, nn

from zoo.errors import InputError, WorkError, in_brief
from zoo.models.base import FeatureModel, Model
from zoo.training.ensemble import Ensemble
from zoo.training.fine_blocks import seen
from zoo.training.weights import set_weights

MakeOptimizer = Callable[[Iterable[nn.Parameter]], torch.optim.Optimizer]
Batch = tuple[Tensor, Tensor]
OPTIMIZER, EVALUATIONS, FINISHED, SETTINGS, GOAL, SPENT = "optimizer_name", "evaluations", "finished", "settings", "goal", "spent_s"
"""Keys under which a checkpoint names the optimizer whose state it holds, counts, says whether that training is over and what it was, and how long it
has taken."""


class Training(LightningModule):
    """Mean squared error in units of the training data's spread.

    Model and optimizer stay out of the saved hyperparameters, since torch's weights-only loading refuses objects; give them again on reloading:
    ``Training.load_from_checkpoint(path, model=…, optimizer=…)``, of many seeds at once an `Ensemble` as the model.
    """

    def __init__(
        self,
        model: Model | Ensemble,
        optimizer: MakeOptimizer | None = None,
        error_scale: float = 1.0,
        goal: float | None = None,
        log_every: int = 50,
        settings: str = "",
        samples: int = 1,
    ) -> None:
        """Wrap a model.

        Args:
            model: what is trained.
            optimizer: makes the optimizer from the parameters; None for models that are fitted in other ways and only saved through Lightning.
            error_scale: unit of the loss [output's unit].
            goal: training stops once the loss is below; of an ensemble, each member for itself.
            log_every: steps between two points of the loss curve.
            settings: all that decides the training, as text.
            samples: of a block that the loss sees, as of `zoo.training.fine_blocks.seen`.
        """
        super().__init__()
        self.save_hyperparameters(ignore=["model", "optimizer", "settings"])
        self.model = model
        self.make_optimizer = optimizer
        self.error_scale, self.goal, self.log_every = error_scale, goal, log_every
        self.settings, self.samples, self.finished = settings, samples, False
        if isinstance(model, Ensemble):
            model.over(samples)
        self.stepper: str | None = None
        self.kept: dict[str, Any] = {}
        self.evaluations = 0
        self.began_s, self.spent_before_s = time.perf_counter(), 0.0
        self.latest: Tensor | None = None

    @property
    def net(self) -> FeatureModel:
        """What the loss sees of the structure that is trained, with its buffers."""
        return seen(cast(FeatureModel, self.model.net if isinstance(self.model, Ensemble) else self.model), self.samples)

    @property
    def members(self) -> int:
        """E."""
        return len(self.model.weights) if isinstance(self.model, Ensemble) else 1

    def start_from(self, weights: Tensor) -> None:
        """Take (E, D) initial weights."""
        if isinstance(self.model, Ensemble):
            with torch.no_grad():
                self.model.weights.copy_(weights)
        else:
            set_weights(self.model, weights[0])

    def forward(self, features: Tensor) -> Tensor:
        """(M, F) features, or rows of so many samples, -> (M,) or, of an ensemble, (E, M) predicted errors [output's unit]."""
        predicted: Tensor = self.model(features) if isinstance(self.model, Ensemble) else self.net.head(features)
        return predicted

    def loss(self, predicted: Tensor, error: Tensor) -> Tensor:
        """(..., M) predicted and (M,) true error -> (...) mean squared error, dimensionless."""
        return ((predicted - error) / self.error_scale).square().mean(-1)

    def training_step(self, batch: Batch, index: int) -> Tensor:
        """One evaluation of the loss; L-BFGS asks several times a step."""
        if isinstance(self.model, Ensemble):
            objective, self.latest = self.model.objective(*batch, self.error_scale)
        else:
            objective = self.loss(self(batch[0]), batch[1])
            self.latest = objective.detach()
        self.evaluations += 1
        return objective

    def optimizer_step(self, *args: Any, **kwargs: Any) -> None:
        """The optimizer's, after which those members of an ensemble that are done go back: before any callback sees or saves them."""
        super().optimizer_step(*args, **kwargs)
        if isinstance(self.model, Ensemble):
            assert self.latest is not None
            self.model.stepped(self.latest < (self.goal or 0.0))

    def on_train_batch_end(self, outputs: object, batch: Batch, batch_idx: int) -> None:
        """Log now and then; stop at the goal, or where the loss is no number any more."""
        assert self.latest is not None
        step = self.trainer.global_step
        if step % self.log_every == 0 or step == 1:
            if self.logger:
                self.logger.log_metrics({"loss/fit": float(self.latest.nanmedian())}, step)
            if not bool(self.latest.isfinite().any()):
                where = f"after {step} steps; try a smaller optimizer.lr" if step > 1 else "from the first weights on, before any step"
                raise WorkError(f"training diverged: the loss is {float(self.latest.max())} {where}")
        if isinstance(self.model, Ensemble):
            self.trainer.should_stop |= bool(self.model.done.all())
        elif self.goal is not None and float(self.latest) < self.goal:
            self.trainer.should_stop = True

    def validation_step(self, batch: Batch, index: int) -> None:
        """The loss of the runs to check on; of an ensemble the median, as of the fitted runs."""
        self.log("loss/check", self.loss(self(batch[0]), batch[1]).nanmedian(), batch_size=len(batch[1]))

    @property
    def optimizer_name(self) -> str | None:
        """Class of the optimizer; None for a model that brings its own fit."""
        return self.stepper if self.make_optimizer is None else type(self.configure_optimizers()).__name__

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Says whose state the checkpoint holds, since one optimizer's state means nothing to another, and what is needed to go on."""
        checkpoint |= {OPTIMIZER: self.optimizer_name, EVALUATIONS: self.evaluations, FINISHED: self.finished, SETTINGS: self.settings}
        checkpoint |= {GOAL: self.goal, SPENT: self.spent_before_s + time.perf_counter() - self.began_s} | self.kept

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Goes on counting; who had reached a goal goes on to a lower one."""
        self.evaluations, self.spent_before_s = checkpoint.get(EVALUATIONS, 0), checkpoint.get(SPENT, 0.0)
        if isinstance(self.model, Ensemble) and lowered(checkpoint, self.goal):
            checkpoint["state_dict"]["model.done"].fill_(False)

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """The optimizer chosen."""
        assert self.make_optimizer is not None
        return self.make_optimizer([parameter for parameter in self.parameters() if parameter.requires_grad])


def check_steps(make: MakeOptimizer, device: str = "cpu") -> None:
    """Let an optimizer take two steps with one weight: what it does not take, it says here, and not in the middle of a training.

    Args:
        make: the optimizer from parameters.
        device: where it will work; some settings suit one only.

    Raises:
        InputError: its settings are none.
    """
    weight = nn.Parameter(torch.tensor([1.5], dtype=torch.float64, device=device))

    def loss() -> Tensor:
        stepper.zero_grad()
        value = (weight**4).sum()  # its minimum is more than a step away
        value.backward()
        return value

    try:
        stepper = make([weight])
        stepper.step(loss)  # type: ignore[arg-type]
        if bool(weight.isnan()):
            raise ValueError("its first step leads nowhere")
        stepper.step(loss)  # type: ignore[arg-type]
    except (TypeError, ValueError, RuntimeError, AssertionError) as error:
        given = ", ".join(f"optimizer.{key}={value}" for key, value in getattr(make, "keywords", {}).items())
        raise InputError(f"{given}: {getattr(getattr(make, 'func', make), '__name__', 'the optimizer')} refuses ({in_brief(error)})") from error


def lowered(checkpoint: Mapping[str, Any], goal: float | None) -> bool:
    """Whether a training goes on to a lower goal than that of its checkpoint, so that who had reached that one is not done."""
    before = checkpoint.get(GOAL)
    return before is not None and (goal is None or goal < before)
