"""The verb `simulate`: chamber runs of a device that does not exist, with the truth beside them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from hydra.core.hydra_config import HydraConfig
from hydra.types import RunMode
from omegaconf import DictConfig
from rich.console import Console
from rich.progress import track
from rich.table import Table

from zoo.catalog import create, names
from zoo.cli.command_line import plain, searchpath
from zoo.cli.effects import catalogue, chosen
from zoo.errors import InputError, nearest
from zoo.given import LARGEST_SEED
from zoo.models.prediction import usable_device
from zoo.simulator.accelerometer.fleet import accelerometer_fleet
from zoo.simulator.accelerometer.preset import Accelerometer
from zoo.simulator.files import write
from zoo.simulator.settings import Settings
from zoo.simulator.simulate import fleet
from zoo.simulator.simulated import Simulated
from zoo.simulator.simulation import Simulation
from zoo.threads import threads_for
from zoo.units import symbol

MANY_RUNS, MANY_DEVICES = 4, 100_000


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
    devices = config.devices
    if isinstance(devices, bool) or not isinstance(devices, int) or not 1 <= devices <= MANY_DEVICES:
        raise InputError(f"devices={devices}: a whole number from 1 to {MANY_DEVICES} is possible")
    if isinstance(config.seed, int) and config.seed + devices - 1 > LARGEST_SEED:
        raise InputError(f"seed={config.seed}: the last of {devices} devices would have one above {LARGEST_SEED}")
    usable_device(config.torch_device)
    drawn = _wants_pictures(config)
    # Two threads gain nothing with some dozens of gyros at once, and lose much on a busy machine.
    with threads_for(0):
        _simulated(config, out, drawn)
    return out


def _simulated(config: DictConfig, out: Path, drawn: bool) -> None:
    devices_of, devices = simulations(config), config.devices
    if devices == 1:
        simulation = next(devices_of)
        quiet = len(simulation.runs) < MANY_RUNS
        write(simulation, out, track=iter if quiet else lambda runs: track(runs, description="writing"))
        _print(simulation, drawn and _draw(simulation, out))
    else:
        for simulation in track(devices_of, total=devices, description="devices"):
            folder = write(simulation, out / f"device_{simulation.seed:0{len(str(config.seed + devices - 1))}d}")
            if drawn:
                _draw(simulation, folder)
        Console(markup=False, highlight=False).print(f"{devices} {simulation.name} {simulation.kind}s, each with its truth.json")


def simulations(config: DictConfig) -> Iterator[Simulated]:
    """Every device that a config asks for, recorded but not written.

    Args:
        config: as composed from conf/simulate.yaml.

    Raises:
        InputError: absurd input; names the key.
    """
    device = create(config.gyro)
    settings = {key: plain(config[key]) for key in (*Settings.__dataclass_fields__, "devices", "hidden", "parameters")}
    asked = {**settings, "noise": create(config.noise), "chamber": create(config.chamber)}
    if isinstance(device, Accelerometer):
        return accelerometer_fleet(device, create(config.profile), chosen(config), **asked)
    _check_sizes(config)
    hideable = catalogue(config, names("effects", searchpath())) if config.hidden else None
    return fleet(device, create(config.profile), chosen(config), catalogue=hideable, **asked)


def _check_sizes(config: DictConfig) -> None:
    known = names("effects", searchpath())
    for name in config.gyro.get("effects") or {}:
        if name not in known:
            raise InputError(f"gyro.effects.{name}: {nearest(str(name), known)}")


def _wants_pictures(config: DictConfig) -> bool:
    wanted = config.pictures
    if wanted is None:
        return config.devices == 1 and HydraConfig.get().mode is not RunMode.MULTIRUN
    if not isinstance(wanted, bool):
        raise InputError(f"pictures={wanted}: true, false, or null (where one gyro is simulated, and not in a sweep) is possible")
    return wanted


def _draw(simulation: Simulated, folder: Path) -> bool:
    """Write the page of pictures; of an accelerometer there is none."""
    if not isinstance(simulation, Simulation):
        return False
    # Brings matplotlib, which a sweep of gyros has no use for.
    from zoo.report.truth.page import write_truth_page

    write_truth_page(simulation, folder)
    return True


def _print(simulation: Simulated, drawn: bool) -> None:
    title = f"{simulation.name} {simulation.kind}, profile {HydraConfig.get().runtime.choices['profile']}, seed {simulation.seed}"
    table = Table("file", "rows", "hours", "chamber °C", f"error std {symbol(simulation.unit)}", title=title)
    for one in [*simulation.runs, simulation.check]:
        low, high = one.program.range_c
        span = f"{low:g} … {high:g}" if low < high else f"{low:g}"
        table.add_row(f"{one.name}.csv", str(len(one.error)), _hours(one.program.seconds), span, f"{one.error.std(correction=0):.4f}")
    console = Console()
    console.print(table)
    secret = f", and {len(simulation.hidden)} hidden" if simulation.hidden else ""
    truth = f"the truth is in truth.json and truth_*.csv{', its pictures in truth.html' if drawn else ''}"
    console.print(f"effects: {', '.join(simulation.present) or 'none'}{secret}; {truth}", highlight=False, soft_wrap=True)


def _hours(seconds: float) -> str:
    hours = seconds / 3600
    return f"{hours:.1f}" if hours >= 1 else f"{hours:.2g}"
