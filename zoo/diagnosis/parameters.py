"""Fitted values of a solved grey box."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.diagnosis.solved import Solved
from zoo.effects.base import RUN
from zoo.effects.bounds import to_physical, to_unit
from zoo.effects.repeated import by_kind
from zoo.fitting.parameters import Fitted, parameters_of
from zoo.fitting.projection import project

SLOWLY_KNOWN = 1.3
"""Square of Student's 97.5 % quantile over the normal one, at ten degrees of freedom: the slow part of the noise is known from as few."""

LIKELY = 1.96
"""Standard errors within which a normal variable lies in 95 % of cases."""


def fitted_parameters(solved: Solved, unit: str) -> dict[str, Fitted]:
    """See `zoo.fitting.parameters.parameters_of`; with the errors that `Solved.likely` makes, where fits are weighted with another, and so wide
    that they hold other shapes that explain as much."""
    covariance = solved.fit.covariance(scores(solved))
    least = others_as_good(solved, covariance.diagonal().clamp_min(0.0).sqrt())
    return parameters_of(solved.model, solved.fit, unit, covariance, least)


def times_of(solved: Solved) -> dict[str, list[str]]:
    """Under which names a model has what it has several times, by what the catalogue calls that: in the order of runs, and of moments in a run."""
    effects = dict(solved.model.named_effects())

    def when(name: str) -> list[float]:
        values = dict(zip((one.name for one in effects[name].shape), solved.shape_of(name).tolist(), strict=True))
        return [abs(values.get(RUN, 0.0)), *(values[moment] for moment in effects[name].moments)]

    return {one: sorted(names, key=when) for one, names in by_kind(effects, effects).items() if names != [one]}


def others_as_good(solved: Solved, errors: Tensor) -> Tensor:
    """(P,) how wide errors (P+K,) have to be for 1.96 of them to hold those shapes of an effect with one of them, but for whole numbers,
    that explain nearly as much.

    Nearly: the cost rises by no more than it would, were it a parabola, by 1.96 errors. It is none where one law ends and another begins, or between
    one line and the next, which is what `Effect.shapes_near` gives. All other parameters are free, to first order.
    """
    fit, parameters, at = solved.fit, [one for _, one in solved.model.parameters_of_theta()], len(solved.model.coil_parameters)
    span_s = max(float(blocks.time[-1] - blocks.time[0]) for blocks in solved.mixtures.runs)
    least = torch.zeros_like(fit.theta)
    for _, effect in solved.model.named_effects():
        places = slice(at, at + len(effect.shape))
        near = effect.shapes_near(to_physical(fit.theta, parameters)[places], span_s)
        own = [at + i for i, one in enumerate(effect.shape) if one.scale != "index"]
        if len(own) == 1 and len(near) > 1 and bool(fit.tangent[:, own].any()):
            theta, (one,) = fit.theta.repeat(len(near), 1), own
            theta[:, places] = to_unit(near, effect.shape).clamp(0.0, 1.0)
            others = fit.tangent.clone()
            others[:, one] = 0.0
            steep = project(torch.cat([fit.columns, others], dim=1), fit.tangent[:, one]).cost
            costs = project(torch.cat([solved.design.columns(theta), others.expand(len(near), -1, -1)], dim=-1), solved.design.target).cost
            rise = costs + fit.prior.cost(theta) - min(fit.total, float(costs.min()))
            away = (theta[:, one] - fit.theta[one]).abs()
            least[one] = torch.where(rise <= steep * (LIKELY * errors[one]).square(), away, 0.0).max() / LIKELY
        at = places.stop
    return least


def scores(solved: Solved) -> Tensor:
    """(P+K, P+K) covariance that the likeliest noise, slow as it is, gives the scores Jᵀr of a fit that was weighted with the assumed one."""
    likely, whitener, jacobian = solved.likely.noise, solved.design.whitener, solved.fit.jacobian
    total = torch.zeros(jacobian.shape[1], jacobian.shape[1], dtype=jacobian.dtype, device=jacobian.device)
    pieces = [piece for blocks in solved.mixtures.runs for piece in blocks.pieces]
    for piece, factor, part in zip(pieces, whitener.factors, jacobian.split(whitener.sizes), strict=True):
        along = factor.mT @ part
        total += along.mT @ likely.covariance(piece) @ along
    return SLOWLY_KNOWN * total
