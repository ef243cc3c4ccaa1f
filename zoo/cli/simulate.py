"""The verb `simulate`: chamber runs of a gyro that does not exist, with the truth beside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from omegaconf import DictConfig, OmegaConf
from rich.console import Console
from rich.progress import track
from rich.table import Table

from zoo.catalog import create, names
from zoo.cli.effects import catalogue, chosen
from zoo.cli.inputs import searchpath
from zoo.simulator.files import write
from zoo.simulator.settings import Settings
from zoo.simulator.simulate import Simulation, simulate

MANY_RUNS = 4


def run(config: DictConfig, out: Path) -> Path:
    """Simulate and write.

    Args:
        config: as composed from conf/simulate.yaml.
        out: folder of the results.

    Returns:
        The folder.

    Raises:
        InputError: absurd input; names the key.
    """
    settings = {key: config[key] for key in Settings.__dataclass_fields__}
    simulation = simulate(
        create(config.gyro),
        create(config.profile),
        chosen(config),
        create(config.noise),
        hidden=_plain(config.hidden),
        catalogue=catalogue(config, names("effects", searchpath())) if config.hidden else None,
        parameters=_plain(config.parameters),
        **settings,
    )
    quiet = len(simulation.runs) < MANY_RUNS
    write(simulation, out, track=iter if quiet else lambda runs: track(runs, description="writing"))
    _print(simulation, out)
    return out


def _plain(value: Any) -> Any:
    return OmegaConf.to_container(value) if OmegaConf.is_config(value) else value


def _print(simulation: Simulation, out: Path) -> None:
    table = Table("file", "rows", "hours", "chamber °C", "error RMS °/h", title=f"{simulation.device.name} gyro, seed {simulation.settings.seed}")
    for one in [*simulation.runs, simulation.check]:
        error = one.table["rate_dph"] - one.table["reference_dph"]
        low, high = one.scenario.program.range_c
        hours = one.scenario.program.seconds / 3600
        table.add_row(f"{one.name}.csv", str(len(error)), f"{hours:.1f}", f"{low:g} … {high:g}", f"{error.std(correction=0):.4f}")
    console = Console()
    console.print(table)
    secret = f", and {len(simulation.hidden)} hidden" if simulation.hidden else ""
    console.print(f"effects: {', '.join(simulation.present) or 'none'}{secret}; the truth is in truth.json and truth_*.csv", highlight=False)
