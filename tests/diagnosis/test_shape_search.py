"""Where in the space of its shapes an effect explains most."""

from dataclasses import replace

import pytest
import torch

from zoo.diagnosis.diagnose import open_bench
from zoo.diagnosis.screening import Here
from zoo.diagnosis.shape_search import FITS, apart
from zoo.diagnosis.trials import round_of
from zoo.effects.base import Effect, History, Parameter
from zoo.simulator.in_process import as_run

BLOCK_S = 100.0


class Bump(Effect):
    """A·exp(−((T − T0)/w)²/2): a cubic bias takes up much of one, and what it leaves looks like a bump elsewhere."""

    name = "bump"
    place = "coil"
    shape = (
        Parameter("centre", 10.0, "°C", -30.0, 50.0, source="a user's", meaning="T0"),
        Parameter("width", 5.0, "K", 2.0, 15.0, "log", source="a user's", meaning="w"),
    )
    amplitudes = (Parameter("height", 0.0, "unit", -10.0, 10.0, source="a user's", meaning="A"),)
    formula, source, signature, confused_with = "A·exp(−((T − T0)/w)²/2)", "a user", "a bump at one temperature", ("polarization",)

    def columns(self, history: History, shape: torch.Tensor) -> torch.Tensor:
        return torch.exp(-(((history.temperature - shape[..., 0:1]) / shape[..., 1:2]) ** 2) / 2).unsqueeze(-1)


@pytest.mark.parametrize(("seed", "centre"), [(11, 10.4), (14, -2.2)])
def test_of_two_minima_the_lower_is_found(simulation, base, catalogue, seed, centre) -> None:
    """The grid of an effect of one's own is coarse: where it is lowest another minimum may lie, far above."""
    runs = []
    for one in simulation(seed=seed).runs:
        coil = one.truth["temperature_coil_c"]
        runs.append(replace(as_run(one), error=as_run(one).error + 0.22 * torch.exp(-(((coil - centre) / 8.4) ** 2) / 2)))
    bench = open_bench(runs, base, {**{name: catalogue[name] for name in base}, "bump": Bump()})
    model = round_of(bench, bench.begin(tuple(base)), ["bump"], 3.0, lambda told: None).trials[0].solved.model
    assert float(dict(model.named_effects())["bump"].shape_value[0].detach()) == pytest.approx(centre, abs=1.0)


def test_shapes_to_start_from_are_apart_and_the_cheapest_first(catalogue) -> None:
    effect = Bump()
    shapes = effect.shapes_to_try(36000.0, 2)
    costs = (shapes[:, 0] - 11.0).square() + shapes[:, 1]
    found = apart(effect, shapes, costs, 36000.0)
    assert len(found) == FITS
    assert found[0] == int(costs.argmin())
    assert costs[found].tolist() == sorted(costs[found].tolist())
    close = torch.cat([shapes, shapes[found[0]] + torch.tensor([[0.5, 0.0]])])
    cheap = torch.cat([costs, costs[found[:1]] + 1e-3])
    assert apart(effect, close, cheap, 36000.0) == found, "what is next to the best leads where that does"
    assert len(apart(effect, shapes[:1], costs[:1], 36000.0)) == 1, "no more than there are"
    fringes = catalogue["polarization"]
    grid = fringes.shapes_to_try(36000.0, 2)
    assert len(apart(fringes, grid, torch.arange(float(len(grid))), 36000.0)) == 1, "it says itself what is near"


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
