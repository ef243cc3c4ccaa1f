"""Cases side by side in processes of their own, each written down as soon as it is done."""

from __future__ import annotations

import json
import multiprocessing
import os
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import torch
from hidden_effects.recipe import recipe
from tqdm import tqdm

from zoo.catalog import names

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
    os.environ["OMP_NUM_THREADS"] = "1"
    with path.open("a") as file:
        for row in tqdm(_results(left, task, jobs), desc=path.stem, total=len(left), unit="case", disable=not left):
            file.write(json.dumps(row) + "\n")
            file.flush()
    known = done(path)
    return [known[seed] for seed in wanted]


def _results(left: list[int], task: Callable[[int], Row], jobs: int) -> Iterator[Row]:
    """Rows as they are done, each process in a copy of its own with one thread: several side by side would fight for the cores."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, context, initializer=torch.set_num_threads, initargs=(1,)) as pool:
        for future in as_completed([pool.submit(task, seed) for seed in left]):
            yield future.result()
