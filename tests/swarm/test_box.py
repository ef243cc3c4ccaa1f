"""Walls."""

import torch

from zoo.swarm.box import reflected


def test_walls_reflect_and_who_comes_back_beyond_the_opposite_stays_at_it() -> None:
    low, high = torch.tensor([10.0]), torch.tensor([14.0])
    position = torch.tensor([[9.0], [15.5], [12.0], [10.0], [14.0], [3.0], [40.0]])
    expected = torch.tensor([[11.0], [12.5], [12.0], [10.0], [14.0], [14.0], [10.0]])
    torch.testing.assert_close(reflected(position, low, high), expected, rtol=0, atol=0)
