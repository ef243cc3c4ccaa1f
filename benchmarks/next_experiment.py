"""How often the proposed run separates what the runs at hand leave open: a simulated gyro, a diagnosis, a proposal, the run taken, a diagnosis again.

python benchmarks/next_experiment.py 10                    how many gyros of each kind (default 5)
python benchmarks/next_experiment.py 10 viscoelastic       one hidden effect only
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import torch

from zoo.catalog import build, names
from zoo.diagnosis.diagnose import Diagnosis, diagnose
from zoo.diagnosis.experiment.proposal import Proposal
from zoo.diagnosis.experiment.propose import propose
from zoo.diagnosis.experiment.rivals import rivals_of
from zoo.effects.base import Effect
from zoo.errors import InputError
from zoo.simulator.gyros.presets import gyro_class
from zoo.simulator.in_process import as_run
from zoo.simulator.laboratory.profiles import cycle, tour
from zoo.simulator.laboratory.program import Campaign, Program
from zoo.simulator.simulate import Simulation, simulate
from zoo.units import convert

EARTH_DPH = 10.0
"""True rate of the runs at hand, the Earth's share at 42° of latitude."""
RANDOM_WALK = 0.003
WHITE_DPH = 60 * RANDOM_WALK / 10
"""White noise of a block of 100 s."""
GYRO = gyro_class("medium", random_walk=RANDOM_WALK, flicker=0.003, rate_random_walk=0.001)
BASE, WITH_MOHR, WITHOUT_BIAS = ("static_bias", "shupe"), ("static_bias", "shupe", "mohr"), ("shupe", "mohr")
SHORT = tour(20.0, [(45.0, 1.0, 3600.0)], 3600.0)
CYCLE = cycle(-40.0, 60.0, 20.0, 1.0, 3600.0)
CASES: dict[str, tuple[tuple[str, ...], Campaign, float]] = {
    "fixture_rotation": (BASE, CYCLE, 30.0),
    "mohr": (BASE, CYCLE, 30.0),
    "thermal_gradient": (BASE, CYCLE, 30.0),
    "viscoelastic": (WITH_MOHR, CYCLE, 1.0),
    "moisture": (WITH_MOHR, SHORT, 2.0),
    "aging": (WITH_MOHR, SHORT, 2.0),
    "warm_up": (WITH_MOHR, SHORT, 2.0),
    "hysteresis": (WITH_MOHR, CYCLE, 0.7),
    "rate_temperature_coupling": (WITH_MOHR, CYCLE, 1.0),
    "static_bias": (WITHOUT_BIAS, CYCLE, 4.0),
    "misalignment": (WITHOUT_BIAS, CYCLE, 4.0),
    "scale_factor": (WITHOUT_BIAS, CYCLE, 4.0),
}
"""Hidden effect -> model as it stands, chamber program of the run at hand, RMS of the effect over the white noise of block means."""


@dataclass
class Tally:
    """What became of the gyros with one hidden effect."""

    gyros: int = 0
    classes: int = 0
    proposed: int = 0
    apart: int = 0
    right: int = 0
    sure: int = 0
    alone: int = 0
    seconds: list[float] = field(default_factory=list)


def main(gyros: int, only: str | None) -> None:
    torch.set_num_threads(1)
    catalogue = {name: build("effects", name) for name in names("effects")}
    total = Tally()
    for hidden, (base, profile, noises) in CASES.items():
        if only not in {None, hidden}:
            continue
        tally = Tally()
        for seed in range(gyros):
            one(catalogue, hidden, base, profile, noises * WHITE_DPH, seed, tally)
        print(f"{hidden:26s} {said(tally)}", flush=True)
        for key in ("gyros", "classes", "proposed", "apart", "right", "sure", "alone", "seconds"):
            setattr(total, key, getattr(total, key) + getattr(tally, key))
    print(f"{'all':26s} {said(total)}")


def said(tally: Tally) -> str:
    slow, middle = max(tally.seconds, default=0.0), statistics.median(tally.seconds or [0.0])
    return (
        f"{tally.gyros} gyros, {tally.classes} left open; {tally.proposed} runs proposed: "
        f"then {tally.apart} told from all that was promised, {tally.right} named alone; "
        f"{tally.sure} promised a clear decision: then {tally.alone} named alone; a proposal takes {middle:.1f} s of CPU, at most {slow:.1f}"
    )


def one(catalogue: Mapping[str, Effect], hidden: str, base: tuple[str, ...], profile: Campaign, rms: float, seed: int, tally: Tally) -> None:
    sim = simulated(catalogue, hidden, base, profile, seed, amplitude=rms)
    runs = [as_run(run) for run in sim.runs]
    found = diagnose(runs, list(base), dict(catalogue))
    tally.gyros += 1
    started = time.process_time()
    rivals = rivals_of(found.bench, found.search, twins(found))
    proposal = propose(found.bench, rivals)
    if len(rivals) > 1:
        tally.seconds.append(time.process_time() - started)
        tally.classes += 1
    if proposal is None or hidden not in proposal.separates:
        names = [rival.names[-1] for rival in rivals]
        print(f"    seed {seed}: {found.verdict} {found.record['missing']} of {names}, {proposal and proposal.separates}: no run for it", flush=True)
        return
    try:
        new = as_run(taken(catalogue, sim, base, proposal).runs[0])
    except InputError as beyond:  # the amplitude that shows in the runs at hand is larger than any gyro's
        print(f"    seed {seed}: {beyond}", flush=True)
        return
    tally.proposed += 1
    after = diagnose([*runs, new], list(base), dict(catalogue))
    left = twins(after).get(hidden, [])
    kept = {other for pair in proposal.remaining if hidden in pair for other in pair} - {hidden}
    named = after.record["missing"]
    sure = proposal.enough and not kept
    tally.apart += named in [[one] for one in (hidden, *kept)] and not set(left) & set(proposal.separates) - kept
    tally.right += named == [hidden] and not left
    tally.sure += sure
    tally.alone += sure and named == [hidden] and not left
    print(
        f"    seed {seed}: {found.record['missing']} of {proposal.separates}; {proposal.candidate.name}, ln B {proposal.evidence:.0f}"
        f" -> {after.verdict} {named} or {left}; not promised {sorted(kept)}",
        flush=True,
    )


def twins(found: Diagnosis) -> dict[str, list[str]]:
    return {entry["effect"]: entry["indistinguishable_from"] for entry in found.record["candidates"] if entry["effect"] in found.record["missing"]}


def simulated(catalogue: Mapping[str, Effect], hidden: str, base: tuple[str, ...], profile: Campaign, seed: int, **more: Any) -> Simulation:
    effects = {name: catalogue[name] for name in base}
    settings: dict[str, Any] = {"runs": 1, "seed": seed, "reference_dph": EARTH_DPH, **more}
    return simulate(GYRO, profile, effects, build("noise", "gyro"), hidden=[hidden], catalogue=dict(catalogue), **settings)


def taken(catalogue: Mapping[str, Effect], sim: Simulation, base: tuple[str, ...], proposal: Proposal) -> Simulation:
    """The proposed run on the same gyro: its parameters as drawn for the first runs."""
    profile = proposal.record()["profile"]
    rates = tuple((float(convert(rate, "dps", "dph")), seconds) for rate, seconds in profile.get("rates", ()))
    program = Program(tuple((begin, end, seconds) for begin, end, seconds in profile["legs"]), rates)
    known = {name: {one: value for one, (value, _) in share.parameters().items()} for name, share in sim.shares.items()}
    more = {"parameters": known, "cold_start": proposal.candidate.extra == "power_on"}
    return simulated(catalogue, sim.hidden[0], base, Campaign((program,), program), sim.seed, **more)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5, sys.argv[2] if len(sys.argv) > 2 else None)
