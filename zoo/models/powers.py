"""Powers of features, the columns of every polynomial here, and what their weights mean in physical units."""

import math

import torch
from torch import Tensor

from zoo.given import check_number


def check_orders(order: object, rate_order: object) -> None:
    """Refuse orders below 1: to be without a feature, it is left out of model.features.

    Raises:
        InputError: one is no whole number from 1 up.
    """
    check_number("model.order", order, 1, whole=True)
    check_number("model.rate_order", rate_order, 1, whole=True)


def powers(features: Tensor, orders: list[int]) -> Tensor:
    """Powers 1 … order of each feature, feature by feature.

    Args:
        features: (..., F).
        orders: F highest powers.

    Returns:
        (..., sum of orders).
    """
    columns = [features[..., :0]]
    for index, order in enumerate(orders):
        base = features[..., index : index + 1]
        power = base
        for _ in range(order):
            columns.append(power)
            power = power * base
    return torch.cat(columns, dim=-1)


def expanded(name: str, weights: list[float], centre: float, scale: float) -> dict[str, float]:
    """Sum over p of w_p·((u − centre)/scale)^p by powers of u itself, by the binomial theorem.

    Args:
        name: of the feature u.
        weights: w_1, w_2, … [any unit].
        centre: in the unit of u.
        scale: in the unit of u.

    Returns:
        ``{"1": …, name: …, "name^2": …}`` [unit of the weights per unit of u to its power].
    """
    found: dict[str, float] = {"1": 0.0}
    for p, weight in enumerate(weights, start=1):
        for q in range(p + 1):
            key = "1" if q == 0 else name if q == 1 else f"{name}^{q}"
            found[key] = found.get(key, 0.0) + weight * math.comb(p, q) * (-centre) ** (p - q) / scale**p
    return found
