"""Beyond the catalogue's laws, which a fresh model obeys trivially: the sum over support points, some rows at a time, saved and loaded."""

import pytest
import torch

from zoo.catalog import load_model, save_model
from zoo.models.ls_svm import LsSvm, gaussians
from zoo.training.checkpoints import save_fitted
from zoo.training.files import CHECKPOINT
from zoo.training.module import Training

FEATURES = ["temperature", "temperature_rate"]


def drawn(*shape: int, seed: int = 1) -> torch.Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64)


@pytest.fixture
def model(raw) -> LsSvm:
    """Standardised, with 70 support points."""
    made = LsSvm(FEATURES)
    x = raw(made.inputs)
    made.standardise(made.features(x), torch.sin(x[:, 0] / 300))
    made.assign(drawn(70, 2), drawn(70, seed=2), torch.tensor(0.3, dtype=torch.float64), torch.tensor([0.7, 2.0], dtype=torch.float64))
    return made


def test_the_prediction_is_the_sum_of_its_definition(model, raw) -> None:
    features = model.features(raw(model.inputs, samples=20))
    for point, found in zip(features, model.head(features), strict=True):
        apart = ((point - model.scaler.centre) / model.scaler.scale - model.support) / model.width
        value = sum(a * torch.exp(-d.square().sum()) for a, d in zip(model.weight, apart, strict=True)) + model.bias
        torch.testing.assert_close(found, model.scaler.restore(value))


def test_rows_at_once_or_one_by_one(model, raw) -> None:
    features = model.features(raw(model.inputs))
    whole = model.head(features)
    torch.testing.assert_close(torch.stack([model.head(one) for one in features]), whole, rtol=1e-12, atol=1e-12)
    model.values_at_once = 70 * 37
    torch.testing.assert_close(model.head(features), whole, rtol=1e-12, atol=1e-12)
    torch.testing.assert_close(model.head(features.view(3, 200, 2)), whole.view(3, 200), rtol=1e-12, atol=1e-12)


def test_far_from_all_support_points_it_predicts_the_bias(model) -> None:
    far = torch.tensor([[1e4, 0.0]], dtype=torch.float64)
    torch.testing.assert_close(model.head(far), model.scaler.restore(model.bias).expand(1))


def test_scripted_and_exported_equal_eager(model, raw) -> None:
    x = raw(model.inputs)
    torch.testing.assert_close(torch.jit.script(model)(x), model(x), rtol=1e-12, atol=1e-12)

    class Head(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.model = model

        def forward(self, features: torch.Tensor) -> torch.Tensor:
            return self.model.head(features)

    features = model.features(x)
    graph = torch.export.export(Head(), (features[:50],), dynamic_shapes={"features": {0: torch.export.Dim("rows")}}).module()
    torch.testing.assert_close(graph(features), model.head(features), rtol=1e-12, atol=1e-12)


def test_a_model_built_anew_takes_as_many_support_points_as_were_saved(model, raw, tmp_path) -> None:
    x = raw(model.inputs)
    save_model(tmp_path, {"_target_": "zoo.models.ls_svm.LsSvm", "features": FEATURES}, model)
    assert torch.equal(load_model(tmp_path)(x), model(x))
    save_fitted(Training(model), tmp_path)
    assert torch.equal(Training.load_from_checkpoint(tmp_path / CHECKPOINT, model=LsSvm(FEATURES)).model(x), model(x))


def test_kernel_is_the_gaussian_of_the_distance_and_positive() -> None:
    points = 3 * drawn(60, 3)
    kernel = gaussians(points, points)
    torch.testing.assert_close(kernel, torch.exp(-(points[:, None] - points).square().sum(-1)), rtol=1e-12, atol=1e-14)
    assert float(torch.linalg.eigvalsh(kernel).min()) > -1e-13
