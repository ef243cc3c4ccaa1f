"""A record in pieces is the record: every effect and every model, and what remembers by itself is found out."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from zoo.catalog import build, load, names
from zoo.effects.base import Effect, History, Parameter
from zoo.effects.bounds import to_physical
from zoo.errors import WorkError
from zoo.models.base import FeatureModel, Model
from zoo.models.example import example, used_inputs
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.models.streaming import Stream, check_streams, continued
from zoo.physics.carry import at_start
from zoo.physics.lag import lagged
from zoo.training.weights import reset

ONE, TWO = ["temperature_c"], ["temperature_c", "temperature_outer_c"]


class Peak(Effect):
    """A user's effect that uses what there is: a lag of the rate's size, and how far it is from where the record began."""

    name = "peak"
    shape = (Parameter("time", 1800.0, "s", 300.0, 14400.0, "log"),)
    amplitudes = (Parameter("a", 0.0, "unit", -1.0, 1.0), Parameter("b", 0.0, "unit", -1.0, 1.0))

    def columns(self, history: History, shape: Tensor) -> Tensor:
        late = lagged(history.time, history.rate.abs(), shape[..., 0])
        return torch.stack(torch.broadcast_tensors(late, history.temperature - at_start(history.temperature).unsqueeze(-1)), dim=-1)


class Highest(Effect):
    """One that remembers by itself the highest temperature so far."""

    name = "highest"
    amplitudes = (Parameter("a", 0.0, "unit", -1.0, 1.0),)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        return history.temperature.cummax(-1).values.unsqueeze(-1)


class Sloped(Effect):
    """One that cannot be computed for a single sample."""

    name = "sloped"
    amplitudes = (Parameter("a", 0.0, "unit", -1.0, 1.0),)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        return torch.gradient(history.temperature, dim=-1)[0].unsqueeze(-1)


def record(inputs: list[str], samples: int = 500) -> Tensor:
    """(T, C) a lively record with noise on every column and a clock that does not start at 0."""
    chance = torch.Generator().manual_seed(3)
    x = example(inputs, {name: (-30.0, 55.0) for name in inputs if name.startswith("temp")} | {inputs[-1]: (-9.0, 9.0)})[:samples].clone()
    x[:, 1:] += 0.05 * torch.randn(samples, len(inputs) - 1, generator=chance, dtype=torch.float64)
    x[:, 0] += 1e5
    return x


def graybox(effects: dict[str, Effect], thermometers: list[str], in_motion: bool = False) -> GrayBox:
    """With shapes away from their defaults, amplitudes that are not 0, and the columns that the effects need."""
    needs = list(dict.fromkeys(name for effect in effects.values() for name in effect.needs))
    model = GrayBox(effects, ["time_s", *thermometers, *needs, "reference_dph"], in_motion)
    parameters = [one for _, one in model.parameters_of_theta()]
    theta = torch.tensor([0.0 if one.scale == "index" else 0.37 for one in parameters], dtype=torch.float64)
    model.assign(theta, torch.linspace(0.5, 1.5, sum(len(one.amplitudes) for one in effects.values()), dtype=torch.float64))
    assert to_physical(theta, parameters).isfinite().all()
    return model


def check_pieces(model: Model, x: Tensor, sizes: list[int]) -> None:
    with torch.no_grad():
        whole = model(x)
        states: list[Tensor] = []
        parts = []
        for piece in x.split(sizes):
            predicted, states = continued(model, piece, states)
            parts.append(predicted)
    torch.testing.assert_close(torch.cat(parts), whole, rtol=0, atol=1e-9 * float(whole.abs().max()))


def cuts(samples: int, seed: int, first: int = 1) -> list[int]:
    """Random lengths, single samples among them."""
    chance = torch.Generator().manual_seed(seed)
    sizes = [first]
    while sum(sizes) < samples:
        longest = int(torch.tensor([1, 8, 150])[torch.randint(3, (1,), generator=chance)])
        sizes.append(min(int(torch.randint(1, longest + 1, (1,), generator=chance)), samples - sum(sizes)))
    return sizes


@pytest.mark.parametrize("thermometers", [ONE, TWO], ids=["one", "two"])
@pytest.mark.parametrize("name", names("effects"))
def test_every_effect_goes_on(name, thermometers) -> None:
    model = graybox({name: build("effects", name)}, thermometers)
    x = record(model.inputs)
    for sizes in (cuts(len(x), 1), cuts(len(x), 2, first=40)):
        check_pieces(model, x, sizes)


def test_all_effects_together_go_on_sample_by_sample() -> None:
    model = graybox({name: build("effects", name) for name in names("effects")}, TWO)
    x = record(model.inputs, 60)
    check_pieces(model, x, [1] * len(x))


@pytest.mark.parametrize("thermometers", [ONE, TWO], ids=["one", "two"])
def test_a_record_that_starts_in_motion_needs_its_first_minute_at_once(thermometers) -> None:
    model = graybox({"mohr": build("effects", "mohr")}, thermometers, in_motion=True)
    x = record(model.inputs)
    check_pieces(model, x, cuts(len(x), 1, first=5))  # 18 s from row to row
    with pytest.raises(WorkError, match="first 60 s"):
        check_pieces(model, x, cuts(len(x), 1, first=2))
    with torch.no_grad():
        torch.testing.assert_close(Stream(model, lambda: iter([1] * len(x)))(x), model(x), rtol=1e-9, atol=1e-9)


def made(name: str) -> Model:
    """A model of the catalogue with random weights; one that is put together from a run's columns has all effects that need no more."""
    settings = load("model", name)
    if "inputs" in settings:
        effects = {one: build("effects", one) for one in ("static_bias", "shupe", "hysteresis", "moisture")}
        physics = graybox(effects, ONE)
        if "network" not in settings:
            return physics
        network = build("model", "polynomial")
        hybrid = Hybrid(network, effects, physics.inputs)
        hybrid.physics = physics
        return hybrid
    model = build("model", name)
    assert isinstance(model, FeatureModel)
    reset(model, torch.Generator().manual_seed(2))
    for parameter in model.parameters():
        parameter.data += 0.1
    x = record(model.inputs)
    model.standardise(model.features(x), torch.sin(x[:, 0] / 300))
    return model


@pytest.mark.parametrize("name", names("model"))
def test_every_model_goes_on(name) -> None:
    model = made(name)
    x = record(model.inputs)
    check_pieces(model, x, cuts(len(x), 1))
    check_pieces(model, x[:40], [1] * 40)
    check_streams(model, x)


def test_a_users_effect_of_our_pieces_goes_on() -> None:
    model = graybox({"peak": Peak(), "mohr": build("effects", "mohr")}, ONE)
    x = record(model.inputs)
    check_pieces(model, x, cuts(len(x), 4))
    check_streams(model, x)


@pytest.mark.parametrize(("effect", "found"), [(Highest, "changes by"), (Sloped, "RuntimeError")])
def test_what_remembers_by_itself_is_found_out(effect, found) -> None:
    wrong = effect()
    model = graybox({"mohr": build("effects", "mohr"), wrong.name: wrong, "shupe": build("effects", "shupe")}, ONE)
    with pytest.raises(WorkError, match=rf"effect '{wrong.name}' .*{found}"):
        check_streams(model, example(model.inputs, {}))
    hybrid = Hybrid(made("bp"), dict(model.named_effects()), model.inputs)
    hybrid.physics = model
    with pytest.raises(WorkError, match=f"effect '{wrong.name}'"):
        check_streams(hybrid, example(model.inputs, {}))


def test_states_are_tensors_in_and_out_and_one_sample_can_be_exported() -> None:
    model = graybox({name: build("effects", name) for name in ("static_bias", "hysteresis", "viscoelastic", "moisture", "bias_step")}, ONE)
    x = record(model.inputs, 30)

    class Step(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.model = model

        def forward(self, x: Tensor, states: list[Tensor]) -> tuple[Tensor, list[Tensor]]:
            return continued(self.model, x, states)

    with torch.no_grad():
        predicted, states = continued(model, x[:1], [])
        program = torch.export.export(Step(), (x[1:2], states), strict=False).module()
        found = [predicted]
        for row in x[1:].split(1):
            predicted, states = program(row, states)
            found.append(predicted)
        torch.testing.assert_close(torch.cat(found), model(x), rtol=1e-9, atol=1e-9)


def test_which_columns_matter() -> None:
    model = graybox({"mohr": build("effects", "mohr"), "magnetic": build("effects", "magnetic")}, TWO)
    assert used_inputs(model, example(model.inputs, {})) == ["temperature_c", "temperature_outer_c", "field_ut"]
    turned = graybox({"fixture_rotation": build("effects", "fixture_rotation")}, ONE)
    assert used_inputs(turned, example(turned.inputs, {"reference_dph": (-9.0, 9.0)})) == ["temperature_c", "reference_dph"]
