"""Work on several cores: the same results in the same order, whatever becomes of the copies."""

from __future__ import annotations

import mmap
import os
import resource
import select
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
import torch

from zoo import side_by_side as module
from zoo.side_by_side import of_item, side_by_side
from zoo.threads import threads_for

HERE = os.getpid()
MANY = 2000
"""Files."""
LONG_S = 60.0
"""Nothing here takes so long, whatever else the machine does."""
pytestmark = [
    pytest.mark.skipif(not module.COPIES, reason="no copies of a process on this system"),
    pytest.mark.usefixtures("nothing_is_left"),
]


class Lasting(dict):
    """Work that has always lasted for seconds, so that copies are made at once."""

    def get(self, *_: object) -> float:
        return 5.0


@pytest.fixture(autouse=True)
def copies_are_worth_it(monkeypatch) -> None:
    monkeypatch.setattr(module, "_paces", Lasting())


@pytest.fixture(params=[1, 3])
def allowed(request, monkeypatch) -> int:
    monkeypatch.setattr(module, "ALLOWED", request.param)
    return request.param


@pytest.fixture
def three(monkeypatch) -> None:
    monkeypatch.setattr(module, "ALLOWED", 3)


def meeting(together: int) -> Callable[[int], int]:
    """Work on an item that ends when so many that follow each other are at work, so that no process does two of them. Gives the process."""
    begun = mmap.mmap(-1, mmap.PAGESIZE)

    def work(item: int) -> int:
        begun[item] = 1
        first, until = item - item % together, time.monotonic() + LONG_S
        while not all(begun[first : first + together]):
            assert time.monotonic() < until, "the others do not come"
            time.sleep(0.001)
        return os.getpid()

    return work


def in_copy() -> bool:
    return os.getpid() != HERE


def test_results_come_in_the_order_of_the_items(allowed) -> None:
    def slow_first(item: int) -> int:
        time.sleep(0.002 * (5 - item))
        return item * item

    assert side_by_side(slow_first, range(5)) == [0, 1, 4, 9, 16]
    assert side_by_side(slow_first, []) == []


def test_as_many_processes_as_are_allowed_with_one_core_each(allowed) -> None:
    meet = meeting(allowed)

    def where(item: int) -> tuple[int, int]:
        return meet(item), torch.get_num_threads()

    before = torch.get_num_threads()
    found = side_by_side(where, range(allowed))
    assert len({process for process, _ in found}) == allowed
    assert {threads for _, threads in found} == ({before} if allowed == 1 else {1})
    assert torch.get_num_threads() == before


def test_whoever_is_free_takes_the_next(three) -> None:
    """The first item ends only after all others have: the two other processes share them."""
    done, tell = os.pipe()

    def work(item: int) -> bool:
        if item:
            return os.write(tell, b".") == 1
        return all(select.select([done], [], [], LONG_S)[0] and os.read(done, 1) for _ in range(12))

    try:
        assert side_by_side(work, range(13)) == [True] * 13
    finally:
        os.close(done)
        os.close(tell)


def test_within_one_of_them_no_more_are_started(allowed) -> None:
    def inner(_: int) -> bool:
        return set(side_by_side(lambda _: os.getpid(), range(3))) == {os.getpid()}

    assert all(side_by_side(inner, range(2)))


def test_beside_the_main_thread_everything_is_done_there(three) -> None:
    found: list[int] = []
    thread = threading.Thread(target=lambda: found.extend(side_by_side(lambda _: os.getpid(), range(3))))
    thread.start()
    thread.join()
    assert found == [HERE] * 3


@pytest.mark.parametrize("gradients", [True, False])
def test_gradients_are_taken_where_they_would_be_alone(allowed, gradients) -> None:
    with torch.set_grad_enabled(gradients):
        assert side_by_side(lambda _: torch.is_grad_enabled(), range(3)) == [gradients] * 3


def test_what_goes_wrong_in_one_is_raised(allowed) -> None:
    with pytest.raises(ZeroDivisionError):
        side_by_side(lambda item: 1 / item, [1, 0, 1])


def fails() -> None:
    raise MemoryError


def dies() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def hangs() -> None:
    time.sleep(1000.0)


@pytest.mark.parametrize("fate", [fails, dies, hangs])
def test_what_a_copy_does_not_bring_is_done_here_with_one_core_as_well(three, monkeypatch, fate) -> None:
    monkeypatch.setattr(module, "PATIENCE_S", 0.1)

    def work(item: int) -> tuple[int, int]:
        if in_copy() and item == 3:
            fate()
        time.sleep(0.02)
        return -item, torch.get_num_threads()

    assert side_by_side(work, range(6)) == [(-item, 1) for item in range(6)]


def test_results_that_cannot_travel_are_made_here(three) -> None:
    assert [one(2) for one in side_by_side(lambda item: lambda x: item * x, range(4))] == [0, 2, 4, 6]


class Broken:
    """A result that is not made again from what was sent."""

    def __reduce__(self) -> tuple[Callable[[int], float], tuple[int]]:
        return (1).__truediv__, (0,)


def test_results_that_do_not_arrive_are_made_here(three) -> None:
    assert all(isinstance(one, Broken) for one in side_by_side(lambda _: Broken(), range(4)))


def test_a_copy_that_stops_within_its_result_is_not_waited_for(three) -> None:
    copy = module.copy_of_this(Stopping)
    begun = time.monotonic()
    assert copy.result(0.3) is None
    assert time.monotonic() - begun < LONG_S
    copy.end()


class Stopping:
    """Written up to a part of it, and no further."""

    def __reduce__(self) -> tuple[object, ...]:
        return bytes, (), None, pieces()


def pieces() -> Iterator[bytes]:
    """More than is held back before it is written, and then nothing for ever; pickle takes the second before it writes the first."""
    yield bytes(10_000_000)
    yield bytes(10_000_000)
    time.sleep(1000.0)


def test_what_a_copy_has_done_is_taken_though_nobody_waits_any_more(three) -> None:
    copy = module.copy_of_this(lambda: bytes(5_000_000))
    time.sleep(0.5)
    assert copy.result(-1.0) == bytes(5_000_000)
    copy.end()


def test_however_many_files_are_open_copies_are_heard(three) -> None:
    """More than the 1024 that `select` can tell apart."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if hard != resource.RLIM_INFINITY and hard < MANY:
        pytest.skip("no more files are allowed")
    with ExitStack() as opened:
        opened.callback(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, MANY), hard))
        for _ in range(1100):
            opened.enter_context(Path(os.devnull).open())
        assert side_by_side(lambda item: -item, range(6)) == [-item for item in range(6)]


def test_where_the_system_gives_no_more_processes_one_does_it_all(three, monkeypatch) -> None:
    def refused() -> int:
        raise BlockingIOError("Resource temporarily unavailable")

    monkeypatch.setattr(os, "fork", refused)
    assert side_by_side(lambda _: os.getpid(), range(4)) == [HERE] * 4


def test_products_are_the_same_to_the_last_digit_wherever_they_are_made(allowed) -> None:
    torch.manual_seed(0)
    matrices = [torch.randn(200, 200, dtype=torch.float64) for _ in range(6)]
    with threads_for(0):
        alone = [one @ one for one in matrices]
    for one, other in zip(side_by_side(lambda one: one @ one, matrices), alone, strict=True):
        torch.testing.assert_close(one, other, rtol=0, atol=0)


class Clock:
    """Goes on in this process only, and only when told to."""

    now = 0.0

    def monotonic(self) -> float:
        return self.now


def test_what_does_not_last_is_done_here_and_what_does_by_copies(three, monkeypatch) -> None:
    monkeypatch.setattr(module, "_paces", {})
    monkeypatch.setattr(module, "time", clock := Clock())

    def worked(seconds: float, items: range, together: int = 1) -> list[int]:
        """The processes that did each item."""
        meet = meeting(together)

        def where(item: int) -> int:
            clock.now += seconds
            return meet(item) if item >= 0 else os.getpid()

        return side_by_side(where, items)

    assert len(set(worked(0.001, range(3), together=3))) == 3, "nobody knows yet"
    assert worked(0.001, range(20)) == [HERE] * 20
    suddenly = worked(0.2, range(-1, 6), together=3)
    assert suddenly[0] == HERE, "short the last time"
    assert len(set(suddenly[1:4])) == len(set(suddenly[4:])) == 3, "the first has shown that the rest lasts"
    assert len(set(worked(0.2, range(3), together=3))) == 3, "known to last"
    worked(0.001, range(20))
    assert worked(0.001, range(20)) == [HERE] * 20, "and known not to"


def test_a_long_item_that_comes_last_is_done_all_the_same(three, monkeypatch) -> None:
    monkeypatch.setattr(module, "_paces", {})
    assert side_by_side(lambda item: time.sleep(0.4 if item == 5 else 0.0) or item, range(6)) == list(range(6))


def test_what_is_done_here_has_one_core_as_in_a_copy(three, monkeypatch) -> None:
    """Products are rounded by the number of threads: what is done where must not matter."""
    monkeypatch.setattr(module, "_paces", {})
    before = torch.get_num_threads()
    assert side_by_side(lambda _: torch.get_num_threads(), range(4)) == [1] * 4
    assert torch.get_num_threads() == before


def test_what_goes_wrong_here_is_raised_and_leaves_all_threads(three, monkeypatch) -> None:
    monkeypatch.setattr(module, "_paces", {})
    before = torch.get_num_threads()
    with pytest.raises(ZeroDivisionError):
        side_by_side(lambda item: 1 / item, [1, 0, 1])
    assert torch.get_num_threads() == before


def test_what_one_item_remembers_no_other_finds(allowed) -> None:
    """Whichever process did which, so that it cannot matter; an item within an item has the memory of the outer one."""
    shared = ["before"]

    def work(item: int) -> tuple[list[str], list[str]]:
        mine = of_item(shared, list)
        found = [*shared, *mine]
        mine.append(f"of {item}")
        side_by_side(lambda inner: of_item(shared, list).append(f"within {inner}"), range(2))
        return found, list(of_item(shared, list))

    for item, (found, left_over) in enumerate(side_by_side(work, range(6))):
        assert found == ["before"]
        assert left_over == [f"of {item}", "within 0", "within 1"]
    assert of_item(shared, list) is shared
    assert shared == ["before"]
