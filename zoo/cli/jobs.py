"""One job: its record, where its output goes, and the number that a sweeper gets of it."""

from __future__ import annotations

import json
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext, redirect_stderr, redirect_stdout, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig

from zoo.artifacts import writable_folder, write_text
from zoo.cli.alone import alone_in
from zoo.cli.closed_pipe import CLOSED_PIPE
from zoo.cli.outcomes import FAILED, SINGLE, Outcome, finished_before, made_from, replaced_by, started_by
from zoo.errors import InputError, WorkError, causes
from zoo.processes import end_with_parent

OUTPUT = "output.txt"
"""What a job prints that runs beside others."""
REPEATABLE = ("train",)
"""Verbs whose results depend on nothing but settings, files and version: what a sweep has done of them is not done again."""
OBJECTIVES = ("auto", "rms", "rms_check")


class Job:
    """A job of Hydra's, single or of a sweep.

    Args:
        verb: what it does.
        config: as composed, without Hydra's own.
    """

    def __init__(self, verb: str, config: DictConfig) -> None:
        hydra = HydraConfig.get()
        self.overrides = list(hydra.overrides.task)
        self.result: Path | None = None
        self._verb, self._config = verb, config
        self._folder = Path(hydra.runtime.output_dir)
        self._sweep = str((hydra.callbacks or {}).get("sweep", {}).get("id") or SINGLE)
        self._launcher = str(hydra.runtime.choices.get("hydra/launcher"))
        self._beside_others = self._sweep != SINGLE and self._launcher != "basic"
        self._outcome: Outcome | None = None

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Keeps other jobs of sweeps from the folder, and a worker from going on without the sweep that wants its results.

        Raises:
            WorkError: another process is at work there.
        """
        if self._sweep == SINGLE:
            yield
            return
        if self._launcher == "joblib":
            end_with_parent(started_by(self._sweep))
        with alone_in(self._folder):
            yield

    @contextmanager
    def output(self) -> Iterator[None]:
        """Gives the output of a job beside others, which would be mixed with theirs, a file of its own; there no progress bar moves either."""
        if not self._beside_others:
            yield
            return
        with (self._folder / OUTPUT).open("a", encoding="utf-8", buffering=1) as file, redirect_stdout(file), redirect_stderr(file):
            yield

    def begin(self) -> Path:
        """Take the folder, unless the same was done there before: then `result` is that job's.

        Returns:
            The folder.

        Raises:
            InputError: it cannot be written to, or the objective is none.
        """
        asked = self._config.get("objective", OBJECTIVES[0])
        if asked not in OBJECTIVES:
            raise InputError(f"objective={asked}: possible: {', '.join(OBJECTIVES)}")
        folder = writable_folder(self._folder)
        repeatable = self._verb in REPEATABLE
        new = Outcome(self._sweep, self.overrides, made_from(self._config) if repeatable else "")
        old = finished_before(folder, new) if repeatable and self._sweep != SINGLE else None
        self._outcome = (old or replace(new, replaced=replaced_by(folder, new))).write(folder)
        if old is not None:
            self.result = Path(str(old.result))
            print(f"{folder}: finished by an earlier sweep, with the same settings; remove the folder to have it done again")
        else:
            (folder / FAILED).unlink(missing_ok=True)
        return folder

    def end(self, result: Path) -> None:
        """It is done."""
        self.result = result
        self._record(code=0, result=str(result))

    def fail(self, error: BaseException, code: int, message: str) -> None:
        """It failed: in a sweep, a note says why, and of what nobody has foreseen also where."""
        self._record(code=code, message=message)
        if self._sweep != SINGLE and code != CLOSED_PIPE:
            foreseen = any(isinstance(cause, InputError | WorkError) for cause in causes(error))
            trace = "" if foreseen else f"\n{''.join(traceback.format_exception(error))}"
            with suppress(InputError):
                write_text(self._folder / FAILED, f"{message}\n{trace}")

    def _record(self, **changed: Any) -> None:
        # Wrong settings may be why there is no record yet.
        known = self._outcome or Outcome(self._sweep, self.overrides, "")
        with suppress(InputError) if changed["code"] else nullcontext():
            self._outcome = replace(known, **changed).write(self._folder)

    @property
    def value(self) -> float | None:
        """The number that a sweeper makes small: by default the RMS of the check runs, of the fitted ones where there are none [output's unit].

        Of several seeds it is their median; of a job that failed, and of a verb without an objective, nothing.
        """
        if self._verb not in REPEATABLE or self.result is None:
            return None
        return objective(json.loads(self.result.read_text(encoding="utf-8")), str(self._config.objective))


def objective(metrics: Mapping[str, Any], key: str) -> float | None:
    """The number of a training that is to be small [output's unit]; None where there is none, as there are no check runs.

    Args:
        metrics: of the training.
        key: one of `OBJECTIVES`.
    """
    if key == "auto":
        key = "rms" if metrics["rms_check"] is None else "rms_check"
    members = metrics.get("members")
    value = metrics[key] if not members or metrics[key] is None else members[f"{key}_quantiles"]["median"]
    return None if value is None else float(value)
