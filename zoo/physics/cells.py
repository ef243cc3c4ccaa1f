"""Finite volumes across a winding and along it: a node at both faces and at every layer or turn between."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor


@dataclass(frozen=True, eq=False)
class Cells:
    """One direction of a winding, per unit of the other one.

    The faces between the nodes are placed so that a steady flow and the parabola of a steady ramp are exact at the nodes.

    Attributes:
        node: (..., N) place [m].
        volume: (..., N) of each node's cell: [m²] across the winding, [m] along its axis.
        link: (..., N − 1) conductance between neighbours at unit conductivity: [1] across, [1/m] along.
        area: (..., 2) of the first and the last face: [m] across, [1] along.
    """

    node: Tensor
    volume: Tensor
    link: Tensor
    area: Tensor

    def stiffness(self, conductivity: Tensor, films: Tensor) -> Tensor:
        """(..., N, N) conductance matrix with films on both faces, per unit of the other direction.

        Args:
            conductivity: (...) [W/m/K].
            films: (..., 2) heat transfer coefficient of the first and the last face [W/m²/K].
        """
        link = conductivity.unsqueeze(-1) * self.link
        flow = films * self.area
        zero = torch.zeros_like(link[..., :1])
        diagonal = torch.cat([zero, link], -1) + torch.cat([link, zero], -1)
        ends = torch.cat([flow[..., :1], torch.zeros_like(diagonal[..., 2:]), flow[..., 1:]], -1)
        return torch.diag_embed(diagonal + ends) - torch.diag_embed(link, 1) - torch.diag_embed(link, -1)


def across(inner_m: Tensor, pitch_m: Tensor, layers: int) -> Cells:
    """The layers of a winding from its inner to its outer face; hollow cylinders, per unit height.

    Between nodes at r₁ and r₂ the face is at r² = (r₂² − r₁²)/(2·ln(r₂/r₁)), where the flow of A·ln r + B·r² is that of the difference quotient.

    Args:
        inner_m: (...) radius of the inner face [m].
        pitch_m: (...) thickness of a layer [m].
        layers: how many.
    """
    radius = inner_m.unsqueeze(-1) + pitch_m.unsqueeze(-1) * _places(layers, inner_m)
    ratio = torch.log1p(torch.diff(radius) / radius[..., :-1])
    square = radius[..., :-1].square() * torch.expm1(2 * ratio) / (2 * ratio)
    ends = radius[..., [0, -1]]
    volume = math.pi * torch.diff(torch.cat([ends[..., :1].square(), square, ends[..., 1:].square()], -1))
    return Cells(radius, volume, 2 * math.pi / ratio, 2 * math.pi * ends)


def along(pitch_m: Tensor, turns: int) -> Cells:
    """The turns of a layer from the bottom to the top; a slab, per unit area.

    Args:
        pitch_m: (...) height of a turn [m].
        turns: how many.
    """
    height = pitch_m.unsqueeze(-1) * _places(turns, pitch_m)
    middle = (height[..., 1:] + height[..., :-1]) / 2
    volume = torch.diff(torch.cat([height[..., :1], middle, height[..., -1:]], -1))
    return Cells(height, volume, 1 / torch.diff(height), torch.ones_like(height[..., :2]))


def _places(count: int, like: Tensor) -> Tensor:
    """(count + 2,) 0, ½, 1½, …, count: both faces and the middles between."""
    middles = torch.arange(count, dtype=like.dtype, device=like.device) + 0.5
    return torch.cat([torch.zeros_like(middles[:1]), middles, torch.full_like(middles[:1], count)])
