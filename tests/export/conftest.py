"""Models as they come out of a training, and records to try them on; each fixture makes them as asked."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch
from torch import Tensor

from zoo.catalog import build
from zoo.models.base import FeatureModel
from zoo.models.example import example
from zoo.models.graybox import GrayBox
from zoo.training.weights import reset

RANGES = {"temperature_c": (-30.0, 55.0), "temperature_outer_c": (-35.0, 60.0)}


def _record(inputs: list[str], samples: int = 700, seed: int = 3) -> Tensor:
    chance = torch.Generator().manual_seed(seed)
    x = example(inputs, RANGES).repeat(1 + samples // 2000, 1)[:samples].clone()
    x[:, 0] = 1e5 + torch.exp(4 * torch.rand(samples, generator=chance, dtype=torch.float64)).cumsum(0)
    x[:, 1:] += 0.05 * torch.randn(samples, len(inputs) - 1, generator=chance, dtype=torch.float64)
    return x


@pytest.fixture(scope="session")
def record() -> Callable[..., Tensor]:
    """(T, C) uneven steps from a second to a minute, noise on every column, a clock that does not start at 0."""
    return _record


@pytest.fixture(scope="session")
def network() -> Callable[..., FeatureModel]:
    """A map of features with random weights, standardised."""

    def make(name: str, **settings: object) -> FeatureModel:
        model: FeatureModel = build("model", name, **settings)
        reset(model, torch.Generator().manual_seed(2))
        for parameter in model.parameters():
            parameter.data += 0.1
        x = _record(model.inputs)
        model.standardise(model.features(x), torch.sin(x[:, 0] / 300))
        return model

    return make


@pytest.fixture(scope="session")
def graybox() -> Callable[..., GrayBox]:
    """A sum of effects with shapes away from their defaults and amplitudes that are not 0."""

    def make(effects: list[str], thermometers: tuple[str, ...] = ("temperature_c",), more: tuple[str, ...] = (), in_motion: bool = False) -> GrayBox:
        parts = {name: build("effects", name) for name in effects}
        needs = [column for part in parts.values() for column in part.needs]
        model = GrayBox(parts, list(dict.fromkeys(["time_s", *thermometers, *needs, *more, "reference_dph"])), in_motion)
        theta = torch.tensor([0.0 if one.scale == "index" else 0.37 for _, one in model.parameters_of_theta()], dtype=torch.float64)
        model.assign(theta, torch.linspace(0.5, 1.5, sum(len(part.amplitudes) for part in parts.values()), dtype=torch.float64))
        return model

    return make
