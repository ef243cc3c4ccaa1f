"""A proposed run, as it is written down and as a command."""

from __future__ import annotations

import json
import math
import shlex
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import torch

from zoo.diagnosis.experiment.family import Candidate
from zoo.diagnosis.experiment.prediction import Predicted
from zoo.diagnosis.experiment.simulable import simulable, simulated_values
from zoo.effects.base import Effect
from zoo.errors import InputError
from zoo.simulator.settings import PLACES
from zoo.units import UNITS, convert

POINTS = 160
"""How many points of the predicted curves are written down."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """The run to take next.

    Attributes:
        candidate: the run.
        separates: explanations that it tells apart, the likeliest first; of an explanation, what the others lack.
        remaining: pairs of explanations that it leaves close together.
        evidence: expected log Bayes factor of the pair that it tells apart worst, of those that it does.
        predicted: what it would record.
        difference: (N,) of the two leading explanations that it tells apart [unit].
        compared: names of these two.
        alternatives: the next best runs and their evidence.
        truth: what the first of them is; None where it is not one effect.
        fitted: what that comes to on the runs at hand, by parameter [output's unit].
        model: what all explanations share, by name.
        enough: whether the evidence is as much as was asked for.
    """

    candidate: Candidate
    separates: tuple[str, ...]
    remaining: tuple[tuple[str, str], ...]
    evidence: float
    predicted: Predicted
    difference: torch.Tensor
    compared: tuple[str, str]
    truth: Effect | None
    fitted: Mapping[str, float]
    alternatives: tuple[tuple[Candidate, float], ...]
    model: Mapping[str, Effect]
    enough: bool

    def record(self) -> dict[str, Any]:
        """The contract's `next_experiment`, ready for JSON."""
        one = self.candidate
        return {
            "separates": list(self.separates),
            "why": self.why(),
            "name": one.name,
            "profile": {"legs": [list(leg) for leg in one.legs], **self._turned()},
            "input": one.extra,
            "duration_s": one.seconds,
            "expected_evidence": self.evidence,
            "enough": self.enough,
            "not_separated": [list(pair) for pair in self.remaining],
            "command": self.command(),
            "alternatives": [{"name": other.name, "duration_s": other.seconds, "expected_evidence": worth} for other, worth in self.alternatives],
            "prediction": self._curves(),
        }

    def why(self) -> str:
        """What the run does and how much it would tell, in plain words."""
        first, second = self.compared
        sentences = [
            f"{_capital(self.candidate.name)} ({self.candidate.seconds / 3600:.1f} h): {self.candidate.why}.",
            f"Between {first} and {second} their predictions, refitted to each other, come to differ by up to "
            f"{float(self.difference.abs().max()):.2g} {_symbol(self.predicted.run.unit)}; "
            f"a log Bayes factor of {self.evidence:.0f} is to be expected.",
        ]
        if not self.enough:
            sentences.append("That is less than a clear decision takes: take the run several times, or more quietly.")
        if self.remaining:
            sentences.append(f"It does not tell {'; '.join(_not_told(self.remaining))}.")
        return " ".join(sentences)

    def command(self) -> str | None:
        """The run as a simulation, to try before the chamber is booked: of another gyro, whose hidden effect is that of the runs at hand.

        Returns:
            None where no simulated gyro can show that effect.
        """
        if self.truth is None or not simulable(self.truth) or (self.truth.needs_varied_reference and not _is_rate(self.predicted.run.unit)):
            return None
        one, run, hidden = self.candidate, self.predicted.run, self.compared[0]
        model = ",".join(name for name, effect in self.model.items() if simulable(effect))
        told = [f"effects=[{model}]", f"hidden={hidden}", "runs=1", "profile=legs", f"profile.legs={_short(one.legs)}"]
        values = simulated_values(self.truth, self.fitted, run.unit) if _is_rate(run.unit) else {}
        told += [f"+parameters.{hidden}.{name}={value:g}" for name, value in values.items()]
        turns = self._turned().get("rates")
        if turns:
            told.append(f"profile.rates={_short(turns)}")
        usual = float(run.table[0, -1])
        if usual and _is_rate(run.unit):
            told.append(f"reference_dph={convert(usual, run.unit, 'dph'):g}")
        told += ["cold_start=true"] * (one.extra == "power_on") + [f"thermometers={min(len(run.thermometers), len(PLACES))}"]
        return shlex.join(["fogzoo", "simulate", *told])

    def _turned(self) -> dict[str, Any]:
        """What a rate table adds to the usual true input, as `profile.rates` takes it [°/s, s]; for an output that is no rate, the input itself."""
        pieces, run = self.predicted.program.rates, self.predicted.run
        if not pieces:
            return {}
        if not _is_rate(run.unit):
            return {f"reference_{run.unit}": [list(piece) for piece in pieces]}
        usual = pieces[0][0]
        return {"rates": [[convert(rate - usual, run.unit, "dps"), seconds] for rate, seconds in pieces]}

    def _curves(self) -> dict[str, Any]:
        """Temperature, true input and difference against time, thinned."""
        run = self.predicted.run
        keep = torch.arange(0, run.blocks, max(1, math.ceil(run.blocks / POINTS)))
        means = {"time_s": run.time, "temperature_c": run.temperature, "reference": run.table[:, -1]}
        curves = {name: _rounded(run.block_mean(value)[keep]) for name, value in means.items()}
        return {"compared": list(self.compared), **curves, "difference": _rounded(self.difference[keep])}


def _not_told(pairs: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Pairs in few words, ``a from b or c``, those that occur most often first."""
    left = list(pairs)
    while left:
        count = Counter(name for pair in left for name in pair)
        name = max(count, key=count.__getitem__)
        others = [second if first == name else first for first, second in left if name in {first, second}]
        left = [pair for pair in left if name not in pair]
        yield f"{name} from {' or '.join([', '.join(others[:-1]), others[-1]] if len(others) > 1 else others)}"


def _rounded(values: torch.Tensor) -> list[float]:
    return [float(f"{value:.5g}") for value in values.tolist()]


def _short(rows: Sequence[Sequence[float]]) -> str:
    """Numbers as short as they can be without becoming others, and no zero with a sign."""
    return json.dumps([[float(f"{value:.9g}") + 0.0 for value in row] for row in rows], separators=(",", ":")).replace(".0,", ",").replace(".0]", "]")


def _is_rate(unit: str) -> bool:
    try:
        convert(1.0, unit, "dph")
    except InputError:
        return False
    return True


def _capital(words: str) -> str:
    return words[0].upper() + words[1:]


def _symbol(unit: str) -> str:
    """A unit as usually written."""
    return UNITS[unit].symbol if unit in UNITS else unit
