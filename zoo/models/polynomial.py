"""Polynomial of temperature and its rate, the usual compensation of fibre-optic gyroscopes."""

from typing import Any, ClassVar

import torch
from torch import Tensor, nn

from zoo.models.features import RATE
from zoo.models.powers import check_orders, expanded, powers
from zoo.models.standardised import StandardisedModel
from zoo.physics.differentiator import SMOOTHING_S


class Polynomial(StandardisedModel):
    """y = k + sum over features u and powers p of k_up · u^p, without mixed terms.

    As it stands by default: y = k1 + k2·T + k3·dT/dt (qiu2023, eq. 7). Order 4 in both is tong2019, eq. 6.
    The weights belong to standardised features, whose powers are far less alike than those of degrees Celsius; `formula` gives physical ones.

    Attributes:
        fitted_by: the optimizer that `train` takes unless told otherwise.
        orders: highest power of each feature.
        weight: (1 + sum of orders,) constant first, then feature by feature, power by power.
    """

    fitted_by: ClassVar[str] = "least_squares"
    linear_in: ClassVar[tuple[str, ...]] = ("weight",)

    def __init__(self, features: list[str], order: int = 1, rate_order: int = 1, smoothing_s: float = SMOOTHING_S) -> None:
        super().__init__(features, smoothing_s)
        check_orders(order, rate_order)
        self.orders = [rate_order if name.endswith(RATE) else order for name in features]
        self.weight = nn.Parameter(torch.zeros(1 + sum(self.orders), dtype=torch.float64))

    def head(self, features: Tensor) -> Tensor:
        """See `FeatureModel.head`."""
        standardised = self.scaler(features)
        columns = torch.cat([torch.ones_like(standardised[..., :1]), powers(standardised, self.orders)], dim=-1)
        return self.scaler.restore(columns @ self.weight)

    def formula(self) -> dict[str, Any]:
        """``{"equation": …, "coefficients": {"1": k1, "temperature": k2, "temperature_rate": k3, …}}``, powers as ``temperature^2``.

        [output's unit per unit of the feature to its power].
        """
        scale = float(self.scaler.error_scale)
        constant, *weights = [scale * weight for weight in self.weight.detach().tolist()]
        found = {"1": float(self.scaler.error_centre) + constant}
        for name, order, m, s in zip(self.extract.names, self.orders, self.scaler.centre.tolist(), self.scaler.scale.tolist(), strict=True):
            part = expanded(name, weights[:order], m, s)
            weights = weights[order:]
            found = found | part | {"1": found["1"] + part["1"]}
        return {"equation": "sum of coefficient × feature^power, the constant under 1", "coefficients": found}
