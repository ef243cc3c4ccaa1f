"""Members of an ensemble that cannot be trained as one batch."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence

from zoo.errors import Stopped, WorkError
from zoo.models.base import Model
from zoo.progress import progress
from zoo.training.members import Member


def one_after_another(model: Model, seeds: Sequence[int], train: Callable[[Model, int], Member]) -> list[Member]:
    """Train each by itself; those whose work fails are left out.

    Args:
        model: a pattern, left as it is.
        seeds: one a member.
        train: fits a copy with its seed.

    Raises:
        WorkError: none came to an end, or the system asked to stop.
    """
    members: list[Member] = []
    failure = WorkError("no member was trained")
    with progress("members", len(seeds)) as advance:
        for seed in seeds:
            try:
                members.append(train(copy.deepcopy(model), seed))
            except Stopped:
                raise
            except WorkError as failed:
                failure = failed
            advance()
    if not members:
        raise failure
    return members
