"""A tape plays what it has heard, in memory of its own."""

import random

import pytest
import torch
from torch import Tensor

from zoo.training.tape import KEPT, Recorded, Tape, _copied


def test_a_tape_follows_lists_views_and_changes_in_place() -> None:
    fixed = torch.arange(6.0)

    def function(x: Tensor) -> Tensor:
        left, right = x.exp().split([2, 4])
        right.mul_(3)
        return torch.cat([right, left.expand(2), fixed.sqrt()]).view(12).cumsum(dim=0)

    x = torch.linspace(-1, 1, 6)
    tape = Tape(function, x)
    for value in (x, 2 * x, x.flip(0)):
        torch.testing.assert_close(tape(value), function(value), rtol=0, atol=0)


def test_a_network_s_gradient_is_played_without_copies_and_to_the_last_digit() -> None:
    columns = torch.randn(2, 50, dtype=torch.float64)

    def function(inner: Tensor, outer: Tensor) -> Tensor:
        with torch.enable_grad():
            one, other = inner.detach().requires_grad_(), outer.detach().requires_grad_()
            loss = (other @ (one @ columns).sigmoid()).tanh().square().sum()
            return torch.cat([part.flatten() for part in torch.autograd.grad(loss, (one, other))])

    for members in (1, 3):
        values = [torch.randn(members, *shape, dtype=torch.float64) for shape in ((9, 2), (1, 9))]
        tape = Tape(function, *values)
        copied = [place for step in tape.steps if step.func is _copied for place in step.args[1]]
        assert max(len(place.flatten()) for place in copied) < members * 9 * 50
        for _ in range(2):
            torch.testing.assert_close(tape(*values), function(*values), rtol=0, atol=0)
            values = [torch.randn_like(value) for value in values]


def drawn(seed: int):
    """A program of thirty random operations whose results are used late or soon, once or often, whole or in part."""

    def function(x: Tensor) -> Tensor:
        chance, known = random.Random(seed), [x, x.T, x[0].expand(4, 4)]
        for _ in range(30):
            one, other = chance.choice(known[-6:]), chance.choice(known[-9:])
            made = chance.choice(
                [
                    lambda a, b: a + b,
                    lambda a, b: a * b.sigmoid(),
                    lambda a, b: (a @ b).tanh(),
                    lambda a, b: torch.cat([a[:2], b[2:]]).contiguous(),
                    lambda a, b: a.sigmoid().T,
                    lambda a, b: torch.where(a > b, a, -b),
                    lambda a, b: a.sort(dim=0).values - b[:, :1],
                    lambda a, b: (a + b[1]).reshape(-1).view(4, 4),
                    lambda a, b: a.max(dim=1, keepdim=True).indices * 0.25 + b,
                ]
            )(one, other)
            known.append(made / (1 + made.abs()))
        return torch.stack(known[-3:])

    return function


@pytest.mark.parametrize("seed", range(25))
def test_any_program_is_played_to_the_last_digit(seed: int) -> None:
    function, chance = drawn(seed), torch.Generator().manual_seed(seed)
    values = torch.randn(3, 4, 4, generator=chance, dtype=torch.float64)
    tape = Tape(function, values[0])
    for value in (*values, values[0]):
        kept = value.clone()
        torch.testing.assert_close(tape(value), function(value), rtol=0, atol=0)
        torch.testing.assert_close(value, kept, rtol=0, atol=0)


@pytest.mark.parametrize("seed", range(15))
def test_the_gradient_of_any_program_is_played_to_the_last_digit(seed: int) -> None:
    program, chance = drawn(seed), torch.Generator().manual_seed(seed)

    def function(x: Tensor, y: Tensor) -> tuple[Tensor, tuple[Tensor, ...]]:
        here = x.detach().requires_grad_(), y.detach().requires_grad_()
        with torch.enable_grad():
            value = program(here[0] * here[1].sum(0)) + here[1]
            return value.detach(), torch.autograd.grad(value.square().sum(), here)

    values = torch.randn(4, 4, 4, generator=chance, dtype=torch.float64)
    tape = Tape(function, values[0], values[1])
    assert tape.faithful
    for given in (values[:2], values[2:], values[1:3], values[[3, 3]]):
        torch.testing.assert_close(tape(*given), function(*given), rtol=0, atol=0)


def test_a_played_tape_asks_for_no_memory() -> None:
    weight = torch.randn(64, 64, generator=torch.Generator().manual_seed(1))
    tape = Tape(lambda x: ((x @ weight).sigmoid() * 2 - x[:, :1]).square().sum(-1), torch.ones(64, 64))
    with torch.profiler.profile(activities=[torch.profiler.ProfilerActivity.CPU], profile_memory=True) as profiled:
        tape(weight)
    asked = [event.self_cpu_memory_usage for event in profiled.events()]
    assert len(asked) > 5
    assert max(asked) <= 8  # the factor 2


def test_what_is_the_same_is_computed_once() -> None:
    once = Tape(lambda x: x.exp() * 3, torch.ones(4))
    twice = Tape(lambda x: torch.stack([(x.exp() * 3) for _ in range(5)])[4], torch.ones(4))
    assert len(twice.steps) == len(once.steps) + 1


def test_a_tape_plays_gradients_and_several_inputs() -> None:
    def function(x: Tensor, y: Tensor) -> tuple[Tensor, Tensor]:
        here = x.detach().requires_grad_()
        with torch.enable_grad():
            value = ((here.sigmoid() * y).tanh() * here.exp()).sum()
            return value.detach(), torch.autograd.grad(value, here)[0]

    x, y = torch.linspace(-1, 1, 6), torch.linspace(2, 3, 6)
    tape = Tape(function, x, y)
    for given in ((x, y), (2 * x, y - 1), (x.flip(0), y.square())):
        for played, expected in zip(tape(*given), function(*given), strict=True):
            torch.testing.assert_close(played, expected, rtol=0, atol=0)


def test_what_is_written_into_a_constant_is_computed_every_time() -> None:
    def function(x: Tensor) -> Tensor:
        sums = torch.ones(3)
        sums[0] += x.sum()
        return sums.cumsum(0)

    x = torch.linspace(-1, 2, 4)
    tape = Tape(function, x)
    assert not tape.faithful
    for value in (x, 2 * x, x):
        torch.testing.assert_close(tape(value), function(value), rtol=0, atol=0)


def test_what_is_read_from_a_constant_before_it_changes_is_computed_every_time() -> None:
    def function(x: Tensor) -> Tensor:
        step = torch.ones(4)
        first = x + step
        step.mul_(2)
        return first * (x + step)

    x = torch.linspace(-1, 2, 4)
    tape = Tape(function, x)
    for value in (x, 2 * x):
        torch.testing.assert_close(tape(value), function(value), rtol=0, atol=0)


def test_a_tape_takes_a_tensor_twice_for_two_inputs() -> None:
    x, y = torch.linspace(-1, 2, 4), torch.linspace(2, 3, 4)
    torch.testing.assert_close(Tape(torch.sub, x, x)(x, y), x - y, rtol=0, atol=0)


def test_who_gets_a_result_may_change_it() -> None:
    fixed = torch.arange(4.0)
    tape = Tape(lambda x: (fixed, x, x.T, x.exp()), torch.ones(2, 2))
    for value in (torch.zeros(2, 2), torch.eye(2)):
        kept = value.clone()
        for found, expected in zip(tape(value), (torch.arange(4.0), kept, kept.T, kept.exp()), strict=True):
            torch.testing.assert_close(found, expected, rtol=0, atol=0)
        for found in tape(value):
            found.fill_(7)
        torch.testing.assert_close(value, kept, rtol=0, atol=0)


def test_a_tape_recorded_in_inference_mode_is_played_outside_and_without_a_gradient() -> None:
    with torch.inference_mode():
        tape = Tape(lambda x: (2 * x).exp().cumsum(0), torch.ones(4))
    x = torch.linspace(-1, 1, 4, requires_grad=True)
    found = tape(x)
    assert not found.requires_grad
    torch.testing.assert_close(found, (2 * x).exp().cumsum(0).detach(), rtol=0, atol=0)


def test_a_tape_is_played_without_a_gradient_though_its_constants_have_one() -> None:
    weight = torch.linspace(1, 2, 4, requires_grad=True)
    tape = Tape(lambda x: ((x * weight).exp().add_(weight), weight), torch.ones(4))
    assert tape.faithful
    for value in (torch.linspace(-1, 1, 4), torch.linspace(0, 2, 4, requires_grad=True)):
        found, constant = tape(value)
        assert not found.requires_grad
        assert not constant.requires_grad
        torch.testing.assert_close(found, ((value * weight).exp() + weight).detach(), rtol=0, atol=0)


def test_an_operation_that_torch_calls_otherwise_is_played_as_it_is() -> None:
    def function(x: Tensor) -> tuple[Tensor, ...]:
        return torch.linalg.vector_norm(x, 1, 0), x.norm(3, dim=0), x.var(0, correction=0), torch.where(x > 0, x, x.sqrt()), 2 - x.relu()

    x = torch.linspace(-1, 2, 6)
    tape = Tape(function, x)
    for value in (x, 2 * x, x.flip(0)):
        for played, expected in zip(tape(value), function(value), strict=True):
            torch.testing.assert_close(played, expected, rtol=0, atol=0, equal_nan=True)


def test_shapes_and_types_have_tapes_of_their_own_and_the_latest_are_kept() -> None:
    played = Recorded(lambda x: x.exp().cumsum(0) - x)
    chance = random.Random(1)
    results = {}
    for _ in range(40 * KEPT):
        size, dtype = chance.randrange(1, KEPT), chance.choice([torch.float32, torch.float64])
        x = torch.linspace(-1, chance.random(), size, dtype=dtype)
        found = played(x)
        torch.testing.assert_close(found, x.exp().cumsum(0) - x, rtol=0, atol=0)
        for others, (other, expected) in results.items():
            if others != (size, dtype):
                torch.testing.assert_close(other, expected, rtol=0, atol=0)
        results[size, dtype] = found, found.clone()
        assert sum(tape is not None for tape in played.tapes.values()) <= KEPT
