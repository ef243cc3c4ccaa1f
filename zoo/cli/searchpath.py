"""Where the user's own configs lie."""

from __future__ import annotations

from pathlib import Path

from hydra.core.hydra_config import HydraConfig


def searchpath() -> list[Path]:
    """The user's own config folders, as given by `hydra.searchpath`; none where a config was composed outside of a Hydra application."""
    if not HydraConfig.initialized():
        return []
    sources = HydraConfig.get().runtime.config_sources
    return [Path(source.path) for source in sources if source.schema == "file" and source.provider not in {"main", "hydra"}]
