"""What drawn gyros show is of the size that their class is known for."""

from __future__ import annotations

import pytest
import torch
from torch import Tensor

from zoo.catalog import build
from zoo.effects.base import History
from zoo.simulator.draws import Scene, draw_amplitude, draw_shape
from zoo.simulator.gyros.device import draw
from zoo.simulator.gyros.presets import gyro_class

GYROS = 60
SCENE = Scene(3, 25_000.0, -40.0, 60.0, 0.0)


def loop(shape: Tensor) -> float:
    """Half the height of the loop that a full cycle of temperature runs through, of unit amplitude."""
    up = torch.linspace(-60.0, 100.0, 801, dtype=torch.float64)
    temperature = torch.cat([up, up.flip(0)])
    nothing = torch.zeros_like(temperature)
    history = History(torch.arange(len(temperature), dtype=torch.float64), temperature, nothing, nothing, temperature, nothing)
    there, back = build("effects", "hysteresis").columns(history, shape).squeeze(-1).chunk(2)
    return float((there - back.flip(0)).abs().max()) / 2


@pytest.mark.parametrize(("name", "low", "high"), [("medium", 0.002, 0.02), ("tactical", 0.05, 0.5)])
def test_hysteresis_opens_loops_of_the_known_width(name: str, low: float, high: float) -> None:
    """`docs/physics.md` 7 and 10.5: half-widths of 0.002 to 0.02 °/h in a medium gyro, of 0.05 to 0.5 °/h in a tactical one."""
    effect, halves = build("effects", "hysteresis"), []
    for seed in range(GYROS):
        amplitude = draw_amplitude("hysteresis", effect, draw(gyro_class(name), seed))
        assert amplitude is not None
        halves.append(abs(float(amplitude[0])) * loop(draw_shape("hysteresis", effect, SCENE, seed)))
    middle = torch.tensor(halves).median()
    assert (low * high) ** 0.5 / 1.5 < middle < (low * high) ** 0.5 * 1.5, "in the middle of the range, on its logarithmic scale"
    assert sum(low / 2 < half < high * 2 for half in halves) > 0.9 * GYROS


@pytest.mark.parametrize("seed", range(3))
def test_what_is_about_known_beforehand_is_as_in_most_gyros(seed) -> None:
    """A warm-up's time is drawn, its ratio and what a cold start does are not: a seed keeps its gyro."""
    effect = build("effects", "warm_up")
    time, *others = draw_shape("warm_up", effect, SCENE, seed).tolist()
    assert others == [one.default for one in effect.shape[1:]]
    assert time != effect.shape[0].default
