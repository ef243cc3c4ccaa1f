"""γ and widths of a Gaussian kernel, where what is left out is predicted best."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.models.ls_svm import gaussians
from zoo.training.leave_out import Dual

LEAST, MOST_GAMMA = -4.0, 36.0
"""log2 γ within which is searched: noise from 4 times what the kernel spans down to a 250 000th of it (engineering prior), where 1/γ is still
well above the rounding of K."""
GAMMAS = torch.arange(LEAST, MOST_GAMMA + 1, 4, dtype=torch.float64)
"""log2 γ tried with each width of the grid."""
WIDTHS = torch.arange(-3, 6, dtype=torch.float64)
"""log2 σ tried, one for all features [their standard deviations] (engineering prior)."""
STEPS = (1.0, 0.5, 0.25)
"""Of the refinement, width by width [octaves]."""
MOST = 40
"""Kernels that a refinement tries."""
WORTH = 1e-3
"""Share by which a step must lower the mean square to be taken."""


MOST_OF_WEIGHTS = 1e6
"""Σ|α| up to which a choice counts: rounding of features and sums (1e-15) then leaves 1e-9 of the error's spread in a prediction. Beyond, large
weights cancel where there are samples, and nowhere else."""


@dataclass(frozen=True, eq=False)
class Kernel:
    """One choice.

    Attributes:
        width: (F,) log2 σ [standard deviations].
        gamma: log2 γ.
        loss: mean square by which what is left out is missed.
    """

    width: Tensor
    gamma: float
    loss: float


def search(points: Tensor, target: Tensor, folds: Tensor | None, advance: Callable[[], None]) -> Kernel:
    """A grid of one width for all features, then each width by itself, with every γ for the price of one.

    Args:
        points: (M, F) standardised.
        target: (M,) standardised.
        folds: (M,) what is left out together, see `Dual.left_out_errors`.
        advance: called once a kernel; at most ``len(WIDTHS) + MOST + 1`` times.
    """

    def tried(width: Tensor, gammas: Tensor) -> Kernel:
        advance()
        inside = gammas.clamp(LEAST, MOST_GAMMA).unique().to(points)
        return _best_gamma(points, target, folds, width, inside)

    features = points.shape[1]
    best = min((tried(value.to(points).expand(features), GAMMAS) for value in WIDTHS), key=lambda kernel: kernel.loss)
    return tried(*_refined(best, tried))


def _refined(best: Kernel, tried: Callable[[Tensor, Tensor], Kernel]) -> tuple[Tensor, Tensor]:
    """The best widths around a first choice, by compass search, and the log2 γ to try with them."""
    features = len(best.width)
    ways = torch.cat([torch.eye(features), torch.ones(1, features)] if features > 1 else [torch.eye(1)]).to(best.width)
    left = MOST
    for step in STEPS:
        moved = True
        while moved and left > 0:
            moved = False
            for way in torch.cat([ways, -ways])[:left]:
                left -= 1
                found = tried(best.width + step * way, best.gamma + torch.tensor([-4.0, -2.0, 0.0, 2.0, 4.0]))
                if found.loss < (1.0 - WORTH) * best.loss:
                    best, moved = found, True
    return best.width, best.gamma + torch.arange(-2.0, 2.1, 0.5)


def _best_gamma(points: Tensor, target: Tensor, folds: Tensor | None, width: Tensor, gammas: Tensor) -> Kernel:
    scaled = points / 2.0**width
    dual = Dual(gaussians(scaled, scaled), target, 2.0**gammas)
    losses = dual.left_out_errors(folds).square().mean(0).nan_to_num(nan=torch.inf)
    losses = torch.where(dual.solution[0].abs().sum(0) <= MOST_OF_WEIGHTS, losses, torch.inf)
    index = int(losses.argmin())
    return Kernel(width, float(gammas[index]), float(losses[index]))
