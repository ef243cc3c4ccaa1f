"""The wavelet network: Morlet's wavelet, the freedom between its weights, and the curve of hui2016."""

from __future__ import annotations

import math
from functools import partial

import pytest
import torch
from torch import Generator, Tensor

from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.models.wavelet import LEAST, Morlet, Wavelet
from zoo.simulator.accelerometer.runs import simulate_accelerometer
from zoo.training.random_init import RandomInit
from zoo.training.run import train
from zoo.training.weights import reset


def alone(weight: list[float], translation: float, dilation: float) -> Morlet:
    """One neuron."""
    neuron = Morlet(len(weight), 1)
    neuron.weight.data = torch.tensor([weight], dtype=torch.float64)
    neuron.translation.data.fill_(translation)
    neuron.log_dilation.data.fill_(math.log(dilation - LEAST))
    return neuron


def test_a_neuron_is_morlets_wavelet_moved_and_stretched() -> None:
    """Values of cos(1.75u)·exp(−u²/2) by hand: 1 in the middle, 0 at u = π/3.5, −e^{−(4π/7)²/2} at u = 4π/7, where the cosine is −1."""
    neuron = alone([2.0, -1.0], translation=0.5, dilation=3.0)
    for u, value in ((0.0, 1.0), (math.pi / 3.5, 0.0), (-4 * math.pi / 7, -math.exp(-((4 * math.pi / 7) ** 2) / 2))):
        x = torch.tensor([[3.0 * u + 0.5, 3.0 * u + 0.5]], dtype=torch.float64)  # w·x = x_1 where both are alike
        assert float(neuron(x).detach()) == pytest.approx(value, abs=1e-12)


def test_weights_translation_and_dilation_may_be_stretched_together() -> None:
    x = torch.randn(50, 2, generator=Generator().manual_seed(1), dtype=torch.float64)
    torch.testing.assert_close(alone([0.3, 0.8], 0.2, 0.6)(x), alone([3.0, 8.0], 2.0, 6.0)(x))


def test_no_step_takes_a_dilation_to_zero() -> None:
    x = torch.linspace(-2, 2, 50, dtype=torch.float64).unsqueeze(-1)
    neuron = alone([1.0], 0.1, 0.5)
    neuron.log_dilation.data -= 1e6
    value = neuron(x).sum()
    value.backward()
    assert float(neuron.dilation().detach()) == LEAST
    assert all(bool(torch.isfinite(parameter.grad).all()) for parameter in neuron.parameters() if parameter.grad is not None)


def test_a_start_covers_the_inputs_once_and_depends_on_the_generator_alone() -> None:
    one, two = Wavelet(["temperature", "temperature_rate"], 8), Wavelet(["temperature", "temperature_rate"], 8)
    reset(one, Generator().manual_seed(4))
    reset(two, Generator().manual_seed(4))
    assert all(torch.equal(a, b) for a, b in zip(one.parameters(), two.parameters(), strict=True))
    torch.testing.assert_close(one.hidden.weight.norm(dim=1), torch.ones(8, dtype=torch.float64))
    part = ((one.hidden.translation + 2) / 0.5).floor()
    assert part.tolist() == list(range(8))
    torch.testing.assert_close(one.hidden.dilation(), torch.full((8,), 0.5, dtype=torch.float64))


def test_far_away_the_wavelets_are_gone_and_the_line_goes_on() -> None:
    given = torch.linspace(-40, 60, 200, dtype=torch.float64).unsqueeze(-1)
    error = 3 + 0.1 * given[:, 0]
    far = torch.tensor([[5000.0], [6000.0]], dtype=torch.float64)
    plain, lined = Wavelet(["temperature"]), Wavelet(["temperature"], linear=True)
    for model in (plain, lined):
        reset(model, Generator().manual_seed(1))
        model.standardise(given, error)
    assert plain.head(far).tolist() == [float(error.mean())] * 2
    slope = float(lined.linear.weight.detach()) * float(error.std(correction=0)) / float(given.std(correction=0))
    assert float(lined.head(far).diff().detach()) == pytest.approx(1000 * slope)


def power_on() -> Run:
    """The 48 counts of hui2016."""
    recorded = simulate_accelerometer().runs[0]
    columns = ("time_s", "temperature_c", "reference_pulses")
    table = torch.stack([recorded.table[name] for name in columns], dim=-1)
    return Run("run_1", "pulses", 10.0, columns, table, recorded.error, torch.ones(len(table), dtype=torch.int64), torch.arange(len(table)))


def beside_the_line(run: Run) -> float:
    """Variance that a line of temperature leaves [pulses²]; the paper has 0.138."""
    columns = torch.stack([torch.ones_like(run.temperature), run.temperature], dim=-1)
    left: Tensor = run.error - columns @ torch.linalg.lstsq(columns, run.error.unsqueeze(-1), driver="gelsd").solution.squeeze(-1)
    return float(left.var(correction=0))


@pytest.mark.parametrize(
    ("optimizer", "epochs"),
    [
        (partial(torch.optim.LBFGS, line_search_fn="strong_wolfe", tolerance_grad=1e-9), 50),
        (partial(torch.optim.SGD, lr=0.1, momentum=0.9), 1000),
    ],
    ids=["lbfgs", "gradient descent"],
)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_it_leaves_a_thousandth_of_what_the_line_leaves_of_hui2016(optimizer, epochs, seed, tmp_path) -> None:
    run, model = power_on(), Wavelet(["temperature"])
    train(model, [run], optimizer=optimizer, init=RandomInit(seed), epochs=epochs, seed=seed, out=tmp_path)
    left = run.error - model(run.select(model.inputs)).detach()
    assert beside_the_line(run) == pytest.approx(0.138, rel=0.02)
    assert float(left.var(correction=0)) < 1e-3 * beside_the_line(run)


def test_a_network_without_neurons_is_named() -> None:
    with pytest.raises(InputError, match=r"model\.hidden=0"):
        Wavelet(["temperature"], hidden=0)
