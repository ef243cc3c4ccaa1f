"""Weights of small networks by damped Gauss–Newton steps (Levenberg–Marquardt), which end where a gradient's are still on the way.

One step of weights w with residual r = target − f(w) and Jacobian J = df/dw solves (JᵀJ + λ·diag(s))·δ = Jᵀr (Marquardt 1963), s being the diagonal
of JᵀJ; λ follows the ratio of what a step gains to what it promised (Nielsen 1999, Damping parameter in Marquardt's method, IMM-REP-1999-05).
Any number of members takes its steps side by side, each with a λ of its own.

Wherever a step leads, the weights that f is linear in are solved for before it is judged, so that the search is one of the others, as in variable
projection (Golub & Pereyra 1973). The step itself is that of all weights, all of them damped: with the linear ones undamped, which is Kaufman's
(1975) step, networks got lower no sooner, and were caught in worse places.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import torch
from torch import Tensor

from zoo.models.base import FeatureModel
from zoo.training.fine_blocks import samples_in
from zoo.training.linear_weights import LinearWeights
from zoo.training.tape import Recorded
from zoo.training.weights import ROWS_OF_COLUMNS, derivatives, set_weights, weight_vector

FIRST, LEAST, MOST = 1e-2, 1e-12, 1e9
"""Damping over the diagonal of the normal matrix, at first and within what bounds."""
EASED, HARDER = 1 / 3, 2.0
"""Least factor of the damping after a step that was taken; factor after the first that was not, and of that factor after each further one."""
SETTLED = 1e-6
"""Share of the cost by which a step must lower it to be followed by another."""
RIDGE = 1e-12
"""Damping, over the largest diagonal element, of all weights: some may change nothing."""

Normal = Callable[[Tensor], tuple[Tensor, Tensor]]
"""(E, D) weights -> (E, D, D) JᵀJ and (E, D) Jᵀr."""
Judge = Callable[[Tensor], tuple[Tensor, Tensor]]
"""(E, D) weights -> (E, D) the same with the linear ones solved for, and (E,) sums of squared residuals, in the units of JᵀJ."""


class Descent(NamedTuple):
    """E members on their way down.

    Attributes:
        weights: (E, D).
        losses: (E,) sums of squared residuals.
        damping: (E,) λ.
        harder: (E,) by what factor λ grows should the next step lead up.
        settled: (E,) bool: has come to rest.
        steps: (E,) tried.
    """

    weights: Tensor
    losses: Tensor
    damping: Tensor
    harder: Tensor
    settled: Tensor
    steps: Tensor


def begin(weights: Tensor, judge: Judge) -> Descent:
    """Members at rest nowhere yet.

    Args:
        weights: (E, D).
        judge: solves for the linear ones; a member whose cost is no number stays where it is.
    """
    found, losses = judge(weights)
    first, harder = torch.full_like(losses, FIRST), torch.full_like(losses, HARDER)
    return Descent(found, losses, first, harder, ~losses.isfinite(), torch.zeros_like(losses, dtype=torch.int64))


def step(state: Descent, normal: Normal, judge: Judge, settled: float = SETTLED) -> Descent:
    """One step of all that are not settled; none of them goes up.

    Args:
        state: the members.
        normal: gives the normal equations.
        judge: of where the steps lead.
        settled: share of its cost by which a step must lower it to be followed by another; one after a step that led up needn't.
    """
    active = (~state.settled).nonzero().squeeze(-1)
    here, cost, damping, harder = (one[active] for one in (state.weights, state.losses, state.damping, state.harder))
    matrix, slope = normal(here)
    move = _moves(matrix, slope, damping)
    trials, found = judge(here + move)
    gain = cost - found.nan_to_num(nan=torch.inf)
    promised = (move * (2 * slope - (matrix @ move.unsqueeze(-1)).squeeze(-1))).sum(-1)
    better = gain > 0
    eased = (damping * (1 - (2 * gain / promised - 1) ** 3).clamp(EASED, HARDER)).clamp_min(LEAST)
    rest = torch.where(better, (gain < settled * cost) & (harder == HARDER), damping > MOST)
    return Descent(
        state.weights.index_copy(0, active, torch.where(better.unsqueeze(-1), trials, here)),
        state.losses.index_copy(0, active, torch.where(better, found, cost)),
        state.damping.index_copy(0, active, torch.where(better, eased, damping * harder)),
        state.harder.index_copy(0, active, torch.where(better, HARDER, HARDER * harder)),
        state.settled.index_copy(0, active, rest),
        state.steps.index_add(0, active, torch.ones_like(active)),
    )


def _moves(normal: Tensor, slope: Tensor, damping: Tensor) -> Tensor:
    """(E, D) one step of each member with its damping (E,)."""
    scale = normal.diagonal(dim1=-2, dim2=-1)
    floor = RIDGE * scale.amax(-1, keepdim=True) + 1e-300
    added = damping.unsqueeze(-1) * scale.clamp_min(floor) + floor
    # A member without finite equations gets no step, and does not stop the others.
    return torch.linalg.solve_ex(normal + torch.diag_embed(added), slope.unsqueeze(-1))[0].squeeze(-1)


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
    at_once = max(ROWS_OF_COLUMNS // samples_in(model), 1)
    linear, slopes = LinearWeights(model), Recorded(partial(derivatives, model))

    def residual(outputs: Tensor) -> Tensor:
        return weigh((target - outputs).mT)

    def normal(weights: Tensor) -> tuple[Tensor, Tensor]:
        outputs, columns = weights.new_empty(1, len(features)), weights.new_empty(*weights.shape, len(features))
        for start in range(0, len(features), at_once):
            rows = slice(start, start + at_once)
            outputs[:, rows], columns[..., rows] = slopes(weights, features[rows])
        jacobian = weigh(columns[0].mT)
        return (jacobian.mT @ jacobian).unsqueeze(0), residual(outputs).mT @ jacobian

    def judge(weights: Tensor) -> tuple[Tensor, Tensor]:
        outputs, columns = linear.columns(weights, features)
        left, ways = residual(outputs), weigh(columns[0].mT)
        return linear.solved(weights, left.square().sum(0), left.mT @ ways, (ways.mT @ ways).unsqueeze(0))

    state = begin(weight_vector(model).unsqueeze(0), judge)
    for _ in range(steps):
        if bool(state.settled.all()):
            break
        state = step(state, normal, judge)
    set_weights(model, state.weights[0])
    return float(state.losses[0])
