"""The wavelet network of hui2016: one hidden layer of Morlet wavelets, each with a place and a width."""

import math
from typing import Any, ClassVar

import torch
from torch import Generator, Tensor, cos, exp, float64, nn

from zoo.given import check_number, check_switch
from zoo.models.scaler import neurons
from zoo.models.standardised import StandardisedModel
from zoo.physics.differentiator import SMOOTHING_S

FREQUENCY = 1.75
"""Of the cosine in ψ(u) = cos(1.75u)·exp(−u²/2), as usual for wavelet networks."""
LEAST = 1e-3
"""Smallest dilation, in standard deviations of the inputs; narrower wavelets are spikes at single samples; engineering prior."""
REACH = 2.0
"""Translations begin within ± so many standard deviations of the inputs, where nearly all of them lie; engineering prior."""
MOST = int(REACH / LEAST)
"""Neurons of which each begins twice as wide as the smallest dilation."""


class Morlet(nn.Module):
    """H neurons ψ((w_j·x − b_j)/a_j) with ψ(u) = cos(1.75u)·exp(−u²/2).

    Attributes:
        weight: (H, F) w.
        translation: (H,) b.
        log_dilation: (H,) ln(a − 0.001), so that no step of any optimizer takes a dilation to 0.
    """

    def __init__(self, inputs: int, neurons: int) -> None:
        super().__init__()
        self.frequency, self.least = FREQUENCY, LEAST  # TorchScript sees no constants of the file
        self.weight = nn.Parameter(torch.ones(neurons, inputs, dtype=float64) / math.sqrt(inputs))
        self.translation = nn.Parameter(_spread(neurons, 0.5 * torch.ones(neurons, dtype=float64)))
        self.log_dilation = nn.Parameter(torch.full((neurons,), math.log(_spacing(neurons) - LEAST), dtype=float64))

    def dilation(self) -> Tensor:
        """(H,) a, in the unit of w·x."""
        return self.least + exp(self.log_dilation)

    def forward(self, x: Tensor) -> Tensor:
        """(..., F) standardised inputs -> (..., H)."""
        u = (x @ self.weight.T - self.translation) / self.dilation()
        return cos(self.frequency * u) * exp(-0.5 * u.square())

    def draw_weights(self, generator: Generator) -> None:
        """Start anywhere: directions at random on the sphere, translations one in each of H equal parts of ±2, dilations as wide as a part.

        Args:
            generator: source of chance, see `zoo.training.weights.reset`.
        """
        size, device = self.weight.shape, generator.device
        direction = torch.randn(size, generator=generator, dtype=float64, device=device)
        place = torch.rand(size[0], generator=generator, dtype=float64, device=device)
        self.weight.data.copy_(direction / direction.norm(dim=1, keepdim=True))
        self.translation.data.copy_(_spread(size[0], place))
        self.log_dilation.data.fill_(math.log(_spacing(size[0]) - LEAST))


def _spacing(neurons: int) -> float:
    return 2 * REACH / neurons


def _spread(neurons: int, place: Tensor) -> Tensor:
    """(H,) one in each of H equal parts of ±2, at the given place 0…1 of its part."""
    return _spacing(neurons) * (torch.arange(neurons, dtype=float64, device=place.device) + place) - REACH


class Wavelet(StandardisedModel):
    """y = Σ_j v_j·ψ((w_j·x − b_j)/a_j), or with `linear` + c + l·x; inputs and output standardised.

    Source: hui2016, whose network has no linear part; how many neurons is not given.
    """

    linear_in: ClassVar[tuple[str, ...]] = ("output.weight", "linear.weight", "linear.bias")

    def __init__(self, features: list[str], hidden: int = 9, linear: bool = False, smoothing_s: float = SMOOTHING_S) -> None:
        super().__init__(features, smoothing_s)
        check_number("model.hidden", hidden, 1, MOST, whole=True)
        check_switch("model.linear", linear)
        self.hidden = Morlet(len(features), hidden)
        self.output = nn.Linear(hidden, 1, bias=False, dtype=float64)
        self.linear = nn.Linear(len(features), 1, dtype=float64) if linear else None

    def head(self, features: Tensor) -> Tensor:
        """See `FeatureModel.head`."""
        x = self.scaler(features)
        value = self.output(self.hidden(x))
        if self.linear is not None:
            value = value + self.linear(x)
        return self.scaler.restore(value.squeeze(-1))

    def formula(self) -> dict[str, Any]:
        """The network with both scalings, translations and dilations in its weights.

        Returns:
            ``{"equation": …, "constant": c, "linear": {feature: l}, "neurons": [{"weight": v, "bias": b, "inputs": {feature: w}}, …]}`` [output's
            unit; output's unit per feature's unit; 1; 1 per feature's unit].
        """
        hidden, scaler = self.hidden, self.scaler
        inputs, biases = scaler.folded(hidden.weight / hidden.dilation().unsqueeze(-1), -hidden.translation / hidden.dilation())
        slopes, constant = torch.zeros_like(scaler.centre), torch.zeros_like(scaler.error_centre)
        if self.linear is not None:
            rows, constants = scaler.folded(self.linear.weight, self.linear.bias)
            slopes, constant = scaler.error_scale * rows[0], constants[0]
        return {
            "equation": f"constant + Σ_i linear_i·feature_i + Σ_j weight_j·cos({FREQUENCY}·u_j)·exp(−u_j²/2), u_j = bias_j + Σ_i inputs_ji·feature_i",
            "constant": float(scaler.restore(constant)),
            "linear": dict(zip(self.extract.names, slopes.tolist(), strict=True)),
            "neurons": neurons(self.extract.names, scaler.error_scale * self.output.weight[0], biases, inputs),
        }
