"""Cases side by side in processes of their own, each written down as soon as it is done."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any

from hidden_effects.recipe import recipe
from tqdm import tqdm

from zoo.catalog import names
from zoo.processes import in_processes

Row = dict[str, Any]


def seeds(count: int, first: int, kinds: Collection[str]) -> Iterator[int]:
    """The first cases from a seed on that are of these kinds and whose effects the catalogue has."""
    seed, known = first, {*names("effects"), "outside"}
    while count > 0:
        one = recipe(seed)
        if one.kind in kinds and set(one.hidden) <= known:
            count -= 1
            yield seed
        seed += 1


def done(path: Path) -> dict[int, Row]:
    """Rows written so far by seed; of a case judged twice the later."""
    lines = path.read_text().splitlines() if path.exists() else []
    return {row["seed"]: row for row in map(json.loads, lines)}


def do(task: Callable[[int], Row], wanted: list[int], path: Path, jobs: int) -> list[Row]:
    """Do what is not written down yet, and append it, one line a case.

    Args:
        task: makes the row of a seed.
        wanted: seeds.
        path: of the lines.
        jobs: processes.

    Returns:
        The rows of all wanted seeds.
    """
    left = [seed for seed in wanted if seed not in done(path)]
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a") as file:
        for _, row in tqdm(in_processes(task, left, jobs), desc=path.stem, total=len(left), unit="case", disable=not left):
            file.write(json.dumps(row) + "\n")
            file.flush()
    known = done(path)
    return [known[seed] for seed in wanted]
