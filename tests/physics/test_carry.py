"""Chunk by chunk the primitives with memory give what they give at once."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch
from torch import Tensor

from zoo.errors import WorkError
from zoo.physics.carry import Carried, at_start, is_carried
from zoo.physics.differentiator import temperature_rate
from zoo.physics.lag import lagged, lagged_rate
from zoo.physics.recurrence import affine, clamped, decaying
from zoo.physics.relaxation import elapsed, maxwell

Primitive = Callable[[Tensor, Tensor], Tensor]
TAU = torch.tensor([40.0, 900.0], dtype=torch.float64)
SIZES = [1, 1, 3, 60, 1, 134]

PRIMITIVES: dict[str, Primitive] = {
    "lagged": lambda t, u: lagged(t, u, TAU),
    "lagged from elsewhere": lambda t, u: lagged(t, u, TAU, u[..., 0] - 3.0),
    "lagged_rate": lambda t, u: lagged_rate(t, u, TAU),
    "temperature_rate": temperature_rate,
    "temperature_rate of a batch": lambda t, u: temperature_rate(t, torch.stack([u, u.square()])),
    "affine": lambda t, u: affine(0.99 - 0.01 * torch.sin(u), u, torch.tensor(5.0, dtype=torch.float64)),
    "decaying": lambda t, u: decaying((1 / TAU).unsqueeze(-1) + torch.zeros_like(u), u.expand(2, -1), torch.tensor(5.0, dtype=torch.float64)),
    "decaying fast and slowly": lambda t, u: decaying(torch.where(torch.sin(u) > 0.5, torch.inf, 1e-3 * u.abs()), u, u[..., 0]),
    "clamped": lambda t, u: clamped(u - TAU.unsqueeze(-1) / 100, u + TAU.unsqueeze(-1) / 100, u[..., 0]),
    "elapsed": lambda t, u: elapsed(t, u.abs() / TAU.unsqueeze(-1)),
    "maxwell": lambda t, u: maxwell(t, u, (1.5 + torch.sin(u)) / TAU.unsqueeze(-1)),
    "at_start": lambda t, u: u - at_start(u).unsqueeze(-1),
    "a cascade": lambda t, u: lagged(t, clamped(lagged(t, u, TAU) - 1, lagged(t, u, 2 * TAU) + 9, u[..., 0]), TAU),
}


@pytest.fixture(params=["even", "uneven"])
def record(request) -> tuple[Tensor, Tensor]:
    """(T,) time [s] and a lively drive."""
    chance = torch.Generator().manual_seed(1)
    jitter = torch.rand(sum(SIZES), generator=chance, dtype=torch.float64) if request.param == "uneven" else 0.5
    time = (0.5 + jitter + torch.zeros(sum(SIZES), dtype=torch.float64)).cumsum(0) * 10
    return time, 20 + 9 * torch.sin(time / 200) + torch.randn(sum(SIZES), generator=chance, dtype=torch.float64)


def pieces(primitive: Primitive, time: Tensor, drive: Tensor) -> Tensor:
    states: list[Tensor] = []
    found = []
    for clock, part in zip(time.split(SIZES), drive.split(SIZES), strict=True):
        with Carried(states) as carried:
            found.append(primitive(clock, part))
        states = carried.states
    return torch.cat(found, dim=-1)


@pytest.mark.parametrize("name", PRIMITIVES)
def test_pieces_are_the_whole(record, name) -> None:
    whole = PRIMITIVES[name](*record)
    torch.testing.assert_close(pieces(PRIMITIVES[name], *record), whole, rtol=1e-10, atol=1e-10 * float(whole.abs().max()))


def test_a_chunk_after_the_first_is_not_a_record_of_its_own(record) -> None:
    for name, primitive in PRIMITIVES.items():
        late = torch.cat([primitive(*one) for one in zip(*(value.split(SIZES) for value in record), strict=True)], dim=-1)
        assert float((late - primitive(*record)).abs().max()) > 1e-3, name


def test_what_is_asked_in_another_order_is_refused(record) -> None:
    time, drive = record
    with Carried() as first:
        lagged(time, drive, TAU)
    with pytest.raises(WorkError, match="more are asked for"), Carried(first.states):
        lagged(time, lagged(time, drive, TAU), TAU)
    with pytest.raises(WorkError, match="0 in the next"), Carried(first.states):
        pass


def test_nothing_is_carried_after_a_block_whatever_happened_in_it(record) -> None:
    with pytest.raises(ZeroDivisionError), Carried():
        float(is_carried()) / 0
    assert not is_carried()
    with Carried() as outer:
        with Carried():
            lagged(*record, TAU)
        assert not outer.states


def test_a_scripted_function_is_whole(record) -> None:
    scripted = torch.jit.script(temperature_rate)
    with Carried() as carried:
        found = scripted(*record, 60.0)
    assert not carried.states
    torch.testing.assert_close(found, temperature_rate(*record, 60.0), rtol=1e-12, atol=1e-12)


def test_what_is_no_number_in_a_chunk_leaves_what_came_before_it() -> None:
    rate, offset = torch.full((40,), 0.1, dtype=torch.float64), torch.ones(40, dtype=torch.float64)
    spoilt = offset.clone()
    spoilt[25:] = torch.nan
    with Carried():
        right = decaying(rate, offset, torch.zeros((), dtype=torch.float64))
    with Carried():
        found = decaying(rate, spoilt, torch.zeros((), dtype=torch.float64))
    assert torch.equal(found[:25], right[:25])
    assert found[25:].isnan().all()
