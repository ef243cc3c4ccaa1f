"""Where in the space of its shapes an effect explains most."""

from dataclasses import replace

import pytest
import torch

from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.screening import Here

BLOCK_S = 100.0


def paused(run, pause_s=15.0):
    """The same run from a recorder that stood still in the middle: from there on its blocks begin at other times."""
    time = run.time + pause_s * (torch.arange(len(run.time)) > len(run.time) // 2)
    return replace(run, table=torch.cat([time.unsqueeze(1), run.table[:, 1:]], dim=1))


@pytest.mark.parametrize("image_s", [160.0, 180.0, 190.0])
def test_a_line_is_not_taken_for_its_image_below_the_blocks(runs, white, catalogue, base, image_s) -> None:
    """Means over b show a line of period P where they show 1/(1/b − 1/P): where the grid meets that closer, only the pause tells the two apart."""
    given = [paused(run) for run in runs()]
    bench = open_bench(given, base, catalogue)
    grid = 1 / bench.shapes("chamber_cycling").squeeze(-1)
    line = 1 / BLOCK_S - grid[(grid - 1 / image_s).abs().argmin()]
    told = [replace(run, error=run.error + 3 * white * torch.sin(2 * torch.pi * run.time * line)) for run in given]
    bench = open_bench(told, base, catalogue)
    found = Here(bench, bench.begin(tuple(base))).screened("chamber_cycling")
    assert 1 / float(found.shape) == pytest.approx(float(line), abs=0.25 / bench.span_s)
