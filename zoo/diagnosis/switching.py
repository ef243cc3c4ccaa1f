"""What switches between two levels at random moments: popcorn noise of a source or of electronics, a mode that hops.

Flicker and random walk take over the variance of such a signal, but not that it has two values only. So it is weighed as a hypothesis of its own:
a two-state Markov chain in white noise, whose likelihood the forward recursion gives, its levels by expectation and maximisation together with the
model's amplitudes (Rabiner 1989, Proc. IEEE 77:257; Baum et al. 1970, Ann. Math. Stat. 41:164).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor

from zoo.diagnosis.noise_likelihood import LEVEL_SPREAD, LEVELS
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.projection import project

TWO_LEVELS = 6.0
"""Log Bayes factor that chance may give: for given levels once in 400 times at most (Markov's inequality), and fitting them is paid for. On 155 gyros
of `benchmarks/hidden.py` with nothing hidden it reached 3.3, on the next 2.1."""
TWO_LEVELS_BESIDE = 10.0
"""The same beside added effects, whose simplified forms leave what switches."""
HEIGHTS = (0.5, 1.0, 1.5)
"""Half the distance of the levels to start from, over what the residual has beyond white noise."""
LEAST = 0.3
"""And at least that, over the white noise."""
RATES = (0.1, 0.03, 0.01)
"""Switches per block to start from."""
ROUNDS = 20
FURTHEST = 500.0
"""Largest logarithm of the odds between the levels that one block gives."""


class Switching(NamedTuple):
    """The two levels that suit a residual best.

    Attributes:
        evidence: log Bayes factor of their hypothesis, with white noise, over the likeliest noise alone.
        share: of the residual's variance that they explain.
        apart: distance of the levels [unit].
        dwell_s: mean time on one of them [s].
    """

    evidence: float
    share: float
    apart: float
    dwell_s: float

    @property
    def matters(self) -> bool:
        """Whether noise does not do that."""
        return self.evidence > TWO_LEVELS


class _Chain(NamedTuple):
    """One recursion forth and back over all runs."""

    logarithm: float
    upper: Tensor
    switches: float


def switching(bench: Workbench, solved: Solved) -> Switching:
    """Weigh two levels against the noise that suits a model best.

    The model's amplitudes are fitted with them, to first order its other parameters too. Blocks are taken as evenly spaced, runs as independent.

    Args:
        bench: the runs.
        solved: the model, fitted without them.
    """
    error = solved.design.error
    columns = torch.cat([solved.fit.plain, torch.ones_like(error).unsqueeze(1)], dim=1)
    before = project(columns, error).residual
    sizes = [run.blocks for run in bench.runs]
    white = bench.mixtures.white
    beyond = math.sqrt(max(float(before.square().mean()) - white**2, (LEAST * white) ** 2))
    trials = [(height * beyond, rate) for height in HEIGHTS for rate in RATES]
    half, rate = max(trials, key=lambda trial: _chain(before, trial[0], white, trial[1], sizes).logarithm)
    residual, level = before, white
    for _ in range(ROUNDS):
        chain = _chain(residual, half, level, rate, sizes)
        state = 2.0 * chain.upper - 1.0
        rate = min(max(chain.switches / max(len(error) - len(sizes), 1), 1.0 / len(error)), 0.5)
        residual = half * state + project(columns, error - half * state).residual
        half = abs(float((residual * state).mean()))
        variance = float((residual.square() - 2.0 * half * residual * state + half**2).mean())
        level = white * min(max(math.sqrt(variance) / white, LEVELS[0]), LEVELS[-1])
    chain = _chain(residual, half, level, rate, sizes)
    noise = bench.mixtures.most_likely(solved.fit.plain, error, solved.likely.place, plain=True)  # its tangents as free as they are here
    prior = -0.5 * (math.log(level / white) / LEVEL_SPREAD) ** 2
    left = residual - half * (2.0 * chain.upper - 1.0)
    return Switching(
        chain.logarithm + prior - noise.logarithm - math.log(bench.effective_samples),
        1.0 - float(left.square().sum() / before.square().sum()),
        2.0 * half,
        bench.runs[0].average_s / rate,
    )


def _chain(residual: Tensor, half: float, level: float, rate: float, sizes: list[int]) -> _Chain:
    """Log likelihood, the probability (N,) of the upper level and the expected number of switches, for levels ±half in noise of this level.

    The constant of the Gaussian is left out, as in `Likely`.
    """
    odds = (2.0 * half / level**2 * residual).clamp(-FURTHEST, FURTHEST).exp()
    lower = -0.5 * ((residual + half) / level).square().sum() - len(residual) * math.log(level)
    found = [_both_ways(part.tolist(), rate) for part in odds.split(sizes)]
    upper = torch.cat([torch.tensor(run.upper, dtype=residual.dtype, device=residual.device) for run in found])
    return _Chain(float(lower) + sum(run.logarithm for run in found), upper, sum(run.switches for run in found))


class _Run(NamedTuple):
    """The same of one run: log likelihood over that of the lower level all along, upper level block by block, switches."""

    logarithm: float
    upper: list[float]
    switches: float


def _both_ways(odds: list[float], rate: float) -> _Run:
    """The recursions over one run, in plain numbers, from the odds of the upper level block by block."""
    stay, filtered, logarithm = 1.0 - rate, [], 0.0
    ahead = 0.5
    for odd in odds:
        total = 1.0 + ahead * (odd - 1.0)
        logarithm += math.log(total)
        now = ahead * odd / total
        filtered.append(now)
        ahead = now * stay + (1.0 - now) * rate
    upper, switches, after = [0.0] * len(odds), 0.0, 1.0
    for place in range(len(odds) - 1, -1, -1):
        now = filtered[place]
        if place + 1 < len(odds):
            seen = odds[place + 1] * after
            up, down = stay * seen + rate, rate * seen + stay
            switches += rate * (now + (1.0 - now) * seen) / (now * up + (1.0 - now) * down)
            after = up / down
        upper[place] = now * after / (now * after + 1.0 - now)
    return _Run(logarithm, upper, switches)
