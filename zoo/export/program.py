"""A trained model by `torch.export`: a graph of tensor operations without Python, for torch alone, AOTInductor or other compilers."""

from __future__ import annotations

import io
from importlib.util import find_spec

import torch
from torch import Tensor, nn
from torch.export import Dim, ExportedProgram
from torch.fx import GraphModule

from zoo.errors import InputError, WorkError
from zoo.export.carried import CHUNK, in_pieces
from zoo.export.feature_scan import FeatureScan
from zoo.export.recipe import is_static, recipes
from zoo.export.still import still
from zoo.models.base import FeatureModel, Model
from zoo.models.ranges import Ranges, limits

LONGEST = 2**26
"""Rows of the longest run that the exported `forward` takes: 93 h at 200 Hz."""
SCANS = find_spec("torch._higher_order_ops.scan") is not None
"""Whether this torch writes down loops that hand a state on, as graphs of effects need; 2.4 does not."""


class Checked(nn.Module):
    """What `zoo.export.torchscript.Exported` makes of rows that cannot be used, or may not: NaN, and no trace of the former."""

    low: Tensor
    high: Tensor

    def __init__(self, core: nn.Module, scan: FeatureScan, ranges: Ranges, refuse_outside: bool) -> None:
        """Put together.

        Args:
            core: for rows of finite numbers whose time rises, and the features made of them.
            scan: makes the features.
            ranges: within which the model was trained.
            refuse_outside: whether a row outside of them gets NaN.
        """
        super().__init__()
        self.core = core
        self.scan = scan
        self.refuse_outside = refuse_outside
        between = limits([*scan.inputs, *(one.name for one in scan.recipes)], ranges)
        for name, values in zip(("low", "high"), zip(*between, strict=True), strict=True):
            self.register_buffer(name, torch.tensor(values, dtype=torch.float64))

    def judged(self, x: Tensor, features: Tensor, predicted: Tensor, usable: Tensor) -> Tensor:
        """(..., C) rows, (..., F) features, (...) predictions and whether the rows are usable -> (...) predictions, or NaN."""
        if self.refuse_outside:
            values = torch.cat([x, features], dim=-1)
            usable = usable & ((values >= self.low) & (values <= self.high)).all(dim=-1)
        return torch.where(usable, predicted, torch.nan)


class CheckedWhole(Checked):
    """A whole run, (N, C) -> (N,)."""

    def forward(self, x: Tensor) -> Tensor:
        """(N, C) raw columns -> (N,) predicted error; NaN for a row with a number that is not finite, or not later than all such rows before it."""
        finite = torch.isfinite(x).all(dim=1)
        time = torch.where(finite, x[:, 0], -torch.inf)
        place = torch.arange(x.shape[0], device=x.device)
        latest = torch.cummax(time, dim=0)[0][(place - 1).clamp_min(0)]
        usable = finite & ((time > latest) | (place == 0))
        # A graph knows no run whose length depends on what is in it: the usable rows first, then as many later ones as the others are.
        count = usable.sum()
        rows = x[torch.argsort((~usable).to(torch.int64), stable=True)]
        last = rows.index_select(0, (count - 1).clamp_min(0).unsqueeze(0))
        after = (place - count + 1).clamp_min(0).unsqueeze(-1)
        later = torch.cat([last[:, :1] + after.to(x.dtype), last[:, 1:].expand(x.shape[0], -1)], dim=1)
        kept = torch.where(after > 0, later, rows)
        features = self.scan(kept, self.scan.fresh())[0]
        predicted = self.core(kept, features)
        where = (usable.cumsum(0) - 1).clamp_min(0)
        return self.judged(x, features[where], predicted[where], usable)


class CheckedStep(Checked):
    """One sample, the state handed in and out: (C,), (1 + S,) -> (), (1 + S,).

    The first of the state is the time of the last row that was used, then comes what the features remember, then what the core does.
    """

    def forward(self, x: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """The next sample's prediction and the state after it; a state of NaN is before the first sample."""
        usable = torch.isfinite(x).all() & ~(x[0] <= state[0])
        features, seen = self.scan(x.unsqueeze(0), state[1 : 1 + self.scan.size])
        predicted, after = self.core(x, features[0], state[1 + self.scan.size :])
        return self.judged(x, features[0], predicted, usable), torch.where(usable, torch.cat([x[:1], seen, after]), state)


class FeatureWhole(nn.Module):
    """A whole run of a network, (N, C), (N, F) -> (N,)."""

    def __init__(self, model: FeatureModel) -> None:
        super().__init__()
        self.model = model

    def forward(self, x: Tensor, features: Tensor) -> Tensor:
        """(N, C) raw columns, finite, the time rising, and (N, F) features -> (N,) predicted error."""
        return self.model.head(features)


class FeatureStep(FeatureWhole):
    """One sample of a network, which has no state of its own: (C,), (F,), (0,) -> (), (0,)."""

    def forward(self, x: Tensor, features: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:  # type: ignore[override]
        """See `CheckedStep`."""
        return self.model.head(features), state


class CarriedWhole(nn.Module):
    """A whole run of any other model: its first row, then chunk after chunk, (N, C), (N, F) -> (N,)."""

    def __init__(self, first: nn.Module, chunk: nn.Module) -> None:
        """Put together.

        Args:
            first: see `zoo.export.carried`.
            chunk: for `CHUNK` rows that follow others, as a graph.
        """
        super().__init__()
        self.first = first
        self.chunk = chunk

    def forward(self, x: Tensor, features: Tensor) -> Tensor:
        """(N, C) raw columns, finite, the time rising -> (N,) predicted error; by its features it is only watched."""
        from torch._higher_order_ops.scan import scan  # only where `SCANS`

        first, state = self.first(x[:1])
        rows = x.shape[0] - 1
        # Chunks are looked up row by row, since a graph knows no run whose length happens to fit. Rows after the last one change nothing before it.
        place = 1 + CHUNK * torch.arange(rows // CHUNK + 2, device=x.device).unsqueeze(-1) + torch.arange(CHUNK, device=x.device)
        later = (place - rows).clamp_min(0).to(x.dtype)
        known = x[place.clamp_max(rows)]
        chunks = torch.cat([known[..., :1] + later.unsqueeze(-1), known[..., 1:]], dim=-1)
        _, predicted = scan(self._follow, state, chunks, dim=0)
        row = torch.arange(x.shape[0], device=x.device)
        after = (row - 1).clamp_min(0)
        return torch.where(row == 0, first, predicted[after // CHUNK, after % CHUNK])

    def _follow(self, state: Tensor, chunk: Tensor) -> tuple[Tensor, Tensor]:
        predicted, state = self.chunk(chunk, state)
        return state, predicted


class CarriedStep(nn.Module):
    """One sample of any other model, the state handed in and out: (C,), (F,), (S,) -> (), (S,)."""

    def __init__(self, first: nn.Module, following: nn.Module) -> None:
        super().__init__()
        self.first = first
        self.following = following

    def forward(self, x: Tensor, features: Tensor, state: Tensor) -> tuple[Tensor, Tensor]:
        """See `CheckedStep`."""
        fresh = torch.isnan(state).all()
        row = x.unsqueeze(0)
        at_first, begun = self.first(row)
        predicted, after = self.following(row, state)
        return torch.where(fresh, at_first, predicted)[0], torch.where(fresh, begun, after)


def to_programs(model: Model, x: Tensor, ranges: Ranges, refuse_outside: bool = False) -> tuple[bytes, bytes]:
    """The files ``model.pt2`` (whole runs) and ``step.pt2`` (one sample).

    Args:
        model: trained; not changed.
        x: (T, C) raw columns of a record like those it will see, some thousand rows.
        ranges: within which it was trained.
        refuse_outside: whether a row outside of them gets NaN.

    Raises:
        InputError: a model of this kind cannot be exported.
        WorkError: the same, for a reason that lies in one of its parts.
    """
    try:
        return _programs(still(model), x, ranges, refuse_outside)
    except (InputError, WorkError):
        raise
    except Exception as error:  # whatever comes out of torch's tracing
        told = next((line.strip() for line in str(error).splitlines() if line.strip()), type(error).__name__)
        raise WorkError(f"{type(model).__name__}: torch.export does not take it ({told})\nprogram=false leaves model.pt2 and step.pt2 out") from error


def _programs(model: Model, x: Tensor, ranges: Ranges, refuse_outside: bool) -> tuple[bytes, bytes]:
    whole: nn.Module
    step: nn.Module
    if isinstance(model, FeatureModel) and is_static(model):
        made_of, state = recipes(model, ranges), x.new_zeros(0)
        whole, step = FeatureWhole(model), FeatureStep(model)
    elif not SCANS:
        raise InputError(f"physical effects as model.pt2 need a newer torch than {torch.__version__}: program=false writes model.ts alone")
    else:
        made_of = recipes(model, ranges) if refuse_outside else []  # nothing here tells what it does not refuse
        first, following = in_pieces(model, x)
        state = torch.full_like(first(x[:1])[1], torch.nan)
        chunk = _with_buffers(torch.export.export(following, (x[1 : 1 + CHUNK], state)).module())
        whole, step = CarriedWhole(first, chunk), CarriedStep(first, following)
    many, one = FeatureScan(made_of, model.inputs, LONGEST), FeatureScan(made_of, model.inputs, 1)
    whole, step = CheckedWhole(whole, many, ranges, refuse_outside), CheckedStep(step, one, ranges, refuse_outside)
    state = torch.cat([torch.full_like(x[0, :1], torch.nan), one.fresh(), state])
    rows = Dim("rows", min=1, max=LONGEST)
    program = torch.export.export(whole, (x[: 2 * CHUNK + 40],), dynamic_shapes=({0: rows},))
    return _saved(program), _saved(torch.export.export(step, (x[0], state)))


def _with_buffers(module: nn.Module) -> nn.Module:
    """The same with the constants of its graph as buffers: `scan` takes no others."""
    for part in module.modules():
        for name, value in [(name, value) for name, value in vars(part).items() if isinstance(value, Tensor)]:
            delattr(part, name)
            part.register_buffer(name, value)
    return module


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
