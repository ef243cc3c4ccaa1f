"""A case, made: runs as files would be read, with the base, the noise and every hidden part beside them."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import torch
from hidden_effects.body import Array, Body, body
from hidden_effects.forms.form import Form
from hidden_effects.programs import at_rows, random_program, run_program, turned
from hidden_effects.recipe import BASE, Recipe, band_dph, forms_of
from torch import Tensor

from zoo.catalog import build
from zoo.measurements.read import read_runs
from zoo.measurements.run import Run
from zoo.measurements.write import write_measurements
from zoo.scoring.noise import NoiseModel
from zoo.simulator.gyros.classes import MEDIUM, TACTICAL
from zoo.simulator.gyros.device import draw
from zoo.simulator.gyros.gyro_class import GyroClass, changed
from zoo.simulator.laboratory.program import Campaign
from zoo.simulator.plant import scenario
from zoo.simulator.recorded import Recorded
from zoo.simulator.simulate import simulate
from zoo.simulator.simulation import Simulation

SAMPLE_S = 10.0
FEW_LAYERS, FEW_TURNS, FEW_ERRORS = 16, 10, 0.2
"""Of the windings whose heat is computed turn by turn; a tactical gyro's errors would be whole layers of these."""
Table = Mapping[str, Tensor]


@dataclass(frozen=True, eq=False)
class Hidden:
    """One hidden effect, scaled.

    Attributes:
        name: the catalogue's, or ``"outside"``.
        form: what it is made of.
        scale: what its signal is multiplied by.
        amplitude: half of peak to peak over the fitted runs [°/h].
        parts: (T,) of each fitted run, then of the check run [°/h], all rows.
    """

    name: str
    form: Form
    scale: float
    amplitude: float
    parts: Sequence[Array]


@dataclass(frozen=True, eq=False)
class Case:
    """Everything about one case.

    Attributes:
        recipe: what was drawn.
        simulation: the gyro with its base effects and its noise.
        hidden: its hidden effects.
        kept: rows of each fitted run that were recorded, then of the check run.
        average_s: block length that the runs are read with [s].
    """

    recipe: Recipe
    simulation: Simulation
    hidden: Sequence[Hidden]
    kept: Sequence[Array]
    average_s: float

    @property
    def sigma_dph(self) -> float:
        """White noise of a mean over 10 s [°/h]."""
        return sigma_10(self.simulation.device["random_walk"])

    @property
    def noise(self) -> NoiseModel:
        """What the block means' noise is made of [°/h]."""
        device = self.simulation.device
        return NoiseModel(60.0 * device["random_walk"] / self.average_s**0.5, device["flicker"], device["rate_random_walk"])

    def measured(self) -> list[Run]:
        """The fitted runs, as the diagnosis gets them, and the check run last."""
        return self._read(_with_spikes(self.recipe, self._rates(), self.sigma_dph))

    def without_hidden(self) -> list[Run]:
        """The same without what is hidden and without spikes."""
        return self._read([one.table["rate_dph"] for one in self._recorded])

    def without_noise(self) -> list[Run]:
        """The base effects alone, as they are in truth: neither what is hidden nor noise."""
        return self._read([one.table["rate_dph"] - one.noise for one in self._recorded])

    def hidden_blocks(self, one: Hidden) -> list[Run]:
        """Runs whose error is one hidden effect and nothing else, in the same blocks."""
        plain = self.without_hidden()
        both = self._read([run.table["rate_dph"] + torch.as_tensor(part) for run, part in zip(self._recorded, one.parts, strict=True)])
        return [replace(more, error=more.error - less.error) for more, less in zip(both, plain, strict=True)]

    def noise_blocks(self) -> list[Run]:
        """Runs whose error is the noise and nothing else, in the same blocks."""
        return self._read([run.table["reference_dph"] + run.noise for run in self._recorded])

    @property
    def _recorded(self) -> list[Recorded]:
        return [*self.simulation.runs, self.simulation.check]

    def _rates(self) -> list[Tensor]:
        totals = [sum((torch.as_tensor(one.parts[place]) for one in self.hidden), torch.zeros(())) for place in range(len(self._recorded))]
        return [run.table["rate_dph"] + total for run, total in zip(self._recorded, totals, strict=True)]

    def _read(self, rates: Sequence[Tensor]) -> list[Run]:
        """Through files, so that blocks and gaps are those that a user's would have."""
        tables = [{**run.table, "rate_dph": rate} for run, rate in zip(self._recorded, rates, strict=True)]
        with tempfile.TemporaryDirectory() as folder:
            paths = [Path(folder) / f"{run.name}.parquet" for run in self._recorded]
            for path, table, kept in zip(paths, tables, self.kept, strict=True):
                write_measurements(path, {name: value[torch.as_tensor(kept)] for name, value in table.items()})
            fitted = read_runs(paths[:-1], average_s=self.average_s or "auto")
            return [*fitted, *read_runs(paths[-1:], average_s=fitted[0].average_s)]


def sigma_10(random_walk: float) -> float:
    """White noise of a mean over 10 s [°/h] for N [°/√h]."""
    return 60.0 * random_walk / SAMPLE_S**0.5


@torch.no_grad()
def made(one: Recipe) -> Case:
    """Simulate a case."""
    gyro = _gyro(one)
    sigma = sigma_10(draw(gyro, one.seed, len(one.thermometers))["random_walk"])
    campaign, across = _campaign(one, sigma)
    effects = {name: build("effects", name) for name in BASE}
    latitude = None if one.turns == "slow" else one.latitude_deg
    settings = {
        "runs": len(one.programs),
        "seed": one.seed,
        "sample_s": SAMPLE_S,
        "thermometers": one.thermometers,
        "heat": one.heat,
        "latitude_deg": latitude,
    }
    simulation = simulate(gyro, campaign, effects, build("noise", "gyro"), chamber=one.chamber, **settings)
    bodies = _bodies(simulation, campaign, across)
    hidden = [_scaled(name, size * sigma, form, bodies) for name, size, form in zip(one.hidden, one.amplitudes, forms_of(one, sigma), strict=True)]
    kept = [np.ones(len(run.time), dtype=bool) for run in bodies]
    if one.gap:
        _cut(kept[:-1], one.chance(4))
    case = Case(one, simulation, hidden, kept, 0.0)
    return replace(case, average_s=case.without_hidden()[0].average_s)


def _gyro(one: Recipe) -> GyroClass:
    gyro = {"medium": MEDIUM, "tactical": TACTICAL}[one.gyro]
    return changed(gyro, layers=FEW_LAYERS, turns=FEW_TURNS, winding_error_turns=FEW_ERRORS) if one.heat == "radial_axial" else gyro


def _campaign(one: Recipe, sigma_dph: float) -> tuple[Campaign, list[tuple[tuple[float, float], ...]]]:
    """Programs of the fitted runs and of the check run, which goes nowhere that they do not, and the rates across the axis."""
    plain = [run_program(kind, label, one.chance(2, label)) for label, kind in enumerate(one.programs, 1)]
    ends = [end for program in plain for end in program.range_c]
    programs = [*plain, random_program(one.chance(2, 0), min(ends), max(ends))]
    width = band_dph(one, sigma_dph) or 3.0 * sigma_dph
    ways = [turned(program, one.turns, one.latitude_deg, width, one.chance(3, place)) for place, program in enumerate(programs)]
    return Campaign(tuple(program for program, _ in ways[:-1]), ways[-1][0]), [across for _, across in ways]


def _bodies(simulation: Simulation, campaign: Campaign, across: Sequence[tuple[tuple[float, float], ...]]) -> list[Body]:
    """The truth of each fitted run and of the check run; the heat is computed once more, by the same seed."""
    labels: list[int | str] = [*range(1, len(simulation.runs) + 1), "check"]
    programs = [*campaign.runs, campaign.check]
    runs = [
        scenario([simulation.device], program, label, simulation.chamber, simulation.settings)
        for program, label in zip(programs, labels, strict=True)
    ]
    return [body(run, at_rows(pieces, run.time.numpy())) for run, pieces in zip(runs, across, strict=True)]


def _scaled(name: str, amplitude: float, form: Form, bodies: Sequence[Body]) -> Hidden:
    signals = [form.signal(run) for run in bodies]
    fitted = np.concatenate(signals[:-1])
    scale = amplitude / (0.5 * float(fitted.max() - fitted.min()))
    return Hidden(name, form, scale, amplitude, [scale * signal for signal in signals])


def _cut(kept: Sequence[Array], chance: np.random.Generator) -> None:
    """A twentieth to a seventh of one run is missing."""
    rows = kept[int(chance.integers(len(kept)))]
    length = int(chance.uniform(0.05, 0.15) * len(rows))
    first = int(chance.integers(len(rows) // 10, len(rows) - length))
    rows[first : first + length] = False


def _with_spikes(one: Recipe, rates: Sequence[Tensor], sigma_dph: float) -> list[Tensor]:
    """Some rows of the fitted runs far off."""
    chance, spiked = one.chance(5), [rate.clone() for rate in rates]
    for _ in range(one.spikes):
        rate = spiked[int(chance.integers(len(spiked) - 1))]
        rate[int(chance.integers(len(rate)))] += chance.choice([-1, 1]) * chance.uniform(50, 300) * sigma_dph
    return spiked
