"""Takagi–Sugeno fuzzy model: a few planes, each trusted in its own part of the inputs' space, and blended between them."""

from typing import Any, ClassVar

import torch
from torch import Generator, Tensor, nn
from torch.nn.functional import softplus

from zoo.given import check_number
from zoo.models.standardised import StandardisedModel
from zoo.physics.differentiator import SMOOTHING_S

NARROWEST = 1e-3
"""Width that a membership cannot fall below, as a share of the feature's spread (engineering prior: far narrower than thermometers resolve)."""
REACH = 3**0.5
"""Standardised features that are spread evenly lie within ± this."""


class TakagiSugeno(StandardisedModel):
    """y = Σ_j β_j(x)·(a_j0 + Σ_i a_ji·x_i),  β_j = μ_j / Σ_k μ_k,  μ_j = Π_i exp(−(x_i − c_ji)²/(2σ_ji²)).

    Source: Takagi & Sugeno 1985 (IEEE Trans. SMC 15:116); with Gaussian memberships and 4 rules for a fibre-optic gyro in liu2010. The shares
    β are taken from the logarithms of μ: far from all rules the least far one speaks, where the quotient itself would be 0/0.

    Attributes:
        fitted_by: the optimizer that `train` takes unless told otherwise.
        centre: (R, F) c of each rule, in standardised features.
        free_width: (R, F) any number w; σ = `narrowest` + ln(1 + eʷ), standardised, so that no optimizer's step makes a width zero or infinite.
        consequent: (R, 1+F) a of each rule, constant first, standardised.
    """

    fitted_by: ClassVar[str] = "gustafson_kessel"
    linear_in: ClassVar[tuple[str, ...]] = ("consequent",)

    def __init__(self, features: list[str], rules: int = 4, smoothing_s: float = SMOOTHING_S) -> None:
        super().__init__(features, smoothing_s)
        check_number("model.rules", rules, 1, whole=True)
        self.centre = nn.Parameter(torch.zeros(rules, len(features), dtype=torch.float64))
        self.narrowest = NARROWEST
        self.free_width = nn.Parameter(torch.zeros(rules, len(features), dtype=torch.float64))
        self.consequent = nn.Parameter(torch.zeros(rules, 1 + len(features), dtype=torch.float64))

    def head(self, features: Tensor) -> Tensor:
        """See `FeatureModel.head`."""
        standardised = self.scaler(features)
        planes = self.consequent[:, 0] + standardised @ self.consequent[:, 1:].t()
        return self.scaler.restore((self._shares(standardised) * planes).sum(dim=-1))

    def columns(self, features: Tensor) -> Tensor:
        """(..., F) features -> (..., R·(1+F)) what multiplies each of `consequent`, in its order, in the standardised error."""
        standardised = self.scaler(features)
        local = torch.cat([torch.ones_like(standardised[..., :1]), standardised], dim=-1)
        return (self._shares(standardised).unsqueeze(-1) * local.unsqueeze(-2)).flatten(-2)

    def _shares(self, standardised: Tensor) -> Tensor:
        """(..., F) -> (..., R) β of each rule; they sum to 1."""
        distance = (standardised.unsqueeze(-2) - self.centre) / self.width()
        return torch.softmax(-0.5 * distance.square().sum(dim=-1), dim=-1)

    def width(self) -> Tensor:
        """(R, F) σ of each rule and feature, standardised."""
        return self.narrowest + softplus(self.free_width)

    @torch.jit.unused
    def set_antecedents(self, centre: Tensor, width: Tensor) -> None:
        """Place the rules.

        Args:
            centre: (R, F) standardised.
            width: (R, F) standardised; what is below twice the narrowest width is raised to that.
        """
        with torch.no_grad():
            self.centre.copy_(centre)
            above = width.clamp_min(2 * self.narrowest) - self.narrowest
            self.free_width.copy_(above + torch.log(-torch.expm1(-above)))

    @torch.jit.unused
    def draw_weights(self, generator: Generator) -> None:
        """Rules anywhere among the standardised features, half as wide as R evenly spread ones are apart; planes drawn as linear layers are.

        Args:
            generator: source of chance.
        """
        rules, features = self.centre.shape
        centre, consequent = (
            2 * torch.rand(one.shape, generator=generator, dtype=one.dtype, device=generator.device) - 1 for one in (self.centre, self.consequent)
        )
        self.set_antecedents(REACH * centre, torch.full_like(self.centre, REACH / rules ** (1 / features)))
        with torch.no_grad():
            self.consequent.copy_(consequent / (1 + features) ** 0.5)

    def formula(self) -> dict[str, Any]:
        """The rules.

        Returns:
            ``{"equation": …, "rules": [{"centre": {feature: c}, "width": {feature: σ}, "consequent": {"1": a_0, feature: a}}, …]}`` [feature's
            unit; output's unit per feature's unit].
        """
        names, scaler = self.extract.names, self.scaler
        slopes = scaler.error_scale * self.consequent[:, 1:] / scaler.scale
        constants = scaler.restore(self.consequent[:, 0]) - slopes @ scaler.centre
        centres, widths = scaler.centre + scaler.scale * self.centre, scaler.scale * self.width()
        rules = [
            {
                "centre": dict(zip(names, centre.tolist(), strict=True)),
                "width": dict(zip(names, width.tolist(), strict=True)),
                "consequent": {"1": constant} | dict(zip(names, slope.tolist(), strict=True)),
            }
            for centre, width, constant, slope in zip(centres, widths, constants.tolist(), slopes, strict=True)
        ]
        equation = (
            "Σ_j μ_j·(consequent_j of the features) / Σ_j μ_j,  μ_j = exp(e_j − max_j e_j),  e_j = −Σ_i (feature_i − centre_ji)²/(2·width_ji²); "
            "without the maximum all μ_j round to 0 far outside"
        )
        return {"equation": equation, "rules": rules}
