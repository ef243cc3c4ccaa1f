"""A sweep from where it was typed: its jobs may run in other processes or on other machines, and tell of themselves by their records."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.experimental.callback import Callback
from omegaconf import DictConfig, OmegaConf, open_dict, read_write

from zoo.cli.jobs import REPEATABLE
from zoo.cli.outcomes import left_by_others, new_sweep, read_outcomes

THREADS = "OMP_NUM_THREADS"
LOOK_S = 1.0
"""Seconds between two looks at the records."""

# Hydra builds its callbacks itself, so the sweep under way is told through the module.
_under_way: list[Sweep] = []


class Sweep:
    """A sweep under way.

    Args:
        config: of the sweep, with Hydra's own; takes the sweep's name, which the jobs get with their settings.
    """

    def __init__(self, config: DictConfig) -> None:
        self.name = new_sweep()
        with read_write(config), open_dict(config):
            config.hydra.callbacks.sweep.id = self.name
            # The jobs compose their configs anew, from the overrides.
            config.hydra.overrides.hydra.append(f"hydra.callbacks.sweep.id={self.name}")
        self.config, self.folder = config, Path(config.hydra.sweep.dir)
        self._ended = threading.Event()
        self._watch = threading.Thread(target=self._tell_as_they_end, daemon=True)
        self._threads_before = os.environ.get(THREADS)

    def start(self) -> None:
        """Prepare for jobs beside each other: who watches sees them end, and each gets its share of the cores."""
        if self.config.hydra.runtime.choices.get("hydra/launcher") == "basic":
            return
        share = OmegaConf.select(self.config, "hydra.launcher.cpus_per_task")
        if share and self._threads_before is None:
            os.environ[THREADS] = str(share)  # the others limit their processes themselves
        threading.excepthook = _unless_a_pool_is_torn_down
        self._watch.start()

    def stop(self) -> None:
        """The jobs are done, or given up."""
        self._ended.set()
        if self._watch.is_alive():
            self._watch.join()
        threading.excepthook = threading.__excepthook__
        if self._threads_before is None:
            os.environ.pop(THREADS, None)

    def tell(self) -> int:
        """Print what came of the jobs.

        Returns:
            The highest of their exit codes.
        """
        from zoo.cli.sweep_tables import tell_failed, tell_mixed, tell_results  # pandas takes as long as a third of torch: only after a sweep

        outcomes = read_outcomes(self.folder, self.name)
        if self.config.hydra.job.name in REPEATABLE:
            tell_results(self.config, self.folder, outcomes)
            tell_mixed(outcomes, left_by_others(self.folder, self.name))
        codes = [1 if one.code is None else one.code for one in outcomes.values()]
        if {1, 2} & {*codes}:
            tell_failed(outcomes)
        if 1 in codes:  # wrong settings would be wrong again
            self.tell_how_to_go_on()
        return max(codes, default=0)

    def tell_how_to_go_on(self) -> None:
        """The way to what is missing."""
        typed = any(one.startswith("hydra.sweep.dir=") for one in sys.argv)
        if self.config.hydra.job.name in REPEATABLE and self.folder.is_dir():
            again = "the same command" if typed else f"the same command with 'hydra.sweep.dir={self.folder}'"
            print(f"{again} runs what is missing and nothing twice", file=sys.stderr)

    def _tell_as_they_end(self) -> None:
        from zoo.cli.sweep_tables import progress_line

        told: set[Path] = set()
        parsed = OverridesParser.create().parse_overrides(list(self.config.hydra.overrides.task))
        swept = [one.key_or_group for one in parsed if one.is_sweep_override()]
        over = False
        while not over:
            over = self._ended.wait(LOOK_S)
            for folder, one in read_outcomes(self.folder, self.name).items():
                if one.code is not None and folder not in told:
                    told.add(folder)
                    print(progress_line(folder, one, swept), flush=True)


class SweepRecords(Callback):
    """Hydra's hook before the first job of a sweep.

    Args:
        id: name of the sweep that a job belongs to.
    """

    def __init__(self, id: str | None = None) -> None:
        self.id = id

    def on_multirun_start(self, config: DictConfig, **kwargs: Any) -> None:
        """Of a sweep."""
        _under_way[:] = [Sweep(config)]
        _under_way[0].start()


def _unless_a_pool_is_torn_down(found: threading.ExceptHookArgs) -> None:
    """After Ctrl-C, joblib's thread may still look for jobs that are gone already, and fall over with a trace."""
    if found.thread is None or "ExecutorManager" not in found.thread.name:
        threading.__excepthook__(found)


@contextmanager
def sweep_told(codes: list[int]) -> Iterator[None]:
    """Tells at its end what came of the sweep in it, where there was one, however it ended.

    Args:
        codes: takes the highest exit code of its jobs.
    """
    _under_way.clear()
    try:
        yield
    except Exception:
        for sweep in _under_way:
            sweep.stop()
            sweep.tell()
        raise
    except KeyboardInterrupt:
        for sweep in _under_way:
            if any(one.code == 0 for one in read_outcomes(sweep.folder, sweep.name).values()):
                sweep.tell_how_to_go_on()
        raise
    else:
        for sweep in _under_way:
            sweep.stop()
            codes.append(sweep.tell())
    finally:
        _under_way.clear()
