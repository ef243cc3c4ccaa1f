"""What a swarm algorithm is: a module with `init`, `ask` and `tell` on a state that is a tuple of tensors."""

from __future__ import annotations

from typing import Any, Protocol

from torch import Tensor

from zoo.swarm.box import Chance


class SwarmAlgorithm(Protocol):
    """A module such as `zoo.swarm.pso`; pure functions that know nothing of what the positions mean."""

    def init(self, low: Tensor, high: Tensor, particles: int, generator: Chance, **settings: Any) -> Any:
        """Place the swarm in the box (..., D) and return its state. The setting `steps` says how often it will be told, for schedules."""

    def ask(self, state: Any) -> Tensor:
        """(..., P, D) positions whose cost is wanted."""

    def tell(self, state: Any, cost: Tensor, generator: Chance) -> Any:
        """The next state, given the (..., P) costs of the positions asked for."""
