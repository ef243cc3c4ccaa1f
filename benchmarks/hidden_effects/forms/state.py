"""Effects of the temperatures at one moment and of their rates: fringes, couplings, gradients, a glass transition, another place's bias."""

from __future__ import annotations

import numpy as np
from hidden_effects.body import REFERENCE_C, Array, Body, delayed
from hidden_effects.forms.form import Form, Forms, decade
from scipy.special import erf


def _pigtail(run: Body, toward_housing: float, tau_s: float) -> Array:
    """(T,) temperature of the leads: between coil and housing, and later than both [°C]."""
    return delayed(run.coil + toward_housing * (run.housing - run.coil), tau_s, run.step_s)


def airy(chance: np.random.Generator) -> Form:
    """The fringe of a weak resonator, 1/(1 + F·sin²(πT/P + ψ)), at the leads."""
    period, finesse, phase = decade(chance, 4.0, 30.0), chance.uniform(0.5, 3.0), chance.uniform(0, np.pi)
    place = chance.uniform(0.0, 0.3), chance.uniform(10.0, 60.0)
    return Form("airy", lambda run: 1 / (1 + finesse * np.sin(np.pi * _pigtail(run, *place) / period + phase) ** 2))


def lines(chance: np.random.Generator) -> Form:
    """Two or three lines of incommensurate periods at the leads, as several splices make them."""
    count = int(chance.integers(2, 4))
    periods = decade(chance, 5.0, 25.0) * np.array([1.0, np.sqrt(0.35), np.sqrt(2.3)])[:count]
    sizes, phases = np.array([1.0, *chance.uniform(0.1, 0.35, count - 1)]), chance.uniform(0, 2 * np.pi, count)
    place = chance.uniform(0.0, 0.3), chance.uniform(10.0, 60.0)
    return Form("lines", lambda run: np.asarray(np.cos(2 * np.pi * _pigtail(run, *place)[:, None] / periods + phases) @ sizes))


def coupling(chance: np.random.Generator) -> Form:
    """A mean-rate error whose coefficient saturates beyond the range, tanh((T − T0)/w)·dT/dt; where it saturates within, it is a glass transition."""
    middle, width = chance.uniform(0, 40), decade(chance, 60.0, 200.0)
    return Form("tanh", lambda run: run.coil_rate * np.tanh((run.coil - middle) / width))


def glass(chance: np.random.Generator) -> Form:
    """The mean-rate error jumps where the glue softens, by an error function, with a spike in between."""
    middle, width, spike = chance.uniform(0, 45), chance.uniform(5, 12), chance.uniform(0.2, 1.0) * chance.choice([-1, 1])

    def signal(run: Body) -> Array:
        place = (run.coil - middle) / width
        return run.coil_rate * (0.5 + 0.5 * erf(place / np.sqrt(2)) + spike * np.exp(-(place**2)))

    return Form("erf_and_spike", signal)


def gradient(chance: np.random.Generator) -> Form:
    """b·(T_housing − T_spool), half of the time with a little of its square."""
    bent = chance.choice([0.0, 0.02])

    def signal(run: Body) -> Array:
        across = run.housing - run.spool
        return across + bent * across**2

    return Form("bent" if bent else "linear", signal)


def elsewhere(chance: np.random.Generator) -> Form:
    """A static bias that lives at another place, behind a lag of its own: b'·(lag(T_there) − T_coil), the coil's share being in the base."""
    there, tau_s = str(chance.choice(["spool", "housing", "air"])), decade(chance, 100.0, 1500.0)

    def signal(run: Body) -> Array:
        return delayed(getattr(run, there), tau_s, run.step_s) - run.coil

    shared = {"slope": 1.0} if there == "spool" else {}
    return Form(there, signal, shared)


def magnetic(chance: np.random.Generator) -> Form:
    """(1 + m(T − 20 °C))·B, half of the time with a little of B²."""
    slope, bent = chance.uniform(0.001, 0.0015), chance.choice([0.0, 0.002])

    def signal(run: Body) -> Array:
        return (1 + slope * (run.housing - REFERENCE_C)) * (run.field + bent * run.field**2)

    return Form("bent" if bent else "linear", signal, {} if bent else {"sensitivity": 1.0})


def supply(chance: np.random.Generator) -> Form:
    """(V − 5 V), half of the time with a fifth of its square at 0.1 V."""
    bent = chance.choice([0.0, 2.0])
    return Form("bent" if bent else "linear", lambda run: (run.supply - 5) + bent * (run.supply - 5) ** 2, {} if bent else {"sensitivity": 1.0})


FORMS: Forms = {
    "polarization": (airy, lines),
    "rate_temperature_coupling": (coupling,),
    "glass_transition": (glass,),
    "thermal_gradient": (gradient,),
    "sensor_lag": (elsewhere,),
    "magnetic": (magnetic,),
    "supply_voltage": (supply,),
}
