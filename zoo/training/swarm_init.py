"""Initial weights by a swarm, as a Lightning callback: the search of ACO-BP and PSO-BP before the gradient takes over."""

from __future__ import annotations

from typing import Any

import torch
from lightning.pytorch import Callback, LightningModule, Trainer

from zoo.errors import WorkError
from zoo.progress import progress
from zoo.swarm.algorithm import SwarmAlgorithm
from zoo.training.module import Training
from zoo.training.weights import population_outputs, set_weights, weight_vector


class SwarmInit(Callback):
    """Searches the box ±reach of all weights for the lowest training loss and starts training there.

    `on_train_start` is the first hook with data. On resume the weights are back by then, so the swarm must not run again.
    """

    def __init__(self, algorithm: SwarmAlgorithm, particles: int = 30, steps: int = 100, reach: float = 1.0, seed: int = 1, **settings: Any) -> None:
        """Describe the search.

        Args:
            algorithm: a module such as `zoo.swarm.pso`.
            particles: P.
            steps: evaluations of the whole population.
            reach: the box in every dimension is −reach…reach (features and error are standardised).
            seed: of the search alone.
            **settings: passed on to the algorithm's `init`.
        """
        self.algorithm, self.particles, self.steps, self.reach, self.seed = algorithm, particles, steps, reach, seed
        self.settings = {"steps": steps} | settings
        self.evaluations = 0
        self.best: float | None = None

    def on_train_start(self, trainer: Trainer, pl_module: LightningModule) -> None:
        """Search, unless training goes on from a checkpoint."""
        if trainer.global_step > 0 or self.evaluations > 0:
            return
        assert isinstance(pl_module, Training)
        features, error = trainer.datamodule.fitted  # type: ignore[attr-defined]
        chance = torch.Generator().manual_seed(self.seed)
        edge = torch.full_like(weight_vector(pl_module.model), self.reach)
        state = self.algorithm.init(-edge, edge, self.particles, chance, **self.settings)
        with progress("swarm", self.steps) as advance:
            for step in range(self.steps):
                predicted = population_outputs(pl_module.model, self.algorithm.ask(state), features)  # type: ignore[arg-type]
                state = self.algorithm.tell(state, pl_module.loss(predicted, error), chance)
                if trainer.logger:
                    trainer.logger.log_metrics({"swarm/best": float(state.leader_cost)}, step)
                advance()
        if not torch.isfinite(state.leader_cost):
            raise WorkError(f"init: the swarm found no weights with a finite loss within ±{self.reach}")
        set_weights(pl_module.model, state.leader)
        self.evaluations, self.best = state.evaluations, float(state.leader_cost)

    def state_dict(self) -> dict[str, Any]:
        """What a checkpoint keeps: that the search is done, and what it found."""
        return {"evaluations": self.evaluations, "best": self.best}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        """The inverse of `state_dict`."""
        self.evaluations, self.best = state_dict["evaluations"], state_dict["best"]
