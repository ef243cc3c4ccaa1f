"""What was planted in a residual is named, and noise goes with nothing."""

import pytest
import torch

from zoo.scoring.dependence import shares

CHANCE = torch.Generator().manual_seed(1)
TEMPERATURE = 60 * torch.rand(2000, generator=CHANCE, dtype=torch.float64) - 20
TIME = torch.arange(2000, dtype=torch.float64)
NOISE = torch.randn(2000, generator=CHANCE, dtype=torch.float64)
QUANTITIES = {"temperature": TEMPERATURE, "time": TIME}


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_a_planted_share_is_found(share: float) -> None:
    curve = (TEMPERATURE / 20).sin()
    curve = (curve - curve.mean()) / curve.std()
    found = shares(share**0.5 * curve + (1 - share) ** 0.5 * NOISE, QUANTITIES)
    assert next(iter(found)) == "temperature"
    assert found["temperature"] == pytest.approx(share, abs=0.07)  # eight steps are not quite the curve
    assert max(found["time"], found["constant"]) < 0.03


def test_noise_goes_with_nothing() -> None:
    assert max(shares(NOISE, QUANTITIES).values()) < 0.01


def test_a_constant_is_one() -> None:
    assert shares(torch.full((500,), 3.0, dtype=torch.float64), {"time": TIME[:500]}) == {"constant": 1.0, "time": 0.0}
    assert shares(2 + NOISE, QUANTITIES)["constant"] == pytest.approx(0.8, abs=0.03)


def test_a_quantity_that_does_not_vary_explains_nothing() -> None:
    assert shares(NOISE, {"supply": torch.full_like(NOISE, 5.0)})["supply"] < 1e-20


def test_ten_hours_at_some_hundred_hertz_are_not_too_many() -> None:
    """Torch's own quantiles take no more than 2²⁴ values."""
    rising = torch.arange(2.0**24 + 1, dtype=torch.float32)
    assert shares((rising > rising.mean()).to(torch.float64), {"time": rising})["time"] == pytest.approx(0.5, abs=1e-3)  # the mean is the other half
