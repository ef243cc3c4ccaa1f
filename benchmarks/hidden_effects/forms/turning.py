"""Effects of the true rate, and of what really turns: scale factor, its nonlinearity, a tilting axis, a dead band, a twisting fixture."""

from __future__ import annotations

import numpy as np
from hidden_effects.body import REFERENCE_C, Array, Body, delayed
from hidden_effects.forms.form import Form, Forms, decade

GAIN = 7e-6
"""Sagnac's gain of a small coil [1/(°/h)], about 0.3 s: a rate of 10 °/s makes an argument of 0.25."""


def scale(chance: np.random.Generator) -> Form:
    """A scale factor that goes with temperature and saturates, Ω·(s + tanh((T − T0)/w))."""
    middle, width, offset = chance.uniform(0, 40), decade(chance, 25.0, 100.0), chance.uniform(-0.5, 0.5)
    return Form("tanh", lambda run: run.reference * (offset + np.tanh((run.housing - middle) / width)))


def open_loop(chance: np.random.Generator) -> Form:
    """sin(SΩ)/S − Ω with a gain that goes with temperature."""
    slope = chance.uniform(-4e-4, 4e-4)

    def signal(run: Body) -> Array:
        gain = GAIN * (1 + slope * (run.housing - REFERENCE_C))
        return np.sin(gain * run.reference) / gain - run.reference

    return Form("sine", signal)


def tilting_axis(chance: np.random.Generator) -> Form:
    """The rate across the input axis, times a tilt that goes with temperature."""
    bent = chance.uniform(-0.005, 0.005)

    def signal(run: Body) -> Array:
        above = run.housing - REFERENCE_C
        return run.cross * above * (1 + bent * above)

    return Form("quadratic", signal)


def edge(chance: np.random.Generator) -> float:
    """Of a dead band, as a share of its width: noise smooths it."""
    return float(chance.uniform(0.1, 0.5))


def dead_band(width_dph: float, edge: float) -> Form:
    """An output that stays at nothing near no rate, and comes back over an edge."""
    return Form("smoothed", lambda run: width_dph * band(run.reference / width_dph, edge))


def band(place: Array, edge: float) -> Array:
    """A dead band of width 1."""
    return -0.5 * place * (1 - np.tanh((np.abs(place) - 1) / edge))


def twist(chance: np.random.Generator) -> Form:
    """A fixture that twists about the vertical as it is heated: the rate of a plate's temperature, which is later than the air."""
    tau_s = decade(chance, 300.0, 2400.0)

    def signal(run: Body) -> Array:
        plate = delayed(run.air, tau_s, run.step_s)
        return np.where(run.reference < 0, -60.0, 60.0) * (run.air - plate) / tau_s

    return Form("plate", signal)


FORMS: Forms = {
    "scale_factor": (scale,),
    "scale_factor_nonlinearity": (open_loop,),
    "misalignment": (tilting_axis,),
    "fixture_rotation": (twist,),
}
