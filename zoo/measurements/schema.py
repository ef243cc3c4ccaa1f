"""Which of a file's columns is what: roles, their names, and the mapping of foreign ones."""

from __future__ import annotations

import difflib
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from zoo import units
from zoo.errors import InputError, nearest

INPUTS = ("supply_v", "field_ut", "humidity_pct", "pressure_kpa")
ROLES = ("time", "temperature", "output", "reference", *INPUTS)
ABSOLUTE_ZERO_C = -273.15
_KEY = "data.columns"
_PREFIX = {"rate": "rate", "acceleration": "accel"}


@dataclass(frozen=True)
class Source:
    """Where one of a run's columns comes from.

    Attributes:
        name: its name in the run.
        column: the file's own name.
        given: suffix of the unit in the file; empty where nothing is converted.
        wanted: suffix of the unit in the run.
    """

    name: str
    column: str
    given: str = ""
    wanted: str = ""


@dataclass(frozen=True)
class Layout:
    """One file's columns by role.

    Attributes:
        path: the file.
        unit: suffix of the output's unit.
        inputs: time, main thermometer, other thermometers, recorded inputs, what the user has named besides, in this order.
        output: the gyro's output.
        reference: the true input where it is recorded.
        notes: what was converted or left out, one sentence each.
    """

    path: Path
    unit: str
    inputs: tuple[Source, ...]
    output: Source
    reference: Source | None
    notes: tuple[str, ...] = ()

    @property
    def sources(self) -> tuple[Source, ...]:
        """Everything to be read, the time first and the output last."""
        return (*self.inputs, *([self.reference] if self.reference else []), self.output)


def in_run_units(numbers: np.ndarray, sources: Sequence[Source]) -> np.ndarray:
    """(M, C) numbers as in the file, one column a source -> in the run's units, in the same memory."""
    for place, source in enumerate(sources):
        if source.given != source.wanted:
            numbers[:, place] = units.convert(numbers[:, place], source.given, source.wanted)
    return numbers


def without_temperature(numbers: np.ndarray, sources: Sequence[Source]) -> np.ndarray:
    """(M, C) bool: where a thermometer in a run's units reads below absolute zero, with which some recorders say that they have no temperature."""
    thermometers = np.array([source.name.startswith("temperature_") for source in sources])
    cold: np.ndarray = (numbers < ABSOLUTE_ZERO_C) & thermometers
    return cold


def layout(
    path: Path,
    present: Sequence[str],
    columns: Mapping[str, str | None] | None = None,
    output_unit: str | None = None,
    time_unit: str | None = None,
    temperature_unit: str | None = None,
) -> Layout:
    """Finds the columns of one file.

    Args:
        path: the file, for messages.
        present: the names in its header.
        columns: role -> the file's own name; a role that is missing or None has its default name. A role of no known name is a column more.
        output_unit: the output's unit, as suffix or as usually written, where the column's name does not say it.
        time_unit: the time's, likewise.
        temperature_unit: the thermometers', likewise.

    Raises:
        InputError: a role that looks mistyped, a column that is not there or is two things, an output that cannot be told or whose unit is not
            known or said in two ways.
    """
    mapped = {role: name for role, name in (columns or {}).items() if name is not None}
    _check_mapping(path, present, mapped)
    time = _said(path, _required(path, present, mapped, "time", "time_s", "s"), "time", time_unit)
    temperature = _said(path, _required(path, present, mapped, "temperature", "temperature_c", "c"), "temperature", temperature_unit)
    output = _output(path, present, mapped, output_unit)
    reference = _reference(path, present, mapped, output.wanted)
    others = _thermometers(present, mapped, temperature_unit)
    inputs = [Source(role, mapped.get(role, role)) for role in INPUTS if mapped.get(role, role) in present]
    more = [Source(role, column) for role, column in mapped.items() if role not in ROLES and not _is_thermometer(role)]
    found = Layout(path, output.wanted, (time, temperature, *others, *inputs, *more), output, reference)
    _check_single(found, more)
    changed = (one for one in found.sources if one.given != one.wanted)
    notes = (f"{one.column} is converted from {units.symbol(one.given)} to {units.symbol(one.wanted)}" for one in changed)
    return replace(found, notes=(*notes, *_overlooked(found, present)))


def overruled(one: Layout, reference: float | None) -> list[str]:
    """A note where a file records the true input and another one was given.

    Args:
        one: the file's columns.
        reference: as given for runs that do not record it [output's unit].
    """
    return [f"data.reference={reference:g} is not used, as {one.reference.column} is recorded"] if one.reference and reference else []


def prediction_sources(path: Path, present: Sequence[str], unit: str, time: str | None = None, time_unit: str | None = None) -> tuple[Source, Source]:
    """Finds time and predicted error in a file of predictions.

    Args:
        path: the file, for messages.
        present: the names in its header.
        unit: suffix of the unit that is wanted; another one of the same quantity is converted.
        time: what the measurement files call the time; taken where this file has it as well.
        time_unit: the unit of that, where it was said; a file that calls its time otherwise says its unit by the name.

    Raises:
        InputError: there is no such column.
    """
    names = {f"predicted_error_{one}": one for one in (unit, *units.suffixes(units.UNITS[unit].quantity))}
    found = next((name for name in names if name in present), None)
    if found is None:
        raise InputError(f"{path}: no column 'predicted_error_{unit}' (to be subtracted from the output); its columns: {', '.join(present)}")
    mapped = {"time": time} if time in present and time is not None else {}
    clock = _required(path, present, mapped, "time", "time_s", "s")
    return _said(path, clock, "time", time_unit if mapped else None), Source("predicted", found, names[found], unit)


def keep_shared(layouts: Sequence[Layout]) -> list[Layout]:
    """Leaves out thermometers and inputs that not all the runs have, with a note in the runs that had them; the others come as in the first run.

    Raises:
        InputError: the outputs' units differ.
    """
    first = layouts[0]
    for other in layouts:
        if other.unit != first.unit:
            said = (f"{one.path} is in {units.symbol(one.unit)} ({one.output.column})" for one in (first, other))
            raise InputError(f"{', '.join(said)}\nruns that are read together need one unit")
    shared = set.intersection(*({source.name for source in one.inputs} for one in layouts))
    place = {source.name: i for i, source in enumerate(first.inputs)}
    kept = [_without(one, [source.name for source in one.inputs if source.name not in shared]) for one in layouts]
    return [replace(one, inputs=tuple(sorted(one.inputs, key=lambda source: place[source.name]))) for one in kept]


def check_references(layouts: Sequence[Layout], reference: float | None) -> None:
    """Refuse files of which only some record the true input, where nobody has said that of the others: it would be taken as 0.

    Args:
        layouts: of the files, in the order read.
        reference: as given for files that do not record it [output's unit]; None where it was not.

    Raises:
        InputError: names a file of either kind.
    """
    recorded = [(str(one.path), one.reference.column) for one in layouts if one.reference]
    lacking = [str(one.path) for one in layouts if not one.reference]
    if reference is None and recorded and lacking:
        raise one_sided(lacking, *recorded[0], layouts[0].unit)


def one_sided(lacking: Sequence[str], other: str, column: str, unit: str) -> InputError:
    """What to say of runs that do not record the true input beside one that does.

    Args:
        lacking: those that do not.
        other: one that does.
        column: what the true input is called there.
        unit: suffix of the output's unit.
    """
    more = f" (nor do {len(lacking) - 1} more)" if len(lacking) > 1 else ""
    told = f"{lacking[0]}: does not record the true input{more}, {other} does ({column})"
    return InputError(
        f"{told}; it is not taken as 0\nadd the column, or say the true input of all that lack it: data.reference=… ({units.symbol(unit)})"
    )


def _without(one: Layout, names: list[str]) -> Layout:
    notes = (f"{name} is not used, as not all the runs have it" for name in names)
    return replace(one, inputs=tuple(source for source in one.inputs if source.name not in names), notes=(*one.notes, *notes))


def _check_mapping(path: Path, present: Sequence[str], mapped: Mapping[str, str]) -> None:
    for role, name in mapped.items():
        if role not in ROLES and not _is_thermometer(role) and _looks_mistyped(role):
            raise InputError(f"{_KEY}.{role}: no such role; {nearest(role, (*ROLES, 'temperature_NAME'))}")
        if name not in present:
            raise InputError(f"{path}: no column '{name}' ({_KEY}.{role}={name}); its columns: {', '.join(present)}{_remark(name, role, present)}")
    for role, name in mapped.items():
        twin = next((other for other, column in mapped.items() if column == name and other != role), None)
        if twin:
            raise InputError(f"{path}: column '{name}' is both {_KEY}.{role} and {_KEY}.{twin}; name another for one of them")


def _is_thermometer(role: str) -> bool:
    return re.fullmatch(r"temperature_\w+", role) is not None


def _looks_mistyped(role: str) -> bool:
    """Whether the name of a column more is one of the house's, or nearly."""
    own = (*ROLES, "time_s", "temperature_c")
    return not role.isidentifier() or role.startswith("reference_") or bool(difflib.get_close_matches(role, own, cutoff=0.7))


def _check_single(found: Layout, more: Sequence[Source]) -> None:
    """A column named besides must be none of those that are used already."""
    for one in more:
        twin = next((other for other in found.sources if other is not one and other.column == one.column), None)
        if twin:
            raise InputError(f"{found.path}: column '{one.column}' is both {_KEY}.{one.name} and {twin.name}; name another for one of them")


def _required(path: Path, present: Sequence[str], mapped: Mapping[str, str], role: str, default: str, unit: str) -> Source:
    quantity = units.UNITS[unit].quantity
    called = [default, *(f"{default.removesuffix(unit)}{other}" for other in units.suffixes(quantity))]
    name = mapped.get(role) or next((one for one in called if one in present), default)
    if name not in present:
        hint = _remark(name, role, present) or f"\nif another one holds the {role}: {_KEY}.{role}=NAME"
        raise InputError(f"{path}: no column '{name}'; its columns: {', '.join(present)}{hint}")
    return Source(default, name, units.output_suffix(name, quantity) or unit, unit)


def _remark(name: str, role: str, present: Sequence[str]) -> str:
    """A line on why a column is not found: a comment stands where the header should, or another one is called nearly so; empty where neither is."""
    if present and present[0].startswith("#"):
        return "\nrow 1 begins with #: the header with the columns' names must be the first line, without a #"
    lowered = {one.lower(): one for one in reversed(present) if not _is_thermometer(one)}
    begun = [one for one in lowered if len(one) >= 3 and name.lower().startswith(one)]
    close = begun or ([name.lower()] if name.lower() in lowered else difflib.get_close_matches(name.lower(), lowered, n=1, cutoff=0.7))
    return f"\ndid you mean {lowered[close[0]]}? then say {_KEY}.{role}={shlex.quote(lowered[close[0]])}" if close else ""


def _said(path: Path, found: Source, what: str, unit: str | None) -> Source:
    """A column in the unit that was said, unless its name says another one."""
    if unit is None:
        return found
    named, given = units.output_suffix(found.column, what), _suffix(what, unit)
    if named not in (None, given):
        told = f"'{found.column}' is in {named} by its name, but data.{what}_unit={unit}"
        raise InputError(f"{path}: {told}; leave that out, or call the column otherwise")
    return replace(found, given=given)


def _suffix(what: str, unit: str) -> str:
    """The suffix of a unit as it was said."""
    try:
        return units.parse_unit(unit, what)
    except InputError:
        raise InputError(f"data.{what}_unit={unit}: {nearest(str(unit), units.suffixes(what))}") from None


def _thermometers(present: Sequence[str], mapped: Mapping[str, str], unit: str | None) -> list[Source]:
    """Thermometers beside the main one: called ``temperature_NAME_c`` (_k, _f), in the header's order; mapped as ``temperature_NAME``, as given."""
    called = {name: re.fullmatch(r"(temperature_\w+)_[ckf]", name) for name in present if name not in mapped.values()}
    found = {f"{match[1]}_c": name for name, match in called.items() if match and (name.endswith("_c") or f"{match[1]}_c" not in present)}
    found |= {f"{role.removesuffix('_c')}_c": name for role, name in mapped.items() if role.startswith("temperature_")}
    said = _suffix("temperature", unit) if unit is not None else "c"
    return [Source(name, column, units.output_suffix(column, "temperature") or said, "c") for name, column in found.items()]


def _output(path: Path, present: Sequence[str], mapped: Mapping[str, str], output_unit: str | None) -> Source:
    name = mapped.get("output") or _only_output(path, present)
    named = units.output_suffix(name)
    try:
        unit = units.parse_unit(output_unit) if output_unit is not None else named
    except InputError as error:
        raise InputError(f"data.output_unit={output_unit}: {error}") from None
    if unit is None:
        possible = "|".join(units.suffixes(*units.OUTPUT_QUANTITIES))
        raise InputError(f"{path}: the unit of '{name}' is not known; say data.output_unit={possible}")
    if named not in (None, unit):
        said = f"'{name}' is in {units.symbol(str(named))} by its name, but data.output_unit={output_unit}"
        raise InputError(f"{path}: {said}; leave data.output_unit out, or call the column otherwise")
    return Source("output", name, unit, unit)


def _is_output(name: str) -> bool:
    suffix = units.output_suffix(name)
    if suffix is None:
        return False
    prefix = _PREFIX.get(units.UNITS[suffix].quantity)
    return name == (f"{prefix}_{suffix}" if prefix else suffix)


def _only_output(path: Path, present: Sequence[str]) -> str:
    """The one column that can be the output.

    Raises:
        InputError: there is none, or more than one; names the key that decides.
    """
    found = [name for name in present if _is_output(name)]
    if len(found) == 1:
        return found[0]
    truth = ("reference_", "predicted_error_")
    unlike = [name for name in present if _is_output(name.lower())]
    possible = found or unlike or [name for name in present if units.output_suffix(name) and not name.startswith(truth)] or present
    what = "several columns can be the output" if found else "no column is called rate_UNIT, accel_UNIT, pulses or counts"
    raise InputError(f"{path}: {what}; say which one it is: {_KEY}.output={'|'.join(possible)}")


def _reference(path: Path, present: Sequence[str], mapped: Mapping[str, str], unit: str) -> Source | None:
    """The true input: the mapped column, else ``reference_<unit>``, else a reference in another unit of the same quantity."""
    quantity = units.UNITS[unit].quantity
    name = mapped.get("reference")
    if name is None:
        found = [f"reference_{one}" for one in (unit, *units.suffixes(quantity)) if f"reference_{one}" in present]
        name = found[0] if found else None
    if name is None:
        return None
    given = units.output_suffix(name) or unit
    if units.UNITS[given].quantity != quantity:
        have = f"in {units.symbol(given)}, the output in {units.symbol(unit)}"
        raise InputError(f"{path}: {_KEY}.reference={name} is {have}; one cannot be subtracted from the other")
    return Source(f"reference_{unit}", name, given, unit)


def _overlooked(found: Layout, present: Sequence[str]) -> list[str]:
    """A note on each column that is called like a true input and is not taken as it, where nothing else is."""
    used = {source.column for source in found.sources}
    called = [name for name in present if re.match(r"reference(?![a-z])", name.strip(), re.IGNORECASE) and name not in used]
    return [] if found.reference else [f"{name} is not used, as {_why(name, found.unit)}" for name in called]


def _why(name: str, unit: str) -> str:
    """Why a column is not taken as the true input of an output in some unit, and what takes it where that can be."""
    given = units.output_suffix(name, *units.OUTPUT_QUANTITIES, "temperature")
    if given is not None and units.UNITS[given].quantity != units.UNITS[unit].quantity:
        return f"it is in {units.symbol(given)}, the output in {units.symbol(unit)}"
    return f"it is not called reference_{unit}; if it holds the true input, say {_KEY}.reference={shlex.quote(name)}"
