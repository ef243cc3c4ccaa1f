"""A sum of effects, each at the place where it lives."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import torch
from torch import Tensor, nn

from zoo.effects.base import Effect, History, Parameter, spread
from zoo.errors import InputError, nearest


class Sum(nn.Module):
    """Effects that are on together; what their sum needs is what each of them needs.

    Build one from effects with `+`, take one out with `without`, print it as a table.
    """

    def __init__(self, terms: Mapping[str, Effect]) -> None:
        """Keep the terms in their order.

        Args:
            terms: effects by name.
        """
        super().__init__()
        self.terms = nn.ModuleDict(dict(terms))

    def named(self) -> Iterator[tuple[str, Effect]]:
        """The effects with their names, in order."""
        for name, effect in self.terms.items():
            assert isinstance(effect, Effect)
            yield name, effect

    @property
    def shape(self) -> tuple[tuple[str, Parameter], ...]:
        """Owner and declaration of every nonlinear parameter, in the order of `columns`."""
        return tuple((name, parameter) for name, effect in self.named() for parameter in effect.shape)

    def __add__(self, other: Effect | Sum) -> Sum:
        more = other.named() if isinstance(other, Sum) else [(other.name, other)]
        return Sum({**dict(self.named()), **dict(more)})

    def without(self, name: str) -> Sum:
        """The sum less one effect.

        Raises:
            InputError: it is not in the sum.
        """
        if name not in self.terms:
            raise InputError(f"effect '{name}' is not in the model: {nearest(name, self.terms)}")
        return Sum({other: effect for other, effect in self.named() if other != name})

    def columns(self, places: Mapping[str, History], shape: Tensor) -> Tensor:
        """Columns of all effects, side by side.

        Args:
            places: history at each place, by name.
            shape: (B, S) values of all shapes, in the order of `shape`.

        Returns:
            (B, T, K).
        """
        at, parts = 0, []
        for _, effect in self.named():
            own = shape[:, at : at + len(effect.shape)]
            at += len(effect.shape)
            part = spread(effect.columns(places[effect.place], own), own)
            parts.append(part.expand(len(shape), *part.shape[-2:]))
        return torch.cat(parts, dim=-1)

    def shares(self, places: Mapping[str, History]) -> dict[str, Tensor]:
        """(T,) what each effect contributes [output's unit], by name."""
        return {name: effect(places[effect.place]) for name, effect in self.named()}

    def forward(self, places: Mapping[str, History]) -> Tensor:
        """(T,) the sum's share of the error [output's unit]."""
        return torch.stack(list(self.shares(places).values())).sum(0)

    def __str__(self) -> str:
        width = max((len(name) for name in self.terms), default=0)
        return "\n".join(f"{name:<{width}}  {effect.place:<8} {effect.formula}" for name, effect in self.named())
