"""Laws that every model of the catalogue obeys from the day it is added."""

import re

import pytest
import torch
from omegaconf import OmegaConf

from zoo.catalog import build, load, load_model, names, save_model
from zoo.models.base import FeatureModel, Model
from zoo.training.weights import reset

# A model whose YAML says `inputs: null` is put together from a run's columns; its own tests build it.
BUILT_ALONE = [name for name in names("model") if "inputs" not in load("model", name)]


@pytest.fixture(params=BUILT_ALONE)
def name(request) -> str:
    return request.param


@pytest.fixture
def model(name, raw) -> Model:
    """Standardised and with random weights."""
    made = build("model", name)
    assert isinstance(made, FeatureModel)
    reset(made, torch.Generator().manual_seed(2))
    for parameter in made.parameters():
        parameter.data += 0.1
    x = raw(made.inputs, seed=9)
    made.standardise(made.features(x), torch.sin(x[:, 0] / 300))
    return made


def test_inputs_are_columns_of_a_measurement_file(model) -> None:
    assert model.inputs[0] == "time_s"
    assert all(re.fullmatch(r"temperature_(\w+_)?c|supply_v|field_ut|humidity_pct|pressure_kpa|reference_\w+", one) for one in model.inputs[1:])


def test_forward_is_head_of_features_without_nan(model, raw) -> None:
    x = raw(model.inputs)
    y = model(x)
    assert y.shape == (len(x),)
    assert y.dtype == torch.float64
    assert bool(torch.isfinite(y).all())
    assert torch.equal(y, model.head(model.features(x)))


def test_the_head_has_no_memory_and_takes_leading_axes(model, raw) -> None:
    features = model.features(raw(model.inputs))
    order = torch.randperm(len(features), generator=torch.Generator().manual_seed(1))
    torch.testing.assert_close(model.head(features[order]), model.head(features)[order])
    torch.testing.assert_close(model.head(features.view(3, 200, -1)), model.head(features).view(3, 200))


def test_the_future_changes_nothing(model, raw) -> None:
    x = raw(model.inputs)
    changed = x.clone()
    changed[400:, 1:] += 50
    torch.testing.assert_close(model(changed)[:400], model(x)[:400], rtol=1e-12, atol=1e-12)


def test_scripted_equals_eager(model, raw) -> None:
    x = raw(model.inputs)
    torch.testing.assert_close(torch.jit.script(model)(x), model(x), rtol=1e-12, atol=1e-12)


def test_saved_and_loaded_predicts_the_same(model, name, raw, tmp_path) -> None:
    save_model(tmp_path, OmegaConf.to_container(load("model", name)), model)
    x = raw(model.inputs)
    assert torch.equal(load_model(tmp_path)(x), model(x))


def test_the_units_of_the_error_do_not_matter(name, raw) -> None:
    scaled = []
    for factor in (1.0, 4.848e-6):
        made = build("model", name)
        reset(made, torch.Generator().manual_seed(2))
        for parameter in made.parameters():
            parameter.data += 0.1
        x = raw(made.inputs)
        made.standardise(made.features(x), factor * (3 + torch.sin(x[:, 0] / 300)))
        scaled.append(made(x) / factor)
    torch.testing.assert_close(scaled[0], scaled[1])


def test_gradients_agree_with_finite_differences(model, raw) -> None:
    features = model.features(raw(model.inputs, samples=12))
    parameters = [parameter for parameter in model.parameters() if parameter.requires_grad]

    def loss() -> torch.Tensor:
        return model.head(features).square().mean()

    gradients = torch.autograd.grad(loss(), parameters)
    step = 1e-6
    for parameter, gradient in zip(parameters, gradients, strict=True):
        for index in range(parameter.numel()):
            flat = parameter.data.view(-1)
            middle = float(flat[index])
            flat[index] = middle + step
            above = float(loss().detach())
            flat[index] = middle - step
            below = float(loss().detach())
            flat[index] = middle
            assert (above - below) / (2 * step) == pytest.approx(float(gradient.reshape(-1)[index]), rel=1e-5, abs=1e-8)
