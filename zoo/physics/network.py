"""Lumped heat networks solved in their modes: exact for an air temperature that is linear between samples."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from zoo.physics.recurrence import affine

SERIES_BELOW = 1e-2


@dataclass(frozen=True, eq=False)
class Network:
    """Heat capacities joined by thermal conductances, C·dT/dt = −G·T + g·u(t) + P, batched over devices.

    G = diag(Σ_j K_ij + g_i) − K. Textbook lumped conduction (Incropera, ch. 5).

    Attributes:
        capacity: (..., N) C, positive [J/K].
        link: (..., N, N) K between nodes, symmetric, zero on the diagonal [W/K].
        air: (..., N) g from each node to the air [W/K].
        power: (..., N) P, heat released in each node [W].
    """

    capacity: Tensor
    link: Tensor
    air: Tensor
    power: Tensor

    def conductance(self) -> Tensor:
        """(..., N, N) the matrix G [W/K]; symmetric, positive definite where heat can reach the air from every node."""
        return torch.diag_embed(self.link.sum(-1) + self.air) - self.link


def steady(network: Network, air: Tensor) -> Tensor:
    """Temperatures after an infinite time.

    Args:
        network: B devices, N nodes, each with a way to the air.
        air: (...) temperature [°C].

    Returns:
        (..., N) [°C].
    """
    rise = torch.linalg.solve(network.conductance(), network.power.unsqueeze(-1)).squeeze(-1)
    return air.unsqueeze(-1) + rise


def rates(network: Network, temperature: Tensor, air: Tensor) -> Tensor:
    """dT/dt of every node [K/s], from the heat balance.

    Args:
        network: B devices, N nodes.
        temperature: (..., T, N) [°C].
        air: (..., T) [°C].

    Returns:
        (..., T, N).
    """
    # Relative to one of the nodes, so that a uniform temperature gives exactly nothing.
    excess = temperature - temperature[..., :1]
    flow = excess @ network.link - excess * network.link.sum(-1).unsqueeze(-2)
    drawn = network.air.unsqueeze(-2) * (air.unsqueeze(-1) - temperature)
    return (flow + drawn + network.power.unsqueeze(-2)) / network.capacity.unsqueeze(-2)


def solve(network: Network, time: Tensor, air: Tensor, start: Tensor | None = None) -> Tensor:
    """Temperatures of every node, exact for air that is linear between samples, at any step.

    With S = C^(−1/2)·G·C^(−1/2) = V·Λ·Vᵀ and z = Vᵀ·C^(1/2)·T each mode is a first-order lag, dz/dt = −λ·z + f(t). With x = λ·h,
    φ1 = (1 − e^(−x))/x and φ2 = (1 − φ1)/x:  z[k] = e^(−x)·z[k−1] + h·(φ1 − φ2)·f[k−1] + h·φ2·f[k].

    Differentiable; the gradient of an eigenvector needs distinct eigenvalues, which a network of unequal nodes has.

    Args:
        network: B devices, N nodes.
        time: (T,) strictly increasing [s].
        air: (..., T) [°C].
        start: (..., N) temperatures at the first sample [°C]; where None, the steady ones in the first air.

    Returns:
        (..., T, N) [°C].
    """
    first = steady(network, air[..., 0]) if start is None else start
    root = network.capacity.sqrt()
    scaled = network.conductance() / (root.unsqueeze(-1) * root.unsqueeze(-2))
    decay_rate, modes = torch.linalg.eigh(scaled)
    force = _to_modes(modes, network.air / root).unsqueeze(-1) * air.unsqueeze(-2) + _to_modes(modes, network.power / root).unsqueeze(-1)
    step = torch.diff(time)
    if bool((step == step[:1]).all()):
        step = step[:1]  # the usual case; a weight a mode instead of one a sample
    decay, phi_1, phi_2 = exponential_weights(decay_rate.clamp_min(0.0).unsqueeze(-1) * step)
    driven = step * ((phi_1 - phi_2) * force[..., :-1] + phi_2 * force[..., 1:])
    begin = _to_modes(modes, first * root) + torch.zeros_like(driven[..., 0])
    amplitude = torch.cat([begin.unsqueeze(-1), affine(decay, driven, begin)], dim=-1)
    return (modes @ amplitude).mT / root.unsqueeze(-2)


def _to_modes(modes: Tensor, value: Tensor) -> Tensor:
    """Vᵀ·value: (..., N, N), (..., N) -> (..., N)."""
    return (modes.mT @ value.unsqueeze(-1)).squeeze(-1)


def exponential_weights(x: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """e^(−x), φ1 and φ2 for x ≥ 0, by series where the closed form would cancel."""
    small = x < SERIES_BELOW
    safe = torch.where(small, torch.ones_like(x), x)
    phi_1 = torch.where(small, _series(x, 1), -torch.expm1(-safe) / safe)
    phi_2 = torch.where(small, _series(x, 2), (1 - phi_1) / safe)
    return torch.exp(-x), phi_1, phi_2


def _series(x: Tensor, order: int) -> Tensor:
    """φ1 = 1 − x/2 + x²/6 − …, φ2 = 1/2 − x/6 + x²/24 − …, to x⁶ (5e-18 at the limit)."""
    total, term = torch.zeros_like(x), torch.ones_like(x)
    factor = 1.0 if order == 1 else 0.5
    for power in range(7):
        total = total + factor * term
        term = -term * x
        factor /= power + order + 1
    return total
