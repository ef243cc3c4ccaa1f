"""Weights of small networks by damped Gauss–Newton steps (Levenberg–Marquardt), which end where a gradient's are still on the way.

One step of weights w with residual r = target − f(w) and Jacobian J = df/dw solves (JᵀJ + λ·diag(s))·δ = Jᵀr (Marquardt 1963), s being the diagonal
of JᵀJ. Any number of members takes its steps side by side, each with a λ of its own. Weights that f is linear in are damped like the others: left
undamped, which makes δ that of variable projection as Kaufman (1975) simplified it, they gained in the first five steps, and then crept.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import torch
from torch import Tensor

from zoo.models.base import FeatureModel
from zoo.training.weights import population_outputs, set_weights, weight_jacobian, weight_vector

FIRST, LEAST, MOST = 1e-2, 1e-9, 1e9
"""Damping over the diagonal of the normal matrix, at first and within what bounds."""
RATIOS = (0.1, 1.0, 10.0)
"""Dampings of one step over that of the last."""
SETTLED = 1e-6
"""Share of the cost by which a step must lower it to be followed by another."""
RIDGE = 1e-12
"""Damping, over the largest diagonal element, of all weights: some may change nothing."""

Normal = Callable[[Tensor], tuple[Tensor, Tensor]]
"""(E, D) weights -> (E, D, D) JᵀJ and (E, D) Jᵀr."""
Losses = Callable[[Tensor], Tensor]
"""(E, P, D) weights -> (E, P) sums of squared residuals, in the units of JᵀJ."""


class Descent(NamedTuple):
    """E members on their way down.

    Attributes:
        weights: (E, D).
        losses: (E,) sums of squared residuals.
        damping: (E,) λ.
        settled: (E,) bool: has come to rest.
        steps: (E,) tried.
    """

    weights: Tensor
    losses: Tensor
    damping: Tensor
    settled: Tensor
    steps: Tensor


def begin(weights: Tensor, losses: Tensor) -> Descent:
    """Members at rest nowhere yet.

    Args:
        weights: (E, D).
        losses: (E,); a member whose cost is no number stays where it is.
    """
    return Descent(weights, losses, torch.full_like(losses, FIRST), ~losses.isfinite(), torch.zeros_like(losses, dtype=torch.int64))


def step(state: Descent, normal: Normal, losses: Losses, settled: float = SETTLED) -> Descent:
    """One step of all that are not settled; none of them goes up.

    Args:
        state: the members.
        normal: gives the normal equations.
        losses: judges the trials, one for each of `RATIOS`.
        settled: share of its cost by which a step must lower it to be followed by another.
    """
    active = (~state.settled).nonzero().squeeze(-1)
    here, cost, damping = state.weights[active], state.losses[active], state.damping[active]
    dampings = damping.unsqueeze(-1) * torch.tensor(RATIOS, dtype=here.dtype, device=here.device)
    trials = here.unsqueeze(1) + _steps(*normal(here), dampings)
    found, best = losses(trials).nan_to_num(nan=torch.inf).min(dim=-1)
    gain, chosen = cost - found, best.unsqueeze(-1)
    better = gain > 0
    reached = torch.where(better.unsqueeze(-1), trials.gather(1, chosen.unsqueeze(-1).expand(-1, 1, here.shape[-1])).squeeze(1), here)
    eased = torch.where(better, dampings.gather(1, chosen).squeeze(1).clamp_min(LEAST), damping * RATIOS[-1] ** 2)
    rest = torch.where(better, gain < settled * cost, damping > MOST)
    return Descent(
        state.weights.index_copy(0, active, reached),
        state.losses.index_copy(0, active, torch.where(better, found, cost)),
        state.damping.index_copy(0, active, eased),
        state.settled.index_copy(0, active, rest),
        state.steps.index_add(0, active, torch.ones_like(active)),
    )


def _steps(normal: Tensor, slope: Tensor, dampings: Tensor) -> Tensor:
    """(E, P, D) one step a damping (E, P)."""
    scale = normal.diagonal(dim1=-2, dim2=-1)
    floor = RIDGE * scale.amax(-1, keepdim=True) + 1e-300
    added = dampings.unsqueeze(-1) * scale.clamp_min(floor).unsqueeze(1) + floor.unsqueeze(1)
    # A member without finite equations gets no step, and does not stop the others.
    steps = torch.linalg.solve_ex(normal.unsqueeze(1) + torch.diag_embed(added), slope.unsqueeze(1).expand_as(added).unsqueeze(-1))[0]
    return steps.squeeze(-1)


def descend(model: FeatureModel, features: Tensor, target: Tensor, weigh: Callable[[Tensor], Tensor], steps: int) -> float:
    """Lower χ² = ‖weigh(target − model(features))‖² from the weights that a model has, in place.

    Args:
        model: with D weights.
        features: (N, F).
        target: (N,) [output's unit].
        weigh: linear map (..., N, K) -> (..., N, K), such as a whitener.
        steps: most steps.

    Returns:
        χ² at the end.
    """

    def residuals(weights: Tensor) -> Tensor:
        return weigh((target - population_outputs(model, weights, features)).mT).mT

    def normal(weights: Tensor) -> tuple[Tensor, Tensor]:
        set_weights(model, weights[0])
        jacobian = weigh(weight_jacobian(model, features))
        return (jacobian.mT @ jacobian).unsqueeze(0), residuals(weights) @ jacobian

    def losses(weights: Tensor) -> Tensor:
        return residuals(weights[0]).square().sum(dim=-1).unsqueeze(0)

    here = weight_vector(model).unsqueeze(0)
    state = begin(here, losses(here.unsqueeze(0))[0])
    for _ in range(steps):
        if bool(state.settled.all()):
            break
        state = step(state, normal, losses)
    set_weights(model, state.weights[0])
    return float(state.losses[0])
