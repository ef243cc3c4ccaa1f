"""Numbers as a reader wants them: rounded to what is known, with a true minus, and a dash where there is none."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from zoo.units import OUTPUT_QUANTITIES, UNITS, suffixes

NONE = "–"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PREFIXES = {-3: "m", -6: "µ", -9: "n"}
_PREFIXED = ("rad/s", "m/s²")
"""Units that are usually written with a prefix."""


def finite(value: Any) -> float | None:
    """The number, or None for whatever is no finite number."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if math.isfinite(value) else None


def fixed(value: Any, decimals: int) -> str:
    """A number with so many decimals: ``fixed(-1.25, 1) == "−1.2"``."""
    number = finite(value)
    if number is None:
        return NONE
    text = f"{number:.{max(decimals, 0)}f}"
    return text.lstrip("-") if float(text) == 0 else text.replace("-", "−")


def significant(value: Any, digits: int = 3) -> str:
    """A number with so many significant digits; powers of ten far from one."""
    number = finite(value)
    if number is None:
        return NONE
    if number == 0:
        return "0"
    exponent = _exponent(number, digits)
    if -4 <= exponent < 6:
        return fixed(round(number, digits - 1 - exponent), digits - 1 - exponent)
    return f"{fixed(number / 10.0**exponent, digits - 1)}·10{str(exponent).translate(_SUPERSCRIPT)}"


def _exponent(number: float, digits: int) -> int:
    """Of ten, in a number that is rounded to so many digits: 1 of 9.996 with three."""
    return int(f"{number:.{digits - 1}e}".partition("e")[2])


BEYOND = {"low": "≤", "high": "≥"}
"""What goes before a value that the runs would have beyond its bound."""


def with_error(value: Any, stderr: Any, at_bound: Any = None) -> str:
    """A value and its standard error, both rounded where the error's second digit is: ``6.10 ± 0.41``; beyond its bound ``≥ 6``."""
    number, error = finite(value), finite(stderr)
    if number is not None and at_bound in BEYOND:
        return f"{BEYOND[at_bound]} {significant(number)}"
    if number is None or not error:
        return significant(number)
    size = max(abs(number), error)
    exponent = math.floor(math.log10(size)) if not 1e-4 <= size < 1e6 else 0
    decimals = 1 - _exponent(error, 2) + exponent
    scaled = f"{fixed(number / 10.0**exponent, decimals)} ± {fixed(error / 10.0**exponent, decimals)}"
    return f"({scaled})·10{str(exponent).translate(_SUPERSCRIPT)}" if exponent else scaled


def percent(share: Any) -> str:
    """A probability or a fraction; never quite 0 or 100 %."""
    number = finite(share)
    if number is None:
        return NONE
    whole = round(100 * number)
    return "> 99 %" if whole >= 100 else "< 1 %" if whole <= 0 else f"{whole} %"


def times(ratio: Any) -> str:
    """A multiple: ``11.2×``."""
    number = finite(ratio)
    if number is None:
        return NONE
    return "> 999×" if number >= 999.5 else f"{fixed(number, 1 if number < 99.95 else 0)}×"


def worse_than_none(left: float | None, before: float) -> str:
    """Half a sentence where a model leaves more than there is without one; nothing where it does not."""
    return f"the model leaves {times(left / before)} the RMS of no model at all" if left is not None and left > before > 0 else ""


def reached_beyond(found: Mapping[str, Any]) -> str:
    """Which columns go beyond what was fitted, as `zoo.models.reach.beyond` found, and how far."""
    said = []
    for name, one in found.items():
        reached, fitted = _told_apart(one.get("reached") or [], one.get("fitted") or [])
        said.append(f"{name} is {reached} there, {fitted} in the fitted runs")
    return "; ".join(said)


def _told_apart(reached: Sequence[float], fitted: Sequence[float]) -> tuple[str, str]:
    """Two ranges, with as many digits as it takes to see that they differ: a pressure changes in its fourth."""
    for digits in range(3, 7):
        words = [[significant(value, digits) for value in values] for values in (reached, fitted)]
        if words[0] != words[1]:
            break
    return " … ".join(words[0]), " … ".join(words[1])


def unit_symbol(unit: Any) -> str:
    """A unit, or a product with one, as usually written: ``unit_symbol("dph·min/K^2") == "°/h·min/K²"``."""
    text = re.sub(r"\^(-?\d+)", lambda match: match[1].translate(_SUPERSCRIPT), str(unit or ""))
    return re.sub(r"[A-Za-z_][A-Za-z_0-9]*", lambda match: UNITS[match[0]].symbol if match[0] in suffixes(*OUTPUT_QUANTITIES) else match[0], text)


def of_parameter(name: str, value: str, symbol: str) -> str:
    """``width 6.10 ± 0.41 K``."""
    return f"{name} {value} {'' if symbol == '1' else symbol}".rstrip()


def names_in_model(record: Mapping[str, Any], effects: Iterable[str]) -> list[str]:
    """Under which names a diagnosis or a refinement has parameters of effects that it adds: of one that happens several times under several."""
    times, there = record.get("times") or {}, record.get("effects") or ()
    return [str(name) for effect in effects for name in times.get(effect) or [effect] if name not in there]


def joined(names: Any, last: str = "and") -> str:
    """``a``, ``a and b``, ``a, b and c``."""
    items = [str(name) for name in names or []]
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {last} {items[-1]}" if items else ""


@dataclass(frozen=True)
class Sides:
    """What a page calls the model it begins with and the one with effects added.

    Attributes:
        now: the former, short.
        stands: the former, where more room is.
        after: the latter, short.
        added: the latter, where more room is.
    """

    now: str
    stands: str
    after: str
    added: str


DIAGNOSED = Sides("now", "as it stands", "with the missing", "with the missing effects")
REFINED = Sides("before", "before", "after", "after")


@dataclass(frozen=True)
class Scale:
    """One way to write every value of the output, so that columns align.

    Attributes:
        symbol: the output's unit.
        exponent: values are written in this power of ten of the unit.
        decimals: how many are worth writing.
    """

    symbol: str
    exponent: int = 0
    decimals: int = 4

    @classmethod
    def of(cls, unit: Any, floor: Any, rms: Any, finer: float = 1.0) -> Scale:
        """Two to three significant digits of the noise floor, or of an RMS far above it.

        Args:
            unit: the output's suffix.
            floor: noise floor [unit].
            rms: RMS of the residual [unit].
            finer: share of these that is worth writing as well.
        """
        resolution = max(finite(floor) or 0.0, 0.03 * (finite(rms) or 0.0)) or 1.0
        exponent = 0 if -5 < (coarse := math.floor(math.log10(resolution / 2))) < 6 else 3 * (coarse // 3)
        digits = math.floor(math.log10(resolution / finer / 2))
        return cls(unit_symbol(unit), exponent, max(0, 1 - digits + exponent))

    @property
    def label(self) -> str:
        """The unit with its power of ten, as a prefix where there is one."""
        if self.exponent in _PREFIXES and self.symbol in _PREFIXED:
            return _PREFIXES[self.exponent] + self.symbol
        return f"10{str(self.exponent).translate(_SUPERSCRIPT)} {self.symbol}" if self.exponent else self.symbol

    @property
    def factor(self) -> float:
        """Multiplies a value in the output's unit."""
        return 10.0**-self.exponent

    def text(self, value: Any) -> str:
        """A value in this scale, without unit."""
        number = finite(value)
        return NONE if number is None else fixed(number * self.factor, self.decimals)

    def full(self, value: Any) -> str:
        """A value with its unit."""
        text = self.text(value)
        return text if text == NONE else f"{text} {self.label}"

    def parameter(self, value: Any, stderr: Any, unit: Any, at_bound: Any = None) -> tuple[str, str]:
        """A parameter with its standard error, and its unit: in this scale where it is one of the output's unit or of a product with that."""
        symbol = unit_symbol(unit)
        if not self.exponent or not re.match(re.escape(self.symbol) + r"(?![A-Za-z²])", symbol):
            return with_error(value, stderr, at_bound), symbol
        number, error = (None if known is None else known * self.factor for known in (finite(value), finite(stderr)))
        return with_error(number, error, at_bound), self.label + symbol[len(self.symbol) :]
