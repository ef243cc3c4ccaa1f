"""Results are written whole or not at all."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
from pathlib import Path

import pytest

from zoo.artifacts import folder_replacing, replacing, writable_folder, write_json, write_text
from zoo.errors import InputError, WorkError


def test_text_is_utf8_with_plain_newlines(tmp_path: Path) -> None:
    assert write_text(tmp_path / "new" / "a.txt", "°/h\n").read_bytes() == b"\xc2\xb0/h\n"


def test_json_is_readable_and_indented(tmp_path: Path) -> None:
    text = write_json(tmp_path / "a.json", {"unit": "°/h", "rms": 0.1}).read_text(encoding="utf-8")
    assert json.loads(text) == {"unit": "°/h", "rms": 0.1}
    assert '\n  "unit": "°/h"' in text


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_json_refuses_what_is_no_json_and_keeps_the_old_file(tmp_path: Path, value: float) -> None:
    path = write_json(tmp_path / "a.json", {"rms": 1})
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(path, {"rms": [value]})
    assert json.loads(path.read_text()) == {"rms": 1}
    assert list(tmp_path.iterdir()) == [path]


def test_an_interrupted_write_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = write_text(tmp_path / "a.txt", "old")

    def half() -> None:
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        half()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def write_into(place: Path) -> None:
    (place / "inside" if place.is_dir() else place).write_text("some")


def killed_while_writing(writes, path: Path) -> None:
    with writes(path) as temporary:
        write_into(temporary)
        os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.skipif(os.name != "posix", reason="nothing tells there whether a process lives")
@pytest.mark.parametrize("writes", [replacing, folder_replacing])
def test_what_a_killed_process_left_goes_with_the_next(tmp_path: Path, writes) -> None:
    path, other = tmp_path / "a[1]", tmp_path / "a[1].b"
    for one in (path, other):
        process = multiprocessing.get_context("fork").Process(target=killed_while_writing, args=(writes, one))
        process.start()
        process.join()
    _, others = sorted(tmp_path.iterdir(), key=lambda left: other.name in left.name)
    with writes(path) as mine, writes(path) as second:
        write_into(mine)
        write_into(second)
        assert set(tmp_path.iterdir()) == {mine, second, others}
    assert set(tmp_path.iterdir()) == {path, others}


def test_the_target_does_not_change_before_the_end(tmp_path: Path) -> None:
    path = write_text(tmp_path / "a.txt", "old")
    with replacing(path) as temporary:
        temporary.write_text("new")
        assert temporary.parent == path.parent
        assert path.read_text() == "old"
    assert path.read_text() == "new"


def test_a_write_that_fails_half_way_is_a_failure_of_the_work(tmp_path: Path) -> None:
    with pytest.raises(WorkError, match=r"a\.txt.*No space"), replacing(tmp_path / "a.txt"):
        raise OSError(28, "No space left on device")
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_there_is_no_excuse_for_a_full_disk(tmp_path: Path) -> None:
    """Somebody else's that came in the meantime stays; what goes wrong while writing is told all the same."""
    (tmp_path / "a").mkdir()
    with pytest.raises(WorkError, match=r"a.*No space"), folder_replacing(tmp_path / "a"):
        raise OSError(28, "No space left on device")
    with folder_replacing(tmp_path / "a") as own:
        (own / "mine").touch()
    assert list(tmp_path.iterdir()) == [tmp_path / "a"]
    assert not list((tmp_path / "a").iterdir())


def test_a_folder_that_cannot_be_written_to_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"file/sub.*cannot be written"):
        write_text(tmp_path / "file" / "sub" / "a.txt", "")
    with pytest.raises(InputError, match="is a folder"):
        write_text(tmp_path, "")


def test_a_writable_folder_is_made_and_left_empty(tmp_path: Path) -> None:
    assert not list(writable_folder(tmp_path / "a" / "b").iterdir())
