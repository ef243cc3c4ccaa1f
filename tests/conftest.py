"""What all tests share."""

import gc
import multiprocessing
import multiprocessing.forkserver
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import torch

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # started in a shell's background, which the programs under test would inherit
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(autouse=True, scope="module")
def _as_quick_as_alone() -> Iterator[None]:
    """A file's tests start as in a process of their own.

    The collector's rounds leave alone what other files loaded: with thousands of tests and torch's modules they took most of the time of Python's
    own work. And a file that leaves torch with more threads than it was given would slow down all that come after it, twofold and more.
    """
    gc.collect()
    gc.freeze()
    threads = torch.get_num_threads()
    yield
    assert torch.get_num_threads() == threads, "set back what was changed of torch"


@pytest.fixture
def nothing_is_left() -> Iterator[None]:
    """No more open files and child processes than before: what other tests have left may go meanwhile."""

    def left() -> tuple[int, set[str]]:
        children = Path(f"/proc/self/task/{os.getpid()}/children").read_text()
        return len(list(Path("/proc/self/fd").iterdir())), set(children.split())

    files, processes = left()
    yield
    more_files, more_processes = left()
    assert more_files <= files
    assert more_processes <= processes


COMMAND = """
import os, sys
os.setsid()
for number, file in enumerate(files, 1):
    os.dup2(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), number)
os.environ.clear()
os.environ.update(environment)
exec(first)
sys.argv = ["fogzoo", *arguments]
from zoo.cli import main
main()
"""


class Command:
    """`fogzoo …` in a process and a session of its own, in the present folder; what it prints lies in files."""

    def __init__(self, arguments: list[str], files: list[Path], first: str) -> None:
        given = {"arguments": arguments, "files": [str(file) for file in files], "first": first, "environment": dict(os.environ)}
        self._files = files
        self._process = multiprocessing.get_context("forkserver").Process(target=exec, args=(COMMAND, given))
        self._process.start()

    @property
    def pid(self) -> int:
        """Of the process and of its session."""
        assert self._process.pid is not None
        return self._process.pid

    @property
    def is_over(self) -> bool:
        """Whether it has ended."""
        return self._process.exitcode is not None

    def end(self, timeout_s: float = 120.0) -> tuple[int, str, str]:
        """Its exit code, or minus the signal that ended it, and what it printed and told, once it is over."""
        self._process.join(timeout_s)
        if not self.is_over:
            os.killpg(self.pid, signal.SIGKILL)
        assert self.is_over, "still at work"
        printed, told = (file.read_text() for file in self._files)
        return self._process.exitcode, printed, told


@pytest.fixture(scope="session")
def _started_once() -> None:
    """A process that knows torch and Lightning already, with one thread, of which commands are copies."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("OMP_NUM_THREADS", "1")
        multiprocessing.get_context("forkserver").set_forkserver_preload(["zoo.cli.application", "zoo.training.run"])
        multiprocessing.forkserver.ensure_running()


@pytest.fixture(scope="session")
def command(_started_once: None, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Command]:
    """Begins ``fogzoo ARGUMENTS``, after some lines of Python where it needs them, without the seconds that importing Lightning takes each time.

    Not for what has workers that end with the program, as joblib's launcher: the end of such a process waits for them.
    """

    def begin(*arguments: str, first: str = "") -> Command:
        folder = tmp_path_factory.mktemp("printed")
        return Command([str(one) for one in arguments], [folder / "printed.txt", folder / "told.txt"], first)

    return begin
