"""Work that a copy of this process gets ready for: done once told, by it or here, and nothing left behind."""

from __future__ import annotations

import os
import time
from functools import partial
from pathlib import Path

import pytest

from zoo import ahead as module
from zoo import side_by_side
from zoo.ahead import ahead
from zoo.report import page
from zoo.report.page_ahead import page_ahead

HERE = os.getpid()
pytestmark = [
    pytest.mark.skipif(not side_by_side.COPIES, reason="no copies of a process on this system"),
    pytest.mark.usefixtures("nothing_is_left"),
]


@pytest.fixture(params=[1, 2])
def allowed(request, monkeypatch) -> int:
    monkeypatch.setattr(side_by_side, "ALLOWED", request.param)
    return request.param


@pytest.fixture
def two(monkeypatch) -> None:
    monkeypatch.setattr(side_by_side, "ALLOWED", 2)


def written(path: Path, *, text: str) -> None:
    path.write_text(f"{os.getpid()} {text}")


def there(path: Path, until: float) -> str:
    """What another process has written, as soon as it has."""
    while not (path.exists() and path.read_text()) and time.monotonic() < until:
        time.sleep(0.01)
    return path.read_text()


def gone(process: int, until: float) -> bool:
    """Whether a process has ended by then."""
    ended = False
    while not ended and time.monotonic() < until:
        try:
            ended = "State:\tZ" in Path(f"/proc/{process}/status").read_text()
        except OSError:
            ended = True
        time.sleep(0.01)
    return ended


def nothing() -> None:
    pass


def test_it_is_done_by_the_copy_where_one_is_allowed(tmp_path, allowed) -> None:
    with ahead(nothing, written) as work:
        work.begin(tmp_path / "a", text="x" * 1_000_000)
        work.end()
    process, text = (tmp_path / "a").read_text().split()
    assert (int(process) == HERE) == (allowed == 1)
    assert text == "x" * 1_000_000


def test_tools_are_fetched_before_anybody_says_what_to_work_on(tmp_path, two) -> None:
    def fetch() -> None:
        written(tmp_path / "fetched", text="")

    with ahead(fetch, written):
        assert int(there(tmp_path / "fetched", time.monotonic() + 60.0)) != HERE


def test_what_goes_wrong_in_the_copy_is_done_here_and_raised_here(tmp_path, allowed) -> None:
    with ahead(nothing, written) as work:
        work.begin(tmp_path / "no folder" / "a", text="")
        with pytest.raises(FileNotFoundError):
            work.end()


def test_a_copy_that_dies_before_it_is_told_leaves_the_work_to_this_process(tmp_path, two) -> None:
    def dies() -> None:
        os._exit(1)

    with ahead(dies, written) as work:
        time.sleep(0.2)
        work.begin(tmp_path / "a", text="x" * 1_000_000)
        work.end()
    assert int((tmp_path / "a").read_text().split()[0]) == HERE


def test_nothing_waits_where_the_search_fails(tmp_path, two) -> None:
    with pytest.raises(ValueError, match="search"), ahead(nothing, written):
        raise ValueError("search")


def hangs() -> None:
    time.sleep(1000.0)


def test_a_copy_that_hangs_keeps_nobody_waiting(tmp_path, two, monkeypatch) -> None:
    """However much it is to be told."""
    monkeypatch.setattr(module, "PATIENCE_S", 0.1)
    with ahead(hangs, written) as work:
        work.begin(tmp_path / "a", text="x" * 1_000_000)
        work.end()
    assert int((tmp_path / "a").read_text().split()[0]) == HERE


def test_what_cannot_be_told_is_done_here(tmp_path, allowed) -> None:
    seen = []

    def tell(process: int) -> None:  # local: nobody else could find it
        seen.append(process)

    with ahead(nothing, lambda told: told(os.getpid())) as work:
        work.begin(tell)
        assert work._copy is None, "nobody waits for it"
        work.end()
    assert seen == [HERE]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_where_there_is_no_room_to_tell_it_is_done_here(tmp_path, two, monkeypatch) -> None:
    monkeypatch.setattr(module, "TemporaryFile", partial(Path("/dev/full").open, "w+b"))
    with ahead(nothing, written) as work:
        work.begin(tmp_path / "a", text="x" * 1_000)
        work.end()
    assert int((tmp_path / "a").read_text().split()[0]) == HERE


def test_a_page_is_drawn_by_the_copy(tmp_path, two, monkeypatch) -> None:
    """With what draws imported, told as the commands tell it."""
    monkeypatch.setattr(page, "write_report", lambda path, **named: written(path, text=str(sorted(named))))
    with page_ahead() as work:
        work.begin(tmp_path / "a", record={}, commands=[])
        work.end()
    process, told = (tmp_path / "a").read_text().split(maxsplit=1)
    assert int(process) != HERE
    assert told == "['commands', 'record']"


def test_the_copy_ends_where_this_process_is_gone(tmp_path, two) -> None:
    """Killed, it closes what it would have told by."""
    process = os.fork()
    if not process:
        try:
            with ahead(lambda: (tmp_path / "copy").write_text(str(os.getpid())), written):
                time.sleep(60.0)
        finally:
            os._exit(0)
    until = time.monotonic() + 30.0
    copy = int(there(tmp_path / "copy", until))
    os.kill(process, 9)
    os.waitpid(process, 0)
    assert gone(copy, until)


def test_copies_of_the_copy_end_with_it(tmp_path, two) -> None:
    """They would hold the output that the user reads, and work on for nobody."""

    def work(item: int) -> None:
        (tmp_path / str(item)).write_text(str(os.getpid()))
        time.sleep(60.0)

    until = time.monotonic() + 30.0
    with ahead(lambda: side_by_side.side_by_side(work, range(2)), written):
        both = [int(there(tmp_path / str(item), until)) for item in range(2)]
    assert len({HERE, *both}) == 3
    assert all(gone(process, until) for process in both)
