"""Launchers and sweepers that come in packages of their own."""

from __future__ import annotations

import re

PACKAGES = {
    "joblib": ("hydra/launcher=joblib", "pip install 'fogzoo[sweep]'"),
    "submitit": ("hydra/launcher=submitit_…", "pip install 'fogzoo[sweep]'"),
    "optuna": ("hydra/sweeper=optuna", "pip install 'fogzoo[sweep]'"),
    "ray": ("hydra/launcher=ray", "pip install ray && pip install --no-deps hydra-ray-launcher"),
}
"""What is typed for each plugin, and what brings it. Ray's plugin asks for packages of Python 3.7 that it does not use on one machine."""


def missing_plugin(error: BaseException) -> str | None:
    """What to install, in a line, where an exception says that a plugin of Hydra's is not there; None where it says something else."""
    found = re.search(r"Unknown plugin class : 'hydra_plugins\.hydra_(\w+?)_(?:launcher|sweeper)|'hydra/sweeper/sampler/(\w+)'", str(error))
    if found is None:
        return None
    typed, install = PACKAGES[found.group(1) or "optuna"]
    return f"{typed}: its plugin is not installed: {install}"
