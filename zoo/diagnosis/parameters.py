"""Fitted values of a solved grey box."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.diagnosis.solved import Solved
from zoo.fitting.parameters import Fitted, parameters_of

SLOWLY_KNOWN = 1.3
"""Square of Student's 97.5 % quantile over the normal one, at ten degrees of freedom: the slow part of the noise is known from as few."""


def fitted_parameters(solved: Solved, unit: str) -> dict[str, Fitted]:
    """See `zoo.fitting.parameters.parameters_of`; with the errors that `Solved.slow_noise` makes, where fits are weighted with another."""
    return parameters_of(solved.model, solved.fit, unit, scores(solved))


def scores(solved: Solved) -> Tensor:
    """(P+K, P+K) covariance that the likeliest noise, slow as it is, gives the scores Jᵀr of a fit that was weighted with the assumed one."""
    likely, whitener, jacobian = solved.slow_noise.noise, solved.design.whitener, solved.fit.jacobian
    total = torch.zeros(jacobian.shape[1], jacobian.shape[1], dtype=jacobian.dtype, device=jacobian.device)
    pieces = [piece for blocks in solved.mixtures.runs for piece in blocks.pieces]
    for piece, factor, part in zip(pieces, whitener.factors, jacobian.split(whitener.sizes), strict=True):
        along = factor.mT @ part
        total += along.mT @ likely.covariance(piece) @ along
    return SLOWLY_KNOWN * total
