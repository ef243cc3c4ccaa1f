"""Laws that every model of the catalogue obeys from the day it is added, however it is fitted."""

import copy
import inspect
import re
from functools import partial
from typing import Any

import pytest
import torch
from hydra.utils import get_class
from omegaconf import OmegaConf
from torch import Generator, Tensor

from zoo.catalog import build, create, load, load_model, names, save_model
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.training.files import CHECKPOINT
from zoo.training.module import Training
from zoo.training.population import Population
from zoo.training.random_init import RandomInit
from zoo.training.run import train
from zoo.training.weights import reset, set_weights, weight_vector

COLUMNS = ["time_s", "temperature_c", "temperature_outer_c", "reference_dph"]
"""What a model whose YAML says `inputs: null` is put together from."""
EFFECTS = ("static_bias", "mohr")
SAMPLES, BLOCK = 600, 3
ADAM = partial(torch.optim.Adam, lr=0.01)
SHORT = {"alternating": {"rounds": 1, "steps": 5, "first_steps": 10}}
"""What a fit of its own need not take to its end for these laws, by optimizer."""


def settings(name: str) -> dict[str, Any]:
    """A model's YAML, completed as `train` completes it."""
    config = load("model", name)
    if "inputs" not in config:
        return OmegaConf.to_container(config)
    given = {"inputs": COLUMNS, "effects": {one: load("effects", one)[one] for one in EFFECTS}}
    if "network" in inspect.signature(get_class(config["_target_"])).parameters:
        given["network"] = load("model", "bp")
    return OmegaConf.to_container(OmegaConf.merge(config, given), resolve=True)


def recorded(x: Tensor, columns: list[str], factor: float = 1.0) -> Run:
    """Raw columns as a run, with an error that no model has exactly; `factor` is the error's unit."""
    phase = (x[:, 1] - 20) / 15 if len(columns) > 1 else x[:, 0] / 900
    noise = torch.randn(len(x), generator=Generator().manual_seed(3), dtype=torch.float64)
    error = factor * (3 + torch.sin(x[:, 0] / 300) + torch.tanh(phase) + 0.1 * noise)
    return Run("run_1", "dph", 30.0, tuple(columns), x, error, torch.ones(len(x), dtype=torch.int64), torch.arange(len(x)) // BLOCK)


def own_fit(model: Model) -> Any:
    """The optimizer that a model names and that fits by itself; None for a model that is trained by gradient."""
    chosen = getattr(model, "fitted_by", "adam")
    optimizer = build("optimizer", chosen, **SHORT.get(chosen, {}))
    return optimizer if hasattr(optimizer, "fit") else None


def fitted(name: str, raw, factor: float = 1.0, samples: int = SAMPLES) -> Model:
    """As its own optimizer leaves it, or standardised with random weights where that is Adam."""
    model = create(settings(name))
    run = recorded(raw(model.inputs, samples=samples, seed=9), model.inputs, factor)
    optimizer = own_fit(model)
    if optimizer is not None:
        optimizer.fit(model, [run], Generator().manual_seed(2))
        return model.eval()
    assert isinstance(model, FeatureModel)
    reset(model, Generator().manual_seed(2))
    model.standardise(model.features(run.table), run.error)
    return model.eval()


@pytest.fixture(scope="module")
def fitted_once() -> dict[str, Model]:
    return {}


def moved(name: str, raw, fitted_once: dict[str, Model]) -> Model:
    """A copy of the fitted model, its weights anywhere but at a minimum or at 0."""
    if name not in fitted_once:
        fitted_once[name] = fitted(name, raw)
    model = copy.deepcopy(fitted_once[name])
    for parameter in model.parameters():
        parameter.data += 0.1
    return model


@pytest.fixture(params=names("model"))
def name(request) -> str:
    return request.param


@pytest.fixture
def model(name, raw, fitted_once) -> Model:
    return moved(name, raw, fitted_once)


FEATURE_MODELS = [name for name in names("model") if issubclass(get_class(load("model", name)["_target_"]), FeatureModel)]


@pytest.fixture(params=FEATURE_MODELS)
def feature_name(request) -> str:
    return request.param


@pytest.fixture
def feature_model(feature_name, raw, fitted_once) -> FeatureModel:
    made = moved(feature_name, raw, fitted_once)
    assert isinstance(made, FeatureModel)
    return made


def test_inputs_are_columns_of_a_measurement_file(model) -> None:
    assert model.inputs[0] == "time_s"
    assert all(re.fullmatch(r"temperature_(\w+_)?c|supply_v|field_ut|humidity_pct|pressure_kpa|reference_\w+", one) for one in model.inputs[1:])


def test_it_is_linear_in_the_parameters_that_it_says(feature_model, raw) -> None:
    """All together: whatever the others are, the output is the sum of what each of these adds."""
    state = {name: value.detach().clone() for name, value in feature_model.named_parameters()}
    names = [name for name in feature_model.linear_in if name in state]
    assert bool(names) == bool(feature_model.linear_in)
    features, chance = feature_model.features(raw(feature_model.inputs)), Generator().manual_seed(4)

    def outputs(factor: float) -> Tensor:
        feature_model.load_state_dict({name: value + factor * way[name] if name in names else value for name, value in state.items()}, strict=False)
        return feature_model.head(features).detach()

    way = {name: torch.randn(value.shape, generator=chance, dtype=value.dtype) for name, value in state.items()}
    here, once, far = outputs(0.0), outputs(1.0), outputs(-7.0)
    torch.testing.assert_close(far - here, -7 * (once - here), rtol=1e-9, atol=1e-9 * float((far - here).abs().max()))


@pytest.mark.parametrize("samples", [SAMPLES, 2, 1])
def test_there_is_one_finite_prediction_for_each_sample(model, raw, samples) -> None:
    x = raw(model.inputs, samples)
    y = model(x)
    assert y.shape == (samples,)
    assert y.dtype == torch.float64
    assert bool(torch.isfinite(y).all())


def test_the_future_changes_nothing(model, raw) -> None:
    x = raw(model.inputs)
    changed = x.clone()
    changed[400:, 1:] += 50
    torch.testing.assert_close(model(changed)[:400], model(x)[:400], rtol=1e-12, atol=1e-12)


def test_a_record_cut_short_is_predicted_as_far_as_it_goes(model, raw) -> None:
    x = raw(model.inputs)
    # Other lengths are summed in another order; a kernel machine's terms are a million times as large as their sum.
    torch.testing.assert_close(model(x[:399]), model(x)[:399], rtol=1e-9, atol=1e-6 if getattr(model, "fitted_by", "") == "dual_solve" else 1e-9)


def test_saved_and_loaded_predicts_the_same(model, name, raw, tmp_path) -> None:
    save_model(tmp_path, settings(name), model)
    x = raw(model.inputs)
    assert torch.equal(load_model(tmp_path)(x), model(x))


def test_a_state_goes_into_a_model_just_built_and_into_one_fitted_before(model, name, raw) -> None:
    x = raw(model.inputs)
    for other in (create(settings(name)), fitted(name, raw, samples=400)):
        other.load_state_dict({key: value.clone() for key, value in model.state_dict().items()})
        assert torch.equal(other(x), model(x))


def test_a_checkpoint_of_its_training_gives_it_back(name, raw, tmp_path) -> None:
    trained, fresh = create(settings(name)), create(settings(name))
    x = raw(trained.inputs, samples=SAMPLES, seed=9)
    own = own_fit(trained)
    train(trained, [recorded(x, trained.inputs)], optimizer=own or ADAM, epochs=2, out=tmp_path)
    reloaded = Training.load_from_checkpoint(tmp_path / CHECKPOINT, model=fresh, optimizer=None, weights_only=True)
    assert torch.equal(reloaded.model.cpu().eval()(x), trained(x))


def test_equal_seeds_give_equal_models_whatever_the_global_state(name, raw, fitted_once, tmp_path) -> None:
    results = []
    for position in range(2):
        torch.manual_seed(position)
        model = create(settings(name))  # torch's own layers draw from the global state as they are built
        before = torch.get_rng_state()
        run = recorded(raw(model.inputs, samples=SAMPLES, seed=9), model.inputs)
        train(model, [run], optimizer=own_fit(model) or ADAM, init=RandomInit(5), seed=5, epochs=3, out=tmp_path / str(position))
        assert torch.equal(torch.get_rng_state(), before)
        results.append(model.state_dict())
    assert results[0].keys() == results[1].keys()
    assert all(torch.equal(value, results[1][key]) for key, value in results[0].items())


def test_the_units_of_the_error_do_not_matter(feature_name, raw) -> None:
    large, small = (fitted(feature_name, raw, factor=factor) for factor in (1.0, 4.848e-6))
    x = raw(large.inputs)
    # The terms of a kernel machine are a million times as large as their sum.
    torch.testing.assert_close(small(x) / 4.848e-6, large(x), **({"rtol": 1e-6, "atol": 1e-6} if feature_name == "ls_svm" else {}))


def test_forward_is_head_of_features(feature_model, raw) -> None:
    x = raw(feature_model.inputs)
    assert torch.equal(feature_model(x), feature_model.head(feature_model.features(x)))


def test_the_head_has_no_memory_and_takes_leading_axes(feature_model, raw) -> None:
    features = feature_model.features(raw(feature_model.inputs))
    order = torch.randperm(len(features), generator=Generator().manual_seed(1))
    together = feature_model.head(features)
    torch.testing.assert_close(feature_model.head(features[order]), together[order])
    torch.testing.assert_close(feature_model.head(features.view(3, 200, -1)), together.view(3, 200))
    for index in range(0, 600, 60):
        torch.testing.assert_close(feature_model.head(features[index]), together[index])


def test_far_away_it_is_a_number_and_so_are_its_slopes(feature_model, raw) -> None:
    """A tenfold excursion, as where a thermometer's plug comes loose."""
    features = feature_model.features(raw(feature_model.inputs))
    features = (features + 9 * (features - features.mean(0))).requires_grad_()
    value = feature_model.head(features)
    (slope,) = torch.autograd.grad(value.sum(), features)
    assert bool(torch.isfinite(value).all())
    assert bool(torch.isfinite(slope).all())


def test_scripted_equals_eager(feature_model, raw) -> None:
    x = raw(feature_model.inputs)
    torch.testing.assert_close(torch.jit.script(feature_model)(x), feature_model(x), rtol=1e-12, atol=1e-12)


def test_many_weights_at_once_are_each_by_itself(feature_model, raw) -> None:
    if not list(feature_model.parameters()):
        pytest.skip("has no weights; its fit sets buffers")
    features = feature_model.features(raw(feature_model.inputs))
    here = weight_vector(feature_model)
    several = here + 0.3 * torch.randn(4, len(here), generator=Generator().manual_seed(1), dtype=torch.float64)
    together = Population(feature_model, features).outputs(several)
    for weights, outputs in zip(several, together, strict=True):
        set_weights(feature_model, weights)
        torch.testing.assert_close(feature_model.head(features).detach(), outputs)


def test_gradients_agree_with_finite_differences(feature_model, raw) -> None:
    features = feature_model.features(raw(feature_model.inputs, samples=12))
    parameters = [parameter for parameter in feature_model.parameters() if parameter.requires_grad]
    if not parameters:
        pytest.skip("has no weights; its fit sets buffers")

    def loss() -> Tensor:
        return feature_model.head(features).square().mean()

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
