"""Papers are asked for by name."""

from __future__ import annotations

import re

GROUP = "experiment"
"""The config group in which the papers' protocols are."""
PAPER = "paper"
"""What is typed instead."""


def paper_settings(arguments: list[str]) -> list[str]:
    """Command-line arguments with `paper=NAME` as `experiment=NAME`, the config group of the papers' protocols."""
    return [re.sub(rf"^{PAPER}=", f"{GROUP}=", one) for one in arguments]
