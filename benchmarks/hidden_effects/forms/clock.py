"""Effects of the time since power-on: warm-up, ageing, a step, the chamber's cycling."""

from __future__ import annotations

import numpy as np
from hidden_effects.body import Array, Body
from hidden_effects.forms.form import Form, Forms, decade


def one_exponential(chance: np.random.Generator) -> Form:
    """e^(−t/τ), as the catalogue has it."""
    tau_s = decade(chance, 600.0, 3600.0)
    return Form("one_exponential", lambda run: np.exp(-run.time / tau_s), {"amplitude": 1.0}, {"time": tau_s})


def two_exponentials(chance: np.random.Generator) -> Form:
    """Source and body: one to four minutes and ten to forty."""
    fast, slow, share = decade(chance, 60.0, 240.0), decade(chance, 600.0, 2400.0), chance.uniform(0.2, 0.5)
    return Form("two_exponentials", lambda run: share * np.exp(-run.time / fast) + (1 - share) * np.exp(-run.time / slow))


def power(chance: np.random.Generator) -> Form:
    """t^p."""
    exponent = chance.uniform(0.4, 0.8)
    return Form("power", lambda run: (run.time / 3600) ** exponent)


def logarithm(chance: np.random.Generator) -> Form:
    """ln(1 + t/τ), as the catalogue has it."""
    tau_h = decade(chance, 1.0, 10.0)
    return Form("logarithm", lambda run: np.log1p(run.time / 3600 / tau_h), {"drift": float(np.log1p(10 / tau_h))}, {"time": tau_h})


def slow_exponential(chance: np.random.Generator) -> Form:
    """1 − e^(−t/15 h) or thereabouts."""
    tau_s = 3600 * chance.uniform(10, 20)
    return Form("slow_exponential", lambda run: 1 - np.exp(-run.time / tau_s))


def step_once(chance: np.random.Generator) -> Form:
    """A jump in the first run only."""
    at_s = 3600 * chance.uniform(0.7, 2.0)
    return Form("in_one_run", lambda run: (run.time > at_s) * float(run.number == 1), {"step": 1.0}, {"onset": at_s / 3600})


def step_always(chance: np.random.Generator) -> Form:
    """A jump at the same time of every run, spread over two minutes."""
    at_s = 3600 * chance.uniform(0.7, 2.0)
    return Form("in_all_runs", lambda run: np.clip((run.time - at_s) / 120 + 0.5, 0, 1), {"step": 1.0}, {"onset": at_s / 3600})


def cycling(chance: np.random.Generator) -> Form:
    """The line of the chamber's cycling and its octave, with another phase in each run."""
    period_s, octave, seed = decade(chance, 250.0, 900.0), chance.uniform(0.05, 0.2), int(chance.integers(2**31))

    def signal(run: Body) -> Array:
        phase = 2 * np.pi * np.random.default_rng([seed, run.number]).uniform()
        angle = 2 * np.pi * run.time / period_s + phase
        return np.sin(angle) + octave * np.sin(2 * angle + 1)

    return Form("line_and_octave", signal, {}, {"period": period_s})


FORMS: Forms = {
    "warm_up": (one_exponential, two_exponentials),
    "aging": (power, logarithm, slow_exponential),
    "bias_step": (step_once, step_always),
    "chamber_cycling": (cycling,),
}
