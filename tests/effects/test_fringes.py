"""Interference fringes: waves in temperature."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch
from torch import Tensor

from zoo.catalog import build
from zoo.effects.polarization import APART, LONGEST_K


def shape_of(*values: float) -> Tensor:
    return torch.tensor(values, dtype=torch.float64)


def test_by_default_it_is_a_fundamental_with_its_harmonics(seen) -> None:
    effect = build("effects", "polarization")
    history = seen(effect)
    phase = 2 * torch.pi * (history.temperature - 20.0) / 12.0
    waves = [wave(h * phase) for h in (1, 2, 3) for wave in (torch.cos, torch.sin)]
    torch.testing.assert_close(effect.columns(history, effect.shape_value.detach()), torch.stack(waves, -1), rtol=0, atol=1e-12)


def test_each_line_is_periodic_in_temperature(seen) -> None:
    effect = build("effects", "polarization")
    history, shape = seen(effect), shape_of(12.0, 0.7, 2.6, 0.0)
    columns = effect.columns(history, shape)
    for line, ratio in enumerate((1.0, 0.7, 2.6)):
        shifted = effect.columns(replace(history, temperature=history.temperature + 12.0 / ratio), shape)
        own = slice(2 * line, 2 * line + 2)
        torch.testing.assert_close(shifted[:, own], columns[:, own], rtol=0, atol=1e-9)
        torch.testing.assert_close(columns[:, own].square().sum(1), torch.ones_like(history.time))
        others = [i for i in range(6) if i not in (2 * line, 2 * line + 1)]
        assert float((shifted - columns)[:, others].abs().max()) > 0.1


def test_the_phase_is_the_same_up_and_down(seen, warped) -> None:
    effect = build("effects", "polarization")
    up = torch.linspace(0, 40, 51, dtype=torch.float64)
    course = torch.cat([up, up.flip(0)[1:]])
    fringes = effect.columns(warped(seen(effect), torch.arange(len(course), dtype=torch.float64), course), shape_of(12.0, 0.7, 2.6, 0.0))
    torch.testing.assert_close(fringes, fringes.flip(0), rtol=0, atol=1e-9)


def test_a_search_tries_one_line_first_and_then_a_second_and_a_third_beside_it() -> None:
    effect = build("effects", "polarization")
    tried = effect.shapes_to_try(3e4, 3)
    assert bool((tried[:, 1:3] == 1.0).all()), "three lines in one place are one line"
    assert float(torch.diff(1 / tried[:, 0]).abs().max()) * 100 < 0.5, "half a fringe in 100 K"
    for best in (tried[10], tried[60], tried[95]):
        inside = [one for one in (best[0] / tried[:, 0]).tolist() if 0.3 <= one <= 4.0 and abs(one - 1) > APART]
        seconds = effect.shapes_near(best, 3e4)
        assert torch.equal(seconds[0], best)
        moved = [seconds[seconds[:, place] != best[place]] for place in range(4)]
        assert [len(one) > 0 for one in moved] == [False, True, False, True], "another second line, or another place"
        assert sorted(moved[1][:, 1].tolist()) == pytest.approx(sorted([*inside, 2.0, 3.0]))
        thirds = effect.shapes_near(moved[1][5], 3e4)
        assert bool((thirds[:, 1] == moved[1][5, 1]).all())
        apart = [one for one in [*inside, 2.0, 3.0] if abs(one / float(moved[1][5, 1]) - 1) > APART]
        assert sorted(thirds[thirds[:, 2] != 1.0][:, 2].tolist()) == pytest.approx(sorted(apart))
        whole = thirds[thirds[:, 2] != 1.0][5]
        again = effect.shapes_near(whole, 3e4)
        assert [bool((again[:, place] != whole[place]).any()) for place in range(4)] == [False, True, True, True]


@pytest.mark.parametrize("ratio", [1.0 + 0.9 * APART, 1.0 - 0.9 * APART, 0.5])
def test_a_line_beside_the_first_or_a_very_long_one_is_the_first(seen, ratio) -> None:
    """Else two lines of nearly one period cancel to whatever is slow, at amplitudes of a thousand times what they explain."""
    effect = build("effects", "polarization")
    columns = effect.columns(seen(effect), shape_of(0.9 * LONGEST_K, ratio, 3.0, 0.0))
    torch.testing.assert_close(columns[..., 2:4], columns[..., :2])


def test_a_lead_is_the_temperature_of_a_place_ahead(seen) -> None:
    effect = build("effects", "polarization")
    history, shape = seen(effect), shape_of(12.0, 2.0, 3.0, 120.0)
    ahead = replace(history, temperature=history.temperature + 2.0 * history.rate)
    torch.testing.assert_close(effect.columns(history, shape), effect.columns(ahead, shape_of(12.0, 2.0, 3.0, 0.0)))
