"""Work that a copy of this process gets ready for: done once told, by it or here, and nothing left behind."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from zoo import side_by_side
from zoo.ahead import ahead

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
        until = time.monotonic() + 60.0
        while not (tmp_path / "fetched").exists() and time.monotonic() < until:
            time.sleep(0.01)
        assert int((tmp_path / "fetched").read_text()) != HERE


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
    assert not list(tmp_path.iterdir())


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
    while not ((tmp_path / "copy").exists() and (tmp_path / "copy").read_text()) and time.monotonic() < until:
        time.sleep(0.01)
    copy = int((tmp_path / "copy").read_text())
    os.kill(process, 9)
    os.waitpid(process, 0)
    gone = False
    while not gone and time.monotonic() < until:
        status = Path(f"/proc/{copy}/status")
        gone = not status.exists() or "State:\tZ" in status.read_text()
        time.sleep(0.01)
    assert gone
