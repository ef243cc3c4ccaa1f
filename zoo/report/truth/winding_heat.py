"""The temperature of every turn of a winding at chosen moments of a simulated run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from zoo.report.truth.moments import Moment, moments
from zoo.simulator.plant import air_of
from zoo.simulator.recorded import Recorded
from zoo.simulator.simulation import Simulation
from zoo.simulator.thermal.heat import fields
from zoo.units import convert

LABEL = 1
"""Number of the run that is pictured."""


@dataclass(frozen=True, eq=False)
class Snapshots:
    """Temperature fields of the first run.

    Attributes:
        moments: K moments.
        field_c: (K, layers, turns) [°C].
        mean_c: (K,) mean over the fibre [°C].
        hours: (T,) of the run [h].
        asked_c: (T,) set point [°C].
        coil_c: (T,) mean over the fibre [°C].
    """

    moments: Sequence[Moment]
    field_c: np.ndarray
    mean_c: np.ndarray
    hours: np.ndarray
    asked_c: np.ndarray
    coil_c: np.ndarray


def pictured(simulation: Simulation) -> Recorded:
    """The first run."""
    return simulation.runs[LABEL - 1]


def snapshots(simulation: Simulation) -> Snapshots:
    """The first run's temperature fields around the first motion of its program.

    Args:
        simulation: a gyro's runs.
    """
    run, settings = pictured(simulation), simulation.settings
    time = run.table["time_s"]
    chosen = moments(run.program, settings.cold_start)
    rows = {min(round(one.time_s / settings.sample_s), len(time) - 1): one for one in reversed(chosen)}
    samples = sorted(rows)
    turns = temperatures(simulation, samples)
    return Snapshots(
        moments=[replace(rows[row], time_s=row * settings.sample_s) for row in samples],
        field_c=turns.numpy(),
        mean_c=over_fibre(simulation, turns).numpy(),
        hours=convert(time.numpy(), "s", "h"),
        asked_c=run.program.asked(time).numpy(),
        coil_c=run.truth["temperature_coil_c"].numpy(),
    )


@torch.no_grad()
def temperatures(simulation: Simulation, samples: Sequence[int]) -> Tensor:
    """The first run's heat once more, turn by turn, in whatever detail it was simulated.

    Args:
        simulation: a gyro's runs.
        samples: K rows of the run.

    Returns:
        (K, layers, turns) [°C].
    """
    run, device = pictured(simulation), simulation.device
    time = run.table["time_s"]
    air = air_of(device, run.program, LABEL, simulation.chamber, time)[: max(samples) + 1]
    soaked_c, cold_start = float(run.program.asked(time[:1])), simulation.settings.cold_start
    return fields([device], time[: len(air)], air, torch.tensor(samples), cold_start, soaked_c).squeeze(0)


def over_fibre(simulation: Simulation, turns: Tensor) -> Tensor:
    """Mean over the fibre: (..., layers, turns) -> (...)."""
    length = simulation.device.winding.length
    return (turns * length).sum((-1, -2)) / length.sum()
