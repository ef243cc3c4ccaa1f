"""The gyros that come with the simulator, by name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from zoo.errors import InputError, nearest
from zoo.simulator.gyros.classes import MEDIUM, NAVIGATION, TACTICAL
from zoo.simulator.gyros.gyro_class import GyroClass, changed
from zoo.simulator.gyros.paper_gyros import LIU2010, QIU2023, TONG2019

PRESETS: Mapping[str, GyroClass] = {one.name: one for one in (MEDIUM, TACTICAL, NAVIGATION, QIU2023, TONG2019, LIU2010)}


def gyro_class(name: str, effects: Mapping[str, Any] | None = None, **changes: Any) -> GyroClass:
    """A preset with some of its spreads changed; see `changed`.

    Args:
        name: of the preset.
        effects: leading amplitudes to change.
        **changes: parameters to change.

    Raises:
        InputError: no such preset; see `changed`.
    """
    if name not in PRESETS:
        raise InputError(f"gyro.name='{name}': {nearest(name, PRESETS)}")
    return changed(PRESETS[name], effects, **changes)
