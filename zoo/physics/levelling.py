"""Levelling: pitch and roll of a body at rest from its three accelerometers, which then feel nothing but the reaction to gravity.

Axes: x right, y forward, z up in the body; at pitch, roll and heading 0 they point east, north and up. Rotations in the order heading (about z),
pitch (about x), roll (about y), so that a raised nose is a positive pitch and a lowered right side a positive roll. At rest the specific force is the
local vertical, pointing up, seen in the body:  f = g·(−cos θ·sin φ, sin θ, cos θ·cos φ).

Groves 2013, Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems, 2nd ed., section 5.6, has forward, right, down and
φ = atan2(−f_y, −f_z), θ = atan(f_x/√(f_y² + f_z²)). His axes are (y, x, −z) of these, and the angles the same.
"""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.errors import InputError


def specific_force(pitch: Tensor, roll: Tensor) -> Tensor:
    """What ideal accelerometers of a body at rest show.

    Args:
        pitch: (...) θ [°], −90 to 90.
        roll: (...) φ [°].

    Returns:
        (..., 3) along right, forward and up [g].
    """
    theta, phi = torch.deg2rad(pitch), torch.deg2rad(roll)
    return torch.stack([-theta.cos() * phi.sin(), theta.sin(), theta.cos() * phi.cos()], dim=-1)


def attitude(force: Tensor) -> tuple[Tensor, Tensor]:
    """Pitch and roll of a body at rest. Exact, whatever the unit of the force and the size of g; the heading cannot be seen.

    A small error δf of a level axis tilts the result by δf/g: 0.005° for 87 µg. Near a pitch of ±90° the roll has no meaning.

    Args:
        force: (..., 3) specific force along right, forward and up, any unit.

    Returns:
        Pitch (...) and roll (...) [°].

    Raises:
        InputError: a force of no length, which has no direction.
    """
    right, forward, up = force.unbind(-1)
    if bool((force == 0).all(-1).any()):
        raise InputError("the specific force is 0 along all three axes: in free fall there is no attitude to be found")
    return torch.rad2deg(torch.atan2(forward, torch.hypot(right, up))), torch.rad2deg(torch.atan2(-right, up))
