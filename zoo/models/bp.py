"""The back-propagation network of the compensation papers: one hidden layer of tanh nodes."""

from typing import Any, ClassVar

from torch import Tensor, cat, float64, nn, ones_like, sigmoid

from zoo.given import check_number
from zoo.models.scaler import neurons
from zoo.models.standardised import StandardisedModel
from zoo.physics.differentiator import SMOOTHING_S


class BP(StandardisedModel):
    """Three layers: features, tanh nodes, one linear output; both ends standardised.

    Source: qiu2023, which takes 3 to 12 hidden nodes from N = sqrt(m + n) + a and chooses 9.
    """

    linear_in: ClassVar[tuple[str, ...]] = ("output.weight", "output.bias")

    def __init__(self, features: list[str], hidden: int = 9, smoothing_s: float = SMOOTHING_S) -> None:
        super().__init__(features, smoothing_s)
        check_number("model.hidden", hidden, 1, whole=True)
        self.hidden = nn.Linear(len(features), hidden, dtype=float64)
        self.output = nn.Linear(hidden, 1, dtype=float64)

    def head(self, features: Tensor) -> Tensor:
        """See `FeatureModel.head`."""
        standardised = self.scaler(features).reshape(-1, features.shape[-1])
        # tanh(u) = 2 σ(2u) − 1, and torch's σ takes a seventh of the time. Samples stand last, in memory as well, in one product for any number of
        # nets under vmap.
        columns = 2 * cat([standardised.T, ones_like(standardised[:, :1]).T])
        nodes = sigmoid(cat([self.hidden.weight, self.hidden.bias.unsqueeze(-1)], dim=1) @ columns)
        # Back to the output's unit in the weights, not in the samples, of which there are more.
        weight = self.output.weight
        constant = self.scaler.restore(self.output.bias - weight.sum(-1)).unsqueeze(-1)
        return (2 * self.scaler.error_scale * weight @ nodes + constant).reshape(features.shape[:-1])

    def formula(self) -> dict[str, Any]:
        """The network with both scalings in its weights.

        Returns:
            ``{"equation": …, "constant": c, "neurons": [{"weight": v, "bias": b, "inputs": {feature: w}}, …]}`` [output's unit; 1; 1 per feature's
            unit].
        """
        inputs, biases = self.scaler.folded(self.hidden.weight, self.hidden.bias)
        weights = self.scaler.error_scale * self.output.weight[0]
        return {
            "equation": "constant + Σ_j weight_j·tanh(bias_j + Σ_i inputs_ji·feature_i)",
            "constant": float(self.scaler.restore(self.output.bias.detach()[0])),
            "neurons": neurons(self.extract.names, weights, biases, inputs),
        }
