"""What several verbs do with their config: read the runs named in it."""

from __future__ import annotations

from pathlib import Path

from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig, OmegaConf, open_dict

from zoo.catalog import create
from zoo.measurements.run import Run


def read_data(config: DictConfig) -> tuple[list[Run], list[Run]]:
    """The runs to fit and the runs only to check on, from `config.data`.

    The block length found for the fitted runs is used for the others as well.
    """
    data = config.data.copy()
    with open_dict(data):
        check_files = OmegaConf.to_container(data.pop("check_files", OmegaConf.create([])))
    if isinstance(check_files, str):
        check_files = [check_files]
    runs = create(data)
    if not check_files:
        return runs, []
    average_s = data.average_s if data.average_s is None else runs[0].average_s
    return runs, create(data, files=check_files, average_s=average_s)


def searchpath() -> list[Path]:
    """The user's own config folders, as given by `hydra.searchpath`."""
    sources = HydraConfig.get().runtime.config_sources
    return [Path(source.path) for source in sources if source.schema == "file" and source.provider not in {"main", "hydra"}]
