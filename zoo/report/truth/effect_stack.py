"""What each effect adds to a simulated gyro's output, so that the parts can be stacked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from zoo.report.trace import rms
from zoo.simulator.recorded import Recorded

MOST = 7
"""More effects cannot be told apart by colour."""
OTHERS = "others"


@dataclass(frozen=True, eq=False)
class Parts:
    """One run's effects, as changes from what they are at rest.

    Attributes:
        constant: what each effect has at rest [°/h].
        change: (T,) what each adds to that [°/h].
    """

    constant: dict[str, float]
    change: dict[str, np.ndarray]


def effects_of(run: Recorded) -> dict[str, np.ndarray]:
    """(T,) what each effect adds [°/h]."""
    return {key.removesuffix("_dph"): value.numpy() for key, value in run.truth.items() if key.endswith("_dph") and key != "sum_dph"}


def parts_of(run: Recorded, cold_start: bool = False) -> Parts:
    """The effects of a run as changes from its first row, where the gyro has soaked; from the last one where it was just switched on in the first.

    On a rate table they are left as they are.

    Args:
        run: with its truth.
        cold_start: whether it was switched on at the first row.
    """
    each, reference = effects_of(run), run.table["reference_dph"]
    turning = bool((reference != reference[0]).any())
    # On a table that turns no row is at rest: there each effect is drawn from zero.
    constant = {name: 0.0 if turning else float(values[-1 if cold_start else 0]) for name, values in each.items()}
    return Parts(constant, {name: values - constant[name] for name, values in each.items()})


def ranked(runs: Sequence[Parts]) -> list[str]:
    """Names of the effects, the one that changes most over all runs first."""
    names = dict.fromkeys(name for run in runs for name in run.change)
    sizes = {name: rms(np.concatenate([run.change[name] for run in runs if name in run.change])) or 0.0 for name in names}
    return sorted(sizes, key=lambda name: -sizes[name])


def grouped(change: Mapping[str, np.ndarray], order: Sequence[str]) -> dict[str, np.ndarray]:
    """The largest effects by themselves, and the rest as one.

    Args:
        change: (T,) of each effect [°/h].
        order: all effects, the largest first, see `ranked`.
    """
    present = [name for name in order if name in change]
    own = present if len(order) <= MOST else [name for name in order[: MOST - 1] if name in change]
    rest = [change[name] for name in present if name not in own]
    return {name: change[name] for name in own} | ({OTHERS: np.sum(rest, axis=0)} if rest else {})


def stacked(change: Mapping[str, np.ndarray]) -> dict[str, list[tuple[np.ndarray, np.ndarray]]]:
    """Areas that pile up from zero, positive parts upwards and negative ones downwards; the outermost edges add up to the sum of all.

    Args:
        change: (T,) of each effect, the one nearest to zero first.

    Returns:
        Edges of the area above zero and of that below it, each (T,), for each effect.
    """
    found: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {name: [] for name in change}
    for low, high in ((0.0, np.inf), (-np.inf, 0.0)):
        edge = np.zeros(len(next(iter(change.values()))) if change else 0)
        for name, values in change.items():
            outer = edge + np.clip(values, low, high)
            found[name].append((edge, outer))
            edge = outer
    return found


def means(values: np.ndarray, most: int) -> np.ndarray:
    """(N,) means over equal pieces of (T,), at most so many; the last piece may be shorter."""
    starts = np.arange(0, len(values), -(-len(values) // most))
    return np.add.reduceat(values, starts) / np.diff([*starts, len(values)])
