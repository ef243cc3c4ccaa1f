"""The members of an ensemble: one training for each of several seeds, what becomes of each, and how far they are apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from zoo.artifacts import replacing
from zoo.errors import InputError, in_brief
from zoo.measurements.run import Run
from zoo.models.base import FeatureModel, Model
from zoo.models.prediction import raw_columns
from zoo.scoring.stages import rms
from zoo.training.files import MEMBERS, UNREADABLE
from zoo.training.scores import residual_blocks

SHARES = {"low": 0.05, "median": 0.5, "high": 0.95}
"""Quantiles of the members' errors: the middle and the ends of the 90 % range."""


@dataclass(frozen=True, eq=False)
class Member:
    """One trained member.

    Attributes:
        seed: of its chance.
        state: the model's weights and buffers, on the CPU.
        facts: passes, evaluations and last loss, and what else its fit tells; as the metrics of a training alone have them.
    """

    seed: int
    state: dict[str, Tensor]
    facts: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, seed: int, model: Model, **facts: Any) -> Member:
        """A model as it is now."""
        return cls(seed, {name: tensor.detach().cpu().clone() for name, tensor in model.state_dict().items()}, facts)


def compare_members(model: Model, members: Sequence[Member], runs: Sequence[Run], check_runs: Sequence[Run]) -> tuple[Member, dict[str, Any]]:
    """Score all members.

    Args:
        model: takes each one's state in turn, and keeps that of the best.
        members: all that came to an end.
        runs: fitted; the best member is the one with the lowest RMS here, as the runs to check on must not choose.
        check_runs: only scored.

    Returns:
        The best member, and RMS of each, with quantiles [output's unit]; quantiles of the physical parameters where members have some.
    """
    found = {key: _rms_of_each(model, members, some) for key, some in (("rms", runs), ("rms_check", check_runs))}
    best = members[min(range(len(members)), key=found["rms"].__getitem__)]
    model.load_state_dict(best.state)
    block: dict[str, Any] = {"seeds": [member.seed for member in members], "best_seed": best.seed}
    for key, values in found.items():
        block[key] = values or None
        block[f"{key}_quantiles"] = {name: _quantile(values, share) for name, share in SHARES.items()} if values else None
    if physical := [told for member in members if (told := member.facts.get("physical"))]:
        block["physical"] = {owner: {key: _range(physical, owner, key) for key in values} for owner, values in physical[0].items()}
    return best, block


def _range(physical: list[dict[str, Any]], owner: str, key: str) -> dict[str, float]:
    """How far the members are apart in one parameter."""
    values = [float(value) for told in physical if (value := told.get(owner, {}).get(key, {}).get("value")) is not None]
    return {name: _quantile(values, share) for name, share in SHARES.items()} if values else {}


def _quantile(values: list[float], share: float) -> float:
    return float(torch.tensor(values, dtype=torch.float64).quantile(share))


def _rms_of_each(model: Model, members: Sequence[Member], runs: Sequence[Run]) -> list[float]:
    """Features do not depend on weights and are computed once: they take longer than all the rest."""
    if not runs:
        return []
    if not isinstance(model, FeatureModel):
        return [rms(torch.cat([residual_blocks(_with(model, member), run) for run in runs])) for member in members]
    with torch.no_grad():
        features = [model.features(raw_columns(model, run)) for run in runs]
        errors = torch.cat([run.block_mean(run.error) for run in runs])
        return [
            rms(errors - torch.cat([run.block_mean(_with(model, member).head(one)) for run, one in zip(runs, features, strict=True)]))
            for member in members
        ]


def _with(model: Any, member: Member) -> Any:
    model.load_state_dict(member.state)
    return model


def write_members(folder: Path, members: Sequence[Member]) -> None:
    """Keep the weights of all members.

    Args:
        folder: an existing folder.
        members: trained.
    """
    with replacing(folder / MEMBERS) as path:
        torch.save({"seeds": [member.seed for member in members], "states": [member.state for member in members]}, path)


def read_members(folder: Path) -> list[Member]:
    """The inverse of `write_members`.

    Raises:
        InputError: the folder holds no ensemble, or a damaged one.
    """
    if not (folder / MEMBERS).is_file():
        raise InputError(f"{folder}: no ensemble here ({MEMBERS} is missing); give the output folder of a train command with seeds=2 or more")
    try:
        kept = dict(torch.load(folder / MEMBERS, weights_only=True, map_location="cpu"))
        return [Member(seed, state) for seed, state in zip(kept["seeds"], kept["states"], strict=True)]
    except UNREADABLE as error:
        raise InputError(f"{folder / MEMBERS}: damaged ({in_brief(error)}); train it again") from error
