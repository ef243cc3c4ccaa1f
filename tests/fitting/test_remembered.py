"""What was computed before is not computed again, and is the same; what is too much is forgotten, the oldest first."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from zoo.fitting import remembered
from zoo.fitting.remembered import Remembered
from zoo.side_by_side import side_by_side


class Counting:
    """Makes (2, 3) columns of the number that a key is, and notes which it was asked for."""

    def __init__(self, memory: Remembered) -> None:
        self.memory, self.asked = memory, list[int]()

    def __call__(self, *keys: int) -> Tensor:
        def made(places: list[int]) -> Tensor:
            self.asked += [keys[i] for i in places]
            return torch.stack([torch.full((2, 3), float(keys[i])) for i in places], dim=1).movedim(1, 0)

        return self.memory.batch(list(keys), made)


def numbers(batch: Tensor) -> list[float]:
    assert batch.shape[1:] == (2, 3)
    return batch[:, 0, 0].tolist()


def test_each_is_made_once_and_comes_in_the_order_asked_for() -> None:
    of = Counting(Remembered())
    assert numbers(of(1, 2)) == [1, 2]
    assert numbers(of(3, 2, 4, 1)) == [3, 2, 4, 1]
    assert numbers(of(4, 3)) == [4, 3]
    assert of.asked == [1, 2, 3, 4]


def test_time_goes_first_in_memory_whatever_was_known() -> None:
    of = Counting(Remembered())
    for batch in (of(1, 2), of(2, 3), of(3, 1)):
        assert batch.movedim(1, 0).is_contiguous()


def test_what_is_remembered_is_not_what_was_given_out() -> None:
    of = Counting(Remembered())
    of(1, 2).fill_(9.0)
    of(1, 2).fill_(9.0)
    assert numbers(of(1, 2)) == [1, 2]


def test_the_oldest_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remembered, "KEPT", 18)
    of = Counting(Remembered())
    of(1, 2, 3)
    of(1)
    of(4)
    assert numbers(of(1, 3, 4)) == [1, 3, 4]
    assert of.asked == [1, 2, 3, 4], "2 was used longest ago"
    assert numbers(of(2, 5, 6, 7)) == [2, 5, 6, 7], "more at once than are kept"
    assert of.asked == [1, 2, 3, 4, 2, 5, 6, 7], "2 had to be made again"


def test_what_one_item_of_several_computed_another_computes_itself(monkeypatch) -> None:
    """And finds what was known before them: whatever process does which, it adds the same numbers up."""
    monkeypatch.setattr("zoo.side_by_side.ALLOWED", 1)
    memory, made = Remembered(), list[list[str]]()

    def column(key: str) -> None:
        def make(new: list[int]) -> Tensor:
            made.append([key] * len(new))
            return torch.zeros(len(new), 3, 1)

        memory.batch([key], make)

    column("before")
    side_by_side(lambda key: [column(key) for _ in range(2)], ["before", "a", "a"])
    assert made == [["before"], ["a"], ["a"]]
    column("a")
    assert made[3:] == [["a"]]
