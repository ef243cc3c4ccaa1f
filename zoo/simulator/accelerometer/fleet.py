"""Accelerometers asked for as gyros are: with the same settings, of which those that mean nothing to an accelerometer are refused."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from zoo.errors import InputError
from zoo.simulator.accelerometer.preset import Accelerometer
from zoo.simulator.accelerometer.runs import PowerOnRuns, simulate_accelerometer
from zoo.simulator.laboratory.chamber import Chamber
from zoo.simulator.laboratory.earth import direction
from zoo.simulator.laboratory.program import Campaign
from zoo.simulator.noise import SILENT, Noise
from zoo.simulator.settings import Settings

POSSIBLE: Mapping[str, Sequence[Any]] = {
    "amplitude": (None,),
    "thermometers": (1, 2),
    "heat": ("radial",),
    "reference_dph": (0.0,),
    "latitude_deg": (None,),
}
"""What settings of gyros may be: the defaults, and one thermometer, which an accelerometer has."""
CHAMBER = ("cycling_k", "fan_dph")
"""What a chamber that has held one temperature for hours still does."""
INSTRUMENT = ("random_walk", "count_step", "thermometer")
"""What ``noise=none`` silences; the bias of each power-on is a cause of the error like the others, and stands in the truth."""


def accelerometer_fleet(
    device: Accelerometer,
    profile: Campaign,
    effects: Mapping[str, Any],
    noise: Noise | None = None,
    hidden: int | str | Sequence[str] = 0,
    parameters: Mapping[str, Any] | None = None,
    chamber: Chamber | None = None,
    devices: int = 1,
    **settings: Any,
) -> Iterator[PowerOnRuns]:
    """Simulate accelerometers of the same numbers, each with the chances of its own seed: ``seed``, ``seed + 1``, …

    Args:
        device: the accelerometer.
        profile: soak and length of each run.
        effects: must be none; those of gyros are not known to an accelerometer.
        noise: the default for the device's own, `SILENT` for none.
        hidden: must be 0.
        parameters: must be none.
        chamber: one that neither cycles nor shakes.
        devices: how many.
        **settings: `Settings`; `axis` says which force the accelerometer feels, a cold start is always one.

    Raises:
        InputError: a setting that means nothing here; see `simulate_accelerometer`.
    """
    chosen = Settings(**settings)
    extra = {"effects": list(effects), "hidden": hidden, "parameters": parameters or {}}
    _refuse(device, {key: value for key, value in extra.items() if value not in ([], 0, {})})
    _refuse(device, {key: getattr(chosen, key) for key, possible in POSSIBLE.items() if getattr(chosen, key) not in possible})
    _refuse(device, {f"chamber.{key}": getattr(chamber, key) for key in CHAMBER if chamber and getattr(chamber, key) != 0})
    _, _, up = direction(chosen.axis)
    asked: dict[str, Any] = {"sample_s": chosen.sample_s, "runs": chosen.runs, "force_g": up}
    own = _with_noise(device, noise or Noise())
    for seed in range(chosen.seed, chosen.seed + devices):
        yield simulate_accelerometer(own, profile=profile, seed=seed, **asked)


def _refuse(device: Accelerometer, given: Mapping[str, Any]) -> None:
    """Say of the first setting that it is none of an accelerometer, and what is."""
    for key, value in given.items():
        shown = f"[{','.join(value)}]" if isinstance(value, list) else value
        raise InputError(
            f"{key}={shown}: is for gyros; {device.name} is an accelerometer\n"
            "its settings are runs, seed, devices, sample_s, axis, profile, noise=none, and gyro.… (--cfg job prints them)"
        )


def _with_noise(device: Accelerometer, noise: Noise) -> Accelerometer:
    """The device with its own noise, or without any."""
    changed = {f"noise.{key}": value for key, value in vars(noise).items() if value != getattr(Noise(), key)}
    if noise not in (Noise(), SILENT):
        _refuse(device, dict(sorted(changed.items(), key=lambda one: one[1] == 0)))
    silenced = {key: replace(getattr(device, key), value=0.0, source="given") for key in INSTRUMENT}
    return replace(device, **silenced) if noise == SILENT else device
