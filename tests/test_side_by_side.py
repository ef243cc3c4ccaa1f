"""Work on several cores: the same results in the same order, whatever the threads do."""

from __future__ import annotations

import threading
import time

import pytest
import torch

from zoo import side_by_side as module
from zoo.side_by_side import side_by_side


@pytest.fixture(params=[1, 3])
def allowed(request, monkeypatch) -> int:
    monkeypatch.setattr(module, "ALLOWED", request.param)
    return request.param


def test_results_come_in_the_order_of_the_items(allowed) -> None:
    def slow_first(item: int) -> int:
        time.sleep(0.002 * (5 - item))
        return item * item

    assert side_by_side(slow_first, range(5)) == [0, 1, 4, 9, 16]
    assert side_by_side(slow_first, []) == []


def test_as_many_threads_as_are_allowed_with_one_core_each(allowed) -> None:
    """All wait for each other: with fewer threads, nobody would go on."""
    together = threading.Barrier(allowed, timeout=5)

    def meets(_: int) -> int:
        together.wait()
        return torch.get_num_threads()

    before = torch.get_num_threads()
    found = side_by_side(meets, range(allowed))
    assert found == ([before] if allowed == 1 else [1] * allowed)
    assert torch.get_num_threads() == before


def test_within_one_of_them_no_more_are_started(allowed) -> None:
    def inner(_: int) -> bool:
        return len(set(side_by_side(lambda _: threading.get_ident(), range(3)))) == 1

    assert all(side_by_side(inner, range(2)))


@pytest.mark.parametrize("gradients", [True, False])
def test_gradients_are_taken_where_they_would_be_without_threads(allowed, gradients) -> None:
    with torch.set_grad_enabled(gradients):
        assert side_by_side(lambda _: torch.is_grad_enabled(), range(3)) == [gradients] * 3


def test_what_goes_wrong_in_one_is_raised(allowed) -> None:
    with pytest.raises(ZeroDivisionError):
        side_by_side(lambda item: 1 / item, [1, 0, 1])


def test_products_are_the_same(allowed) -> None:
    torch.manual_seed(0)
    matrices = [torch.randn(200, 200, dtype=torch.float64) for _ in range(6)]
    for one, other in zip(side_by_side(lambda one: one @ one, matrices), [one @ one for one in matrices], strict=True):
        torch.testing.assert_close(one, other, rtol=1e-14, atol=1e-11)
