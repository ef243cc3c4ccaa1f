"""What no catalogue has."""

from __future__ import annotations

import numpy as np
from hidden_effects.body import Array, Body, delayed
from hidden_effects.forms.form import Form, Forms, decade


def rate_squared(chance: np.random.Generator) -> Form:
    """(dT/dt)², the same in heating and cooling."""
    del chance
    return Form("rate_squared", lambda run: run.coil_rate**2)


def root_of_rate(chance: np.random.Generator) -> Form:
    """|dT/dt|^½: friction or convection."""
    del chance
    return Form("root_of_rate", lambda run: np.sqrt(np.abs(run.coil_rate)))


def hot_rate_squared(chance: np.random.Generator) -> Form:
    """T·(dT/dt)²."""
    del chance
    return Form("temperature_times_rate_squared", lambda run: run.coil * run.coil_rate**2)


def highest_so_far(chance: np.random.Generator) -> Form:
    """The hottest that the coil ever was in this run."""
    del chance
    return Form("running_maximum", lambda run: np.maximum.accumulate(run.coil))


def telegraph(chance: np.random.Generator) -> Form:
    """A bias that jumps between two levels at random moments."""
    mean_s, seed = decade(chance, 1200.0, 5000.0), int(chance.integers(2**31))
    return Form("telegraph", lambda run: np.where(np.cumsum(_events(run, mean_s, seed)) % 2, 1.0, -1.0))


def _events(run: Body, mean_s: float, seed: int) -> Array:
    """(T,) how many random events fall into each row, none into the first tenth; one in a run at least."""
    own = np.random.default_rng([seed, run.number])
    count = max(1, own.poisson(len(run.time) * run.step_s / mean_s))
    return np.bincount(own.integers(len(run.time) // 10, len(run.time), count), minlength=len(run.time)).astype(float)


def chirp(chance: np.random.Generator) -> Form:
    """A line whose period shrinks with time."""
    first_s, growth = decade(chance, 3600.0, 9000.0), chance.uniform(1.0, 3.0)
    return Form("chirp", lambda run: np.sin(2 * np.pi * run.time / first_s * (1 + growth * run.time / 40000)))


def heating_only(chance: np.random.Generator) -> Form:
    """T_outer·dT/dt where it heats, nothing where it cools."""
    del chance
    return Form("heating_only", lambda run: (run.outer + 60) * np.maximum(run.coil_rate, 0.0))


def door(chance: np.random.Generator) -> Form:
    """The door is opened some times a run: a burst that dies in minutes."""
    mean_s, tau_s, seed = decade(chance, 4000.0, 9000.0), decade(chance, 300.0, 900.0), int(chance.integers(2**31))
    return Form("door", lambda run: delayed(_events(run, mean_s, seed), tau_s, run.step_s))


def late_friction(chance: np.random.Generator) -> Form:
    """lag(|dT/dt|): strain that grows with any change and relaxes."""
    tau_s = decade(chance, 900.0, 5000.0)
    return Form("late_size_of_rate", lambda run: delayed(np.abs(run.coil_rate), tau_s, run.step_s))


ALL = (rate_squared, root_of_rate, hot_rate_squared, highest_so_far, telegraph, chirp, heating_only, door, late_friction)
FORMS: Forms = {"outside": ALL}
