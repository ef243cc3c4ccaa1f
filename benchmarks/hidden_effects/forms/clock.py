"""Effects of the time since power-on: warm-up, ageing, a step, the chamber's cycling."""

from __future__ import annotations

import numpy as np
from hidden_effects.body import Array, Body
from hidden_effects.forms.form import Form, Forms, decade

HARMONICS = 12
"""Of the chamber's cycle; the last is 2e-3 of the first or less behind the coil."""
WANDER = 0.003
"""How far the chamber's phase walks within one cycle [cycles]: a tenth of a cycle in a thousand of them, so that its line stays one."""


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
    return Form("logarithm", lambda run: np.log1p(run.time / 3600 / tau_h), {"drift": float(np.log1p(10 / tau_h))}, {"bend": -1 / tau_h})


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
    """The chamber's limit cycle under two-point control, seen as the coil's rate through housing and coil, with another phase in each run.

    The air heats and cools at rates of its own, so that its rate is a rectangle wave, high for the share d of the period: Σ sin(πnd)/n·cos(nωt),
    each harmonic through two first-order lags, 1/((1 + inωτ₁)(1 + inωτ₂)). The period is nobody's to know: means over 100 s show one from 120 s
    to 600 s and its image alike.
    """
    period_s, duty = decade(chance, 120.0, 600.0), chance.uniform(0.3, 0.7)
    housing_s, coil_s = decade(chance, 180.0, 900.0), decade(chance, 30.0, 180.0)
    seed = int(chance.integers(2**31))
    order = np.arange(1, HARMONICS + 1)
    turn = 2j * np.pi * order
    size = np.sin(np.pi * order * duty) / order / ((1 + turn * housing_s / period_s) * (1 + turn * coil_s / period_s))

    def signal(run: Body) -> Array:
        own = np.random.default_rng([seed, run.number])
        wander = WANDER * np.sqrt(run.step_s / period_s) * np.cumsum(own.normal(size=len(run.time)))
        cycles = run.time / period_s + own.uniform() + wander
        return np.asarray(np.exp(cycles[:, None] * turn) @ size).real

    return Form("two_point", signal)


FORMS: Forms = {
    "warm_up": (one_exponential, two_exponentials),
    "aging": (power, logarithm, slow_exponential),
    "bias_step": (step_once, step_always),
    "chamber_cycling": (cycling,),
}
