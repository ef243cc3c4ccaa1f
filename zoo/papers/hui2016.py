"""Wavelet network for a quartz vibrating-beam accelerometer: J. Ordnance Equipment Eng. 37(7), 2016, doi 10.11809/scbgxb2016.07.026."""

from __future__ import annotations

from functools import cache

import torch
from torch import Tensor

from zoo.given import check_number
from zoo.measurements.run import Run
from zoo.papers.study import Claim, Row, Study, in_words, row
from zoo.scoring.comparison import UNCOMPENSATED, WHOLE
from zoo.scoring.stages import rms
from zoo.simulator.accelerometer.alignment import AXES, Alignment, simulate_alignment
from zoo.simulator.accelerometer.in_process import as_run

LINE, NETWORK, TRAINED, KNOWN = "line", "wavelet network", "wavelet network by L-BFGS", "known point by point"
LARGEST, VARIANCE, ACCELEROMETER, ATTITUDE = "largest error", "variance", "RMS of the level accelerometers", "largest attitude error"
PRINTED = {LINE: (1.3211, 0.138), NETWORK: (0.0021, 2.834e-9)}
"""Largest error [pulses] and variance of what is left of the fitted counts."""
REMARKS = (
    "By gradient descent on all 48 counts at once, with the printed rate 0.7 and 1000 epochs, the network is hardly better than the line.",
    "By L-BFGS the same network comes to the printed largest error, by Levenberg–Marquardt to the noise, but for one training in a hundred.",
    "The alignment is that of inertial units, each with three accelerometers and networks of its own: fitted at one power-on, judged at the next.",
    "No model of the first power-on knows the bias that comes anew with the next, nor how the table is set then: 'known point by point' is one that "
    "knows every count of the first.",
)
"""What there is to know about the claims."""
WANTED_DEG = 0.005
LEVEL = (AXES.index("east"), AXES.index("north"))
"""The accelerometers that tell pitch and roll."""


@cache
def units(count: int) -> tuple[Alignment, ...]:
    """Inertial units 1 … `count`, each powered on twice on the table."""
    return tuple(simulate_alignment(seed=seed) for seed in range(1, count + 1))


def accelerometers(count: int) -> dict[str, tuple[list[Run], list[Run]]]:
    """The runs of every accelerometer of some units: the power-on that is fitted, and the next.

    Args:
        count: of units.

    Raises:
        InputError: not a number of units.
    """
    check_number("others.count", count, 1, whole=True)
    found = {}
    for number, done in enumerate(units(count), 1):
        for axis in AXES:
            first, second = (as_run(done.recorded(name)[axis], f"unit_{number}_{axis}_{name}") for name in ("run_1", "check"))
            found[_name(number, axis)] = ([first], [second])
    return found


def _name(number: int, axis: str) -> str:
    return f"unit {number} {axis}"


def levelled(study: Study, model: str) -> tuple[Tensor, Tensor]:
    """What a method leaves of the second power-on of U units.

    Args:
        study: with the runs of `accelerometers` as its others.
        model: one of its methods, `UNCOMPENSATED` or `KNOWN`.

    Returns:
        (U, 3, T) of the accelerometers by themselves, without the turn of the table [pulses], and (U, 2, T) of pitch and roll [°].
    """
    single, angles = [], []
    for number, done in enumerate(units(len(study.others) // len(AXES)), 1):
        left = {axis: _left(study.others[_name(number, axis)], model) for axis in AXES}
        first, second = done.recorded("run_1"), done.recorded()
        turned = {axis: second[axis].truth["fixture_rotation_pulses"] - first[axis].truth["fixture_rotation_pulses"] for axis in AXES}
        single.append(torch.stack([left[axis] - turned[axis] for axis in AXES]))
        found = done.attitude({axis: second[axis].error - left[axis] for axis in AXES})
        angles.append(torch.stack(found) - torch.tensor([[done.pitch_deg], [done.roll_deg]], dtype=torch.float64))
    return torch.stack(single), torch.stack(angles)


def _left(other: Study, model: str) -> Tensor:
    """(T,) of one accelerometer's second power-on [pulses]."""
    first, second = (left[0] for left in other.left[UNCOMPENSATED])
    return second - first if model == KNOWN else other.left[model][1][0]


def rows(study: Study) -> list[Row]:
    """The fit's figures beside the printed ones, the same of another power-on, and those of the alignment."""
    found = []
    for model in study.left:
        for sample, name in enumerate(("fitted", "next power-on")):
            left, printed = study.left[model][sample], PRINTED.get(model, (None, None)) if sample == 0 else (None, None)
            found.append(row(left.abs().amax(-1), LARGEST, "pulses", WHOLE, name, model, printed[0]))
            found.append(row(left.var(-1), VARIANCE, "pulses²", WHOLE, name, model, printed[1]))
    for model in [*study.left, KNOWN] if study.others else []:
        single, angles = levelled(study, model)
        found.append(row(single[:, LEVEL].square().mean((1, 2)).sqrt(), ACCELEROMETER, "pulses", WHOLE, "alignment", model, None))
        found.append(row(angles.abs().amax((1, 2)), ATTITUDE, "°", WHOLE, "alignment", model, None))
    return found


def claims(study: Study, floors: list[float]) -> list[Claim]:
    """What the paper says of its network, and what is asked of the zoo's.

    Args:
        study: with the methods `LINE`, `NETWORK` and `TRAINED`, and others.
        floors: RMS that a complete model would leave of each run [pulses].
    """
    line = study.left[LINE][0].var(-1)
    best = min(study.methods, key=lambda name: float(study.left[name][0].var(-1).median()))
    found = []
    for name, called in ((NETWORK, "trained as printed, the wavelet network's"), (TRAINED, f"the {TRAINED}'s"), (best, "the best method's")):
        ratio = study.left[name][0].var(-1) / line
        text = f"{called} variance is at least 1000 times below the line's"
        found.append(Claim(text, f"{name}: {in_words(ratio, '{:.2g}')} of it", float(ratio.median()) <= 1e-3))
    room = floors[0] ** 2 / float(line)
    found.append(Claim("noise alone is at least 1000 times below the line's", f"{room:.2g} of it", room <= 1e-3))
    return found + (_alignment(study) if study.others else [])


def _alignment(study: Study) -> list[Claim]:
    """The claims on attitude."""
    single, angles = {}, {}
    for name in (LINE, TRAINED, KNOWN):
        single[name], angles[name] = levelled(study, name)
    missed = {name: int((angle.abs().amax((1, 2)) > WANTED_DEG).sum()) for name, angle in angles.items()}
    total = len(angles[LINE])
    one = {name: float(angle[0].abs().max()) for name, angle in angles.items()}
    claims = [
        Claim(
            f"in one unit, the paper's case, all attitudes are within {WANTED_DEG}° with the {TRAINED}, and with the line not",
            f"unit 1: {one[TRAINED]:.4f}°, {one[LINE]:.4f}°",
            one[TRAINED] <= WANTED_DEG < one[LINE],
        ),
        Claim(f"with the line some attitudes are off by more than {WANTED_DEG}°", f"in {missed[LINE]} of {total} units", missed[LINE] > 0),
        Claim(f"with the {TRAINED} none is", f"in {missed[TRAINED]} of {total} units", missed[TRAINED] == 0),
        Claim(
            "it misses in no more units than a model that knows every count of the first power-on",
            f"{missed[TRAINED]} and {missed[KNOWN]} of {total}",
            missed[TRAINED] <= missed[KNOWN],
        ),
    ]
    for kind, parts, printed in (("accelerometers'", single, 0.73), ("attitude's", angles, 0.60)):
        shown = {name: rms(part[:, LEVEL] if parts is single else part) for name, part in parts.items()}
        gain, most = (1 - shown[name] / shown[LINE] for name in (TRAINED, KNOWN))
        text = f"the {kind} error falls by {printed:.0%} against the line's, to 5 points"
        claims.append(Claim(text, f"{gain:.1%}; with every count known {most:.1%}", abs(gain - printed) <= 0.05))
    return claims
