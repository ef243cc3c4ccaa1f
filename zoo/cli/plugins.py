"""Launchers and sweepers that come in packages of their own."""

from __future__ import annotations

import re

from hydra.core.config_store import ConfigStore
from hydra.core.plugins import Plugins

from zoo.catalog import config_folder

PACKAGES = {
    "joblib": ("hydra/launcher=joblib", "hydra-joblib-launcher"),
    "submitit": ("hydra/launcher=submitit_…", "hydra-submitit-launcher"),
    "optuna": ("hydra/sweeper=optuna", "hydra-optuna-sweeper"),
    "ray": ("hydra/launcher=ray", "ray && pip install --no-deps hydra-ray-launcher"),
}
"""What is typed for each plugin, and what pip is to install. Ray's plugin asks for boto3, needed only at Amazon's, and an old cloudpickle."""


def missing_plugin(error: BaseException) -> str | None:
    """What to do, in a line, where an exception says that a plugin of Hydra's, or a cluster that one is for, is not there; else None."""
    if 'Could not detect "srun"' in str(error):
        return (
            "hydra/launcher=submitit_slurm: this machine is in no Slurm cluster, srun is not there; hydra/launcher=submitit_local runs the jobs here"
        )
    found = re.search(r"Unknown plugin class : 'hydra_plugins\.hydra_(\w+?)_(?:launcher|sweeper)|'hydra/sweeper/sampler/(\w+)'", str(error))
    if found is None:
        return None
    typed, install = PACKAGES[found.group(1) or "optuna"]
    return f"{typed}: its plugin is not installed: pip install {install}"


def prefer_own_settings() -> None:
    """Makes conf/hydra/ the only place for settings of launchers and sweepers that are there.

    Plugins bring settings of the same names, against which Hydra checks ours, with a deprecation warning for every job.
    """
    Plugins.instance()  # finds the plugins, once a process
    for path in config_folder().glob("hydra/*/*.yaml"):
        stored = ConfigStore.instance().repo.get("hydra", {}).get(path.parent.name, {})
        stored.pop(path.name, None)
