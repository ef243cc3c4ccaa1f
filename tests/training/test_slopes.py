"""Losses and gradients of many members at once."""

import pytest
import torch
from torch import Generator

from zoo.models.bp import BP
from zoo.models.takagi_sugeno import TakagiSugeno
from zoo.models.wavelet import Wavelet
from zoo.training import population
from zoo.training.slopes import Slopes
from zoo.training.weights import set_weights, weight_vector

FEATURES = ["temperature", "temperature_rate"]


@pytest.mark.parametrize("make", [BP, Wavelet, TakagiSugeno])
@pytest.mark.parametrize("at_once", [(16, 2048), (3, 7), (1, 1)])
@pytest.mark.parametrize("own", [False, True])
def test_they_are_those_of_each_member_alone(make, at_once, own, monkeypatch) -> None:
    monkeypatch.setitem(population.AT_ONCE, "cpu", at_once)
    model, chance = make(FEATURES), Generator().manual_seed(1)
    features, error = (torch.randn(5, 17, *last, generator=chance, dtype=torch.float64) for last in ((2,), ()))
    model.standardise(features[0], error[0])
    slopes = Slopes(model)
    for factor in (1.0, 0.5, 0.3):  # as it is, recorded, played
        weights = factor * torch.randn(5, len(weight_vector(model)), generator=chance, dtype=torch.float64)
        found = slopes(weights, features, error) if own else slopes(weights, features[0], error[0])
        for k, one in enumerate(weights):
            set_weights(model, one)
            model.zero_grad()
            loss = (model.head(features[k * own]) - error[k * own]).square().mean()
            loss.backward()
            expected = torch.cat([parameter.grad.flatten() for parameter in model.parameters()])
            torch.testing.assert_close(found[0][k], loss.detach(), rtol=1e-12, atol=0)
            torch.testing.assert_close(found[1][k], expected, rtol=1e-9, atol=1e-12)
