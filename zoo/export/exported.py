"""An exported file, loaded again: a model of which nothing is known but its columns and its unit."""

# No `from __future__ import annotations` in the files of models: TorchScript reads class annotations.
import hashlib
import io
import json
import warnings
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from zoo.errors import InputError
from zoo.export.files import METADATA, SCRIPT
from zoo.models.base import Model
from zoo.models.features import Features
from zoo.models.ranges import TIME, Ranges, checked


class ExportedModel(Model):
    """The file behind the interface of the zoo's models.

    Attributes:
        script: what was in the file.
        ranges: within which it was fitted, by raw column, rate and lag.
        watched: the rates and lags among these, and the time where it counts; None where there are none.
    """

    def __init__(self, script: torch.nn.Module, inputs: list[str], ranges: Ranges) -> None:
        super().__init__()
        self.script = script
        self.inputs = inputs
        self.ranges = ranges
        made, stream = [name for name in ranges if name not in inputs or name == TIME], getattr(script, "stream", None)
        smoothed = [] if stream is None else [tau for tau, is_rate in zip(stream.tau, stream.is_rate, strict=True) if is_rate]
        self.watched = Features(made, *smoothed[:1]) if made else None

    def forward(self, x: Tensor) -> Tensor:
        """Predict the error, see `Model.forward`."""
        predicted: Tensor = self.script(x)
        return predicted


def load_exported(folder: Path) -> tuple[ExportedModel, dict[str, Any]]:
    """Load ``model.ts`` by torch alone, and what ``metadata.json`` beside it says.

    Args:
        folder: the two files'.

    Raises:
        InputError: one of them is missing or is not what it should be.
    """
    try:
        facts = json.loads((folder / METADATA).read_text(encoding="utf-8"))
        inputs = [str(name) for name in facts["inputs"]]
        ranges = checked({name: known for name, known in (facts.get("trained_range") or {}).items() if known})
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DeprecationWarning)  # TorchScript as a whole is deprecated
            file = (folder / SCRIPT).read_bytes()
            model = ExportedModel(torch.jit.load(io.BytesIO(file), map_location="cpu").eval(), inputs, ranges)
    except OSError as error:
        raise InputError(f"{folder}: no exported model here ({error.strerror}: {METADATA}); {SCRIPT} and {METADATA} are needed") from error
    except (ValueError, KeyError, TypeError, RuntimeError, AttributeError, InputError) as error:
        raise InputError(f"{folder}: {SCRIPT} and {METADATA} are not what fogzoo export writes ({' '.join(str(error).split())[:120]})") from error
    told = (facts.get("files") or {}).get(SCRIPT, {}).get("sha256")
    if told not in (None, hashlib.sha256(file).hexdigest()):
        raise InputError(f"{folder}: {SCRIPT} is not the file that {METADATA} tells of; export the model again")
    return model, facts
