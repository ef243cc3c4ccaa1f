"""A network and effects trained together: planted effects come back, whatever the network could have made of them."""

from __future__ import annotations

import pytest
import torch
from torch import Generator, Tensor

from zoo.catalog import build
from zoo.errors import InputError, WorkError
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.models.prediction import predict_blocks
from zoo.training import alternating
from zoo.training.alternating import Alternating
from zoo.training.damped_steps import descend
from zoo.training.least_squares import LeastSquares
from zoo.training.run import train

COLUMNS = ("time_s", "temperature_c", "temperature_outer_c", "reference_dph")
STEP_S, BLOCK = 20.0, 5
NOISE = 0.01
PLANTED = {
    "hysteresis": ([6.0, 20.0, 40.0, 0.0], [0.4]),
    "warm_up": ([1500.0, 0.0, 0.0, 10.0], [0.3, 0.1]),
}
"""Shapes and amplitudes."""


def recording(name: str, stops: list[float], truth: GrayBox, seed: int) -> Run:
    """Ramps of 1 K/min between the stops with 40 min of hold; a curved static error, the planted effect, noise."""
    hold, levels, times = 2400.0, [20.0], [0.0]
    for stop in stops:
        times += [times[-1] + hold, times[-1] + hold + 60 * abs(stop - levels[-1])]
        levels += [levels[-1], stop]
    time = torch.arange(STEP_S / 2, times[-1] + hold, STEP_S, dtype=torch.float64)
    places = torch.searchsorted(torch.tensor(times, dtype=torch.float64), time).clamp(1, len(times) - 1)
    ends, values = torch.tensor(times, dtype=torch.float64), torch.tensor(levels, dtype=torch.float64)
    share = ((time - ends[places - 1]) / (ends[places] - ends[places - 1])).clamp(0, 1)
    outer = values[places - 1] + share * (values[places] - values[places - 1])
    inner = truth.histories(torch.stack([time, outer, outer, 0 * time], -1), torch.tensor([300.0, 0.0, 0.0], dtype=torch.float64))["coil"].temperature
    table = torch.stack([time, inner, outer, 0 * time], -1)
    noise = NOISE * BLOCK**0.5 * torch.randn(len(time), generator=Generator().manual_seed(seed), dtype=torch.float64)
    with torch.no_grad():
        error = 0.4 * torch.tanh((inner - 30) / 25) + 0.002 * inner + truth(table) + noise
    count, block = torch.ones(len(time), dtype=torch.int64), torch.arange(len(time)) // BLOCK
    return Run(name, "dph", STEP_S * BLOCK, COLUMNS, table, error, count, block)


def planted(effect: str) -> tuple[GrayBox, list[Run], Run]:
    """What is true, two runs to fit and one to check on."""
    truth = GrayBox({effect: build("effects", effect)}, list(COLUMNS))
    shape, amplitudes = PLANTED[effect]
    term = dict(truth.named_effects())[effect]
    with torch.no_grad():
        truth.coil_value.copy_(torch.tensor([200.0, 0.3, 0.0], dtype=torch.float64))
        term.shape_value[:] = torch.tensor(shape, dtype=torch.float64)
        term.amplitude[:] = torch.tensor(amplitudes, dtype=torch.float64)
    runs = [recording("a", [60, 30, 45, -20, 5, -10, 20], truth, 1), recording("b", [-20, 10, -5, 55, 20, 40, 20], truth, 2)]
    return truth, runs, recording("check", [50, 0, 35, -15, 25], truth, 3)


def left(model: torch.nn.Module, run: Run) -> float:
    return float((run.block_mean(run.error) - predict_blocks(model, run)).square().mean().sqrt())  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize("effect", list(PLANTED))
@pytest.mark.parametrize("network", ["bp", "polynomial", "takagi_sugeno"])
def test_a_planted_effect_comes_back_and_the_check_run_is_noise(effect, network, tmp_path) -> None:
    truth, runs, check = planted(effect)
    settings = {"polynomial": {"order": 5}, "takagi_sugeno": {"rules": 2}}.get(network, {})
    hybrid = Hybrid(build("model", network, **settings), {effect: build("effects", effect)}, list(COLUMNS))
    metrics = train(hybrid, runs, [check], optimizer=Alternating(), out=tmp_path)
    alone = build("model", "polynomial", order=5)
    LeastSquares().fit(alone, runs, Generator().manual_seed(1))
    assert metrics["rms_check"] < 1.25 * NOISE < 0.5 * left(alone, check)
    assert set(metrics["physical"]) == {"coil", effect}
    shape, amplitudes = PLANTED[effect]
    declared = dict(truth.named_effects())[effect]
    for parameter, planted_value in ((declared.shape[0], shape[0]), (declared.amplitudes[0], amplitudes[0])):
        found = metrics["physical"][effect][parameter.name]
        assert abs(found["value"] - planted_value) < 3.5 * found["stderr"] < 0.6 * planted_value
        assert found["unit"] == parameter.unit.replace("unit", "dph")


def test_it_goes_on_from_what_is_there_unless_told_to_draw() -> None:
    """From the truth, with a network that is linear in its weights: the width stays, and chance has no part in it."""
    truth, runs, _ = planted("hysteresis")
    ends = []
    for seed in (1, 2):
        network = build("model", "polynomial", order=5)
        LeastSquares().fit(network, runs, Generator().manual_seed(1))
        hybrid = Hybrid(network, {"hysteresis": build("effects", "hysteresis")}, list(COLUMNS))
        hybrid.physics.load_state_dict(truth.state_dict())
        Alternating(draw=False).fit(hybrid, runs, Generator().manual_seed(seed))
        ends.append(torch.cat([one.detach().flatten() for one in hybrid.parameters()]))
        shape: Tensor = dict(hybrid.physics.named_effects())["hysteresis"].shape_value
        assert float(shape.detach()[0]) == pytest.approx(6.0, rel=0.1)
    assert torch.equal(*ends)


def settled_then(monkeypatch, event: str) -> tuple[list[Tensor], Hybrid]:
    """All weights as they were after each of three rounds, of which something goes wrong in the third, and the hybrid at the end."""
    _, runs, _ = planted("hysteresis")
    hybrid = Hybrid(build("model", "polynomial", order=5), {"hysteresis": build("effects", "hysteresis")}, list(COLUMNS))
    rounds: list[Tensor] = []

    def watched(model, features, target, weigh, steps) -> float:
        """χ² as it is; the first turn, before all rounds, counts as none, and χ² after the first round is made to look worse than it is."""
        left = descend(model, features, target, weigh, steps)
        rounds.append(torch.cat([one.detach().flatten() for one in hybrid.parameters()]))
        if len(rounds) == 4:
            if event == "breaks down":
                raise torch.linalg.LinAlgError("singular")
            with torch.no_grad():
                hybrid.network.weight += 1.0 if event == "is worse" else torch.nan
            return float(weigh((target - model.head(features).detach()).unsqueeze(1)).square().sum())
        return left * (2.0 if len(rounds) == 2 else 1.0)

    monkeypatch.setattr(alternating, "descend", watched)
    optimizer = Alternating()
    optimizer.fit(hybrid, runs, Generator().manual_seed(1))
    assert optimizer.solution is not None
    assert optimizer.physical("dph")["hysteresis"]["width"]["value"] == pytest.approx(
        float(dict(hybrid.physics.named_effects())["hysteresis"].shape_value.detach()[0]), rel=1e-9
    )
    return rounds[1:], hybrid


@pytest.mark.parametrize("event", ["is worse", "diverges", "breaks down"])
def test_the_best_round_is_kept_where_a_later_one(monkeypatch, event) -> None:
    rounds, hybrid = settled_then(monkeypatch, event)
    kept = torch.cat([one.detach().flatten() for one in hybrid.parameters()])
    assert len(rounds) == 3
    assert torch.equal(kept, rounds[1])


def test_a_network_that_diverges_at_once_fails(monkeypatch) -> None:
    _, runs, _ = planted("hysteresis")
    hybrid = Hybrid(build("model", "bp"), {"hysteresis": build("effects", "hysteresis")}, list(COLUMNS))
    monkeypatch.setattr(alternating, "descend", lambda *given: float("nan"))
    with pytest.raises(WorkError, match="training diverged: the network BP leaves"):
        Alternating().fit(hybrid, runs, Generator().manual_seed(1))


class Table(FeatureModel):
    """Knows its training data by heart: nothing in it is a weight."""

    def __init__(self) -> None:
        super().__init__()
        self.inputs = ["time_s", "temperature_c"]
        self.register_buffer("kept", torch.zeros(3, dtype=torch.float64))

    def features(self, x: Tensor) -> Tensor:
        return x[:, 1:]

    def head(self, features: Tensor) -> Tensor:
        return 0 * features[..., 0]

    def standardise(self, features: Tensor, error: Tensor) -> None: ...


def test_a_network_without_weights_is_refused_before_any_work() -> None:
    _, runs, _ = planted("hysteresis")
    hybrid = Hybrid(Table(), {"hysteresis": build("effects", "hysteresis")}, list(COLUMNS))
    with pytest.raises(InputError, match=r"model\.network: Table has no weights to train .*; possible: .*bp, polynomial or takagi_sugeno"):
        Alternating().fit(hybrid, runs, Generator())


def test_what_it_cannot_fit_is_named() -> None:
    truth, runs, _ = planted("hysteresis")
    with pytest.raises(InputError, match="model=hybrid"):
        Alternating().fit(truth, runs, Generator())
    with pytest.raises(InputError, match="GrayBox is no map of features"):
        Alternating().fit(Hybrid(truth, {"hysteresis": build("effects", "hysteresis")}, list(COLUMNS)), runs, Generator())
    assert Alternating().physical("dph") == {}
    with pytest.raises(InputError, match=r"optimizer\.rounds=0"):
        Alternating(rounds=0)


@pytest.mark.slow
def test_several_seeds_show_how_far_the_effect_and_the_network_share_it_otherwise(tmp_path) -> None:
    _, runs, _ = planted("hysteresis")
    hybrid = Hybrid(build("model", "bp"), {"hysteresis": build("effects", "hysteresis")}, list(COLUMNS))
    metrics = train(hybrid, runs, optimizer=Alternating(), out=tmp_path, seeds=2)
    one, both = metrics["physical"]["hysteresis"]["width"]["value"], metrics["members"]["physical"]["hysteresis"]["width"]
    other = 2 * both["median"] - one  # of two, the middle is the mean
    assert one != pytest.approx(other, rel=1e-6)
    assert both["low"] == pytest.approx(min(one, other) + 0.05 * abs(one - other))
    assert both["high"] == pytest.approx(max(one, other) - 0.05 * abs(one - other))
    assert metrics["members"]["best_seed"] in metrics["members"]["seeds"]
