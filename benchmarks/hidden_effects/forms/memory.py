"""Effects that remember: relays, Bouc–Wen, Maxwell branches, water in the coil."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from hidden_effects.body import REFERENCE_C, Array, Body
from hidden_effects.forms.form import Form, Forms, decade

KELVIN = 273.15
GAS = 8.314
"""Gas constant [J/mol/K]."""


def relays(temperature: Array, thresholds: Array, half_widths: Array, density: Array) -> Array:
    """(T,) sum of R relays that switch up at c + h and down at c − h (Preisach 1935, Z. Phys. 94:277), each soaked at the first temperature."""
    up, down = thresholds + half_widths, thresholds - half_widths
    state = np.where(temperature[0] > thresholds, 1.0, -1.0)
    out = np.empty_like(temperature)
    for i, value in enumerate(temperature):
        state[value >= up] = 1.0
        state[value <= down] = -1.0
        out[i] = state @ density
    return out


def preisach(chance: np.random.Generator) -> Form:
    """A grid of relays, Gaussian over the thresholds, falling exponentially over the widths."""
    centre, spread = chance.uniform(-5, 40), chance.uniform(12, 40)
    typical = decade(chance, 2.0, 6.0)
    grid, half = np.meshgrid(np.linspace(-60, 90, 61), typical * np.array([0.4, 0.8, 1.3, 2.0, 3.0]))
    density = np.exp(-0.5 * ((grid - centre) / spread) ** 2 - half / typical)
    return Form("preisach", lambda run: relays(run.coil, grid.ravel(), half.ravel(), density.ravel()))


def bouc_wen(chance: np.random.Generator) -> Form:
    """With memory in one variable, dz = A·dT − β|dT||z|^(n−1)z − γ·dT|z|^n (Wen 1976, J. Eng. Mech. 102:249), saturating after some kelvins."""
    width, power, share = decade(chance, 3.0, 10.0), chance.uniform(1.0, 2.0), chance.uniform(0.5, 0.8)

    def signal(run: Body) -> Array:
        z = np.zeros_like(run.coil)
        for i, move in enumerate(np.diff(run.coil) / width):
            size = abs(z[i]) ** power
            z[i + 1] = z[i] + move - share * abs(move) * size * np.sign(z[i]) - (1 - share) * move * size
        return z

    return Form("bouc_wen", signal)


def stress_rate(chance: np.random.Generator) -> Form:
    """Rate of stress of two Maxwell branches, dσ/dt = E·dT/dt − σ/τ(T)."""
    return _branches(chance, "two_branches", lambda run, stress, tau: run.coil_rate - 60.0 * stress / tau)


def stress_itself(chance: np.random.Generator) -> Form:
    """The stress itself of two Maxwell branches."""
    return _branches(chance, "stress", lambda run, stress, tau: stress)


def _branches(chance: np.random.Generator, name: str, seen: Callable[[Body, Array, Array], Array]) -> Form:
    """A form that sees two branches by their stresses (T,) [K] and times (T,) [s].

    Times after Williams, Landel and Ferry 1955, J. Am. Chem. Soc. 77:3701.
    """
    at_20, second = decade(chance, 2000.0, 15000.0), chance.uniform(4.0, 10.0)
    times, weights = (at_20, at_20 / second), (1.0, chance.uniform(0.2, 0.6))
    c1, c2 = chance.uniform(2.0, 6.0), chance.uniform(90.0, 160.0)

    def signal(run: Body) -> Array:
        shift = 10 ** (-c1 * run.above / (c2 + run.above))
        slowed = [np.clip(tau * shift, 30.0, 1e7) for tau in times]
        return np.asarray(sum(weight * seen(run, _stress(run, tau), tau) for tau, weight in zip(slowed, weights, strict=True)))

    return Form(name, signal)


def _stress(run: Body, tau: Array) -> Array:
    """(T,) σ [K] of one branch with E = 1 and times (T,) [s]."""
    step = np.diff(run.coil, prepend=run.coil[0])
    decay = np.exp(-run.step_s / tau)
    stress = np.zeros_like(step)
    for i in range(1, len(step)):
        stress[i] = stress[i - 1] * decay[i] + step[i] * (1 + decay[i]) / 2
    return stress


def water(chance: np.random.Generator) -> Form:
    """Water that leaves a slab (Crank, Mathematics of Diffusion, eq. 4.18), in a clock that runs faster where it is hot (Arrhenius)."""
    tau_h, energy = decade(chance, 3.0, 20.0), chance.uniform(25e3, 50e3)

    def signal(run: Body) -> Array:
        pace = np.exp(energy / GAS * (1 / (REFERENCE_C + KELVIN) - 1 / (run.coil + KELVIN)))
        clock = np.cumsum(pace) * run.step_s / (tau_h * 3600)
        odd = 2 * np.arange(8) + 1
        return np.asarray((np.exp(-np.outer(clock, odd**2)) / odd**2).sum(1))

    return Form("fickian", signal)


FORMS: Forms = {"hysteresis": (preisach, bouc_wen), "viscoelastic": (stress_rate, stress_itself), "moisture": (water,)}
