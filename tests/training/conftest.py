import pytest
import torch

from zoo.measurements.run import Run
from zoo.physics.differentiator import temperature_rate


@pytest.fixture
def make_run():
    """A chamber run of a gyro whose error is k1 + k2·T + k3·dT/dt + bend·tanh(T/20) plus white noise, known exactly."""

    def make(name="run_1", low=-20.0, high=40.0, noise=0.0, bend=0.0, seed=1, hours=3.0, step_s=10.0, average_s=100.0):
        time = torch.arange(step_s / 2, hours * 3600, step_s, dtype=torch.float64)
        phase = (time / time[-1] * 4 - 0.5).clamp(0, 3)
        temperature = low + (high - low) * (phase.clamp(max=1) - (phase - 2).clamp(min=0))
        rate = temperature_rate(time, temperature)
        chance = torch.Generator().manual_seed(seed)
        white = noise * torch.randn(len(time), generator=chance, dtype=torch.float64)
        error = 0.3 + 0.02 * temperature - 0.15 * rate + bend * torch.tanh(temperature / 20) + white
        table = torch.stack([time, temperature, torch.zeros_like(time)], dim=-1)
        block = (time // average_s).long()
        columns = ("time_s", "temperature_c", "reference_dph")
        return Run(name, "dph", average_s, columns, table, error, torch.ones_like(time), block, rows=len(time))

    return make
