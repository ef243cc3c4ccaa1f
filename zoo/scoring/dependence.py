"""What a residual goes with: the share of it that a free function of one quantity would take away."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import torch
from torch import Tensor

BINS = 8


def shares(residual: Tensor, quantities: Mapping[str, Tensor]) -> dict[str, float]:
    """Share of a residual's mean square that goes with each quantity, less what as many bins would take of noise.

    A quantity is cut into eight bins of equally many values, and the residual's mean in each is its function (Fisher's ε², Kelley 1935,
    Proc. Natl. Acad. Sci. 21:554). A constant residual goes with any quantity, so the mean is taken out first and told by itself as ``"constant"``.

    Args:
        residual: (N,) [unit].
        quantities: (N,) by name, in any unit.

    Returns:
        Shares of the mean square from 0 to 1, the largest first. Quantities share what they have in common: the shares may exceed 1 together.
    """
    total, centred = float(residual.square().mean()), residual - residual.mean()
    if total == 0:
        return dict.fromkeys(("constant", *quantities), 0.0)
    found = {"constant": max(float(residual.mean()) ** 2 - float(centred.square().mean()) / max(residual.numel(), 1), 0.0) / total}
    varying = float(centred.square().mean()) / total
    found |= {name: varying * _explained(centred, values) for name, values in quantities.items()}
    return dict(sorted(found.items(), key=lambda pair: -pair[1]))


def _explained(centred: Tensor, values: Tensor) -> float:
    """ε² of (N,) values that have no mean."""
    # NumPy's, as torch's quantile takes no more than 2²⁴ values.
    edges = torch.unique(values.new_tensor(np.quantile(values.cpu().numpy(), np.linspace(0, 1, BINS + 1)[1:-1])))
    where = torch.bucketize(values, edges)
    count = torch.bincount(where, minlength=len(edges) + 1).to(centred.dtype)
    means = torch.zeros_like(count).index_add(0, where, centred) / count.clamp_min(1)
    freedom, size = int((count > 0).sum()) - 1, centred.numel()
    inside, outside = float((count * means.square()).sum()), float(centred.square().sum())
    if outside == 0 or size <= freedom + 1:
        return 0.0
    return max(inside - freedom * (outside - inside) / (size - freedom - 1), 0.0) / outside
