"""A model to write down: nothing in it will be trained or shared any more."""

from __future__ import annotations

import copy
from typing import TypeVar

from torch import nn

Module = TypeVar("Module", bound=nn.Module)


def still(model: Module) -> Module:
    """A copy on the CPU, in evaluation mode, without gradients, each tensor in memory of its own: a file keeps no views of others."""
    kept = copy.deepcopy(model).cpu().eval().requires_grad_(False)
    for tensor in [*kept.parameters(), *kept.buffers()]:
        tensor.data = tensor.data.clone()
    return kept
