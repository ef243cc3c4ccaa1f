"""The jobs of a sweep in one table: what differs but the seed, and how good it was over all seeds."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from omegaconf import DictConfig
from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from zoo.artifacts import write_text
from zoo.cli.closed_pipe import CLOSED_PIPE
from zoo.cli.next_commands import FITTED, compare_command, settled_data
from zoo.cli.outcomes import FAILED, Outcome
from zoo.training.members import SHARES
from zoo.units import symbol

FILE = "sweep.csv"
SEED = "seed"
MOST = 20
"""Failed jobs that are told one by one."""
UNUSED = "–"
UNUSABLE = ("init",)
"""Choices that a fit by itself leaves alone, which its metrics then say."""
USES = {"rms": "fit", "rms_check": "check"}


def tell_results(config: DictConfig, folder: Path, outcomes: Mapping[Path, Outcome]) -> None:
    """Write and print the table, and what to type next; nothing where no job came to an end.

    Args:
        config: of the sweep, with Hydra's own.
        folder: of the sweep.
        outcomes: of its jobs, by folder.
    """
    done = [one for one in outcomes.values() if one.code == 0 and one.result]
    if not done:
        return
    differing = _differing([_settings(one) for one in outcomes.values()])
    metrics = [json.loads(Path(str(one.result)).read_text(encoding="utf-8")) for one in done]
    kept = [key for key in differing if key != SEED]
    table = sweep_table([_of_use(_settings(one), found, kept) for one, found in zip(done, metrics, strict=True)], metrics)
    path = write_text(folder / FILE, str(table.to_csv(index=False, float_format="%.6g", lineterminator="\n")))
    again = sum(one.again for one in done)
    _print(table, f"{_jobs(len(done))}{f' ({again} done before)' if again else ''}: RMS, median [90 % range]")
    data = settled_data(config)
    if data is not None:
        print(f"compare by run and stage:\n  {compare_command(folder, data)}")
        if all(found.get("rms_check") is None for found in metrics):
            print(f"  {FITTED}")
    print(path.absolute(), flush=True)


def sweep_table(settings: Sequence[Mapping[str, str]], metrics: Sequence[Mapping[str, Any]]) -> pd.DataFrame:
    """One row for all jobs of equal settings, the best first.

    Args:
        settings: of each job that ended well, those that the rows are told apart by; the same keys for each.
        metrics: of each; an ensemble counts with all its members.

    Returns:
        The settings; ``n`` trainings; median and ends of the 90 % range of the RMS of the fitted runs, and of the check runs where there are any;
        the median ``wall_time_s`` of a job; the ``unit``.
    """
    groups: dict[tuple[tuple[str, str], ...], list[Mapping[str, Any]]] = {}
    for one, found in zip(settings, metrics, strict=True):
        groups.setdefault((*one.items(), ("unit", found["unit"])), []).append(found)
    rows = [_row(dict(key), members) for key, members in groups.items()]
    table = pd.DataFrame(rows)
    best = "rms_check_median" if "rms_check_median" in table else "rms_median"
    return table.sort_values(best, kind="stable", ignore_index=True)


def _of_use(settings: Mapping[str, str], metrics: Mapping[str, Any], keys: Sequence[str]) -> dict[str, str]:
    """Some settings of a job; a start that its fit did not need is none, so that nobody compares it."""
    return {key: UNUSED if key in UNUSABLE and metrics[key] is None else settings.get(key, "") for key in keys}


def _row(key: dict[str, str], metrics: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    unit = key.pop("unit")
    found: dict[str, Any] = {"n": len({seed for one in metrics for seed in _each(one, "rms")})}
    for name in USES:
        values = pd.Series({seed: value for one in metrics for seed, value in _each(one, name).items()}, dtype=float)
        found |= {f"{name}_{what}": values.quantile(share) for what, share in SHARES.items()} if len(values) else {}
    return key | found | {"wall_time_s": pd.Series([one["wall_time_s"] for one in metrics]).median(), "unit": unit}


def _each(metrics: Mapping[str, Any], key: str) -> dict[int, float]:
    """The RMS of each training of a job by its seed, of which several ensembles may have had the same."""
    members = metrics.get("members") or {"seeds": [metrics["seed"]], key: [metrics[key]]}
    return {seed: value for seed, value in zip(members["seeds"], members[key] or [], strict=False) if value is not None}


def _print(table: pd.DataFrame, title: str) -> None:
    kept = [f"{key}_{what}" for key in USES for what in SHARES]
    keys = [str(key) for key in table.columns if key not in {*kept, "n", "wall_time_s", "unit"}]
    uses = {key: use for key, use in USES.items() if f"{key}_median" in table}
    units = table["unit"].unique()
    told = [f"{use} [{symbol(units[0])}]" if len(units) == 1 else use for use in uses.values()]
    shown = Table(*map(escape, (*keys, "n", *told, "s a job")), title=escape(title))
    for row in table.to_dict("records"):
        cells = [_spread(row, key) for key in uses]
        shown.add_row(*(escape(_short(str(row[key]))) for key in keys), str(row["n"]), *map(escape, cells), f"{row['wall_time_s']:.3g}")
    Console().print(shown)


def _short(value: str) -> str:
    """A number in five digits, as a sweeper proposes it in sixteen."""
    try:
        return f"{float(value):.5g}" if len(value) > 8 else value
    except ValueError:
        return value


def _spread(row: Mapping[Any, Any], key: str) -> str:
    low, middle, high = (row[f"{key}_{what}"] for what in ("low", "median", "high"))
    if pd.isna(middle):
        return ""
    return f"{middle:.4g}" if row["n"] == 1 else f"{middle:.4g}\n[{low:.3g}, {high:.3g}]"


def tell_failed(outcomes: Mapping[Path, Outcome]) -> None:
    """Print which jobs failed, and why.

    Args:
        outcomes: of all jobs, by folder.
    """
    failed = {folder: one for folder, one in outcomes.items() if one.code not in {0, CLOSED_PIPE}}
    differing = _differing([_settings(one) for one in outcomes.values()])
    table = Table("job", "settings", "why", title=f"{len(failed)} of {len(outcomes)} jobs failed")
    for folder, one in list(failed.items())[:MOST]:
        told = _settings(one)
        table.add_row(escape(str(folder)), escape(" ".join(f"{key}={told[key]}" for key in differing if key in told)), escape(_why(one)))
    console = Console(stderr=True)
    console.print(table)
    if len(failed) > MOST:
        console.print(f"and {len(failed) - MOST} more; {FAILED} in the folder of each says why", highlight=False)


def tell_mixed(outcomes: Mapping[Path, Outcome], others: Sequence[Path]) -> None:
    """Print what the sweep has replaced of an earlier one in its folder, and what of that lies there still.

    Args:
        outcomes: of its own jobs, by folder.
        others: folders of the earlier ones' finished jobs.
    """
    replaced = {folder: one.replaced for folder, one in outcomes.items() if one.replaced is not None}
    told = []
    if replaced:
        folder, settings = next(iter(replaced.items()))
        told.append(
            f"{_jobs(len(replaced))} of an earlier sweep in this folder {_were(len(replaced))} replaced, such as {folder.name} ({' '.join(settings)})"
        )
    if others:
        told.append(
            f"{_jobs(len(others))} of an earlier sweep {_were(len(others))} left in this folder, such as {others[0].name}: compare takes them as well"
        )
    if told:
        Console(stderr=True).print(Text("; ".join(told) + ". Another hydra.sweep.dir keeps sweeps apart"), style="yellow", soft_wrap=True)


def _jobs(count: int) -> str:
    return f"{count} job{'' if count == 1 else 's'}"


def _were(count: int) -> str:
    return "was" if count == 1 else "were"


def _why(one: Outcome) -> str:
    return "ended without a word: killed, or out of memory" if one.code is None else one.message


def progress_line(folder: Path, one: Outcome, swept: Sequence[str]) -> str:
    """A job that has just ended, in a line.

    Args:
        folder: of the job.
        one: what became of it.
        swept: the keys by which jobs differ; none where that is not known.
    """
    told = " ".join(f"{key}={value}" for key, value in _settings(one).items() if key in swept or not swept)
    word = "done before" if one.again else "failed" if one.code else "done"
    why = f": {' '.join(one.message.split())}" if one.code else ""
    return f"job {folder.name} {word}: {told}{why}"


def _settings(one: Outcome) -> dict[str, str]:
    """The settings that were typed."""
    split = (override.lstrip("+").partition("=") for override in one.overrides)
    return {key: value for key, _, value in split}


def _differing(settings: Sequence[Mapping[str, str]]) -> list[str]:
    """The keys whose values are not the same for all."""
    every = dict.fromkeys(key for one in settings for key in one)
    return [key for key in every if len({one.get(key) for one in settings}) > 1]
