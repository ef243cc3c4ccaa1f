import pytest
import torch


@pytest.fixture
def raw():
    """Raw columns of a lively run with uneven steps, in the order asked for."""

    def make(names, samples=600, seed=1):
        chance = torch.Generator().manual_seed(seed)
        time = (0.5 + torch.rand(samples, generator=chance, dtype=torch.float64)).cumsum(0) * 10
        columns = {"time_s": time}
        for position, name in enumerate(name for name in names if name != "time_s"):
            walk = torch.randn(samples, generator=chance, dtype=torch.float64).cumsum(0)
            columns[name] = 20 + 25 * torch.sin(time / 700 + position) + 0.1 * walk
        return torch.stack([columns[name] for name in names], dim=-1)

    return make
