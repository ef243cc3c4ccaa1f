"""A network and effects in one model."""

from __future__ import annotations

import pytest
import torch
from omegaconf import OmegaConf
from torch import Generator, Tensor

from zoo.catalog import build, load, load_model, save_model
from zoo.errors import InputError
from zoo.models.hybrid import Hybrid
from zoo.training.weights import reset

COLUMNS = ["time_s", "temperature_c", "temperature_outer_c", "supply_v", "reference_dph"]


@pytest.fixture
def hybrid(raw) -> Hybrid:
    """A network with random weights that takes the columns in another order than they have in the runs, and hysteresis."""
    network = build("model", "bp", features=["supply_v", "temperature_outer", "temperature_rate"])
    reset(network, Generator().manual_seed(2))
    model = Hybrid(network, {"hysteresis": build("effects", "hysteresis")}, COLUMNS)
    model.physics.assign(torch.full_like(model.physics.theta(), 0.4), torch.tensor([0.3], dtype=torch.float64))
    return model


def test_it_is_the_sum_of_its_parts(hybrid, raw) -> None:
    x = raw(COLUMNS)
    network: Tensor = hybrid.network(x[:, [0, 3, 2, 1]])
    assert hybrid.network.inputs == ["time_s", "supply_v", "temperature_outer_c", "temperature_c"]
    torch.testing.assert_close(hybrid(x), network + hybrid.physics(x))
    assert float(hybrid.physics(x).detach().std()) > 0.01


def test_the_future_changes_nothing(hybrid, raw) -> None:
    x = raw(COLUMNS)
    changed = x.clone()
    changed[400:, 1:] += 50
    torch.testing.assert_close(hybrid(changed)[:400], hybrid(x)[:400], rtol=1e-12, atol=1e-12)


def test_saved_and_loaded_predicts_the_same(hybrid, raw, tmp_path) -> None:
    network = OmegaConf.merge(load("model", "bp"), {"features": hybrid.network.extract.names})
    effects = {"hysteresis": load("effects", "hysteresis")["hysteresis"]}
    config = {"_target_": "zoo.models.hybrid.Hybrid", "network": network, "effects": effects, "inputs": COLUMNS}
    save_model(tmp_path, config, hybrid)
    loaded, x = load_model(tmp_path), raw(COLUMNS)
    assert isinstance(loaded, Hybrid)
    assert not loaded.training
    assert torch.equal(loaded(x), hybrid(x))


def test_what_cannot_be_put_together_is_named() -> None:
    effects = {"hysteresis": build("effects", "hysteresis")}
    with pytest.raises(InputError, match=r"network needs the column temperature_flange_c; the runs have time_s"):
        Hybrid(build("model", "bp", features=["temperature_flange"]), effects, COLUMNS)
    with pytest.raises(InputError, match="at least one effect"):
        Hybrid(build("model", "bp"), {}, COLUMNS)
    with pytest.raises(InputError, match="'magnetic' needs the column field_ut"):
        Hybrid(build("model", "bp"), {"magnetic": build("effects", "magnetic")}, COLUMNS)
