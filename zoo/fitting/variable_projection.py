"""Separable least squares: a few nonlinear parameters within bounds, any number of linear ones projected out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from zoo.fitting.prior import Prior
from zoo.fitting.projection import Projection, project

STEP = 1e-4
DAMPINGS = (0.01, 10.0, 100.0, 1e3, 1e4, 1e5)
"""Tried at once: information added to that on each parameter (Levenberg 1944), in that of one residual of the usual size which moves by as much as
the parameter. With shares of each one's own alone, those of which the runs say little go far, and spoil a step that is good for all others: of one
gyro's fits every fifth did not get off its start."""
SHARES = (0.1, 1.0, 10.0, 300.0)
"""Tried where none of these gains anything to speak of: shares of each one's own (Marquardt 1963), for a steep one that leads nowhere."""
SINGULAR = 1e-12
"""Of the largest information on a parameter, added to that on each."""
AGAIN = (2.0, 8.0)
"""Multiples of the last step that are tried as well (a pattern move, Hooke & Jeeves 1961): along a bent valley damped steps creep one way."""
REACH = 0.25
"""Longest step of a parameter, as a share of its range."""
SIMPLER = 0.5
"""χ², in that of one residual of the usual size, that a share may cost where it is as by default: seven tenths of a standard deviation."""
PATIENCE = 2
"""Steps in a row that may lower the cost by next to nothing: of a heavily damped one it says little."""
RANK = 1e-12
"""Information along some direction over that along the best known, both of unit columns, below which it is rounding."""
WEAKEST = 3.0
"""How far in standard deviations of the noise the whole range of a parameter must move a model to count as a freedom. To first order it has no
bounds: by many times its range, a weaker one would account for anything that goes with it."""
ROUNDING = 1e-12
"""Of a column's largest number, below which a difference is rounding: a processor may round one row of a batch otherwise than the next."""
WITHIN = 12.0
"""One over the variance of a parameter that may be anywhere between its bounds, 0…1."""
PIECES = 24
"""Consecutive parts of the residuals, fewer of few rows: longer than most correlations, and enough to know a variance to 30 %; engineering prior."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A solution of min over θ, a of ‖y − Φ(θ)·a‖² + what a prior adds for θ.

    Attributes:
        theta: (P,) nonlinear parameters, in coordinates where every bound is 0…1.
        amplitudes: (K,).
        residual: (N,) y − Φa.
        columns: (N, K) Φ at the solution, weighted.
        tangent: (N, P) dΦ/dθ·a at the solution, weighted; zero for a parameter that its bound holds back, or that hardly matters within its bounds.
        edge: (N, P) the same of those, zero for all others.
        plain: (N, K+P) both before they were weighted.
        plain_edge: (N, P) the edge before it was weighted.
        moves: (P, K) whether a column depends on a parameter.
        cost: sum of squared residuals.
        prior: of θ.
        iterations: Gauss–Newton steps taken.
    """

    theta: Tensor
    amplitudes: Tensor
    residual: Tensor
    columns: Tensor
    tangent: Tensor
    edge: Tensor
    plain: Tensor
    plain_edge: Tensor
    moves: Tensor
    cost: float
    prior: Prior
    iterations: int

    @property
    def moved(self) -> float:
        """What the prior charges for where θ is, as χ²."""
        return float(self.prior.cost(self.theta))

    @property
    def total(self) -> float:
        """What was made least."""
        return self.cost + self.moved

    @property
    def held(self) -> Tensor:
        """(P, K+P+1) rows below (plain, target), whitened, for how far a parameter goes along its tangent: as its prior allows, or its bounds.

        To first order it has none, and by many times its range would account for what goes with it. The last column's squares are no misfit but what
        the prior charges already for where θ is, see `moved`; a parameter without tangent has no row.
        """
        known, amplitudes = self.prior.weight.to(self.theta), len(self.amplitudes)
        free = self.plain[:, amplitudes:].any(dim=0)
        weight = torch.where(free, torch.where(known > 0, known, WITHIN), 0.0).sqrt()
        aim = torch.where(known > 0, weight * (self.prior.center.to(self.theta) - self.theta), 0.0)
        return torch.cat([self.theta.new_zeros(len(self.theta), amplitudes), weight.diag(), aim.unsqueeze(1)], dim=1)

    @property
    def jacobian(self) -> Tensor:
        """(N, P+K) by (θ, amplitudes), weighted, as if there were no bounds."""
        return torch.cat([self.tangent + self.edge, self.columns], dim=1)

    def covariance(self, expected: Tensor | None = None) -> Tensor:
        """(P+K, P+K) covariance of (θ, amplitudes) that allows for correlated residuals.

        Scores are summed over consecutive pieces before they are squared (cluster-robust sandwich, Liang & Zeger 1986), so that a correlation shorter
        than a piece widens the errors as it should; never smaller than the ordinary formula. A parameter that its bound holds back may lie within by
        as much as the likelihood allows. Not a number for what has no influence, or none that others could not have as well.

        Args:
            expected: (P+K, P+K) covariance of the scores Jᵀr that the noise would give; errors are never smaller than it makes them.
        """
        jacobian = self.jacobian
        known = torch.nn.functional.pad(self.prior.weight.to(jacobian) + self._held(), (0, len(self.amplitudes)))
        norm = jacobian.norm(dim=0)
        known = torch.where(norm > 0, known, 0.0)
        unit = (norm.square() + known).sqrt().clamp_min(1e-300)  # of what each is known by: a prior may be all there is
        scaled = jacobian / unit
        values, ways = torch.linalg.eigh(scaled.mT @ scaled + torch.diag((known.sqrt() / unit).square()))
        seen = values > RANK * values.max()
        inverse = (ways[:, seen] / values[seen]) @ ways[:, seen].mT
        together = (ways[:, ~seen].abs() > 1e-6).any(dim=1)
        dof = max(len(self.residual) - jacobian.shape[1], 1)
        plain = inverse * max(self.cost / dof, 1.0)
        parts = zip(scaled.chunk(PIECES), self.residual.chunk(PIECES), strict=True)
        scores = torch.stack([(part * rest.unsqueeze(1)).sum(0) for part, rest in parts])
        scores = scores - scores.mean(dim=0)  # where a bound holds, they all push
        robust = inverse @ (scores.mT @ scores) @ inverse * (len(scores) / max(len(scores) - 1, 1))
        wide = robust.diagonal()
        if expected is not None:
            wide = torch.maximum(wide, (inverse @ (expected / unit.unsqueeze(0) / unit.unsqueeze(1)) @ inverse).diagonal())
        inflate = (wide / plain.diagonal().clamp_min(1e-300)).clamp_min(1.0).sqrt()
        unit = torch.where((norm > 0) & ~together, unit, torch.nan)
        return plain * inflate.unsqueeze(0) * inflate.unsqueeze(1) / unit.unsqueeze(0) / unit.unsqueeze(1)

    @property
    def pressed(self) -> Tensor:
        """(P,) by how many standard deviations what fits best lies beyond the bound that holds a parameter, below it negative; 0 where none holds it.

        Where χ² rises by 2gδ + hδ² at a distance δ from the bound, everything else refitted, that is g/√h.
        """
        return torch.where(self.theta < 0.5, -1.0, 1.0) * self._at_edge()[0]

    def _at_edge(self) -> tuple[Tensor, Tensor]:
        """(P,) g/√h and h, see `pressed`; 0 of what no bound holds."""
        beyond, steep, drawn = torch.zeros_like(self.theta), torch.zeros_like(self.theta), self.prior.slope(self.theta)
        for i in self.edge.any(dim=0).nonzero().flatten().tolist():
            others = self.edge.clone()
            others[:, i] = 0.0
            own = project(torch.cat([self.columns, self.tangent, others], dim=1), self.edge[:, i]).residual
            steep[i] = (own.square().sum() + self.prior.weight.to(own)[i]).clamp_min(1e-30)
            beyond[i] = (own @ self.residual + drawn[i]).abs() / steep[i].sqrt()
        return beyond, steep

    def _held(self) -> Tensor:
        """(P,) what a bound adds to what is known of each parameter, as one over a variance.

        That of δ, see `pressed`, is the second moment of a normal distribution of mean −g/h and variance 1/h cut off at 0: 1/h for g = 0, 2/g² where
        the bound is pressed against hard.
        """
        beyond, steep = self._at_edge()
        return torch.where(steep > 0, steep / _second_moment(beyond) - steep, 0.0)


HARD = 100.0
"""Standard deviations beyond which a cut-off normal distribution is taken for an exponential one."""


def _second_moment(beyond: Tensor) -> Tensor:
    """E[x²] over x > 0 of a normal distribution of unit variance whose mean is so far below 0."""
    hazard = math.sqrt(2.0 / math.pi) / torch.special.erfcx(beyond / math.sqrt(2.0))
    return torch.where(beyond > HARD, 2.0 / beyond.square(), 1.0 + beyond * (beyond - hazard))


def _as_they_are(columns: Tensor) -> Tensor:
    return columns


def fit(
    columns: Callable[[Tensor], Tensor],
    target: Tensor,
    start: Tensor,
    iterations: int = 30,
    tolerance: float = 1e-4,
    weigh: Callable[[Tensor], Tensor] = _as_they_are,
    prior: Prior | None = None,
) -> Fit:
    """Variable projection with Levenberg's steps (Golub & Pereyra 1973; Kaufman 1975), several dampings and longer ways tried at once.

    A share ends where it is by default if that is as good: columns have a kink there, and on which side of it a fit ends, last digits decide.

    Args:
        columns: (B, P) parameters in 0…1 -> (B, N, K) columns.
        target: (N,) y, weighted.
        start: (P,) first parameters in 0…1.
        iterations: most steps to take.
        tolerance: stop when to first order, or twice in fact, a step lowers the cost by less than this share of cost/N · 100.
        weigh: linear map (..., N, K) -> (..., N, K) of the columns, such as a whitener; by default none.
        prior: of the parameters; by default all are as likely.
    """
    theta = start.clone()
    prior = prior or Prior(torch.zeros_like(theta), torch.zeros_like(theta))
    taken, little, last = 0, 0, torch.zeros_like(theta)
    here = _linearise(columns, weigh, target, theta)
    while taken < iterations and theta.numel() and little < PATIENCE:
        normal, slope = _normal(theta, here.columns, here.tangent, here.solution.residual, prior)
        usual, own = float(here.solution.cost) / target.numel(), normal.diagonal()
        steps, hoped = _steps(normal, slope, [usual * damping * torch.ones_like(own) for damping in DAMPINGS])
        enough = tolerance * 100 * usual
        if hoped < enough:
            break
        best, gain = theta, 0.0
        for tried in ([*steps, *(times * last for times in AGAIN if taken)], _steps(normal, slope, [share * own for share in SHARES])[0]):
            trials = (theta + torch.stack(tried)).clamp(0.0, 1.0)
            cost = project(weigh(columns(trials)), target).cost + prior.cost(trials)
            cost = torch.where(cost.isfinite(), cost, torch.inf)
            gained = float(here.solution.cost + prior.cost(theta) - cost.min())
            if gained > gain:
                best, gain = trials[int(cost.argmin())], gained
            if gain >= enough:
                break
        if gain <= 0:
            break
        taken, little = taken + 1, little + 1 if gain < enough else 0
        theta, last = best, best - theta
        here = _linearise(columns, weigh, target, theta)
    simpler = prior.simpler(theta) if iterations else theta
    if not torch.equal(simpler, theta):
        there = _linearise(columns, weigh, target, simpler)
        if float(there.solution.cost - here.solution.cost) <= SIMPLER * float(here.solution.cost) / target.numel():
            theta, here = simpler, there
    found, slope = here.solution, here.tangent.mT @ here.solution.residual + prior.slope(theta)
    inside = ~_blocked(theta, slope) & (here.tangent.norm(dim=0) >= WEAKEST)
    amplitudes, tangent = here.plain.split([here.columns.shape[1], len(theta)], dim=1)
    plain, plain_edge = torch.cat([amplitudes, tangent * inside], dim=1), tangent * ~inside
    free, edge = here.tangent * inside, here.tangent * ~inside
    return Fit(theta, found.amplitudes, found.residual, here.columns, free, edge, plain, plain_edge, here.moves, float(found.cost), prior, taken)


class _Linear(NamedTuple):
    """Columns (N, K) and tangent (N, P) at one θ, weighted; both (N, K+P) before that; what depends on what; the projection on the columns."""

    columns: Tensor
    tangent: Tensor
    plain: Tensor
    moves: Tensor
    solution: Projection


def _moved(columns: Callable[[Tensor], Tensor], theta: Tensor) -> tuple[Tensor, Tensor]:
    steps = torch.where(theta > 0.5, -STEP, STEP).to(theta)
    moved = torch.cat([theta.unsqueeze(0), theta + torch.diag(steps)]) if theta.numel() else theta.unsqueeze(0)
    return columns(moved), steps


def _differences(change: Tensor, steps: Tensor, amplitudes: Tensor) -> Tensor:
    return ((change @ amplitudes) / steps.unsqueeze(1)).mT if steps.numel() else change.new_zeros((change.shape[1], 0))


def _linearise(columns: Callable[[Tensor], Tensor], weigh: Callable[[Tensor], Tensor], target: Tensor, theta: Tensor) -> _Linear:
    """The tangent is weighted after the amplitudes are in it: P columns instead of P·K."""
    batch, steps = _moved(columns, theta)
    weighted = weigh(batch[0])
    solution = project(weighted, target)
    change = batch[1:] - batch[0]
    differences = _differences(change, steps, solution.amplitudes)
    moves = change.abs().amax(dim=1) > ROUNDING * batch[0].abs().amax(dim=0)
    return _Linear(weighted, weigh(differences), torch.cat([batch[0], differences], dim=1), moves, solution)


def _blocked(theta: Tensor, slope: Tensor) -> Tensor:
    """Whether a parameter is at its bound and wants to leave: it stays."""
    return ((theta <= 0) & (slope < 0)) | ((theta >= 1) & (slope > 0))


def _normal(theta: Tensor, basis: Tensor, tangent: Tensor, residual: Tensor, prior: Prior) -> tuple[Tensor, Tensor]:
    """(P, P) and (P,) of the normal equations of a step, in the complement of the columns; a parameter that its bound holds back stays."""
    outside = project(basis, tangent.mT).residual.mT
    slope = outside.mT @ residual + prior.slope(theta)
    free = (~_blocked(theta, slope)).to(theta)
    normal = (outside.mT @ outside + torch.diag(prior.weight.to(theta))) * free.unsqueeze(0) * free.unsqueeze(1)
    return normal + torch.diag(1 - free), slope * free


def _steps(normal: Tensor, slope: Tensor, dampings: Iterable[Tensor]) -> tuple[list[Tensor], float]:
    """(P,) each, one a damping (P,); and by how much the first would lower the cost of a linear model if it were taken at its full length."""
    least = SINGULAR * float(normal.diagonal().max()) + 1e-300
    steps = [torch.linalg.solve(normal + torch.diag(damping + least), slope) for damping in dampings]
    return [step.clamp(-REACH, REACH) for step in steps], float(slope @ steps[0])
