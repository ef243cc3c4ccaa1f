"""What a network's features remember, feature by feature: all that has to be told to compute them without the zoo."""

from __future__ import annotations

from dataclasses import dataclass

from zoo.models.base import FeatureModel, Model
from zoo.models.features import Features


@dataclass(frozen=True)
class Recipe:
    """One feature.

    Attributes:
        column: where its raw column stands among the model's inputs.
        smoothing_s: time constant of its lag [s]; 0 for a column that is taken as it is.
        is_rate: whether it is the column's rate through two such lags [K/min].
    """

    column: int
    smoothing_s: float
    is_rate: bool


def recipes(model: Model) -> list[Recipe] | None:
    """The features of a model, or None where it is more than a static map of `Features`."""
    extract = getattr(model, "extract", None)
    if not isinstance(model, FeatureModel) or type(extract) is not Features or extract.inputs != model.inputs:
        return None
    return [Recipe(column, extract.smoothing_s if is_rate else 0.0, is_rate) for column, is_rate in zip(extract.column, extract.is_rate, strict=True)]
