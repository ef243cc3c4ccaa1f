"""Methods judged: each by its spread and the noise, each pair by whether the difference is more than chance."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import torch
from torch import Generator, Tensor

from zoo.comparison.entrant import Entrant
from zoo.comparison.known_noise import KnownNoise, floors
from zoo.comparison.methods import Method
from zoo.diagnosis.regions import regions
from zoo.fitting.noise import blocks_of, noise_of, of_all
from zoo.measurements.run import HELD_OUT, Run
from zoo.scoring.batches import ratio_interval, rms_interval
from zoo.scoring.comparison import EVERYWHERE, UNCOMPENSATED, UNSEEN, WHOLE, alike
from zoo.scoring.dependence import shares
from zoo.scoring.noise import effective_samples
from zoo.scoring.seeds import RANGE, contest, spread
from zoo.scoring.stages import KINDS, local_rate, rms

ALL_PAIRS = 12
"""Of more methods, only the best is set against each of the others."""
WORST_SHOWN = 6
RATE_WINDOW_S = 600.0


@dataclass(frozen=True, eq=False)
class Scored:
    """What every model leaves of every run.

    Attributes:
        runs: R of them.
        left: (N_r,) residuals by model, run by run, the uncompensated error among them [output's unit].
        rows: RMS by run and kind of stage, one column a model.
        holdout: share of each run that the held-out pieces are, where the runs are such.
        known: the gyro's noise; None where only the white noise of the runs is known.
        together: what all these runs are called.
    """

    runs: list[Run]
    left: list[dict[str, Tensor]]
    rows: list[dict[str, Any]]
    holdout: float = 0.0
    known: KnownNoise | None = None
    together: str = EVERYWHERE

    def unseen(self, fitted: set[str]) -> Scored:
        """Of the runs that no model was fitted to, where there are such beside others; else all."""
        kept = [i for i, one in enumerate(self.runs) if one.name not in fitted]
        if len(kept) in (0, len(self.runs)):
            return self
        return replace(self, runs=[self.runs[i] for i in kept], left=[self.left[i] for i in kept], together=UNSEEN)

    def of(self, model: str) -> list[Tensor]:
        """(N_r,) of each run [output's unit]."""
        return [one[model] for one in self.left]

    def pooled(self, model: str) -> float:
        """RMS over the runs [output's unit]."""
        return rms(torch.cat(self.of(model)))

    @cached_property
    def floors(self) -> dict[str, float]:
        """What a complete model would leave of each run [output's unit]: its white noise, and flicker and random walk where the gyro's are known."""
        return floors(self.runs, self.known)

    @cached_property
    def floor(self) -> float:
        """The same of the runs together."""
        return of_all(self.runs, self.floors.values())

    @cached_property
    def worth(self) -> float:
        """How many independent blocks all are worth if nothing but noise is left."""
        return effective_samples(self.known.noise if self.known else noise_of(self.runs), blocks_of(self.runs))

    @cached_property
    def quantities(self) -> dict[str, Tensor]:
        """(N,) what a residual may go with, one run after the other."""
        time, temperature = ([one.block_mean(column).cpu() for one, column in zip(self.runs, columns, strict=True)] for columns in self._columns())
        found = {
            "temperature": torch.cat(temperature),
            "temperature rate": torch.cat([local_rate(t, u, RATE_WINDOW_S) for t, u in zip(time, temperature, strict=True)]),
            "time": torch.cat([t - t[0] for t in time]),
        }
        which = torch.cat([torch.full_like(t, float(i)) for i, t in enumerate(time)])
        return found | ({"run": which} if len(self.runs) > 1 else {})

    def _columns(self) -> tuple[list[Tensor], list[Tensor]]:
        return [one.time for one in self.runs], [one.temperature for one in self.runs]

    @cached_property
    def kinds(self) -> list[dict[str, Any]]:
        """The rows, and where there are several runs, those of the runs together."""
        if len(self.runs) < 2:
            return self.rows
        pooled, own = [], {one.name for one in self.runs}
        rows = [row for row in self.rows if row["run"] in own]
        there = {row["stage"] for row in rows}
        for stage in (kind for kind in (*KINDS, WHOLE) if kind in there):
            chosen = [row for row in rows if row["stage"] == stage]
            blocks = sum(row["blocks"] for row in chosen)
            means = {key: math.sqrt(sum(row["blocks"] * row[key] ** 2 for row in chosen) / blocks) for key in self.left[0]}
            pooled.append({"run": self.together, "stage": stage, "blocks": blocks} | means)
        return [*self.rows, *pooled]


def judge(methods: Sequence[Method], scored: Scored, generator: Generator) -> dict[str, Any]:
    """What the comparison says of methods, as `comparison.json` takes it: noise floor, methods from the best to the worst, pairs.

    Where some of the runs were fitted by a model and others by none, the latter alone decide.
    """
    fitted = {method.name: _fitted_runs(method, scored) for method in methods}
    seen, scored = scored, scored.unseen({run for runs in fitted.values() for run in runs})
    judged = sorted((_Judged(method, scored) for method in methods), key=lambda one: (one.median, one.method.name))
    pairs = list(itertools.combinations(judged, 2))
    if len(judged) > ALL_PAIRS:
        pairs = [pair for pair in pairs if pair[0] is judged[0]]
    return {
        "ranked_by": [one.name for one in scored.runs],
        "rms": {name: scored.pooled(name) for name in scored.left[0]},
        "noise_floor": scored.floor,
        "noise_floors": seen.floors,
        "noise": None if scored.known is None else asdict(scored.known.noise),
        "methods": [
            _record(one, scored, generator)
            | {"beyond": _beyond(one, seen), "fitted_runs": fitted[one.method.name], "held_out": _held_out(one.method, seen)}
            for one in judged
        ],
        "pairs": [_pair(first, second, scored, generator) for first, second in pairs],
    }


class _Judged:
    """A method and the RMS of its members; those that predict the same are one."""

    def __init__(self, method: Method, scored: Scored) -> None:
        self.method = method
        names = {seed: one.name for seed, one in sorted(method.members.items())}
        self.same = len(alike(scored.left, list(names.values()))) == 1
        # One draw of a start that has others says nothing of those; one that has none is all there is.
        self.lone = len(names) == 1 and next(iter(method.members.values())).facts.get("init") is not None
        self.names = dict(list(names.items())[:1]) if self.same else names
        self.values = {seed: scored.pooled(name) for seed, name in self.names.items()}
        self.median = float(torch.tensor(list(self.values.values()), dtype=torch.float64).quantile(0.5))
        ranked = sorted(self.values, key=lambda seed: (abs(self.values[seed] - self.median), seed))
        self.typical = self.names[ranked[0]]


def _record(one: _Judged, scored: Scored, generator: Generator) -> dict[str, Any]:
    members, left = list(one.method.members.values()), scored.of(one.typical)
    several = spread(torch.tensor(list(one.values.values()), dtype=torch.float64), generator)
    interval = several.interval if len(one.values) > 1 else rms_interval(left, scored.worth)
    return {
        "name": one.method.name,
        "models": [member.name for member in members],
        "seeds": [member.facts["seed"] for member in members if member.facts.get("seed") is not None],
        "distinct": len(one.values),
        "typical": one.typical,
        "rms": {"median": several.median, "low": several.low, "high": several.high, "interval": None if interval is None else list(interval)},
        "interval_over": None if interval is None else "seeds" if len(one.values) > 1 else "time",
        "by_seed": list(one.values.values()),
        "excess": several.median / scored.floor,
        "removed": 1.0 - several.median / max(scored.pooled(UNCOMPENSATED), 1e-300),
        "rows": [_row(row, list(one.names.values()), scored) for row in scored.kinds],
        "where": regions(scored.runs, torch.cat(left), scored.floors)[:WORST_SHOWN],
        "goes_with": shares(torch.cat(left).cpu(), scored.quantities),
    }


def _beyond(one: _Judged, scored: Scored) -> dict[str, Any]:
    """By run, where a method is asked for what it was never fitted to."""
    typical = next(member for member in one.method.members.values() if member.name == one.typical)
    return {run.name: found for run in scored.runs if (found := typical.beyond(run.in_unit(typical.unit(run))))}


def _fitted_runs(method: Method, scored: Scored) -> list[str]:
    member = next(iter(method.members.values()))
    return [run.name for run in scored.runs if _was_fitted(member, run, scored.holdout)]


def _held_out(method: Method, scored: Scored) -> float:
    """Share of its runs that a method's training kept from the fit, where it is not what the comparison judges by."""
    kept = float(next(iter(method.members.values())).settings.get("data.holdout", 0.0))
    return 0.0 if kept == scored.holdout else kept


def _was_fitted(member: Entrant, run: Run, holdout: float) -> bool:
    """Whether a model was fitted to a run, see `Entrant.fitted`; of one fitted to other pieces of it, or to all of it, to held-out pieces as well."""
    kept = float(member.settings.get("data.holdout", holdout))
    return member.fitted(run) and (not run.name.endswith(HELD_OUT) or kept != holdout)


def _row(row: dict[str, Any], names: list[str], scored: Scored) -> dict[str, Any]:
    values = torch.tensor([row[name] for name in names], dtype=torch.float64)
    low, median, high = (float(value) for value in values.quantile(torch.tensor([RANGE[0], 0.5, RANGE[1]], dtype=torch.float64)))
    floor = scored.floors.get(row["run"], scored.floor)
    return {key: row[key] for key in ("run", "stage", "blocks")} | {"median": median, "low": low, "high": high, "excess": median / floor}


def _pair(first: _Judged, second: _Judged, scored: Scored, generator: Generator) -> dict[str, Any]:
    found = contest(first.values, second.values, generator)
    over_time = ratio_interval(scored.of(first.typical), scored.of(second.typical))
    several = found.seeds > 1 and not (first.lone or second.lone)
    same = _same(first, second, scored)
    interval = found.interval if several else over_time
    return {
        "first": first.method.name,
        "second": second.method.name,
        "verdict": "same" if same else _verdict(found.wins, found.seeds, several, interval, over_time),
        "ratio": 1.0 if same else found.ratio,
        "interval": None if interval is None else list(interval),
        "interval_over": None if interval is None else "seeds" if several else "time",
        "interval_over_time": None if over_time is None else list(over_time),
        "wins": found.wins if several else None,
        "ties": found.ties if several else None,
        "seeds": found.seeds if several else None,
        "paired": found.paired,
    }


def _same(first: _Judged, second: _Judged, scored: Scored) -> bool:
    """Whether both predict the same up to rounding, seed by seed where both have seeds."""
    common = first.names.keys() & second.names.keys()
    pairs = [(first.names[seed], second.names[seed]) for seed in common] if len(common) > 1 else [(first.typical, second.typical)]
    return len(first.names) == len(second.names) and all(len(alike(scored.left, pair)) == 1 for pair in pairs)


def _verdict(wins: int, seeds: int, several: bool, interval: tuple[float, float] | None, over_time: tuple[float, float] | None) -> str:
    """Better or worse where a 95 % interval of the ratio excludes 1; with too few seeds for one, where all agree and the interval over time does."""
    decides = interval
    if interval is None and several and wins in (0, seeds):
        decides = over_time
    if decides is None or decides[0] <= 1 <= decides[1]:
        return "open"
    return "better" if decides[1] < 1 else "worse"
