"""A trained model by `torch.export`: a graph of tensor operations without Python, for torch alone, AOTInductor or other compilers."""

from __future__ import annotations

import copy
import io

import torch
from torch import Tensor, nn
from torch.export import Dim, ExportedProgram
from torch.fx import GraphModule

from zoo.errors import InputError
from zoo.export.feature_scan import FeatureScan
from zoo.export.recipe import Recipe, recipes
from zoo.models.base import FeatureModel, Model

LONGEST = 2**26
"""Rows of the longest run that the exported `forward` takes: 93 h at 200 Hz."""


class Whole(nn.Module):
    """A whole run from its first row, (N, C) -> (N,)."""

    def __init__(self, model: FeatureModel, features: list[Recipe]) -> None:
        super().__init__()
        self.model = model
        self.scan = FeatureScan(features, len(model.inputs), LONGEST)
        self.register_buffer("fresh", self.scan.fresh())

    def forward(self, x: Tensor) -> Tensor:
        """(N, C) raw columns, finite, the time rising -> (N,) predicted error."""
        return self.model.head(self.scan(x, self.fresh)[0])


class Step(nn.Module):
    """One sample, the state handed in and out: (C,), (S,) -> (), (S,)."""

    def __init__(self, model: FeatureModel, features: list[Recipe]) -> None:
        super().__init__()
        self.model = model
        self.scan = FeatureScan(features, len(model.inputs), 1)

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """The next sample's prediction and the state after it."""
        features, state = self.scan(x.unsqueeze(0), state)
        return self.model.head(features).squeeze(0), state


def to_programs(model: Model) -> tuple[bytes, bytes]:
    """The files ``model.pt2`` (whole runs) and ``step.pt2`` (one sample).

    Raises:
        InputError: a model of this kind cannot be written.
    """
    features = recipes(model)
    if features is None or not isinstance(model, FeatureModel):
        raise InputError(f"{type(model).__name__}: cannot be exported")
    still = copy.deepcopy(model).cpu().eval().requires_grad_(False)
    example = 1.0 + torch.arange(64 * len(model.inputs), dtype=torch.float64).reshape(64, -1)
    rows = Dim("rows", min=1, max=LONGEST)
    whole = torch.export.export(Whole(still, features), (example,), dynamic_shapes=({0: rows},))
    step = Step(still, features)
    return _saved(whole), _saved(torch.export.export(step, (example[0], step.scan.fresh())))


def load_program(file: bytes) -> ExportedProgram:
    """What `to_programs` made."""
    return torch.export.load(io.BytesIO(file))


def _saved(program: ExportedProgram) -> bytes:
    file = io.BytesIO()
    for graph in [module.graph for module in program.graph_module.modules() if isinstance(module, GraphModule)]:
        for node in graph.nodes:
            node.meta.pop("stack_trace", None)  # the folders of this machine
    torch.export.save(program, file)
    return file.getvalue()
