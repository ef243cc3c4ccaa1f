"""The columns that a regression would try: of what was recorded, each with the catalogue's effect that it stands for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from hidden_effects.body import REFERENCE_C, Array, delayed

from zoo.measurements.run import Run

SMOOTHED_S = 60.0
"""A thermometer's steps are smoothed over this before its rate is taken."""
BASE_LAGS_S, LAGS_S = (300.0, 900.0), (500.0, 1500.0, 4500.0)
APART = 0.01
"""Share of a column that the base must leave for it to be tried."""
PERIODS_K = (5.0, 7.0, 10.0, 14.0, 20.0, 28.0)
Named = tuple[str | None, Array]


@dataclass(frozen=True, eq=False)
class Library:
    """Block means of several runs, one after the other.

    Attributes:
        error: (N,) output − reference.
        base: (N, M) of the base: powers of temperature, its rates, now and some minutes ago.
        columns: (N, K) of what may be missing.
        effects: the effect of each.
        run: (N,) number of the run.
    """

    error: Array
    base: Array
    columns: Array
    effects: tuple[str, ...]
    run: Array

    def named(self, chosen: Array) -> list[str]:
        """Effects of the chosen columns (K,)."""
        return sorted({name for name, one in zip(self.effects, chosen, strict=True) if one})


def library(runs: list[Run]) -> Library:
    """All columns on the blocks of the runs; those that the base has already are left out."""
    parts = [list(_of_run(run)) for run in runs]
    names = [name for name, _ in parts[0]]
    table = np.stack([np.concatenate([part[place][1] for part in parts]) for place in range(len(names))], axis=1)
    own = np.array([name is None for name in names])
    moves = table.std(0) > 1e-9 * np.abs(table).max(0)
    error = np.concatenate([run.block_mean(run.error).numpy() for run in runs])
    run = np.repeat(np.arange(len(runs)), [run.blocks for run in runs])
    base = np.column_stack([np.ones(len(error)), table[:, own & moves]])
    basis, _ = np.linalg.qr(base / np.abs(base).max(0))
    kept = ~own & moves & ((table - basis @ (basis.T @ table)).std(0) > APART * table.std(0))
    return Library(error, base, table[:, kept], tuple(str(name) for name, keep in zip(names, kept, strict=True) if keep), run)


def _of_run(run: Run) -> Iterator[Named]:
    for name, column in _columns(run):
        yield name, np.asarray(run.block_mean(run.time.new_tensor(np.asarray(column, dtype=float))).numpy())


def _columns(run: Run) -> Iterator[Named]:
    """(T,) columns on the fine grid."""
    time = (run.time - run.time[0]).numpy()
    step = float(np.median(np.diff(time)))
    above = run.temperature.numpy() - REFERENCE_C
    rate = (above - delayed(above, SMOOTHED_S, step)) / SMOOTHED_S * 60
    yield from ((None, above**power) for power in (1, 2, 3))
    yield None, rate
    yield from ((None, delayed(rate, lag, step)) for lag in BASE_LAGS_S)
    yield None, (rate - delayed(rate, SMOOTHED_S, step)) / SMOOTHED_S * 60
    yield from _of_temperature(above, rate, step)
    yield from _of_time(time)
    yield from _recorded(run, above, rate)


def _of_temperature(above: Array, rate: Array, step: float) -> Iterator[Named]:
    yield from (("hysteresis", play(above, radius) - above) for radius in (2.0, 5.0, 10.0))
    for period in PERIODS_K:
        yield from (("polarization", wave(2 * np.pi * above / period)) for wave in (np.cos, np.sin))
    yield from (("rate_temperature_coupling", above**power * rate) for power in (1, 2))
    yield from (("sensor_lag", delayed(above, lag, step) - above) for lag in LAGS_S)
    yield from (("glass_transition", rate / (1 + np.exp(-(above - middle) / 8))) for middle in (-30.0, -10.0, 10.0, 30.0))
    yield from (("viscoelastic", delayed(rate, lag, step)) for lag in (7200.0, 20000.0))


def play(value: Array, radius: float) -> Array:
    """(T,) a play of this radius, at rest in the middle at the start."""
    out = np.empty_like(value)
    held = value[0]
    for i, now in enumerate(value):
        held = max(now - radius, min(now + radius, held))
        out[i] = held
    return out


def _of_time(time: Array) -> Iterator[Named]:
    hours = time / 3600
    yield from (("warm_up", np.exp(-time / tau)) for tau in (150.0, 600.0, 1800.0))
    yield from (("aging", column) for column in (hours, np.log1p(hours)))
    yield from (("moisture", np.exp(-hours / tau)) for tau in (3.0, 10.0))
    yield from (("bias_step", (hours > onset).astype(float)) for onset in (0.75, 1.25, 1.75))


def _recorded(run: Run, above: Array, rate: Array) -> Iterator[Named]:
    field, volts, reference = run.column("field_ut").numpy(), run.column("supply_v").numpy(), run.table[:, -1].numpy()
    yield from (("magnetic", column) for column in (field, field * above))
    yield "supply_voltage", volts - 5
    if len(run.thermometers) > 1:
        yield "thermal_gradient", run.column(run.thermometers[1]).numpy() - run.temperature.numpy()
    large = float(np.abs(reference).max()) or 1.0
    yield from (("scale_factor", reference * above**power / large) for power in (0, 1, 2))
    yield from (("scale_factor_nonlinearity", (reference / large) ** power) for power in (2, 3))
    yield from (("misalignment", np.sign(reference) * above**power) for power in (0, 1))
    yield "fixture_rotation", np.sign(reference) * rate
    yield from (("dead_band", reference * np.exp(-((reference / width) ** 2) / 2)) for width in (large / 10, large / 3))
