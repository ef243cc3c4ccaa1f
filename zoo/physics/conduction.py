"""Heat in a gyro at three fidelities behind one interface: the winding as one lump, as layers, as layers and turns.

Assumed: conductivities, heat capacities and films that do not change with temperature; the same temperature all the way around a turn (the fibre
conducts along itself, and the chamber's air is stirred); isothermal spool and housing (metal, a hundred times the winding's conductivity).

Where constant coefficients bite: real ones change by 3 to 7 % for the metal, 12 to 18 % for the winding's capacity and 14 to 28 % for the films
between 20 °C and −40 or 60 °C. Over such a ramp at 1 K/min those of 20 °C put the coil of a medium gyro 0.9 K off, of a tactical one 0.4 K, and its
rate by 2 to 4 %; that is below the gyros' flicker. They bite at the edges of Shupe's effect, by up to a factor of 2 (0.001 °/h), as the film of the
gap shifts heat from one face to the other, and on ramps of 5 K/min, where Mohr's effect is 0.01 °/h (medium) or 0.08 °/h (tactical) wrong.
`benchmarks/constant_coefficients.py` prints it, tests/simulator/test_constant_coefficients.py holds it against the nonlinear solution.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.physics.cells import Cells, across, along
from zoo.physics.lumps import Lumps
from zoo.physics.system import System

FACES = ("inner", "outer", "bottom", "top")
FOLLOWED = 256
"""Modes of the winding that are followed by themselves; the others are taken to follow the lumps around it, late by their time constant."""


@dataclass(frozen=True, eq=False)
class Pack:
    """A winding as a conductor of heat, between the lumps that touch its faces.

    Attributes:
        layers: from the inside.
        turns: from the bottom.
        inner_m: (...) radius of the inner face [m].
        layer_pitch_m: (...) [m].
        turn_pitch_m: (...) [m].
        conductivity: (...) k⊥ across the fibre [W/m/K].
        heat_capacity: (...) ρc [J/m³/K].
        films: (..., 4) coefficient of `FACES`: a contact, or air [W/m²/K].
        touches: number of the lump that each of `FACES` touches.
    """

    layers: int
    turns: int
    inner_m: Tensor
    layer_pitch_m: Tensor
    turn_pitch_m: Tensor
    conductivity: Tensor
    heat_capacity: Tensor
    films: Tensor
    touches: tuple[int, int, int, int]

    @property
    def across(self) -> Cells:
        """Cells from the inner to the outer face."""
        return across(self.inner_m, self.layer_pitch_m, self.layers)

    @property
    def along(self) -> Cells:
        """Cells from the bottom to the top."""
        return along(self.turn_pitch_m, self.turns)


def lumped(pack: Pack, around: Lumps) -> System:
    """The winding at one temperature; no Shupe effect."""
    cells, height = pack.across, pack.turn_pitch_m * pack.turns
    section = cells.volume.sum(-1)
    area = torch.stack([cells.area[..., 0] * height, cells.area[..., 1] * height, section, section], -1)
    through = pack.films * area * _to_middle(pack)
    capacity = (pack.heat_capacity * section * height).unsqueeze(-1)
    return _joined(around, capacity, torch.zeros_like(capacity).unsqueeze(-1), _touching(pack, around, through.unsqueeze(-2)), (1, 1))


def radial(pack: Pack, around: Lumps) -> System:
    """A temperature for each layer; what leaves through the flanges passes the layer's mean distance from them."""
    cells, height = pack.across, (pack.turn_pitch_m * pack.turns).unsqueeze(-1)
    stiffness = height.unsqueeze(-1) * cells.stiffness(pack.conductivity, torch.zeros_like(pack.films[..., :2]))
    ends = pack.films[..., 2:] * _to_middle(pack)[..., 2:]
    flow = torch.zeros(*cells.volume.shape, 4, dtype=cells.volume.dtype, device=cells.volume.device)
    flow[..., 2:] = cells.volume.unsqueeze(-1) * ends.unsqueeze(-2)
    flow[..., 0, 0] = pack.films[..., 0] * cells.area[..., 0] * height[..., 0]
    flow[..., -1, 1] = pack.films[..., 1] * cells.area[..., 1] * height[..., 0]
    capacity = pack.heat_capacity.unsqueeze(-1) * cells.volume * height
    return _joined(around, capacity, stiffness, _touching(pack, around, flow), (pack.layers, 1))


def radial_axial(pack: Pack, around: Lumps, followed: int = FOLLOWED) -> System:
    """A temperature for each turn.

    The winding between lumps held still has modes that are products of one across and one along. The `followed` coarsest ones join the lumps as
    states, the others by what they hold back in a steady state and in a steady ramp (component mode synthesis, Craig & Bampton 1968,
    AIAA J. 6:1313).
    """
    rows, columns = pack.across, pack.along
    decay_r, shape_r = _modes_between(rows, pack.conductivity, pack.films[..., :2])
    decay_z, shape_z = _modes_between(columns, pack.conductivity, pack.films[..., 2:])
    decay = ((decay_r.unsqueeze(-1) + decay_z.unsqueeze(-2)) / pack.heat_capacity[..., None, None]).flatten(-2)
    root = pack.heat_capacity.sqrt()[..., None, None]
    ends_r = shape_r[..., [0, -1], :] * rows.area.unsqueeze(-1)
    mean_r, mean_z = (one.volume.unsqueeze(-2) @ shape for one, shape in ((rows, shape_r), (columns, shape_z)))
    sides = torch.cat([_products(ends_r, mean_z), _products(mean_r, shape_z[..., [0, -1], :])], -2)
    pull = _touching(pack, around, (pack.films.unsqueeze(-1) * sides / root).mT)  # (..., modes, lumps)
    height = columns.volume.sum(-1, keepdim=True)
    section = rows.volume.sum(-1, keepdim=True)
    area = torch.cat([rows.area * height, section, section], -1)
    held = around.conductance() + torch.diag_embed(_touching(pack, around, (pack.films * area).unsqueeze(-2)).squeeze(-2))
    slow = _coarsest(pack, followed).to(decay.device)
    shapes = (shape_r[..., 1:-1, :] / root, shape_z[..., 1:-1, :])  # what the turns themselves see
    return _synthesised(around, held, decay, pull, shapes, slow, (pack.layers, pack.turns))


def _coarsest(pack: Pack, followed: int) -> Tensor:
    """(modes,) whether a mode is among those with the fewest waves for each layer and turn; the same for all devices of a design."""
    across, along = ((torch.arange(count + 2, dtype=torch.float64) / count).square() for count in (pack.layers, pack.turns))
    waves = (across.unsqueeze(1) + along).flatten()
    chosen = torch.zeros(len(waves), dtype=torch.bool)
    chosen[waves.argsort(stable=True)[:followed]] = True
    return chosen


def _synthesised(
    around: Lumps, held: Tensor, decay: Tensor, pull: Tensor, shapes: tuple[Tensor, Tensor], slow: Tensor, cut: tuple[int, int]
) -> System:
    """Lumps with the winding's slow modes as states and the fast ones condensed."""
    fast = pull[..., ~slow, :] / decay[..., ~slow].unsqueeze(-1)
    stiffness = held - pull[..., ~slow, :].mT @ fast
    mass = torch.diag_embed(around.capacity) + fast.mT @ fast
    inverse = torch.linalg.inv(torch.linalg.cholesky(mass))  # R⁻¹ of M = R·Rᵀ; x = Rᵀ·T
    own, cross = inverse @ stiffness @ inverse.mT, -inverse @ pull[..., slow, :].mT
    corner = torch.cat([torch.cat([own, cross], -1), torch.cat([cross.mT, torch.diag_embed(decay[..., slow])], -1)], -2)
    driven = inverse @ torch.cat([around.ambient, around.power.unsqueeze(-1)], -1)
    drive = torch.cat([driven, driven.new_zeros(*driven.shape[:-2], int(slow.sum()), driven.shape[-1])], -2)
    held_back = (pull / decay.unsqueeze(-1)).masked_fill(slow.unsqueeze(-1), 0.0)
    still, lagging = (_over_turns(shapes, part) @ inverse.mT for part in (held_back, -held_back / decay.unsqueeze(-1)))
    followed = _chosen_products(shapes, slow)
    winding, late = torch.cat([still, followed], -1), torch.cat([lagging, torch.zeros_like(followed)], -1)
    lumps = torch.cat([inverse.mT, inverse.new_zeros(*inverse.shape[:-1], int(slow.sum()))], -1)
    return System(corner, drive, lumps, winding, late, cut)


FIDELITIES: Mapping[str, Callable[[Pack, Lumps], System]] = {"lumped": lumped, "radial": radial, "radial_axial": radial_axial}


def _to_middle(pack: Pack) -> Tensor:
    """(..., 4) share of a film's conductance that is left from each face to the mean of the half that it heats: a slab's d/(6k) behind it.

    Right where both faces of a direction are heated alike; where only one is, the way is twice as long.
    """
    thickness, height = pack.layer_pitch_m * pack.layers, pack.turn_pitch_m * pack.turns
    depth = torch.stack([thickness, thickness, height, height], -1)
    return 1 / (1 + pack.films * depth / (6 * pack.conductivity.unsqueeze(-1)))


def _touching(pack: Pack, around: Lumps, flow: Tensor) -> Tensor:
    """(..., N, 4) by face to (..., N, L) by lump."""
    lumps = flow.new_zeros(len(FACES), around.capacity.shape[-1])
    for face, lump in enumerate(pack.touches):
        lumps[face, lump] = 1.0
    return flow @ lumps


def _modes_between(cells: Cells, conductivity: Tensor, films: Tensor) -> tuple[Tensor, Tensor]:
    """(..., N) decay for ρc = 1 and (..., N, N) shapes, ∫φ² = 1, of a winding between ambients held still."""
    root = cells.volume.sqrt()
    decay, vectors = torch.linalg.eigh(cells.stiffness(conductivity, films) / (root.unsqueeze(-1) * root.unsqueeze(-2)))
    return decay, vectors / root.unsqueeze(-1)


def _products(first: Tensor, second: Tensor) -> Tensor:
    """(..., A, M), (..., B, N) -> (..., A·B, M·N), all products."""
    return (first[..., :, None, :, None] * second[..., None, :, None, :]).flatten(-4, -3).flatten(-2)


def _over_turns(shapes: tuple[Tensor, Tensor], amplitude: Tensor) -> Tensor:
    """Modes of amplitude (..., M·N, L) at the turns, (..., R·C, L): along one direction after the other, never all products at once."""
    across, along = shapes
    return torch.einsum("...rm,...mnl,...cn->...rcl", across, amplitude.unflatten(-2, (across.shape[-1], along.shape[-1])), along).flatten(-3, -2)


def _chosen_products(shapes: tuple[Tensor, Tensor], chosen: Tensor) -> Tensor:
    """(..., R·C, chosen) shapes of some of the product modes at the turns."""
    across, along = torch.nonzero(chosen.unflatten(0, (shapes[0].shape[-1], -1)), as_tuple=True)
    return (shapes[0][..., :, None, across] * shapes[1][..., None, :, along]).flatten(-3, -2)


def _joined(around: Lumps, capacity: Tensor, stiffness: Tensor, flow: Tensor, cut: tuple[int, int]) -> System:
    """Lumps and the cells of a winding as one system.

    Args:
        around: L lumps.
        capacity: (..., N) of the cells [J/K].
        stiffness: (..., N, N) conductance among them [W/K].
        flow: (..., N, L) conductance from each to each lump [W/K].
        cut: rows and columns; nodes on faces are not among them.
    """
    own = stiffness + torch.diag_embed(flow.sum(-1))
    lumps = around.conductance() + torch.diag_embed(flow.sum(-2))
    whole = torch.cat([torch.cat([lumps, -flow.mT], -1), torch.cat([-flow, own], -1)], -2)
    root = torch.cat([around.capacity + torch.zeros_like(flow[..., 0, :]), capacity], -1).sqrt()
    entering = torch.cat([around.ambient, around.power.unsqueeze(-1)], -1)
    drive = torch.cat([entering, entering.new_zeros(*flow.shape[:-1], entering.shape[-1])], -2) / root.unsqueeze(-1)
    seen = torch.diag_embed(1 / root)
    count = around.capacity.shape[-1]
    cells = seen[..., count:, :] if capacity.shape[-1] == 1 else seen[..., count + 1 : -1, :]
    return System(whole / (root.unsqueeze(-1) * root.unsqueeze(-2)), drive, seen[..., :count, :], cells, torch.zeros_like(cells), cut)
