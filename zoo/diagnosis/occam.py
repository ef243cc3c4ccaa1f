"""What parameters cost in evidence: the share of what was possible before the runs that is possible after them (Occam's factor).

MacKay 2003, Information Theory, Inference, and Learning Algorithms, 28.1.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor

from zoo.fitting.projection import project

SMALLEST, LARGEST = 0.1, 10.0
"""Sizes that a missing effect may have, every factor as likely as any other [white noise of a mean over 10 s]."""
ALONG_A_LINE = math.sqrt(2.0 * math.pi) / 4.0
"""Times the root of χ² per block: of the moments that a parabola tells apart the share that a straight line does, see `of_moments`."""
BEYOND = 1e6
"""Times the largest of its bounds from which on an amplitude costs more: whatever the unit that bounds were meant in, no gyro is so far from them."""
AGAIN = math.log(20.0)
"""Logarithm of how much likelier it is that what has happened once happens again than that any one of the catalogue's effects is there: as likely as
that one of them all is."""
FAINTEST = 1.0
"""Size in standard deviations below which an amplitude costs no less: a signal in the noise tells nothing of its size."""


def price_of_size(amplitudes: int, chi2: Tensor) -> Tensor:
    """What the amplitudes of one effect cost: how many sizes and mixtures of its columns the runs tell apart.

    Of K amplitudes every mixture is as likely, and every factor on the size of what the runs see of it. Around a signal of z standard deviations the
    likelihood leaves (2π)^(K/2) of the S_K z^K ln(largest/smallest) that a shell of a relative thickness takes, S_K the surface of the unit sphere.

    Args:
        amplitudes: K, at least 1.
        chi2: (...) z², what they explain; the formula is for z well above 1.
    """
    sphere = math.log(2.0) + 0.5 * amplitudes * math.log(math.pi) - math.lgamma(0.5 * amplitudes)
    square = chi2.clamp_min(FAINTEST**2)
    return math.log(math.log(LARGEST / SMALLEST)) + sphere + 0.5 * amplitudes * (square / (2.0 * math.pi)).log()


def price_of_excess(amplitudes: Tensor, largest: Tensor) -> Tensor:
    """What amplitudes far beyond their bounds cost: there density falls as 1/a², where within every factor is as likely as any other.

    A column that is nearly nothing over all runs, such as a dead band's of a width that no input comes near, explains what any column of that form
    does, with an amplitude that no gyro has.

    Args:
        amplitudes: (K,).
        largest: (K,) the largest size that each is declared to have, in the same units; infinite where that says nothing.
    """
    return (amplitudes.abs() / (BEYOND * largest)).clamp_min(1.0).log().sum()


def price_of_shape(tangents: Tensor, others: Tensor, blocks: Tensor) -> float:
    """Logarithm of how many shapes the runs tell apart, of all within the bounds: Laplace's approximation where each is as likely, never below 0.

    Args:
        tangents: (N, S) change of the signal over the whole range of each parameter, in standard deviations of the noise.
        others: (N, K) what else the model may do.
        blocks: (S,) see `of_moments`.
    """
    if not tangents.shape[1]:
        return 0.0
    outside = project(others, tangents.mT).residual
    return float(told_apart(of_moments(outside @ outside.mT, blocks)))


def of_moments(gram: Tensor, blocks: Tensor) -> Tensor:
    """(..., S, S) the Gram of changes over the whole range with those of moments as small as moments are told apart.

    A step that is moved differs in the blocks between: χ² rises along a straight line, by e a block, and not along the parabola of the tangent, e a
    block squared. The line leaves a likelihood 4/e blocks wide, the parabola one of √(2π/e).

    Args:
        gram: (..., S, S).
        blocks: (S,) how many blocks the whole range of a moment passes; 0 of what is none.
    """
    per_block = gram.diagonal(dim1=-2, dim2=-1).clamp_min(0.0).sqrt() / blocks.clamp_min(1.0)
    scale = torch.where(blocks > 0, (ALONG_A_LINE * per_block).clamp_max(1.0), 1.0)
    return gram * scale.unsqueeze(-1) * scale.unsqueeze(-2)


def told_apart(gram: Tensor) -> Tensor:
    """(...) logarithm of how many shapes are told apart, of the Gram (..., S, S) of what only their change can do over the whole range."""
    return 0.5 * torch.logdet(torch.eye(gram.shape[-1]).to(gram) + gram / (2.0 * math.pi))
