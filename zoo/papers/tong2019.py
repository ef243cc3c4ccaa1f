"""Segmented polynomials fitted by a particle swarm: Journal of Chinese Inertial Technology 27(4), 2019."""

from __future__ import annotations

import torch
from torch import Tensor

from zoo.papers.study import Claim, Measure, Row, Study, in_words, row, spread
from zoo.scoring.comparison import UNCOMPENSATED, WHOLE

TRADITIONAL, PROPOSED, OURS = "T alone", "PSO", "continuous"
"""Methods that the claims are about; see conf/experiment/tong2019.yaml."""
PRINTED = {
    UNCOMPENSATED: {"mean": -6.90e-2, "standard deviation": 1.5317e-2},
    TRADITIONAL: {"mean": 1.1209e-4, "standard deviation": 6.9597e-3},
    PROPOSED: {"mean": -2.9621e-5, "standard deviation": 6.6524e-3},
}
"""Of the run that was fitted [°/h]; the check run's values are not printed."""
FITTED, CHECK = 0, 1
REMARKS = (
    "The powers of the rate in eq. (6), the ends of the inertia's schedule and the box of the search are not printed; they are the rate to the "
    "powers 1 to 4, 0.9 to 0.4, and ±2 in units of standardised features and error. One swarm fits one segment.",
    "A least-squares fit with a constant has no mean on its own run but for rounding, and of one set of coefficients no other has a lower sum of "
    "squares: what a swarm can gain on the run that it fits is what the rate's four coefficients add.",
    "The run has one rate: 0.108 K/min but for its first hour. What an error does with the rate cannot be known from it, and powers of the rate that "
    "were fitted to it are worthless at the check run's 0.18 K/min. Four powers take four rates and more.",
    "Every method here that leaves less of the fitted run than the noise has fitted noise; only the check run judges.",
)
"""What the paper leaves open, and what its protocol cannot tell."""


def mean(left: Tensor) -> Tensor:
    """(E, N) -> (E,)."""
    return left.mean(dim=-1)


MEASURES: dict[str, Measure] = {"mean": mean, "standard deviation": spread}


def rows(study: Study) -> list[Row]:
    """Mean and standard deviation of what is left of the fitted run and of the check run."""
    found = []
    for quantity, measure in MEASURES.items():
        for sample, run in enumerate(study.runs):
            for model, left in study.left.items():
                paper = PRINTED.get(model, {}).get(quantity) if sample == FITTED else None
                found.append(row(measure(left[sample]), quantity, "°/h", WHOLE, run.name, model, paper))
    return found


def claims(study: Study, floors: list[float]) -> list[Claim]:
    """What the paper says of its method, and what is asked of the zoo's.

    Args:
        study: with the methods `TRADITIONAL`, `PROPOSED` and `OURS`, and others; the fitted run first, then the check run.
        floors: RMS that a complete model would leave of each run [°/h].
    """
    deviation = {name: [spread(left) for left in each] for name, each in study.left.items()}
    gain = 1.0 - deviation[PROPOSED][FITTED] / deviation[TRADITIONAL][FITTED]
    over_noise = {name: study.left[name][CHECK].square().mean(-1).sqrt() / floors[CHECK] for name in study.methods}
    best = min(over_noise, key=lambda name: float(over_noise[name].median()))
    checked = 1.0 - deviation[PROPOSED][CHECK] / deviation[UNCOMPENSATED][CHECK]
    room = deviation[TRADITIONAL][FITTED] / floors[FITTED]
    rivals = [(other, sample) for other in (TRADITIONAL, PROPOSED) for sample in (FITTED, CHECK)]
    ours = [float(deviation[OURS][sample].median()) for sample in (FITTED, CHECK)]
    below = all(ours[sample] < float(deviation[other][sample].median()) for other, sample in rivals)
    return [
        Claim("PSO's standard deviation is at most that of T alone (paper: 4.4 % less)", f"{in_words(gain)} less", float(gain.median()) >= 0),
        _mean_claim(study, UNCOMPENSATED, "before (paper: 99.96 %)"),
        _mean_claim(study, TRADITIONAL, "that of T alone (paper: 74 %)"),
        Claim("continuous segments leave less than T alone and PSO, of the run and of the check run", f"{ours[0]:.3e}, {ours[1]:.3e} °/h", below),
        Claim(
            "T alone leaves more of the fitted run than noise, so that there is something to gain",
            f"{in_words(room, '{:.3f}')} × noise",
            _above(room),
        ),
        Claim("PSO removes spread at the check run's other rate as well", _share(checked), float(checked.median()) > 0),
        Claim(
            "the best method leaves at most 1.05 times the noise of the check run",
            f"{best}: {in_words(over_noise[best], '{:.3f}')}",
            float(over_noise[best].median()) <= 1.05,
        ),
    ]


def _mean_claim(study: Study, other: str, words: str) -> Claim:
    """That the proposed method's mean on its own run is at least 70 % nearer to zero than another's."""
    ours, theirs = mean(study.left[PROPOSED][FITTED]).abs(), mean(study.left[other][FITTED]).abs()
    value = f"{float(ours.median()):.1e} against {float(theirs.median()):.1e} °/h"
    return Claim(f"PSO's |mean| is at least 70 % below {words}", value, float(ours.median()) <= 0.3 * float(theirs.median()))


def _above(ratio: Tensor) -> bool:
    return float(ratio.median()) > 1.0


def _share(removed: Tensor) -> str:
    """In per cent, or how many times what was there, where it is more."""
    middle = float(torch.quantile(removed, 0.5))
    return in_words(removed) if middle > -1 else f"it leaves {in_words(1.0 - removed, '{:.0f}')} times what was there"
