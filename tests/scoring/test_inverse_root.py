"""The inverse root of a covariance multiplies like the matrix it is, whatever noise it stands for."""

from __future__ import annotations

import pytest
import torch

from zoo.scoring.inverse_root import ROWS, STATES, InverseRoot
from zoo.scoring.noise import Blocks, NoiseModel


def times(count: int, uneven: bool) -> torch.Tensor:
    """Centres of blocks of 100 s; where uneven, with a gap of an hour and a third of a block."""
    time = 100.0 * torch.arange(count, dtype=torch.float64) + 50.0
    return torch.cat([time[: count // 2], time[count // 2 :] + 3633.0]) if uneven else time


@pytest.mark.parametrize("count", [1, 5, ROWS, 2 * ROWS + 1, 430, 1000])
@pytest.mark.parametrize("noise", [NoiseModel(1.0, 0.0), NoiseModel(1.0, 0.18, 0.1), NoiseModel(0.01, 0.014, 0.016)])
@pytest.mark.parametrize("uneven", [False, True])
def test_the_product_is_that_of_the_matrix(count: int, noise: NoiseModel, uneven: bool) -> None:
    time = times(count, uneven)
    covariance = noise.covariance(Blocks(time, torch.ones_like(time), 0.0))
    root, columns = InverseRoot(covariance), torch.randn(count, 7, dtype=torch.float64, generator=torch.Generator().manual_seed(1))
    torch.testing.assert_close(root @ columns, root.matrix @ columns, rtol=1e-10, atol=1e-10 / noise.white)
    torch.testing.assert_close(root.matrix @ covariance @ root.matrix.mT, torch.eye(count, dtype=torch.float64), rtol=0, atol=1e-9)
    single = root @ columns.float()
    assert single.dtype == torch.float32
    torch.testing.assert_close(single.double(), root.matrix @ columns, rtol=1e-4, atol=1e-4 / noise.white)


def test_a_covariance_without_states_is_multiplied_as_it_is() -> None:
    """Of noise that no few states describe, the past of a band has full rank."""
    drawn = torch.randn(300, 300, dtype=torch.float64, generator=torch.Generator().manual_seed(2))
    root = InverseRoot(drawn @ drawn.mT + 300.0 * torch.eye(300, dtype=torch.float64))
    assert torch.linalg.matrix_rank(root.matrix[ROWS : 2 * ROWS, :ROWS]) > STATES
    columns = torch.randn(300, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(3))
    torch.testing.assert_close(root @ columns, root.matrix @ columns, rtol=1e-11, atol=1e-12)
