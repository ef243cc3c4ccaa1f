"""Models of a user's own: what is right is trained, whatever else it does than the house's; what is not is refused when it can be known."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import ClassVar

import pytest
import torch
from torch import Generator, Tensor, nn

from zoo.catalog import build
from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.bp import BP
from zoo.models.checks import check_model
from zoo.models.standardised import StandardisedModel
from zoo.training.run import train


class Bell(StandardisedModel):
    """All that a model of named features needs."""

    def __init__(self) -> None:
        super().__init__(["temperature", "temperature_rate"])
        self.line = nn.Linear(2, 1, dtype=torch.float64)

    def head(self, features: Tensor) -> Tensor:
        return self.scaler.restore(torch.exp(-self.line(self.scaler(features)).square()).squeeze(-1))


class Richer(BP):
    """Makes more of its features than their names say."""

    def __init__(self) -> None:
        super().__init__(["temperature"])

    def features(self, x: Tensor) -> Tensor:
        own = super().features(x)
        return torch.cat([own, own.square()], dim=-1)

    def head(self, features: Tensor) -> Tensor:
        return super().head(features[..., :1])

    def standardise(self, features: Tensor, error: Tensor) -> None:
        super().standardise(features[:, :1], error)


class Steps(Richer):
    """No slope anywhere, which a swarm does not mind."""

    linear_in: ClassVar[tuple[str, ...]] = ()

    def head(self, features: Tensor) -> Tensor:
        return (features[..., 0] > 10 * self.output.bias).double()


class Dropped(Richer):
    """Chance while it is trained, none when it predicts; means that go on and are not a trial's to change."""

    def __init__(self) -> None:
        super().__init__()
        self.norm = nn.BatchNorm1d(2, dtype=torch.float64)

    def head(self, features: Tensor) -> Tensor:
        return super().head(nn.functional.dropout(self.norm(features), 0.5, self.training))


class Unfitted(Model):
    """Brings a fit of its own, before which it has nothing to predict from."""

    fitted_by: ClassVar[str] = "mean_fit"

    def __init__(self, wide: int) -> None:
        super().__init__()
        self.inputs, self.wide = ["time_s", "temperature_c"], wide
        self.register_buffer("weight", torch.zeros(0, dtype=torch.float64))

    def forward(self, x: Tensor) -> Tensor:
        return x[:, 1:] @ self.weight


class MeanFit:
    def fit(self, model: Unfitted, runs: Sequence[Run], generator: Generator) -> None:
        model.weight = torch.full((model.wide,), 0.1, dtype=torch.float64)


@pytest.mark.parametrize(("model", "optimizer"), [(Bell, "levenberg_marquardt"), (Richer, partial(torch.optim.Adam, lr=0.01)), (Steps, "pso")])
def test_what_is_right_is_trained(make_run, tmp_path, model, optimizer) -> None:
    chosen = build("optimizer", optimizer) if isinstance(optimizer, str) else optimizer
    metrics = train(model(), [make_run()], [make_run("check")], optimizer=chosen, epochs=3, out=tmp_path)
    assert metrics["rms"] > 0


class Plain(Richer):
    """Weights of its own beside a layer's."""

    linear_in: ClassVar[tuple[str, ...]] = ()

    def __init__(self, drawn: bool) -> None:
        super().__init__()
        self.own = nn.Parameter(torch.zeros(1, dtype=torch.float64))
        self.layer = nn.Bilinear(1, 1, 1, dtype=torch.float64) if drawn else None
        self.hidden, self.output = nn.Identity(), nn.Identity()

    def head(self, features: Tensor) -> Tensor:
        x = self.scaler(features[..., :1])
        return self.scaler.restore(self.own * x[..., 0] + (0.0 if self.layer is None else self.layer(x, x)[..., 0]))

    def formula(self) -> dict[str, object]:
        return {}


def test_seeds_are_no_copies(make_run, tmp_path) -> None:
    """Of torch's layers those are drawn that say how; a model of which nothing is drawn is refused, unless its optimizer draws."""
    fit = partial(train, runs=[make_run()], seeds=2, epochs=3, out=tmp_path)
    adam = partial(torch.optim.Adam, lr=0.01)
    assert len(set(fit(Plain(True), optimizer=adam)["members"]["rms"])) == 2
    with pytest.raises(InputError, match=r"nothing draws own; give their module a method draw_weights"):
        fit(Plain(False), optimizer=adam)
    assert fit(Plain(False), optimizer=build("optimizer", "pso"))["rms"] > 0


def test_a_model_is_tried_as_it_predicts_and_left_as_it_was() -> None:
    model = Dropped()
    check_model(model)
    assert model.training
    assert not model.norm.running_mean.any()  # type: ignore[union-attr]


def test_one_with_a_fit_of_its_own_is_tried_after_it(make_run, tmp_path) -> None:
    assert train(Unfitted(1), [make_run()], optimizer=MeanFit(), out=tmp_path)["rms"] > 0
    with pytest.raises(InputError, match="Unfitted fails with RuntimeError: size mismatch"):
        train(Unfitted(2), [make_run()], optimizer=MeanFit(), out=tmp_path)
