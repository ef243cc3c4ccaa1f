"""Errors before and after compensation, by stage: the rows of every table that sets models side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import torch
from torch import Tensor

from zoo.scoring.stages import KINDS, Stage, bias_stability, rms, stage_mask

UNCOMPENSATED = "uncompensated"
WHOLE = "whole"
EVERYWHERE, UNSEEN = "all runs", "unseen runs"
TOGETHER = (EVERYWHERE, UNSEEN)
"""What the runs are called by which models are ranked: all, or where models were fitted to some of them, those that none has seen."""
ALIKE = 1e-9
"""Residuals whose largest difference is below this share of the uncompensated error's RMS are one model's."""


def residuals(error: Tensor, predicted: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """What is left of the error, uncompensated and after each model.

    Args:
        error: (N,) block means [output's unit].
        predicted: (N,) by model [output's unit].

    Returns:
        (N,) each [output's unit].
    """
    return {UNCOMPENSATED: error, **{name: error - value for name, value in predicted.items()}}


def rms_by_kind(left: Mapping[str, Tensor], stages: list[Stage]) -> list[dict[str, Any]]:
    """One row for each kind of stage that occurs, then one for the whole run.

    Args:
        left: (N,) residuals by name [output's unit].
        stages: of the same N blocks.

    Returns:
        Rows ``{"stage": ..., "blocks": ..., NAME: rms, ...}`` [output's unit].
    """
    masks = {kind: stage_mask(stages, kind) for kind in KINDS}
    everything = torch.ones(sum(stage.to_index - stage.from_index for stage in stages), dtype=torch.bool)
    chosen = {kind: mask for kind, mask in masks.items() if bool(mask.any())} | {WHOLE: everything}
    return [{"stage": name, "blocks": int(mask.sum())} | {who: rms(value[mask]) for who, value in left.items()} for name, mask in chosen.items()]


def rms_by_stage(left: Mapping[str, Tensor], stages: list[Stage]) -> list[dict[str, Any]]:
    """One row for each single stage in time order, with its times [s], temperatures [°C], RMS and bias stability by name [output's unit]."""
    return [
        {"stage": stage.kind, "from_s": stage.from_s, "to_s": stage.to_s, "temperature_c": list(stage.temperature_c)}
        | {"rms": {who: rms(value[stage.blocks]) for who, value in left.items()}}
        | {"bias_stability": {who: bias_stability(value[stage.blocks]) for who, value in left.items()}}
        for stage in stages
    ]


def alike(left: Sequence[Mapping[str, Tensor]], names: Sequence[str]) -> list[list[str]]:
    """Models that predict the same, as those do whose fit depends on no seed.

    Args:
        left: (N,) residuals by name of every run, the uncompensated error among them [output's unit].
        names: the models to group.

    Returns:
        Groups in the order of their first members; most have one.
    """
    whole = {name: torch.cat([run[name] for run in left]) for name in (UNCOMPENSATED, *names)}
    allowed = ALIKE * rms(whole[UNCOMPENSATED])
    groups: list[list[str]] = []
    for name in names:
        same = next((group for group in groups if bool(((whole[group[0]] - whole[name]).abs() <= allowed).all())), None)
        if same is None:
            groups.append([name])
        else:
            same.append(name)
    return groups
