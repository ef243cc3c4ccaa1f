"""What a network's features remember, feature by feature: all that has to be told to compute them without the zoo."""

from __future__ import annotations

from dataclasses import dataclass

from zoo.models.base import FeatureModel, Model
from zoo.models.features import Features, remembering
from zoo.models.ranges import Ranges


@dataclass(frozen=True)
class Recipe:
    """One feature.

    Attributes:
        name: of it.
        column: where its raw column stands among the model's inputs.
        lag_s: time constant of its lag [s]; 0 for a column that is taken as it is.
        is_rate: whether it is the column's rate through two such lags [K/min].
    """

    name: str
    column: int
    lag_s: float
    is_rate: bool


def is_static(model: Model) -> bool:
    """Whether a model is a static map of `Features` of all its inputs, in their order, and nothing besides."""
    extract = getattr(model, "extract", None)
    return isinstance(model, FeatureModel) and type(extract) is Features and extract.inputs == model.inputs


def recipes(model: Model, ranges: Ranges) -> list[Recipe]:
    """The features of a static model; of any other, the rates and lags by which its range is watched: those with a range.

    Args:
        model: any.
        ranges: within which it was trained.
    """
    static = is_static(model)
    extract = getattr(model, "extract", None) if static else remembering(model)
    if extract is None:
        return []
    made = zip(extract.names, extract.column, extract.time_constant_s, extract.kind, strict=True)
    wanted = [one for one in made if static or one[0] in ranges]
    return [Recipe(name, model.inputs.index(extract.inputs[column]), seconds, kind == "rate") for name, column, seconds, kind in wanted]
