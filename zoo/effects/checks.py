"""An effect from outside, tried once before it is fitted: what is wrong with it would fail obscurely there, or not fail at all."""

from __future__ import annotations

import math
from dataclasses import replace

import torch
from torch import Tensor

from zoo.effects.base import OF_PLACE, Effect, History, spread
from zoo.effects.bounds import to_physical
from zoo.errors import InputError, in_brief

SAMPLES, STEP_S, PERIOD_S = 40, 180.0, 6000.0
BETWEEN = (0.25, 0.75)
"""Where between the bounds the two shapes lie that are tried."""
SWINGS_K = (50.0, 35.0)
"""Of the two histories: through 0 °C, since a root or a logarithm of the temperature ends there."""
SAME = 1e-9
"""Relative; a batch may sum in another order than its members."""
BATCHES = "leading axes are batches, so count axes from the end: shape[..., 0] and not shape[0]; beside (..., T) it is shape[..., 0:1]"


def check_effect(effect: object, name: str) -> None:
    """Refuse what is no effect of that name or whose columns cannot be fitted.

    Args:
        effect: what the YAML's class made.
        name: the YAML's.

    Raises:
        InputError: says what was found and what is needed.
    """
    own = type(effect).__name__
    if not isinstance(effect, Effect):
        raise InputError(f"a {own} is no effect; a class derived from zoo.effects.base.Effect is needed")
    if not hasattr(effect, "shape_value"):
        raise InputError(f"{own}.__init__ does not call super().__init__()")
    if effect.name != name:
        raise InputError(f"{own}.name = '{effect.name}', but its YAML is called '{name}'; one name is needed")
    with torch.no_grad():
        _check_columns(effect)


def _check_columns(effect: Effect) -> None:
    """Two shapes on one history, and each on its own (at the coil, whose temperature is fitted): the batch must be what each is by itself."""
    places = torch.tensor(BETWEEN, dtype=torch.float64).unsqueeze(-1).expand(2, len(effect.shape))
    shapes, both = to_physical(places, effect.shape), _histories(effect)
    first, second = both.take(torch.tensor(0)), both.take(torch.tensor(1))
    alone = [_tried(effect, first, shapes[0]), _tried(effect, first, shapes[1]), _tried(effect, second, shapes[1])]
    _check_same(effect, _tried(effect, first, shapes), alone[:2])
    if effect.place == "coil":
        _check_same(effect, _tried(effect, both, shapes), alone[::2])
    _check_past(effect, first, shapes[0], alone[0])
    if effect.runs_together:
        _check_together(effect, [first, replace(second, run=2, inputs={name: value.flip(0) for name, value in first.inputs.items()})], shapes)


def _check_past(effect: Effect, history: History, shape: Tensor, whole: Tensor) -> None:
    """What comes after a row must not change its columns: in flight nobody knows it."""
    half = SAMPLES // 2

    def other(value: Tensor) -> Tensor:
        return torch.cat([value[..., :half], 1.0 + 1.1 * value[..., half:].flip(-1)], dim=-1)

    changed = {name: other(getattr(history, name)) for name in OF_PLACE}
    found = _tried(effect, replace(history, inputs={name: other(value) for name, value in history.inputs.items()}, **changed), shape)
    if float((found - whole)[:half].abs().max()) > SAME * float(whole.abs().max()):
        raise InputError(f"{type(effect).__name__}.columns looks into the future: a row's columns change with what comes after it")


def _check_together(effect: Effect, runs: list[History], shapes: Tensor) -> None:
    """Runs along a leading axis, as it says that it takes them: what it makes of each must be what it makes of that alone."""
    fields = {name: torch.stack([getattr(run, name) for run in runs]).unsqueeze(1) for name in OF_PLACE}
    inputs = {name: torch.stack([run.inputs[name] for run in runs]).unsqueeze(1) for name in runs[0].inputs}
    numbers = torch.tensor([float(run.run) for run in runs], dtype=torch.float64).reshape(-1, 1, 1)
    own = f"{type(effect).__name__}.runs_together is True"
    try:
        found = effect.columns(replace(runs[0], run=numbers, inputs=inputs, **fields), shapes)
        found = found.expand(len(runs), len(shapes), SAMPLES, len(effect.amplitudes))
    except Exception as error:
        raise InputError(f"{own}, but with runs along a leading axis it fails with {in_brief(error)}; leave it out, or {BATCHES}") from error
    for together, run in zip(found, runs, strict=True):
        expected = _tried(effect, run, shapes)
        if float((together - expected).abs().max()) > SAME * float(expected.abs().max()):
            raise InputError(f"{own}, but runs along a leading axis are not what each is alone; leave it out, or {BATCHES}")


def _histories(effect: Effect) -> History:
    """Two courses of the place's temperature over one run of two hours, which has the columns that the effect says it needs and no others."""
    time = STEP_S * torch.arange(SAMPLES, dtype=torch.float64)
    phase, swing = 2 * math.pi / PERIOD_S * time, torch.tensor(SWINGS_K, dtype=torch.float64).unsqueeze(-1)
    rate = swing * phase.cos() * 2 * math.pi / PERIOD_S * 60
    inputs = {name: 5 + (1.3 * phase).cos() for name in effect.needs}
    return History(time, 10 + swing * phase.sin(), rate, rate / 10, 10 + 50 * (phase + 0.1).sin(), torch.full_like(time, 9.66), inputs)


def _tried(effect: Effect, history: History, shape: Tensor) -> Tensor:
    """(..., T, K) columns for shapes (..., S), as the sum of effects sees them."""
    own = f"{type(effect).__name__}.columns"
    try:
        columns = effect.columns(history, shape)
    except NotImplementedError as error:
        raise InputError(f"{own} is to be written: (..., T, K) columns, one for each of the amplitudes") from error
    except Exception as error:
        why = f"; recorded columns are declared, needs = ({error},)" if isinstance(error, KeyError) else f"; {BATCHES}" if shape.dim() > 1 else ""
        raise InputError(f"{own} fails with {in_brief(error)}{why}") from error
    if not isinstance(columns, Tensor):
        raise InputError(f"{own} returns a {type(columns).__name__}; a Tensor is needed")
    columns = spread(columns, shape)
    _check_size(own, tuple(columns.shape), (*shape.shape[:-1], SAMPLES, len(effect.amplitudes)))
    if columns.dtype != torch.float64:
        raise InputError(f"{own} returns {columns.dtype}; torch.float64 is needed")
    if not bool(torch.isfinite(columns).all()):
        first = shape.reshape(-1, len(effect.shape))[0].tolist() if effect.shape else []
        where = ", ".join(f"{one.name} {value:g}" for one, value in zip(effect.shape, first, strict=True))
        raise InputError(f"{own} has NaN or infinite values{where and f', at {where}'}; finite ones are needed everywhere between the bounds")
    return columns


def _check_size(own: str, found: tuple[int, ...], needed: tuple[int, ...]) -> None:
    count = needed[-1]
    if found == needed:
        return
    if found == needed[:-1]:
        why = "the axis of columns is missing: .unsqueeze(-1)"
    elif found[-1:] == needed[-2:-1]:
        why = "time goes before columns: torch.stack([…], dim=-1)"
    elif found[:-1] == needed[:-1]:
        why = f"one column an amplitude, and there {'is 1 amplitude' if count == 1 else f'are {count} amplitudes'}"
    else:
        why = BATCHES if len(needed) > 2 else "one row a sample, one column an amplitude"
    raise InputError(f"{own} returns {found} for {SAMPLES} samples; {needed} is needed; {why}")


def _check_same(effect: Effect, batch: Tensor, alone: list[Tensor]) -> None:
    for found, expected in zip(batch, alone, strict=True):
        if float((found - expected).abs().max()) > SAME * float(expected.abs().max()):
            raise InputError(f"{type(effect).__name__}.columns treats a batch otherwise than each of its members; {BATCHES}")
