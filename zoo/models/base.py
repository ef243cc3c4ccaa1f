"""What every model of the zoo is to the rest of the house."""

# No `from __future__ import annotations` in the files of models: TorchScript reads class annotations, and takes `list[str]` only as a type.
from typing import Any, ClassVar

from torch import Tensor, arange, int64, nn, zeros


class Model(nn.Module):
    """Abstract: predicts the gyro's error from the raw columns of one run.

    Subclasses are final, hold no training code and can be scripted.

    Attributes:
        inputs: the raw columns that `forward` takes, in that order, named as in a measurement file; the first is ``time_s``.
    """

    inputs: list[str]

    def forward(self, x: Tensor) -> Tensor:
        """Predict the error.

        Args:
            x: (T, C) raw columns `inputs` of one run, in the file's units, in time order, float64.

        Returns:
            (T,) predicted error [output's unit], to be subtracted from the output.
        """
        raise NotImplementedError

    def formula(self) -> dict[str, Any]:
        """The fitted model in physical units, as JSON takes it; empty where nothing is shorter than the weights."""
        return {}


class FeatureModel(Model):
    """Abstract: a model that is a static map of features, so that it can be trained on a table of them.

    `forward(x)` is ``head(features(x))``. Features hold all memory (rates, lags); the head has none.

    Attributes:
        linear_in: names of parameters that `head` is linear in, all of them together: some fits solve for these.
    """

    linear_in: ClassVar[tuple[str, ...]] = ()

    def features(self, x: Tensor) -> Tensor:
        """(T, C) raw columns of one run -> (T, F) physical features, such as temperature [°C] and its rate [K/min]."""
        raise NotImplementedError

    def head(self, features: Tensor) -> Tensor:
        """(..., F) features -> (...) predicted error [output's unit]; scaling of inputs and output lives in here."""
        raise NotImplementedError

    def standardise(self, features: Tensor, error: Tensor) -> None:
        """Set from training data what is not trained: the scaler's buffers, and whatever else they decide, such as where segments begin.

        Every fit calls it first.

        Args:
            features: (M, F).
            error: (M,) [output's unit].
        """
        raise NotImplementedError(f"{type(self).__name__} has no standardise(features, error), which every fit calls first")

    def parts(self, features: Tensor) -> tuple[Tensor, Tensor]:
        """Groups of weights of which each sample sees one only, so that each can be searched for by itself; a single group unless a model knows more.

        Args:
            features: (M, F).

        Returns:
            (S, D/S) int64, places of each group among all D weights, one parameter after the other; (M,) int64, group of each sample.
        """
        size = sum(parameter.numel() for parameter in self.parameters())
        return arange(size, device=features.device).unsqueeze(0), zeros(len(features), dtype=int64, device=features.device)

    def forward(self, x: Tensor) -> Tensor:
        """Predict the error, see `Model.forward`."""
        return self.head(self.features(x))
