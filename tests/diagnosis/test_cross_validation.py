"""Pieces predicted with what the others know: no better than what was fitted, and what the others do not know is not made up."""

from __future__ import annotations

import pytest
import torch
from torch import Generator, Tensor

from zoo.diagnosis.cross_validation import _left_out

N, PIECES = 400, 8


def noise(seed: int = 1) -> Tensor:
    return torch.randn(N, generator=Generator().manual_seed(seed), dtype=torch.float64)


def pieces() -> list[Tensor]:
    return list(torch.arange(N).tensor_split(PIECES))


def slow() -> Tensor:
    time = torch.linspace(0, 1, N, dtype=torch.float64)
    return torch.stack([torch.ones_like(time), time], dim=1)


@pytest.mark.parametrize("size", [1.0, 1e3, 1e6])
def test_of_what_all_pieces_show_it_is_least_squares_without_the_piece(size) -> None:
    """However large the amplitudes: what is reckoned as seen to be 0 must not pull at them."""
    columns = slow()
    target = columns @ torch.tensor([2.0, -3.0], dtype=torch.float64) * size + noise()
    found = _left_out(columns, target, pieces())
    for part, errors in zip(pieces(), found.split([len(part) for part in pieces()]), strict=True):
        keep = torch.ones(N, dtype=torch.bool)
        keep[part] = False
        alone = torch.linalg.lstsq(columns[keep], target[keep].unsqueeze(1)).solution.squeeze(1)
        torch.testing.assert_close(errors, target[part] - columns[part] @ alone, rtol=0, atol=2e-3 * max(size, 1.0))


@pytest.mark.parametrize("decay", [0.05, 0.02, 0.005])
def test_what_only_the_piece_itself_shows_is_predicted_as_nothing(decay) -> None:
    """A fast decay, of which the later pieces hold e^−5 to e^−50: noise there must not be blown up to a prediction of the first one."""
    early = torch.exp(-torch.linspace(0, 1, N, dtype=torch.float64) / decay).unsqueeze(1)
    columns, target = torch.cat([slow(), early], dim=1), noise() + 5.0 * early.squeeze(1)
    first = pieces()[0]
    found = _left_out(columns, target, pieces())[: len(first)]
    without = _left_out(slow(), noise(), pieces())[: len(first)] + 5.0 * early[first].squeeze(1)
    assert float(found.square().mean().sqrt()) < 1.5 * float(without.square().mean().sqrt())


def test_columns_that_repeat_each_other_or_are_nothing_do_no_harm() -> None:
    columns = torch.cat([slow(), slow(), torch.zeros(N, 1, dtype=torch.float64)], dim=1)
    torch.testing.assert_close(_left_out(columns, noise(), pieces()), _left_out(slow(), noise(), pieces()), rtol=0, atol=1e-3)


def test_a_step_in_the_piece_that_is_left_out_is_not_set_against_the_bias_there() -> None:
    last = pieces()[-1]
    step = torch.zeros(N, 1, dtype=torch.float64)
    step[last[5:]] = 1.0
    columns, target = torch.cat([slow(), step], dim=1), 100.0 + 3.0 * step.squeeze(1) + noise()
    found, without = (_left_out(some, target, pieces())[last] for some in (columns, slow()))
    assert float(found.square().mean().sqrt()) < 1.05 * float(without.square().mean().sqrt())
