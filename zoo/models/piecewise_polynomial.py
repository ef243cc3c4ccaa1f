"""Polynomials by segments of one feature, the traditional compensation over wide ranges of temperature."""

import itertools
import math
from typing import Any, ClassVar

import torch
from torch import Tensor, nn

from zoo.errors import InputError
from zoo.given import check_number, check_switch
from zoo.models.features import RATE
from zoo.models.powers import check_orders, expanded, powers
from zoo.models.segmentation import best_edges
from zoo.models.standardised import StandardisedModel
from zoo.physics.differentiator import SMOOTHING_S

LEAST_PER_COEFFICIENT = 2
"""Samples for each coefficient of a segment that is looked for: with as many as coefficients it would follow any noise; engineering prior."""


class PiecewisePolynomial(StandardisedModel):
    """In segment s of the first feature u: y = c_s + Σ_k w_sk·z_s^k + Σ over the other features f and powers p of r_sfp·f^p.

    z_s is u from −1 to 1 over the segment. By default temperature and its rate to order 4 in five segments (tong2019, eq. 6); with the temperature
    alone, its traditional compensation. Below the first and above the last edge the polynomials of the end segments go on without bounds.

    `continuous`: the constant c and all terms of the other features are shared by the segments, and z_s stays at −1 below its segment and at 1
    above, with y = c + Σ_s Σ_k w_sk·z_s^k + Σ r_fp·f^p: every function that is polynomial in each segment and continuous at the edges, whatever
    the other features are, is such a sum, and every such sum is continuous. (With own terms of the rate it could jump wherever there is a rate.)

    Linear in its weights either way. Edges that are not given are found as the model is fitted, where segments with coefficients of their own
    leave the smallest residual, see `zoo.models.segmentation`; they are the same with `continuous`.

    Attributes:
        fitted_by: the optimizer that `train` takes unless told otherwise.
        order: highest power of the first feature.
        orders: highest power of each other feature.
        edges: (S − 1,) where segments meet, ascending; the edge itself belongs to the upper one [unit of the first feature].
        ends: (S + 1,) the same with the lowest and the highest value fitted.
        constant: (S,) c, or (1,) where continuous.
        own: (S, order) w.
        rest: (S, sum of orders) r, or (1, …) where continuous.
    """

    fitted_by: ClassVar[str] = "least_squares"
    linear_in: ClassVar[tuple[str, ...]] = ("constant", "own", "rest")
    edges: Tensor
    ends: Tensor
    orders: list[int]

    def __init__(
        self,
        features: list[str],
        edges: list[float] | None = None,
        segments: int = 5,
        order: int = 4,
        rate_order: int = 4,
        continuous: bool = False,
        smoothing_s: float = SMOOTHING_S,
    ) -> None:
        super().__init__(features, smoothing_s)
        check_orders(order, rate_order)
        check_switch("model.continuous", continuous)
        if edges is None:
            check_number("model.segments", segments, 1, whole=True)
        first, *rest = [rate_order if name.endswith(RATE) else order for name in features]
        self.order, self.orders, self.continuous = first, rest, continuous
        self.given = edges is not None
        inner = torch.linspace(-1, 1, segments + 1, dtype=torch.float64)[1:-1] if edges is None else _checked(edges)
        self.register_buffer("edges", inner)
        self.register_buffer("ends", torch.cat([inner[:1] - 1, inner, inner[-1:] + 1]) if len(inner) else torch.tensor([-1.0, 1.0]).double())
        count = len(inner) + 1
        own = 1 if continuous else count
        self.constant = nn.Parameter(torch.zeros(own, dtype=torch.float64))
        self.own = nn.Parameter(torch.zeros(count, first, dtype=torch.float64))
        self.rest = nn.Parameter(torch.zeros(own, sum(rest), dtype=torch.float64))

    def head(self, features: Tensor) -> Tensor:
        """See `FeatureModel.head`."""
        others = powers(self.scaler(features)[..., 1:], self.orders) @ self.rest.T + self.constant
        place = features[..., :1]
        if self.continuous:
            place = torch.clamp(place, self._below(), self._above())
        z = (place - self._middle()) / self._half()
        value = torch.zeros_like(z)
        for power in range(self.order - 1, -1, -1):
            value = (value + self.own[:, power]) * z
        if self.continuous:
            return self.scaler.restore(value.sum(-1) + others.squeeze(-1))
        segment = self._segment(features).unsqueeze(-1)
        return self.scaler.restore(torch.gather(value + others, -1, segment).squeeze(-1))

    def _segment(self, features: Tensor) -> Tensor:
        """(...) segment of each sample."""
        return torch.bucketize(features[..., 0].contiguous(), self.edges, right=True)

    def parts(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """The segments, unless they share coefficients; see `FeatureModel.parts`."""
        if self.continuous:
            return super().parts(features)
        count = len(self.edges) + 1
        places = torch.arange(sum(one.numel() for one in self.parameters()), device=features.device)
        pieces = places.split([one.numel() for one in self.parameters()])
        return torch.cat([piece.view(count, -1) for piece in pieces], dim=1), self._segment(features)

    def _below(self) -> Tensor:
        """(S,) where each segment begins; the first one nowhere."""
        return torch.cat([torch.full_like(self.ends[:1], -math.inf), self.edges])

    def _above(self) -> Tensor:
        """(S,) where each segment ends; the last one nowhere."""
        return torch.cat([self.edges, torch.full_like(self.ends[:1], math.inf)])

    def _middle(self) -> Tensor:
        """(S,) middle of each segment."""
        return (self.ends[1:] + self.ends[:-1]) / 2

    def _half(self) -> Tensor:
        """(S,) half its width; 1 where all that was fitted lies at one place."""
        half = (self.ends[1:] - self.ends[:-1]) / 2
        return torch.where(half > 0, half, torch.ones_like(half))

    def standardise(self, features: Tensor, error: Tensor) -> None:
        """See `FeatureModel.standardise`; finds the edges where none are given.

        Raises:
            InputError: a segment has fewer samples than coefficients of its own, or so many segments cannot be made.
        """
        super().standardise(features, error)
        place = features[:, 0]
        if not self.given:
            self.edges.copy_(self._found(features, error))
        _check_filled(place, self.edges, self.order + (0 if self.continuous else 1 + sum(self.orders)))
        self.ends.copy_(torch.cat([place.min().unsqueeze(0), self.edges, place.max().unsqueeze(0)]))

    def _found(self, features: Tensor, error: Tensor) -> Tensor:
        """(S − 1,) the best edges for features (M, F) and error (M,)."""
        standardised = self.scaler(features)
        columns = powers(standardised, [self.order, *self.orders])
        columns = torch.cat([torch.ones_like(columns[:, :1]), columns / columns.abs().amax(0).clamp_min(1.0)], dim=-1)
        target = (error - self.scaler.error_centre) / self.scaler.error_scale
        return best_edges(features[:, 0], columns, target, len(self.ends) - 1, LEAST_PER_COEFFICIENT * columns.shape[1])

    def formula(self) -> dict[str, Any]:
        """The polynomial of each segment, lowest first, and from where to where it holds; None where it has no end.

        Returns:
            ``{"equation": …, "segments": [{"temperature": [from, to], "coefficients": {"1": …, "temperature": …, "temperature^2": …, …},
            "centred": {"middle": m, "half": h, "coefficients": {"1": …, "z": …, "z^2": …, …}}}, …]}`` [unit of the feature; output's unit per unit of
            the feature to its power; of z, the output's unit].
        """
        bounds = [None, *self.edges.tolist(), None]
        first = self.extract.names[0]
        return {
            "equation": (
                f"sum of coefficient × feature^power of the segment that {first} is in, from ≤ {first} < to, the constant under 1; in single "
                f"precision those under centred, of z = ({first} − middle)/half"
            ),
            "segments": [self._segment_formula(segment, ends) for segment, ends in enumerate(itertools.pairwise(bounds))],
        }

    def _segment_formula(self, segment: int, ends: tuple[float | None, float | None]) -> dict[str, Any]:
        name, middle, half = self.extract.names[0], float(self._middle()[segment]), float(self._half()[segment])
        centred = {"middle": middle, "half": half, "coefficients": self._coefficients(segment, "z", 0.0, 1.0)}
        return {name: list(ends), "coefficients": self._coefficients(segment, name, middle, half), "centred": centred}

    def _coefficients(self, segment: int, name: str, middle: float, half: float) -> dict[str, float]:
        """Of the powers of (first feature − middle)/half, multiplied out under a name, and of those of the other features."""
        scale, row = float(self.scaler.error_scale), 0 if self.continuous else segment
        own, constant = self.own.detach(), self.constant.detach()
        others = self.extract.names[1:]
        found = expanded(name, (scale * own[segment]).tolist(), middle, half)
        found["1"] += float(self.scaler.error_centre) + scale * float(constant[row])
        if self.continuous:  # the segments below stand at 1, those above at −1
            sign = (-1.0) ** torch.arange(1, self.order + 1).to(own)
            found["1"] += scale * float(own[:segment].sum() + (own[segment + 1 :] * sign).sum())
        weights = (scale * self.rest[row].detach()).tolist()
        for other, order, m, s in zip(others, self.orders, self.scaler.centre.tolist()[1:], self.scaler.scale.tolist()[1:], strict=True):
            part = expanded(other, weights[:order], m, s)
            weights = weights[order:]
            found = found | part | {"1": found["1"] + part["1"]}
        return found


def _checked(edges: list[float]) -> Tensor:
    numbers = isinstance(edges, list) and all(isinstance(edge, int | float) and math.isfinite(edge) for edge in edges)
    if not numbers or not all(low < high for low, high in itertools.pairwise(edges)):
        raise InputError(f"model.edges={edges}: ascending numbers are needed, such as [0, 15, 30, 37]; null finds those of model.segments")
    return torch.tensor(edges, dtype=torch.float64)


def _check_filled(place: Tensor, edges: Tensor, coefficients: int) -> None:
    """Raises InputError where the data leave a segment's coefficients open."""
    samples = torch.bincount(torch.bucketize(place.contiguous(), edges, right=True), minlength=len(edges) + 1).tolist()
    bounds = ["-∞", *(f"{edge:g}" for edge in edges.tolist()), "∞"]
    for segment, found in enumerate(samples):
        if found < coefficients:
            raise InputError(
                f"model.edges: the segment {bounds[segment]} … {bounds[segment + 1]} has {found} samples for {coefficients} coefficients of its own; "
                f"the data reach from {float(place.min()):g} to {float(place.max()):g}: move or leave out an edge, or lower model.order"
            )
