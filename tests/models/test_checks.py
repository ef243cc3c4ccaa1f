"""A model from outside is refused for what would fail obscurely in the training, or not fail at all; those of the house pass."""

from __future__ import annotations

from typing import ClassVar

import pytest
import torch
from torch import Tensor, nn

from zoo.catalog import build, names
from zoo.effects.checks import check_effect
from zoo.errors import InputError
from zoo.models.base import FeatureModel, Model
from zoo.models.checks import check_many_weights, check_model, check_trainable
from zoo.models.features import Features
from zoo.models.graybox import GrayBox


class Good(FeatureModel):
    """Two numbers, linear in both."""

    linear_in: ClassVar[tuple[str, ...]] = ("weight",)

    def __init__(self) -> None:
        super().__init__()
        self.extract = Features(["temperature"])
        self.inputs = self.extract.inputs
        self.weight = nn.Parameter(torch.tensor([1.0, 0.1], dtype=torch.float64))

    def features(self, x: Tensor) -> Tensor:
        return self.extract(x)

    def head(self, features: Tensor) -> Tensor:
        return self.weight[0] + self.weight[1] * features[..., 0]


class OneNumber(Good):
    def head(self, features: Tensor) -> Tensor:
        return super().head(features).mean()


class Column(Good):
    def head(self, features: Tensor) -> Tensor:
        return super().head(features).unsqueeze(-1)


class Single(Good):
    def head(self, features: Tensor) -> Tensor:
        return super().head(features).float()


class Fails(Good):
    def head(self, features: Tensor) -> Tensor:
        return nn.Linear(3, 1)(features)


class Headless(Good):
    head = FeatureModel.head


class Empty(FeatureModel):
    inputs: ClassVar[list[str]] = ["time_s", "temperature_c"]  # type: ignore[misc]


class Ahead(Good):
    def features(self, x: Tensor) -> Tensor:
        return self.extract(x).roll(-1, 0)


class Whole(Good):
    def features(self, x: Tensor) -> Tensor:
        return self.extract(x) - self.extract(x).mean(0)


class Remembers(Good):
    def head(self, features: Tensor) -> Tensor:
        return super().head(features).cumsum(-1)


class Bent(Good):
    def head(self, features: Tensor) -> Tensor:
        return (self.weight[0] + self.weight[1] * features[..., 0]).tanh()


class Absent(Good):
    linear_in: ClassVar[tuple[str, ...]] = ("weigth",)


class Timeless(Good):
    def __init__(self) -> None:
        super().__init__()
        self.inputs = ["temperature_c"]


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (OneNumber, r"returns shape \(\), torch\.float64; one number a row, of shape \(2000,\)"),
        (Column, r"returns shape \(2000, 1\)"),
        (Single, r"torch\.float32; one number a row"),
        (Fails, "Fails fails with RuntimeError"),
        (Headless, "still to be written: head$"),
        (Empty, "still to be written: features, head$"),
        (Ahead, "looks into the future"),
        (Whole, "looks into the future"),
        (Remembers, "depends on the rows beside it"),
        (Bent, "not linear in weight"),
        (Absent, "weigth: no such parameter; there are weight"),
        (Timeless, "time_s first"),
        (nn.Linear, "a Linear is no model"),
    ],
)
def test_what_is_wrong_is_said(wrong, words) -> None:
    with pytest.raises(InputError, match=words) as told:
        check_model(wrong(1, 1) if wrong is nn.Linear else wrong())
    assert len(str(told.value).splitlines()) == 1
    assert wrong.__name__ in str(told.value)


class Layered(Good):
    """A layer before the two numbers."""

    def __init__(self, layer: nn.Module) -> None:
        super().__init__()
        self.layer = layer

    def head(self, features: Tensor) -> Tensor:
        found = self.layer(features.unsqueeze(0))
        return super().head((found[0] if isinstance(found, tuple) else found).squeeze(0))


@pytest.mark.parametrize(
    ("layer", "words"),
    [
        (nn.GRU(1, 1, batch_first=True, dtype=torch.float64), "vmap, by which many weights .* fails with"),
        (nn.Dropout(0.5), "vmap, by which many weights .* random"),
        (nn.Linear(1, 1), "layer.weight, layer.bias: weights of torch.float64 are needed"),
    ],
)
def test_layers_that_do_not_take_many_weights_at_once_are_told(layer, words) -> None:
    check_many_weights(Layered(nn.Linear(1, 1, dtype=torch.float64)))
    with pytest.raises(InputError, match=words):
        check_many_weights(Layered(layer))


def test_weights_that_no_gradient_reaches_are_told() -> None:
    model = Good()
    check_trainable(model)
    model.head = lambda features: Good.head(model, features).detach()  # type: ignore[method-assign]
    with pytest.raises(InputError, match="no gradient reaches its weights"):
        check_trainable(model)


@pytest.mark.parametrize("name", [name for name in names("model") if name not in {"graybox", "hybrid"}])
def test_the_house_s_own_pass(name) -> None:
    check_model(build("model", name))


def test_a_grey_box_of_all_effects_passes() -> None:
    effects = {name: build("effects", name) for name in names("effects")}
    needs = [column for effect in effects.values() for column in effect.needs]
    model: Model = GrayBox(effects, [*dict.fromkeys(["time_s", "temperature_c", "temperature_outer_c", *needs, "reference_dph"])])
    check_model(model)


@pytest.mark.parametrize("name", names("effects"))
def test_the_house_s_own_effects_pass(name) -> None:
    check_effect(build("effects", name), name)


def test_a_weight_that_is_frozen_would_be_trained_all_the_same() -> None:
    model = build("model", "bp")
    model.hidden.weight.requires_grad_(False)
    with pytest.raises(InputError, match=r"BP\.hidden\.weight has requires_grad=False"):
        check_model(model)
