"""How large each effect would have to be for the runs of a diagnosis to show it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from zoo.effects.base import RUN
from zoo.report.floors import excess
from zoo.report.wording import Scale, finite, joined, names_in_model, of_parameter, times, unit_symbol, with_error

Record = dict[str, Any]

LEFT, RIGHT = 0.1, 100.0
"""Ends of the logarithmic bars, in noise floors."""
NAMED = 3
"""How many of the effects that hide best are named in a sentence."""

MUCH = 0.79
"""Walk per √h over a block's white noise from which it is worth a word: few gyros have more, see `zoo.diagnosis.noise_likelihood.MUCH_WALK`."""


@dataclass(frozen=True)
class LimitRow:
    """One effect.

    Attributes:
        effect: its name.
        size: written, of an effect that is seen with 90 %.
        multiple: of the noise floor, written.
        width: of its bar, in percent.
    """

    effect: str
    size: str
    multiple: str
    width: str


def limit_rows(diagnosis: Record, scale: Scale) -> list[LimitRow]:
    """The effects, the one seen best first; those that hide in any size last."""
    floor = diagnosis.get("noise_floor")
    return [_row(name, size, excess(size, floor), scale) for name, size in _sizes(diagnosis)]


def what_could_hide(diagnosis: Record) -> list[str]:
    """What these runs show least of, in a sentence; none where that is not known."""
    sizes, floor = _sizes(diagnosis)[-NAMED:], diagnosis.get("noise_floor")
    ratios = {name: excess(size, floor) for name, size in sizes}
    below = [f"{name} below {times(ratio)}" for name, ratio in ratios.items() if ratio is not None]
    anyhow = [name for name, ratio in ratios.items() if ratio is None]
    told = [f"{joined(below)} the noise floor"] if below else []
    told += [f"{joined(anyhow)} in any size"] if anyhow else []
    return [f"These runs would not show {', and '.join(told)}."] if told else []


def beyond_plausible(record: Record, effects: Iterable[str]) -> list[str]:
    """Which of these effects the runs want with values beyond their bounds, a sentence each."""
    fitted, told = record.get("parameters") or {}, []
    for effect in names_in_model(record, effects):
        held = [(name, one) for name, one in (fitted.get(effect) or {}).items() if one.get("at_bound")]
        values = [of_parameter(name, with_error(one.get("value"), None, one["at_bound"]), unit_symbol(one.get("unit"))) for name, one in held]
        if values:
            what = f"The runs ask more of {effect} than is plausible ({joined(values)})"
            told.append(f"{what}: it may stand in for another effect; do not take its values for the gyro's.")
    return told


def of_single_runs(record: Record, effects: Iterable[str]) -> list[str]:
    """Which of these effects happened in fitted runs of their own, so that no other run can bear them out, in a sentence; none where none did."""
    fitted, times = record.get("parameters") or {}, record.get("times") or {}

    def once(name: str) -> bool:
        return (finite((fitted.get(name, {}).get(RUN) or {}).get("value")) or 0.0) > 0

    known = {name: effect for effect, names in times.items() for name in names}
    single = dict.fromkeys(known.get(name, name) for effect in effects for name in times.get(effect, [effect]) if once(name))
    if not single:
        return []
    return [f"{joined(single)} happened in fitted runs alone, and nothing tells beforehand what happens in another: diagnose that with them."]


def what_walks(record: Record) -> list[str]:
    """That what is left is taken for a walk as few gyros have, in a sentence; none where it is not."""
    noise = record.get("noise") or {}
    white, walk = finite(noise.get("white")), finite(noise.get("walk"))
    if not white or not walk or walk < MUCH * white:
        return []
    taken = f"a walk of {walk / white:.1f} times a block's white noise per √h, which is in the noise floor as well"
    return [f"It wanders more than that of most gyros: it is taken for {taken}. Something slow may hide in it."]


def _sizes(diagnosis: Record) -> list[tuple[str, float | None]]:
    known = [(str(name), finite((limit or {}).get("size"))) for name, limit in (diagnosis.get("detection_limits") or {}).items()]
    return sorted(known, key=lambda one: math.inf if one[1] is None else one[1])


def _row(name: str, size: float | None, ratio: float | None, scale: Scale) -> LimitRow:
    if size is None:
        return LimitRow(name, "in no size", "", "100%")
    place = 0.0 if not ratio else math.log(ratio / LEFT) / math.log(RIGHT / LEFT)
    return LimitRow(name, scale.text(size), "" if ratio is None else times(ratio), f"{100 * min(max(place, 0.0), 1.0):.1f}%")
