"""The expected evidence: against brute force, and what it must be for twins and for louder signals."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from zoo.diagnosis.experiment.circumstances import circumstances_of
from zoo.diagnosis.experiment.evidence import FREE, Old, answer, difference, told_apart
from zoo.diagnosis.experiment.family import Candidate, family
from zoo.diagnosis.experiment.prediction import Predicted, predicted
from zoo.diagnosis.experiment.refit import told_by_refit
from zoo.diagnosis.solved import Solved
from zoo.diagnosis.workbench import Workbench
from zoo.fitting.projection import complement, orthonormal


def chosen(bench: Workbench, name: str) -> Predicted:
    known = circumstances_of(bench.runs)
    one: Candidate = next(one for one in family(known) if one.name.startswith(name))
    return predicted(bench.runs, bench.noise, known, one)


FLIP, TWO = "a cycle at 1 K/min, the axis", "two cycles, at 3 and at 0.5 K/min"


def test_it_is_what_a_fit_to_all_runs_at_once_leaves(bench: Workbench, rivals: list[Solved]) -> None:
    new, old = chosen(bench, FLIP), Old([[one] for one in rivals])
    answers = [[answer(one, new)] for one in rivals]
    told = told_apart(old, answers)
    truth, other = rivals
    before = torch.cat([other.fit.columns, other.fit.tangent], dim=1)
    held = torch.eye(before.shape[1], dtype=torch.float64)[-len(other.fit.theta) :] / FREE
    signal = truth.fit.columns @ truth.fit.amplitudes
    together = orthonormal(torch.cat([before, answers[1][0].columns, held]))
    target = torch.cat([signal, answers[0][0].signal, torch.zeros(len(held), dtype=torch.float64)]).unsqueeze(1)
    left = float(complement(target, together).square().sum()) - float(complement(signal.unsqueeze(1), orthonormal(before)).square().sum())
    assert told[0, 1].evidence == pytest.approx(0.5 * left, rel=1e-4)


def test_an_explanation_is_never_told_from_itself(bench: Workbench, rivals: list[Solved]) -> None:
    for name in (FLIP, TWO):
        new, twice = chosen(bench, name), [rivals[0], rivals[0]]
        told = told_apart(Old([[one] for one in twice]), [[answer(one, new)] for one in twice])
        assert abs(told[0, 1].evidence) < 1e-3


def test_the_axis_tells_a_turning_fixture_from_a_bias_and_no_ramp_does(bench: Workbench, rivals: list[Solved]) -> None:
    old = Old([[one] for one in rivals])
    told = {name: told_apart(old, [[answer(one, chosen(bench, name))] for one in rivals])[0, 1] for name in (FLIP, TWO)}
    assert told[FLIP].evidence > 20 * told[TWO].evidence
    assert told[FLIP].share > 0.1 > told[TWO].share


def test_half_the_noise_is_four_times_the_evidence(bench: Workbench, rivals: list[Solved]) -> None:
    def evidence(factor: float) -> float:
        def scaled(one: Solved) -> Solved:
            fitted = replace(one.fit, columns=one.fit.columns * factor, tangent=one.fit.tangent * factor)
            return replace(one, fit=fitted)

        known = circumstances_of(bench.runs)
        noise = replace(bench.noise, white=bench.noise.white / factor, flicker=bench.noise.flicker / factor)
        flip = next(one for one in family(known) if one.name.startswith(FLIP))
        new, louder = predicted(bench.runs, noise, known, flip), [scaled(one) for one in rivals]
        return told_apart(Old([[one] for one in louder]), [[answer(one, new)] for one in louder])[0, 1].evidence

    assert evidence(2.0) == pytest.approx(4.0 * evidence(1.0), rel=0.02)  # the rows that hold θ stay as they are


def test_a_full_refit_leaves_no_more_than_the_bounds_of_the_linear_one(bench: Workbench, rivals: list[Solved]) -> None:
    new, old = chosen(bench, FLIP), Old([[one] for one in rivals])
    answers = [[answer(one, new)] for one in rivals]
    linear, full = told_apart(old, answers)[0, 1], told_by_refit(bench, old, new, answers, 0, 1)
    assert 0.2 * linear.evidence < full.evidence < 1.5 * linear.evidence


def test_the_difference_is_the_part_that_the_refit_leaves(bench: Workbench, rivals: list[Solved]) -> None:
    new, old = chosen(bench, FLIP), Old([[one] for one in rivals])
    answers = [[answer(one, new)] for one in rivals]
    left = difference(old, answers, 0, 1)
    assert left.shape == (new.run.blocks,)
    white = new.whitener(left.unsqueeze(1)).square().sum()
    assert float(white) <= 2 * told_apart(old, answers)[0, 1].evidence * (1 + 1e-6)
    assert float(difference(old, answers, 0, 0).abs().max()) < 1e-6 * float(left.abs().max())


def test_a_longer_block_is_less_noisy(bench: Workbench) -> None:
    known = circumstances_of(bench.runs)
    day = next(one for one in family(known) if one.name.startswith("a day of rest"))
    new = predicted(bench.runs, bench.noise, known, day)
    longer = new.run.average_s / bench.runs[0].average_s
    assert longer > 1
    first = torch.zeros(new.run.blocks, 1, dtype=torch.float64)
    first[0] = 1.0
    alone = (bench.noise.white**2 / longer + bench.noise.flicker**2) ** -0.5
    assert float(new.whitener(first)[0]) == pytest.approx(alone, rel=0.3)
