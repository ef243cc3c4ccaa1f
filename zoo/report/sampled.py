"""How much was measured, and in which noise."""

from __future__ import annotations

import math

from zoo.report.verdict import Record, badly_trained
from zoo.report.wording import Scale, finite, fixed, significant
from zoo.units import convert


def sampled_facts(diagnosis: Record, scale: Scale) -> list[tuple[str, str]]:
    """Label and text: blocks, how many independent ones they are worth, and the noise.

    The white noise is given as the angle random walk N as well, σ = N/√τ, which no longer depends on the blocks' length τ.

    Args:
        diagnosis: its `noise` has the white RMS of a block, the bias instability B [unit] and the random walk K [unit/√h].
        scale: how values are written.
    """
    noise = _noise(diagnosis.get("noise"), scale)
    counted = "; what is unexplained is counted as noise here" if noise and _unexplained(diagnosis) else ""
    facts = [("Blocks", _blocks(diagnosis)), ("Noise", noise + counted), ("Angle random walk", _angle_random_walk(diagnosis, scale))]
    return [(label, text) for label, text in facts if text]


def known_noise(diagnosis: Record) -> Record:
    """The noise in its colours; where something stays unexplained they would hold that, and only the white noise is known."""
    if _unexplained(diagnosis):
        return {"white": diagnosis.get("noise_floor")}
    return diagnosis.get("noise") or {}


def _unexplained(diagnosis: Record) -> bool:
    return diagnosis.get("verdict") == "unknown" and not badly_trained(diagnosis)


def _angle_random_walk(diagnosis: Record, scale: Scale) -> str:
    """N = σ·√τ [unit·√h]."""
    white, block = finite(known_noise(diagnosis).get("white")), finite(diagnosis.get("average_s"))
    if not white or not block:
        return ""
    unit = scale.label.replace("/h", "/√h") if scale.label.endswith("/h") else f"{scale.label}·√h"
    walk = white * math.sqrt(convert(block, "s", "h")) * scale.factor
    return f"N {significant(walk, 2)} {unit}"


def _blocks(diagnosis: Record) -> str:
    count, worth = finite(diagnosis.get("samples")), finite(diagnosis.get("effective_samples"))
    if count is None:
        return ""
    if worth is None or round(worth) >= round(count):
        return f"{count:.0f}"
    return f"{count:.0f}, worth {significant(worth, 2) if worth < 99.5 else fixed(worth, 0)} independent ones"


def _noise(noise: Record | None, scale: Scale) -> str:
    """The colours that there are."""
    colours = (("white", "white", ""), ("flicker", "flicker B", ""), ("walk", "random walk K", "/√h"))
    known = [(words, finite((noise or {}).get(key)), per) for key, words, per in colours]
    return ", ".join(f"{words} {significant(value * scale.factor, 2)} {scale.label}{per}" for words, value, per in known if value)
