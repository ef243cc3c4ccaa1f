"""Rows of the tables that tell the truth about a simulated gyro, every number already written."""

from __future__ import annotations

import inspect
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from zoo.report.truth.effect_stack import effects_of
from zoo.report.wording import NONE, significant, unit_symbol
from zoo.simulator.draws import shape_parameters
from zoo.simulator.gyros.device import Device
from zoo.simulator.gyros.gyro_class import GyroClass
from zoo.simulator.laboratory.chamber import Chamber
from zoo.simulator.noise import Noise
from zoo.simulator.recorded import Recorded
from zoo.simulator.settings import Settings
from zoo.simulator.shares import Share
from zoo.simulator.simulation import Simulation
from zoo.simulator.streams import Span

DIGITS = 4
Record = dict[str, Any]
"""The contract's `truth.json`, or a part of it."""


@dataclass(frozen=True)
class EffectRow:
    """One effect of a gyro.

    Attributes:
        name: in the catalogue.
        hidden: whether the user was not told.
        formula: in plain text.
        rms: what it adds over the fitted runs, about its mean [°/h].
        parameters: name, value, unit, meaning.
    """

    name: str
    hidden: bool
    formula: str
    rms: str
    parameters: list[tuple[str, str, str, str]]


def effect_rows(simulation: Simulation) -> list[EffectRow]:
    """All effects, those that change the output most first."""
    shares = sorted(simulation.shares.items(), key=lambda item: -item[1].rms)
    return [
        EffectRow(name, name in simulation.hidden, share.effect.formula, significant(share.rms, DIGITS), _parameters(share)) for name, share in shares
    ]


def _parameters(share: Share) -> list[tuple[str, str, str, str]]:
    meanings = {one.name: one.meaning for one in (*shape_parameters(share.effect), *share.effect.amplitudes)}
    return [(name, significant(value, DIGITS), symbol(unit), meanings[name]) for name, (value, unit) in share.parameters().items()]


def run_rows(simulation: Simulation, order: Sequence[str]) -> list[list[str]]:
    """Name, hours, chamber [°C], RMS about the mean of each effect, of their sum, of the noise and of the recorded error [°/h].

    Args:
        simulation: a gyro's runs.
        order: all effects, as the columns are to be.
    """
    return [_run_row(run, order) for run in (*simulation.runs, simulation.check)]


def _run_row(run: Recorded, order: Sequence[str]) -> list[str]:
    each = effects_of(run)
    columns = [*(each.get(name) for name in order), run.truth["sum_dph"].numpy(), run.noise.numpy(), run.error.numpy()]
    low, high = (significant(value) for value in run.program.range_c)
    return [
        run.name,
        significant(run.program.seconds / 3600),
        f"{low} … {high}",
        *(NONE if one is None else significant(one.std()) for one in columns),
    ]


def device_rows(device: Device) -> list[list[str]]:
    """Meaning, key, value, unit, spread of the class, source of each parameter."""
    meanings = said(GyroClass) | said(Noise)
    spans = {key: getattr(device.gyro, key) for key in device.values}
    values = {key: value for key, (value, _) in device.described().items()}
    return [[meanings.get(key, ""), key, significant(values[key], DIGITS), symbol(one.unit), _spread(one), one.source] for key, one in spans.items()]


def _spread(span: Span) -> str:
    return "the same in all" if span.low == span.high else f"{significant(span.low)} … {significant(span.high)}"


def thermometer_rows(truth: Record) -> list[list[str]]:
    """Place, time constant [s], offset [K] of each thermometer."""
    return [
        [one["place"].replace("_", " "), *(significant(one[key]["value"]) for key in ("time_constant", "offset"))] for one in truth["thermometers"]
    ]


def noise_rows(truth: Record) -> list[list[str]]:
    """Meaning, key, value, unit of each coefficient."""
    return [[said(Noise).get(key, ""), key, significant(one["value"], DIGITS), symbol(one["unit"])] for key, one in truth["noise"].items()]


def setting_rows(truth: Record) -> list[list[str]]:
    """Meaning, key, value, unit of what was asked for: how the runs were recorded, and the chamber."""
    own, chamber = dict(truth["settings"]), truth["settings"]["chamber"]
    del own["chamber"]
    recorded = [[said(Settings).get(key, ""), key, *_written(value)] for key, value in own.items()]
    return [*recorded, *([said(Chamber).get(key, ""), f"chamber.{key}", *_written(value)] for key, value in chamber.items())]


def said(owner: type) -> dict[str, str]:
    """What a class's docstring says of its attributes, without unit and markup; nothing where docstrings were left out."""
    text = inspect.getdoc(owner) or ""
    lines = re.findall(r"^ {4}(\w+): (.+?)\.?$", text.partition("Attributes:")[2], re.MULTILINE)
    return {key: re.sub(r" \[[^]]*\]|`|; None .*", "", line) for key, line in lines}


def symbol(unit: str) -> str:
    """A unit as usually written; nothing for a pure number."""
    return "" if unit == "1" else unit_symbol(unit)


def _written(value: Any) -> tuple[str, str]:
    """A value, with its unit where it has one."""
    if isinstance(value, dict):
        return significant(value["value"], DIGITS), symbol(value["unit"])
    if isinstance(value, bool):
        return ("yes" if value else "no"), ""
    return significant(value, DIGITS) if isinstance(value, (int, float)) else NONE if value is None else str(value), ""
