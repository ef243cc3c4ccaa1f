"""What is checked in every algorithm's settings: their names and their ranges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any, TypeVar

from zoo.errors import InputError, nearest
from zoo.given import check_number

Chosen = TypeVar("Chosen")


def chosen(kind: type[Chosen], given: Mapping[str, Any]) -> Chosen:
    """An algorithm's settings from what was given.

    Args:
        kind: its dataclass of settings.
        given: values by name.

    Raises:
        InputError: a name that the dataclass does not have.
    """
    known = [field.name for field in fields(kind)]  # type: ignore[arg-type]
    for name in given:
        if name not in known:
            raise InputError(f"{name}: no setting of this swarm; {nearest(name, known)}")
    return kind(**given)


def within(settings: Any, name: str, low: float, high: float = float("inf")) -> None:
    """Refuse a setting outside low … high, or with a fraction where the dataclass has a whole number.

    Raises:
        InputError: it is none of these.
    """
    whole = next(isinstance(field.default, int) for field in fields(settings) if field.name == name)
    check_number(name, getattr(settings, name), low, high, whole=whole)
