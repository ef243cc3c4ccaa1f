"""Columns that were computed before: the steps of a fit, and fits of similar models, ask for the same ones again and again."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence

import torch
from torch import Tensor

from zoo.side_by_side import of_item

KEPT = 4_000_000
"""Numbers kept at most, in all that share one memory; an item of `zoo.side_by_side` has as many of its own."""


class Remembered:
    """Tensors (N, K) by key, the oldest forgotten where they are too many."""

    def __init__(self) -> None:
        self._known: dict[Hashable, Tensor] = {}
        self._size = 0

    def batch(self, keys: Sequence[Hashable], make: Callable[[list[int]], Tensor]) -> Tensor:
        """(B, N, K) for as many keys, time first in memory.

        Args:
            keys: of each.
            make: places among the keys -> (b, N, K) of these, time first in memory.
        """
        own = of_item(self, Remembered)
        new = [i for i, key in enumerate(keys) if key not in own._known and key not in self._known]
        made = make(new) if new else None
        if made is not None and len(new) == len(keys):
            batch = made
        else:
            fresh = dict(zip([keys[i] for i in new], made if made is not None else (), strict=True))
            batch = torch.stack([fresh[key] if key in fresh else own._again(key, self) for key in keys], dim=1).movedim(1, 0)
        for i in new:
            own._keep(keys[i], batch[i])
        return batch

    def _again(self, key: Hashable, shared: Remembered) -> Tensor:
        if key not in self._known:
            return shared._known[key]
        value = self._known[key] = self._known.pop(key)  # Last, as the latest used.
        return value

    def _keep(self, key: Hashable, value: Tensor) -> None:
        self._known[key] = value.clone(memory_format=torch.contiguous_format)
        self._size += value.numel()
        while self._size > KEPT:
            self._size -= self._known.pop(next(iter(self._known))).numel()
