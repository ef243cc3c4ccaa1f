"""Error bars that allow for the noise that is there, not only for the one that fits are weighted with."""

from __future__ import annotations

import copy
import math
from dataclasses import replace

import pytest
import torch
from torch import Generator, Tensor

from zoo.diagnosis.diagnose import diagnose
from zoo.diagnosis.parameters import SLOWLY_KNOWN, fitted_parameters, scores
from zoo.diagnosis.solved import Solved
from zoo.effects.bounds import to_unit
from zoo.fitting.parameters import ANYWHERE, parameters_of
from zoo.fitting.variable_projection import fit
from zoo.report.limits import beyond_plausible
from zoo.scoring.noise import NoiseModel

DRAWS = 30


def noisy(solved: Solved, noise: NoiseModel, theta: Tensor, chance: Generator) -> Solved:
    """The same model fitted to itself, at other nonlinear parameters, and another draw of noise."""
    design = copy.copy(solved.design)
    roots = [torch.linalg.cholesky(noise.covariance(blocks)) for blocks in solved.mixtures.runs]
    drawn = torch.cat([root @ torch.randn(len(root), generator=chance, dtype=torch.float64) for root in roots])
    design.error = design.plain_columns(theta.unsqueeze(0))[0] @ solved.fit.amplitudes + drawn
    design.target = design.whitener(design.error.unsqueeze(1)).squeeze(1)
    return replace(solved, design=design, fit=fit(design.plain_columns, design.target, theta, weigh=design.whitener))


@pytest.mark.parametrize("hidden", ["bias_step", "warm_up"])
def test_scores_of_a_fit_weighted_with_the_noise_that_is_there(diagnosis, hidden) -> None:
    """Whitened scores Jᵀr of white r have covariance JᵀJ."""
    found = diagnosis(hidden)
    final = found.search.final
    bench = found.bench.with_noise(final.likely.noise)
    solved = bench.solve(final.names, [final.fit.theta])
    assert solved.likely.noise == bench.noise
    jacobian = solved.fit.jacobian
    expected = SLOWLY_KNOWN * jacobian.mT @ jacobian
    size = jacobian.norm(dim=0).clamp_min(1e-300)
    assert torch.allclose(scores(solved) / size / size.unsqueeze(1), expected / size / size.unsqueeze(1), rtol=0, atol=1e-12)


def test_scores_of_a_fit_weighted_with_another_noise(diagnosis) -> None:
    """AᵀS⁻¹ΣS⁻¹A with A the columns, S the noise assumed and Σ the likeliest, all written out."""
    bench, solved = (made := diagnosis("")).bench, made.search.base
    assumed, likely = (torch.block_diag(*[one.covariance(run) for run in solved.mixtures.runs]) for one in (bench.noise, solved.likely.noise))
    assert float((assumed - likely).abs().max()) > 0.01 * float(assumed.abs().max())
    amplitudes = solved.fit.columns.shape[1]
    columns = torch.cat([solved.fit.plain[:, amplitudes:], solved.fit.plain[:, :amplitudes]], dim=1)
    weighted = torch.linalg.solve(assumed, columns)
    expected = SLOWLY_KNOWN * weighted.mT @ likely @ weighted
    free = ~solved.fit.edge.any(dim=0)
    known = torch.cat([free, torch.ones(amplitudes, dtype=torch.bool)])
    size = solved.fit.jacobian.norm(dim=0)[known]
    found, expected = (one[known][:, known] / size / size.unsqueeze(1) for one in (scores(solved), expected))
    assert torch.allclose(found, expected, rtol=0, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("walk", [0.0, 0.5])
def test_error_bars_cover_where_the_noise_is_slower_than_assumed(diagnosis, walk) -> None:
    """The static bias under a drawn noise that the fit is not weighted with: two standard errors hold 95 % of a normal variable.

    0.83 is that less three standard deviations of as many independent draws: the columns of one draw err together where the noise is slow.
    """
    found = diagnosis("")
    base, white = found.search.base, found.bench.mixtures.white
    noise = NoiseModel(white, 0.42 * white, walk * white)
    theta, chance = base.fit.theta.clamp(0.1, 0.9), Generator().manual_seed(1)
    truth = base.fit.amplitudes[base.places()["static_bias"]].tolist()
    errors = []
    for _ in range(DRAWS):
        said = fitted_parameters(noisy(base, noise, theta, chance), "dph")["static_bias"].values()
        errors += [(one["value"] - true) / one["stderr"] for one, true in zip(said, truth, strict=True)]
    assert sum(abs(error) < 2 for error in errors) > 0.83 * len(errors)
    assert 0.6 < math.sqrt(sum(error**2 for error in errors) / len(errors)) < 1.4, "nor are they much too wide"


@pytest.mark.slow
@pytest.mark.parametrize("bend", [-0.4, 0.5])
def test_error_bars_hold_both_laws_of_an_ageing_that_looks_like_either(diagnosis, bend) -> None:
    """Weak ageing by a logarithm is often fitted by a power, and the other way about, many of a parabola's errors away."""
    found = diagnosis("aging")
    assert found.record["missing"] == ["aging"]
    final, chance, errors = found.search.final, Generator().manual_seed(1), []
    shape = dict(final.model.named_effects())["aging"].shape
    bends = torch.tensor([bend, -0.5, -0.1, 0.3], dtype=torch.float64)
    ages = torch.stack([bends, torch.zeros_like(bends)], dim=1)
    truth, *starts = torch.cat([final.fit.theta[:-2].expand(4, -1), to_unit(ages, shape)], dim=1)
    for _ in range(DRAWS):
        drawn = noisy(final, found.bench.noise, truth, chance)
        design = drawn.design
        fits = [drawn.fit, *(fit(design.plain_columns, design.target, start, weigh=design.whitener) for start in starts)]
        said = fitted_parameters(replace(drawn, fit=min(fits, key=lambda one: one.total)), "dph")["aging"]["bend"]
        errors.append(abs(said["value"] - bend) / said["stderr"])
    assert max(errors) < 3


def test_of_what_the_runs_say_nothing_no_error_is_told(diagnosis) -> None:
    """A parameter by which a model moves by next to nothing has a finite error of many times its range."""
    solved = diagnosis("").search.base
    one, covariance = solved.model.parameters_of_theta()[0], solved.fit.covariance()
    known = covariance.clone()
    known[0, 0] = 1.0
    covariance[0, 0] = (2 * ANYWHERE) ** 2
    told = [parameters_of(solved.model, solved.fit, "dph", some)[one[0]][one[1].name]["stderr"] for some in (known, covariance)]
    assert told[0] > 0
    assert told[1] is None


@pytest.mark.slow
@pytest.mark.parametrize(("width", "at_bound"), [(8.0, None), (60.0, "high")])
def test_what_the_runs_want_beyond_its_bounds_is_marked(simulation, with_error_of, catalogue, base, white, width, at_bound) -> None:
    """A transition of 60 K is no glass transition of a potting: with 20 K it explains most of it, and whoever reads is warned."""
    runs = with_error_of(simulation().runs, lambda coil, rate: torch.sigmoid((coil - 20.0) / width) * rate, 20 * white)
    found = diagnose(runs, base, {name: catalogue[name] for name in (*base, "glass_transition")}).record
    assert found["missing"] == ["glass_transition"]
    assert found["parameters"]["glass_transition"]["width"].get("at_bound") == at_bound
    (entry,) = (one for one in found["candidates"] if one["effect"] == "glass_transition")
    assert entry["parameters"] == found["parameters"]["glass_transition"]
    assert bool(beyond_plausible(found, found["missing"])) is bool(at_bound)
