"""What each of the other methods names in one case."""

from __future__ import annotations

import time
from typing import Any

import torch
from hidden_effects.case import made
from hidden_effects.peers.columns import library
from hidden_effects.peers.ranking import ranking
from hidden_effects.peers.sindy import sindy
from hidden_effects.peers.stepwise import stepwise
from hidden_effects.recipe import recipe

from zoo.catalog import build, names
from zoo.diagnosis.preparation import without_spikes


@torch.no_grad()
def asked(seed: int) -> dict[str, Any]:
    """Answers of all methods by their name, spikes left out as for ours."""
    runs = without_spikes(made(recipe(seed)).measured()[:-1])
    catalogue = {name: build("effects", name) for name in names("effects")}
    table = library(runs)
    methods = {"PySINDy": lambda: sindy(table), "stepwise (statsmodels)": lambda: stepwise(table), "BIC ranking": lambda: ranking(runs, catalogue)}
    return {"seed": seed, **{name: _timed(method) for name, method in methods.items()}}


def _timed(method: Any) -> dict[str, Any]:
    started = time.perf_counter()
    return {"named": method(), "seconds": time.perf_counter() - started}
