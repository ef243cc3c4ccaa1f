"""Whether a thermometer reads what no temperature does: for a moment or for longer, as one that has lost its contact."""

from __future__ import annotations

import numpy as np

LEAST_K, FASTEST_K_PER_MIN = 10.0, 60.0
"""Change between neighbouring readings, and rate of it, beyond both of which no chamber has moved a gyro: thermal shock tests reach 30 K/min."""
NAMED = 3
"""More moments than this are counted, not named."""


def jumps(name: str, time_s: np.ndarray, readings: np.ndarray, segment: np.ndarray) -> list[str]:
    """A sentence where a thermometer jumps.

    Args:
        name: the thermometer's column.
        time_s: (T,) as recorded [s].
        readings: (T,) [°C].
        segment: (T,) gap-free piece of the record that each belongs to.
    """
    change, step_s = np.abs(np.diff(readings)), np.diff(time_s)
    found = np.flatnonzero((segment[1:] == segment[:-1]) & (change > LEAST_K) & (60.0 * change > FASTEST_K_PER_MIN * step_s))
    if not len(found):
        return []
    moments = [f"{time_s[place + 1]:g} s" for place in found[:NAMED]]
    more = f" and {len(found) - NAMED} more" if len(found) > NAMED else ""
    largest = found[change[found].argmax()]
    what = f"{name} jumps by up to {change[largest]:.0f} K within {step_s[largest]:g} s"
    return [f"{what} (about {', '.join(moments)}{more}): no temperature does; leave these rows out, for what remembers it is wrong long after"]
