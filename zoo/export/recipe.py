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
        lag_s: time constant of its lag [s]; 0 for a column that is taken as it is.
        is_rate: whether it is the column's rate through two such lags [K/min].
    """

    column: int
    lag_s: float
    is_rate: bool


def recipes(model: Model) -> list[Recipe] | None:
    """The features of a model, or None where it is more than a static map of `Features`."""
    extract = getattr(model, "extract", None)
    if not isinstance(model, FeatureModel) or type(extract) is not Features or extract.inputs != model.inputs:
        return None
    kinds = zip(extract.column, extract.time_constant_s, extract.kind, strict=True)
    return [Recipe(column, seconds, kind == "rate") for column, seconds, kind in kinds]
