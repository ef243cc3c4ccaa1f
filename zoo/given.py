"""Numbers, switches and settings that a user gave: refused where they enter if they are none, written to be given again; who wrote a class."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import TypeGuard

from zoo.errors import InputError

LARGEST_SEED = 2**32 - 1
"""Torch takes longer numbers, and makes no difference between those that end with the same 32 bits."""
_SPECIAL = re.compile(r"[^A-Za-z0-9_ /\\+.$%*@?|:-]")
"""What Hydra reads only between quotes."""


def in_quotes(value: str) -> str:
    """A value as Hydra reads it, in quotes where it needs them and has none."""
    return f'"{value}"' if _SPECIAL.search(value) and not value.startswith(('"', "'")) else value


def listed(key: str, values: Iterable[str]) -> str:
    """A setting that is a list, each value in quotes where it needs them."""
    return f"{key}=[{','.join(map(in_quotes, values))}]"


def is_number(value: object) -> TypeGuard[float]:
    """Whether it is a finite number; true and false are none."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def check_number(key: str, value: object, low: float = -math.inf, high: float = math.inf, unit: str = "", whole: bool = False) -> None:
    """Refuse what is no number, not whole where it should be, or out of range.

    Raises:
        InputError: names the key, what was given and what is possible.
    """
    if is_number(value) and (not whole or isinstance(value, int)) and low <= value <= high:
        return
    kind = "whole number" if whole else "number"
    if not is_number(value) and (low, high) == (-math.inf, math.inf):
        raise InputError(f"{key}={value}: a finite {kind} is expected")
    ends = [f"{end}" if whole else f"{end:g}" for end in (low, high)]
    span = f"up to {ends[1]}" if low == -math.inf else f"from {ends[0]} up" if high == math.inf else f"from {ends[0]} to {ends[1]}"
    raise InputError(f"{key}={value}: a {kind} {span}{unit} is possible")


def check_numbers(group: str, **values: object) -> None:
    """Refuse what is no finite number, by the names of the keys in a group of settings.

    Raises:
        InputError: see `check_number`.
    """
    for key, value in values.items():
        check_number(f"{group}.{key}", value)


def check_seed(key: str, value: object) -> None:
    """Refuse what is no seed.

    Raises:
        InputError: see `check_number`.
    """
    check_number(key, value, 0, LARGEST_SEED, whole=True)


def check_switch(key: str, value: object) -> None:
    """Refuse what is neither true nor false.

    Raises:
        InputError: names the key.
    """
    if not isinstance(value, bool):
        raise InputError(f"{key}={value}: true or false is possible")


def of_the_house(thing: object) -> bool:
    """Whether it is of a class of this package, and no model or effect from outside."""
    return type(thing).__module__.startswith(f"{__package__}.")
