"""A tape plays what it has heard, in memory of its own."""

import random

import pytest
import torch
from torch import Tensor

from zoo.training.tape import Tape


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


def test_a_constant_changed_in_place_is_refused() -> None:
    with pytest.raises(ValueError, match="constant"):
        Tape(lambda x: torch.zeros(4).add_(x), torch.ones(4))
