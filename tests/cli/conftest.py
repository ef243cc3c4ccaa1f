"""Verbs run in the tests' own process, somewhere else than in the checkout; what they leave in it is put back."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest


@pytest.fixture(autouse=True, scope="module")
def _as_it_was() -> Iterator[None]:
    """`run` sets the arguments for its own process's life; a file's shared fixtures call it too, before any test. Hydra's own traces are off."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", [])
        patch.setenv("HYDRA_FULL_ERROR", "0")
        yield


@pytest.fixture(autouse=True)
def _elsewhere(_as_it_was: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each test in a folder of its own, and as if nothing had been typed before it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", [])
