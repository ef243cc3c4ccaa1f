"""Least-squares support vector machine: a sum of Gaussians around samples that were fitted."""

from typing import Any, ClassVar

import torch
from torch import Tensor
from torch.jit import is_scripting  # type: ignore[attr-defined]

from zoo.models.standardised import StandardisedModel
from zoo.physics.differentiator import SMOOTHING_S

VALUES_AT_ONCE = 2_000_000
"""Kernel values held at a time, so that memory does not grow with the rows."""
FITTED = ("support", "weight")
"""Buffers whose size the fit decides."""


class LsSvm(StandardisedModel):
    """y = Σ_i α_i k(x, x_i) + b with k(x, x_i) = exp(−‖(x − x_i)/σ‖²), in standardised features and error.

    Source: Suykens & Vandewalle 1999, Neural Processing Letters 9:293, eqs. 12–18; here with a width σ for each feature. Far from all support
    points the prediction is b. There is nothing in it to train by gradient: `fitted_by` solves for all.

    Attributes:
        fitted_by: the optimizer that `train` takes unless told otherwise.
        support: (S, F) support points x_i, standardised; none before the fit.
        weight: (S,) α_i.
        bias: () b.
        width: (F,) σ, in standard deviations of each feature.
        values_at_once: kernel values held at a time.
    """

    fitted_by: ClassVar[str] = "dual_solve"
    support: Tensor
    weight: Tensor
    bias: Tensor
    width: Tensor

    def __init__(self, features: list[str], smoothing_s: float = SMOOTHING_S) -> None:
        super().__init__(features, smoothing_s)
        self.values_at_once = VALUES_AT_ONCE
        self.register_buffer("support", torch.zeros(0, len(features), dtype=torch.float64))
        self.register_buffer("weight", torch.zeros(0, dtype=torch.float64))
        self.register_buffer("bias", torch.zeros((), dtype=torch.float64))
        self.register_buffer("width", torch.ones(len(features), dtype=torch.float64))

    def head(self, features: Tensor) -> Tensor:
        """See `FeatureModel.head`; rows are taken some at a time."""
        points = self.scaler(features).reshape(-1, features.shape[-1]) / self.width
        return self.scaler.restore(self._sums(points, self.support / self.width).reshape(features.shape[:-1]) + self.bias)

    def _sums(self, points: Tensor, support: Tensor) -> Tensor:
        """(M,) Σ α_i k(x, x_i) for points (M, F) and support points (S, F) in widths."""
        if not is_scripting():  # noqa: SIM102 (TorchScript leaves out what stands below this line, if it stands alone)
            if torch.compiler.is_compiling():
                return gaussians(points, support) @ self.weight  # an exported graph for any number of rows has no loop over them
        size = max(self.values_at_once // max(support.shape[0], 1), 1)
        return torch.cat([gaussians(part, support) @ self.weight for part in points.split(size)])

    def assign(self, support: Tensor, weight: Tensor, bias: Tensor, width: Tensor) -> None:
        """Take over a solution: support points (S, F), weights (S,), bias (), widths (F,)."""
        self.support, self.weight, self.bias, self.width = support, weight, bias, width

    def _load_from_state_dict(self, state_dict: dict[str, Any], prefix: str, *rest: Any) -> None:
        # A model that is built anew knows nothing yet of how many support points there are.
        for name in FITTED:
            if prefix + name in state_dict:
                setattr(self, name, getattr(self, name).new_empty(state_dict[prefix + name].shape))
        super()._load_from_state_dict(state_dict, prefix, *rest)


def gaussians(points: Tensor, support: Tensor) -> Tensor:
    """exp(−‖x − x_i‖²) between all rows.

    Args:
        points: (M, F) in widths.
        support: (S, F) in widths.

    Returns:
        (M, S).
    """
    lengths = points.square().sum(-1).unsqueeze(-1) + support.square().sum(-1)
    return torch.exp(-torch.addmm(lengths, points, support.t(), alpha=-2.0).clamp_min(0.0))
