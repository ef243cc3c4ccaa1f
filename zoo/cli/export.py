"""The verb `export`, announced and not built yet."""

from __future__ import annotations

from pathlib import Path

from omegaconf import DictConfig

from zoo.errors import WorkError


def run(config: DictConfig, out: Path) -> Path:
    """Say that the verb is not there yet.

    Raises:
        WorkError: always.
    """
    raise WorkError("fogzoo export is not built yet: this version has simulate, train, compare, diagnose and refine")
