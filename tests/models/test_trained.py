"""A trained model as a term of a sum: its prediction, and what other weights would make of it."""

from __future__ import annotations

import copy

import pytest
import torch
from torch import Generator, Tensor

from zoo.catalog import build
from zoo.errors import InputError
from zoo.fitting.projection import complement, orthonormal
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel
from zoo.models.graybox import GrayBox
from zoo.models.trained import Trained
from zoo.training.weights import reset, set_weights, weight_vector

COLUMNS = ["time_s", "temperature_c", "temperature_outer_c", "supply_v", "reference_dph"]
FEATURES = ["temperature", "temperature_rate", "temperature_outer", "supply_v", "reference_dph", "time_s"]
BLOCK = 5


@pytest.fixture
def x(raw) -> Tensor:
    return raw(COLUMNS)


@pytest.fixture
def run(x) -> Run:
    count, block = torch.ones(len(x), dtype=torch.int64), torch.arange(len(x)) // BLOCK
    return Run("run_1", "dph", 50.0, tuple(COLUMNS), x, torch.sin(x[:, 0] / 300), count, block)


def network(name: str, x: Tensor, seed: int = 2, **settings) -> FeatureModel:
    """Standardised, with random weights."""
    made: FeatureModel = build("model", name, **settings)
    reset(made, Generator().manual_seed(seed))
    set_weights(made, weight_vector(made) + 0.3 * torch.randn(len(weight_vector(made)), generator=Generator().manual_seed(seed), dtype=torch.float64))
    table = x[:, [COLUMNS.index(name) for name in made.inputs]]
    made.standardise(made.features(table), torch.sin(x[:, 0] / 300))
    return made


def columns(effect: Trained, x: Tensor) -> Tensor:
    """(T, 1+K) as a sum sees them."""
    model = GrayBox({effect.name: effect}, COLUMNS)
    return model.columns(x, model.theta().unsqueeze(0), run=1)[0]


@pytest.mark.parametrize("features", [FEATURES, ["temperature", "temperature_rate"]])
def test_by_default_it_is_the_model_whatever_columns_that_takes(x, run, features) -> None:
    bp = network("bp", x, features=features)
    effect = Trained("bp", bp, [run])
    expected = bp(run.select(bp.inputs)).detach()
    model = GrayBox({"bp": effect}, COLUMNS)
    torch.testing.assert_close(model(x).detach(), expected)
    torch.testing.assert_close(columns(effect, x)[:, 0], expected)
    later = x + torch.tensor([5000.0, 0, 0, 0, 0], dtype=torch.float64)
    torch.testing.assert_close(model(later).detach(), bp(later[:, [COLUMNS.index(name) for name in bp.inputs]]).detach())


def test_each_direction_is_a_small_step_of_the_weights(x, run) -> None:
    """By central differences; of RMS 1 over the blocks and at right angles to the prediction and to each other."""
    bp = network("bp", x)
    effect = Trained("bp", bp, [run])
    found, tangent = columns(effect, x), effect.tangent
    table, size = run.select(bp.inputs), len(weight_vector(bp))
    for k in range(tangent.size):
        step = 1e-4 / float(tangent.directions[:, k].norm())
        ahead, back = copy.deepcopy(bp), copy.deepcopy(bp)
        set_weights(ahead, weight_vector(bp) + step * tangent.directions[:size, k])
        set_weights(back, weight_vector(bp) - step * tangent.directions[:size, k])
        slope = ((ahead(table) - back(table)) / (2 * step)).detach()
        torch.testing.assert_close(found[:, 1 + k], slope - tangent.along[k] * bp(table).detach(), rtol=1e-6, atol=1e-6)
    blocks = run.block_mean_columns(found)
    gram = blocks[:, 1:].mT @ blocks[:, 1:] / len(blocks)
    torch.testing.assert_close(gram, torch.eye(tangent.size, dtype=torch.float64), rtol=0, atol=1e-6)
    assert float((blocks[:, 1:].mT @ blocks[:, 0]).abs().max()) < 1e-6 * len(blocks)


def outside(wanted: Tensor, effect: Trained, x: Tensor) -> float:
    """Share of a prediction's RMS that no amplitudes of the effect make."""
    left = complement(wanted.unsqueeze(1), orthonormal(columns(effect, x)))
    return float(left.norm() / wanted.norm())


def test_of_a_model_that_is_linear_in_its_weights_all_weights_are_in_reach(x, run) -> None:
    first, second = network("polynomial", x, order=4), network("polynomial", x, seed=3, order=4)
    assert outside(second(run.select(second.inputs)).detach(), Trained("polynomial", first, [run]), x) < 1e-6


def test_a_network_that_is_known_with_other_weights_too_reaches_those(x, run) -> None:
    first, second = network("bp", x), network("bp", x, seed=3)
    wanted = second(run.select(second.inputs)).detach()
    alone, both = Trained("bp", first, [run]), Trained("bp", first, [run], [second])
    assert outside(wanted, both, x) < 0.01 < outside(wanted, alone, x)
    torch.testing.assert_close(columns(both, x)[:, 0], first(run.select(first.inputs)).detach())


def test_copies_share_what_was_computed(x, run) -> None:
    effect = Trained("bp", network("bp", x), [run])
    assert copy.deepcopy(effect).tangent is effect.tangent
    other = x.clone()
    other[:, 1] += 5
    table = other[:, [COLUMNS.index(name) for name in effect.tangent.model.inputs]]
    assert not torch.equal(columns(effect, other), columns(effect, x))
    torch.testing.assert_close(columns(effect, other)[:, 0], effect.tangent.predict(table))


def test_a_column_that_the_runs_lack_is_named(x, run) -> None:
    with pytest.raises(InputError, match="run_1: the model needs the column temperature_flange_c"):
        Trained("bp", build("model", "bp", features=["temperature_flange"]), [run])
