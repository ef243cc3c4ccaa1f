"""Lightning without its banners, for the length of a call, and without its counters."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from lightning.pytorch.loggers import TensorBoardLogger

LOGGERS = ("lightning.pytorch", "lightning.fabric", "lightning.pytorch.utilities.rank_zero")


class OwnScalars(TensorBoardLogger):
    """Writes what it is given, without Lightning's count of epochs, which are not those of a training here."""

    def log_metrics(self, metrics: Mapping[str, float], step: int | None = None) -> None:
        """See `TensorBoardLogger.log_metrics`."""
        if own := {name: value for name, value in metrics.items() if name != "epoch"}:
            super().log_metrics(own, step)


@contextmanager
def quiet_lightning() -> Iterator[None]:
    """Silences Lightning's notices (devices, tips, missing workers) and its warnings; errors stay, and everything is put back afterwards."""
    levels = {name: logging.getLogger(name).level for name in LOGGERS}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", module=r"lightning\..*")
        warnings.filterwarnings("ignore", category=DeprecationWarning, module=r"torch\..*")
        for name in LOGGERS:
            logging.getLogger(name).setLevel(logging.ERROR)
        try:
            yield
        finally:
            for name, level in levels.items():
                logging.getLogger(name).setLevel(level)
