"""What the networks, polynomials and fuzzy rules of the zoo have in common: features by name, and both ends standardised."""

from torch import Tensor

from zoo.models.base import FeatureModel
from zoo.models.features import Features
from zoo.models.scaler import Scaler
from zoo.physics.differentiator import SMOOTHING_S


class StandardisedModel(FeatureModel):
    """Abstract: a static map of `Features`, to which `head` is all that is missing; there ``self.scaler`` standardises, and restores the output.

    Attributes:
        extract: makes the features, and knows their names.
        scaler: centres and scales of features and error, set by `standardise`.
    """

    def __init__(self, features: list[str], smoothing_s: float = SMOOTHING_S) -> None:
        super().__init__()
        self.extract = Features(features, smoothing_s)
        self.inputs = self.extract.inputs
        self.scaler = Scaler(len(features))

    def features(self, x: Tensor) -> Tensor:
        """See `FeatureModel.features`."""
        features: Tensor = self.extract(x)
        return features

    def standardise(self, features: Tensor, error: Tensor) -> None:
        """See `FeatureModel.standardise`."""
        self.scaler.fit(features, error)
