"""Polynomial of temperature and its rate, the usual compensation of fibre-optic gyroscopes."""

import math
from typing import ClassVar

import torch
from torch import Tensor, nn

from zoo.errors import InputError
from zoo.models.base import FeatureModel
from zoo.models.features import RATE, Features
from zoo.models.scaler import Scaler
from zoo.physics.differentiator import SMOOTHING_S


class Polynomial(FeatureModel):
    """y = k + sum over features u and powers p of k_up · u^p, without mixed terms.

    As it stands by default: y = k1 + k2·T + k3·dT/dt (qiu2023, eq. 7). Order 4 in both is tong2019, eq. 6.
    The weights belong to standardised features, whose powers are far less alike than those of degrees Celsius; `coefficients` gives physical ones.

    Attributes:
        fitted_by: the optimizer that `train` takes unless told otherwise.
        orders: highest power of each feature.
        weight: (1 + sum of orders,) constant first, then feature by feature, power by power.
    """

    fitted_by: ClassVar[str] = "least_squares"

    def __init__(self, features: list[str], order: int = 1, rate_order: int = 1, smoothing_s: float = SMOOTHING_S) -> None:
        super().__init__()
        if min(order, rate_order) < 1:
            raise InputError(f"model.order={order} model.rate_order={rate_order}: 1 or more is needed; leave a feature out of model.features instead")
        self.extract = Features(features, smoothing_s)
        self.inputs = self.extract.inputs
        self.orders = [rate_order if name.endswith(RATE) else order for name in features]
        self.scaler = Scaler(len(features))
        self.weight = nn.Parameter(torch.zeros(1 + sum(self.orders), dtype=torch.float64))

    def features(self, x: Tensor) -> Tensor:
        """See `FeatureModel.features`."""
        features: Tensor = self.extract(x)
        return features

    def head(self, features: Tensor) -> Tensor:
        """See `FeatureModel.head`."""
        standardised = self.scaler(features)
        columns = [torch.ones_like(standardised[..., 0])]
        for index, order in enumerate(self.orders):
            base = standardised[..., index]
            power = base
            for _ in range(order):
                columns.append(power)
                power = power * base
        return self.scaler.restore(torch.stack(columns, dim=-1) @ self.weight)

    def standardise(self, features: Tensor, error: Tensor) -> None:
        """See `FeatureModel.standardise`."""
        self.scaler.fit(features, error)

    def coefficients(self) -> dict[str, float]:
        """The polynomial in physical units: ``{"1": k1, "temperature": k2, "temperature_rate": k3, ...}``, powers as ``temperature^2``.

        ((u − m)/s)^p is expanded by the binomial theorem [output's unit per unit of the feature to its power].
        """
        scale = float(self.scaler.error_scale)
        weights = [scale * weight for weight in self.weight.detach().tolist()]
        found = {"1": float(self.scaler.error_centre) + weights[0]}
        position = 1
        for name, order, m, s in zip(self.extract.names, self.orders, self.scaler.centre.tolist(), self.scaler.scale.tolist(), strict=True):
            for p in range(1, order + 1):
                for q in range(p + 1):
                    key = "1" if q == 0 else name if q == 1 else f"{name}^{q}"
                    found[key] = found.get(key, 0.0) + weights[position] * math.comb(p, q) * (-m) ** (p - q) / s**p
                position += 1
        return found
