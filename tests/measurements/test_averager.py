"""Means over blocks are weighted means, however wide what they are of, with samples left out and several records at once."""

from __future__ import annotations

import subprocess
import sys

import pytest
import torch
from torch import Generator, Tensor

from zoo.measurements.averager import NARROW, Averager

BLOCK = torch.tensor([0, 0, 0, -1, 1, 1, 2, -1, 2, 2])
WEIGHT = torch.tensor([1.0, 2.0, 1.0, 5.0, 1.0, 3.0, 1.0, 9.0, 1.0, 2.0], dtype=torch.float64)


def values(*shape: int, seed: int = 1) -> Tensor:
    return torch.randn(len(BLOCK), *shape, generator=Generator().manual_seed(seed), dtype=torch.float64)


def by_hand(value: Tensor) -> Tensor:
    means = []
    for block in range(3):
        own = WEIGHT * (block == BLOCK)
        means.append(torch.einsum("t,t...->...", own, value) / own.sum())
    return torch.stack(means)


@pytest.mark.parametrize("shape", [(), (1,), (4, 3), (NARROW,), (NARROW + 1,), (30, 40)])
def test_they_are_weighted_means_of_the_samples_that_belong_to_a_block(shape) -> None:
    value = values(*shape)
    found = Averager.weighted(BLOCK, WEIGHT)(value)
    torch.testing.assert_close(found, by_hand(value), rtol=1e-13, atol=1e-13)
    constant = torch.full_like(value, 20.1)
    torch.testing.assert_close(Averager.weighted(BLOCK, WEIGHT)(constant), torch.full_like(found, 20.1), rtol=1e-14, atol=0)


def test_samples_of_a_block_need_not_be_together() -> None:
    order = torch.randperm(len(BLOCK), generator=Generator().manual_seed(3))
    value = values(2)
    found = Averager.weighted(BLOCK[order], WEIGHT[order])(value[order])
    torch.testing.assert_close(found, by_hand(value), rtol=1e-13, atol=1e-13)


def test_single_precision_is_kept_and_gradients_pass() -> None:
    averager = Averager.weighted(BLOCK, WEIGHT)
    assert averager(values(2).float()).dtype == torch.float32
    value = values(2).requires_grad_()
    averager(value).sum().backward()
    assert value.grad is not None
    torch.testing.assert_close(value.grad[:, 0], averager.share.new_zeros(len(BLOCK)).index_add(0, averager.sample, averager.share))


@pytest.mark.parametrize("width", [2, NARROW + 1])
def test_several_records_joined_are_each_alone(width) -> None:
    """The second is longer; what pads the first belongs to no block."""
    longer = torch.cat([BLOCK, torch.tensor([3, 3])])
    both = Averager.joined([Averager.weighted(BLOCK, WEIGHT), Averager.weighted(longer, torch.ones(12, dtype=torch.float64))], 12)
    padded, other = torch.nn.functional.pad(values(width), (0, 0, 0, 2), value=1e9), torch.randn(12, width, dtype=torch.float64)
    found = both(torch.cat([padded, other]))
    torch.testing.assert_close(found[:3], by_hand(values(width)), rtol=1e-13, atol=1e-13)
    torch.testing.assert_close(found[3:], Averager.weighted(longer, torch.ones(12, dtype=torch.float64))(other), rtol=1e-13, atol=1e-13)


def test_nobody_is_told_that_a_matrix_of_torch_is_a_beta() -> None:
    """It warns once a process."""
    program = (
        "import torch; from zoo.measurements.averager import Averager; "
        "Averager.weighted(torch.tensor([0, 0, 1]), torch.ones(3, dtype=torch.float64))(torch.ones(3, 1, dtype=torch.float64))"
    )
    done = subprocess.run([sys.executable, "-W", "error::UserWarning", "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_record_without_a_block_has_no_mean() -> None:
    found = Averager.weighted(torch.full((5,), -1), torch.ones(5, dtype=torch.float64))(torch.ones(5, 2, dtype=torch.float64))
    assert found.shape == (0, 2)
