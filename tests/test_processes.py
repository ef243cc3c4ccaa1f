"""Work in processes of its own: the same results, errors by name, nobody left behind."""

from __future__ import annotations

import math
import operator
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from functools import partial
from pathlib import Path

import pytest
import torch

from zoo.catalog import load
from zoo.errors import InputError, WorkError
from zoo.processes import in_processes


@pytest.mark.parametrize("jobs", [1, 2])
def test_each_result_comes_with_the_place_of_its_item(jobs) -> None:
    assert dict(in_processes(math.factorial, [5, 3, 4], jobs)) == {0: 120, 1: 6, 2: 24}
    assert list(in_processes(math.factorial, [], jobs)) == []


def test_each_process_has_one_thread_and_tensors_travel_by_value(monkeypatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "2")  # or else it would be one in any case
    found = dict(in_processes(partial(operator.mul, torch.arange(3.0)), [torch.tensor(2.0), torch.tensor(3.0)], 2))
    assert [one.tolist() for _, one in sorted(found.items())] == [[0, 2, 4], [0, 3, 6]]
    assert [threads for _, threads in in_processes(_threads, range(2), 2)] == [1, 1]
    assert os.environ["OMP_NUM_THREADS"] == "2"


def _threads(_: int) -> int:
    return torch.get_num_threads()


def test_what_is_called_first_is_called_in_each_process() -> None:
    found = in_processes(os.getenv, ["FOGZOO_FIRST"] * 2, 2, first=partial(_set, "FOGZOO_FIRST", "done"))
    assert [value for _, value in found] == ["done", "done"]
    assert os.getenv("FOGZOO_FIRST") is None


def _set(name: str, value: str) -> None:
    os.environ[name] = value


@pytest.mark.parametrize("jobs", [1, 2])
def test_an_error_keeps_its_name(jobs) -> None:
    with pytest.raises(InputError, match="unknown effect 'shup': did you mean shupe"):
        list(in_processes(partial(load, "effects"), ["mohr", "shup", "mohr"], jobs))


def test_a_process_ended_from_outside_is_told() -> None:
    with pytest.raises(WorkError, match="ended from outside"):
        list(in_processes(os._exit, [3, 3], 2))


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="looks into /proc")
@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGKILL])
def test_nobody_is_left_behind(end) -> None:
    program = "import time\nfrom zoo.processes import in_processes\nif __name__ == '__main__':\n    list(in_processes(time.sleep, [0, 60, 60], 2))"
    with subprocess.Popen([sys.executable, "-c", program], stderr=subprocess.DEVNULL, start_new_session=True) as parent:
        deadline = time.monotonic() + 60
        while len(_group(parent.pid)) < 4:  # the parent, multiprocessing's tracker, two at work
            assert time.monotonic() < deadline
            time.sleep(0.1)
        os.killpg(parent.pid, end) if end == signal.SIGINT else parent.kill()
        while _group(parent.pid):
            assert time.monotonic() < deadline, "still at work"
            time.sleep(0.1)


def _group(group: int) -> list[str]:
    """Processes of a group that are not over."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # over meanwhile
            state, _, own = path.read_text().rpartition(")")[2].split()[:3]
            if int(own) == group and state != "Z":
                found.append(path.parent.name)
    return found
