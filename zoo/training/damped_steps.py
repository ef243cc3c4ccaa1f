"""Weights of a small network by damped Gauss–Newton steps, which end where a gradient's are still on the way."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from zoo.models.base import FeatureModel
from zoo.training.weights import population_outputs, set_weights, weight_jacobian, weight_vector

FIRST, LEAST, MOST = 1e-2, 1e-9, 1e9
"""Damping over the diagonal of the normal matrix, at first and within what bounds."""
RATIOS = (0.1, 1.0, 10.0)
"""Dampings of one step over that of the last."""
SETTLED = 1e-6
"""Share of χ² by which a step must lower it to be followed by another."""


def descend(model: FeatureModel, features: Tensor, target: Tensor, weigh: Callable[[Tensor], Tensor], steps: int) -> float:
    """Lower χ² = ‖weigh(target − model(features))‖² from the weights that a model has, by Levenberg–Marquardt (Marquardt 1963), in place.

    Args:
        model: with D weights.
        features: (N, F).
        target: (N,) [output's unit].
        weigh: linear map (..., N, K) -> (..., N, K), such as a whitener.
        steps: most steps.

    Returns:
        χ² at the end.
    """
    damping, here = FIRST, weight_vector(model)
    left = _residuals(model, here.unsqueeze(0), features, target, weigh)
    cost = float(left.square().sum())
    for _ in range(steps):
        jacobian = weigh(weight_jacobian(model, features))
        trials = here + _steps(jacobian, left[0], torch.tensor(RATIOS, dtype=here.dtype, device=here.device) * damping)
        found = _residuals(model, trials, features, target, weigh)
        costs = found.square().sum(dim=1).nan_to_num(nan=torch.inf)
        best = int(costs.argmin())
        gain = cost - float(costs[best])
        if gain <= 0:
            if damping > MOST:
                break
            damping *= RATIOS[-1] ** 2
            continue
        here, left, cost = trials[best], found[best : best + 1], float(costs[best])
        set_weights(model, here)
        damping = max(damping * RATIOS[best], LEAST)
        if gain < SETTLED * cost:
            break
    return cost


def _residuals(model: FeatureModel, weights: Tensor, features: Tensor, target: Tensor, weigh: Callable[[Tensor], Tensor]) -> Tensor:
    """(P, N) weighed residuals for weights (P, D)."""
    return weigh((target - population_outputs(model, weights, features)).mT).mT


def _steps(jacobian: Tensor, residual: Tensor, dampings: Tensor) -> Tensor:
    """(P, D) one step a damping (P,)."""
    normal = jacobian.mT @ jacobian
    scale = normal.diagonal().clamp_min(1e-12 * float(normal.diagonal().max()) + 1e-300)
    damped = normal + dampings[:, None, None] * torch.diag(scale)
    return torch.linalg.solve(damped, (jacobian.mT @ residual).expand(len(dampings), -1))
