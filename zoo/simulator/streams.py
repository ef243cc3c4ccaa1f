"""One seed, many independent streams of chance: asking for more of one thing never changes another."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass

import torch
from torch import Tensor

BITS = 32
"""Torch uses no more of a seed: of ten thousand streams hardly one pair is alike, of a million some hundred pairs."""


def stream(seed: int, *labels: object) -> torch.Generator:
    """A generator that depends on the seed and on what it is for, such as ``stream(1, "noise", 2)``.

    Args:
        seed: the user's.
        labels: what the numbers are for.
    """
    text = "/".join(str(one) for one in (seed, *labels))
    number = (int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big") >> 1) % 2**BITS
    return torch.Generator().manual_seed(number)


@dataclass(frozen=True)
class Span:
    """Where a device's parameter may lie.

    Attributes:
        low: smallest value.
        high: largest value.
        unit: physical unit.
        log: spread over decades instead of evenly.
        source: where the numbers come from; an engineering prior where nothing is said.
    """

    low: float
    high: float
    unit: str
    log: bool = True
    source: str = "prior"

    def draw(self, generator: torch.Generator) -> float:
        """One value."""
        place = uniform(generator)
        if self.log and self.low > 0:
            return self.low * math.exp(place * math.log(self.high / self.low))
        return self.low + place * (self.high - self.low)


def uniform(generator: torch.Generator) -> float:
    """One number in 0…1."""
    return float(torch.rand((), generator=generator, dtype=torch.float64))


def sign(generator: torch.Generator) -> float:
    """−1 or 1."""
    return 1.0 if uniform(generator) < 0.5 else -1.0


def normal(count: int, generator: torch.Generator) -> Tensor:
    """(count,) standard normal numbers, float64."""
    return torch.randn(count, generator=generator, dtype=torch.float64)
