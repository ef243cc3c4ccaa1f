"""What `diagnose` and `refine` are asked about: a sum of effects, or a trained model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from omegaconf import DictConfig, open_dict

from zoo.cli.command_line import is_typed
from zoo.cli.effects import catalogue, model_effects
from zoo.cli.saved_models import SavedModel, find_model
from zoo.effects.base import Effect
from zoo.errors import InputError
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.models.trained import Trained


@dataclass(frozen=True, eq=False)
class Subject:
    """The model as it stands, as a sum of effects; a network is one of them.

    Attributes:
        effects: names in the sum.
        catalogue: every effect by name.
        saved: the trained model that was given; None where effects alone are asked about.
        network: its part that is no effect; None where there is none.
        term: what the network is called in the sum.
        more: whether effects were named that the trained model does not have.
    """

    effects: list[str]
    catalogue: dict[str, Effect]
    saved: SavedModel | None = None
    network: Model | None = None
    term: str = ""
    more: bool = False

    @property
    def as_given(self) -> Model | None:
        """The trained model, where it is the model as it stands."""
        return None if self.saved is None or self.more else self.saved.module

    def linearised(self, runs: Sequence[Run], also: Sequence[Model] = ()) -> Subject:
        """The same with the network linearised where the runs need it, see `Trained`."""
        if self.network is None:
            return self
        return replace(self, catalogue={**self.catalogue, self.term: Trained(self.term, self.network, runs, also)})


def subject(config: DictConfig, runs: list[Run], wanted: list[str] | None = None) -> Subject:
    """What a config asks about: a trained model where `model=` gives one, with the effects named beside it; else the effects.

    Args:
        config: with `model`, `effects` and `candidates`.
        runs: to be fitted.
        wanted: effects needed besides those of the model; by default what `candidates` allows.

    Raises:
        InputError: no such model or effect, or the model is of another unit than the runs.
    """
    if config.model.folder is None:
        return Subject(model_effects(config), catalogue(config, wanted))
    saved = find_model("model", str(config.model.folder))
    unit = saved.facts.get("unit", runs[0].unit)
    if unit != runs[0].unit:
        raise InputError(f"model={saved.folder}: was trained on errors in {unit}; {runs[0].name} is in {runs[0].unit}")
    asked = config.copy()
    if not is_typed("effects"):
        with open_dict(asked):
            asked.effects = {}  # the defaults are of a sum of effects that was not asked about
    network, own = _parts(saved.module)
    if network is not None and not any(weights.numel() for weights in network.parameters()):
        why = "has no weights, by which to find what a model lacks beside what it could have learnt"
        raise InputError(f"model={saved.folder}: {saved.kind} {why}; possible: a model with weights, such as bp, or a sum of effects")
    wished, known = list(asked.get("effects") or {}), catalogue(asked, wanted)
    more = [name for name in wished if name not in own]
    term = "" if network is None else saved.kind if saved.kind not in known else f"{saved.kind}_model"
    names = [*([term] if term else []), *own, *more]
    return Subject(names, {**known, **own}, saved, network, term, bool(more)).linearised(runs)


def _parts(model: Model) -> tuple[Model | None, dict[str, Effect]]:
    """The part of a model that is no effect, and its effects."""
    if isinstance(model, GrayBox):
        return None, dict(model.named_effects())
    return (model.network, dict(model.physics.named_effects())) if isinstance(model, Hybrid) else (model, {})
