"""What a user should know before relying on a model that has just been trained."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import torch
from rich.console import Console

from zoo.measurements.run import OUTPUT, Run
from zoo.models.base import FeatureModel, Model
from zoo.models.hybrid import Hybrid
from zoo.models.prediction import block_features
from zoo.report.wording import joined, of_parameter, percent, reached_beyond, significant, worse_than_none
from zoo.scoring.stages import rms
from zoo.units import symbol

STEADY = 1e-9
"""Share of the output within which a true input that is called constant stays."""
NEAR_BOUND = 1e-6
"""Share of a range within which a value rests on its end."""
BENDS = 1.5
"""RMS row by row over that of mean features from which a word is due."""


def print_doubts(model: Model, runs: Sequence[Run], metrics: Mapping[str, Any], unused: Sequence[str] = ()) -> None:
    """Print them, a line each.

    Args:
        model: trained.
        runs: that it was fitted to.
        metrics: of `zoo.training.run.train`.
        unused: settings that were given and that nothing has read.
    """
    ends = "ends by itself" if metrics["epochs"] is None else "goes by optimizer.steps"
    why = {"init": "needs no start", "epochs": ends, "goal": ends}
    idle = (f"{key} was of no use: optimizer={metrics['optimizer']} {why[key]}" for key in unused)
    for told in (
        *idle,
        *_few(runs, metrics),
        *_takes_the_input(model, runs),
        *_worse(metrics),
        *_beyond(metrics),
        *_bends(model, runs, metrics),
        *_at_bounds(model),
    ):
        Console(stderr=True).print(told, style="yellow", soft_wrap=True, highlight=False)


def _few(runs: Sequence[Run], metrics: Mapping[str, Any]) -> Iterator[str]:
    """Where any measurements would be fitted as well."""
    blocks, weights = sum(run.blocks for run in runs), metrics["parameters"]
    if blocks <= weights:
        told = f"{weights} weights were fitted to {blocks} block means, so that what is left of the fitted runs says nothing"
        yield f"{told}; longer runs, a shorter data.average_s or a smaller model help"


def _takes_the_input(model: Model, runs: Sequence[Run]) -> Iterator[str]:
    """Where it may subtract what the gyro is there to show, and no run could tell."""
    one = runs[0].table[0, -1]
    steady = all(bool(((run.table[:, -1] - one).abs() <= STEADY * run.output.abs().max()).all()) for run in runs)
    if OUTPUT in model.inputs and steady:
        yield (
            "the model takes the output, and the true input never changes in the fitted runs: all that the gyro shows passes for error, "
            "a rotation in flight as well; leave output out of model.features, or fit runs with a recorded true input that changes"
        )


def _worse(metrics: Mapping[str, Any]) -> Iterator[str]:
    """Where nothing would do better."""
    advice = {"": "a smaller step of the optimizer or more epochs may help", "_check": "there it is of no use"}
    for kind, what_now in advice.items():
        if worse := worse_than_none(metrics[f"rms{kind}"], metrics[f"rms{kind}_uncompensated"]):
            told = f"on the {'check' if kind else 'fitted'} runs {worse}"
            yield f"{told}; {what_now}" if kind or metrics.get("init") else told
            return


def _beyond(metrics: Mapping[str, Any]) -> Iterator[str]:
    """Where it is asked for what it has never seen."""
    found = metrics["beyond"]
    if found:
        share = percent(max(one["share"] for one in found.values()))
        yield f"the check runs go beyond what was fitted in {share} of their time: {reached_beyond(found)}; there the model extrapolates"


def _at_bounds(model: Model) -> Iterator[str]:
    """Where an effect beside a network is not what its name says: then its parameters run to the end of what is possible."""
    if not isinstance(model, Hybrid):
        return
    held = [
        of_parameter(f"{owner}.{one.name} =", significant(one.low if place <= NEAR_BOUND else one.high), one.unit)
        for (owner, one), place in zip(model.physics.parameters_of_theta(), model.physics.theta().tolist(), strict=True)
        if owner != "coil" and not one.ends_as_likely and not NEAR_BOUND < place < 1.0 - NEAR_BOUND
    ]
    if held:
        yield (
            f"{joined(held)}: at the end of what is possible, so the effect stands in for something that the network cannot draw; "
            "do not take its values for the gyro's. More features, or the effects that the gyro has for certain (effects=[…]), help"
        )


def _bends(model: Model, runs: Sequence[Run], metrics: Mapping[str, Any]) -> Iterator[str]:
    """Where it fits the means of its features, which a dual solution sees, and not the means of what it predicts, which counts."""
    if not isinstance(model, FeatureModel):
        return
    with torch.no_grad():
        left = torch.cat([run.block_mean(run.error) - model.head(block_features(model, run)) for run in runs])
    seen, rows, unit = rms(left), metrics["rms"], symbol(metrics["unit"])
    if rows > BENDS * seen:
        both = f"of each block's mean features it leaves {significant(seen)} {unit}, row by row {significant(rows)} {unit}"
        yield f"the model bends within blocks: {both}; a shorter data.average_s or a smoother model helps"
