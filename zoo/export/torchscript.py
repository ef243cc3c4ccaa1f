"""A trained model as TorchScript: one file that Python or C++ runs with torch alone, whole runs or sample by sample.

TorchScript is deprecated and works; all that the house has of it for files is in here, beside `zoo.export.program`, its successor.
"""

# No `from __future__ import annotations`: TorchScript reads class annotations.
import io
import math
import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import torch
from torch import Tensor, nn
from torch.jit._trace import TracerWarning

from zoo.errors import WorkError
from zoo.export.carried import CHUNK, in_pieces
from zoo.export.feature_stream import FeatureStream
from zoo.export.recipe import is_static, recipes
from zoo.export.still import still
from zoo.models.base import FeatureModel, Model
from zoo.models.ranges import Ranges, limits


class Core(nn.Module):
    """Abstract: a model over whole runs and one sample at a time."""

    def forward(self, x: Tensor) -> Tensor:
        """(T, C) raw columns -> (T,) predicted error; the state of `step` is not touched."""
        raise NotImplementedError

    def step(self, x: Tensor, features: list[float]) -> Tensor:
        """The next sample, (C,) raw columns and (F,) features -> () predicted error."""
        raise NotImplementedError

    def forget(self) -> None:
        """Back to before the first sample."""
        raise NotImplementedError


class FeatureCore(Core):
    """A network as it was trained, and the same one sample at a time; on the CPU, there, what the weights alone decide is computed once."""

    def __init__(self, model: FeatureModel, features: int) -> None:
        super().__init__()
        self.model = model
        self.head = _with_constants(model, features)

    def forward(self, x: Tensor) -> Tensor:
        """See `Core.forward`."""
        predicted: Tensor = self.model(x)
        return predicted

    def forget(self) -> None:
        """See `Core.forget`; a static map remembers nothing."""

    def step(self, x: Tensor, features: list[float]) -> Tensor:
        """See `Core.step`."""
        table = torch.empty([len(features)], dtype=x.dtype, device=x.device)
        for i, value in enumerate(features):
            table.select(0, i).fill_(value)  # torch.tensor(features) and table[i] = value go through single precision in TorchScript
        predicted: Tensor = self.model.head(table) if x.is_cuda else self.head(table)
        return predicted


class CarriedCore(Core):
    """Any other model, traced: the first row, the next one, and as many at once as `forward` takes for speed."""

    state: Tensor

    def __init__(self, first: nn.Module, following: nn.Module, chunk: nn.Module, size: int) -> None:
        super().__init__()
        self.first = first
        self.following = following
        self.chunk = chunk
        self.size = size
        self.begun = False
        self.register_buffer("state", torch.zeros(0, dtype=torch.float64))

    def forward(self, x: Tensor) -> Tensor:
        """See `Core.forward`."""
        predicted, state = self.first(x[:1])
        parts = [predicted]
        missing = (1 - x.size(0)) % self.size
        # Rows after the last change nothing before them.
        later = x[-1:].repeat(missing, 1)
        later[:, 0] += torch.arange(1, missing + 1, dtype=x.dtype, device=x.device)
        rows = torch.cat([x[1:], later])
        for i in range(0, rows.size(0), self.size):
            predicted, state = self.chunk(rows[i : i + self.size], state)
            parts.append(predicted)
        return torch.cat(parts)[: x.size(0)]

    def forget(self) -> None:
        """See `Core.forget`."""
        self.begun = False

    def step(self, x: Tensor, features: list[float]) -> Tensor:
        """See `Core.step`."""
        row = x.unsqueeze(0)
        if self.begun:
            predicted, self.state = self.following(row, self.state)
        else:
            predicted, self.state = self.first(row)
            self.begun = True
        return predicted[0]


class Exported(nn.Module):
    """What lies in ``model.ts``: ``forward``, ``step``, ``step_checked`` and ``reset``.

    A row is used where all its numbers are finite and its time is later than that of the last row used. Any other row gets NaN as its prediction
    and leaves no trace: the next one goes on over the gap, exactly.

    Attributes:
        inputs: names of the raw columns, the time first.
        unit: of the prediction.
        low: (C,) lowest trained value of each, less some room for noise.
        high: (C,) highest, with the same room.
        features: names of the rates and lags (and whatever else) that a network is made of, F of them.
        feature_low: (F,) their lowest trained values, less some room for noise.
        feature_high: (F,) highest, with the same room.
        refuse_outside: whether a row outside of the trained range gets NaN; its numbers are remembered all the same, as they are the gyro's past.
        last: time of the last row that `step` used [s].
    """

    inputs: list[str]
    unit: str
    low: list[float]
    high: list[float]
    features: list[str]
    feature_low: list[float]
    feature_high: list[float]
    refuse_outside: bool
    last: float

    def __init__(self, model: Model, unit: str, x: Tensor, ranges: Ranges, refuse_outside: bool) -> None:
        """Put together, see `to_torchscript`."""
        super().__init__()
        made_of = recipes(model, ranges)
        self.core = _core(model, x, len(made_of))
        self.stream = FeatureStream(made_of)
        self.inputs = list(model.inputs)
        self.unit = unit
        self.low, self.high = _ends(self.inputs, ranges)
        self.features = [one.name for one in made_of]
        self.feature_low, self.feature_high = _ends(self.features, ranges)
        self.refuse_outside = refuse_outside
        self.last = -math.inf

    def forward(self, x: Tensor) -> Tensor:
        """Predict a whole run from its first row, (N, C) raw columns in time order -> (N,)."""
        if x.dim() != 2 or x.size(1) != len(self.inputs):
            raise ValueError("forward takes (N, C) raw columns, C as many as the attribute `inputs` names")
        x = x.to(torch.float64)
        usable = self.usable(x)
        predicted = torch.full_like(x[:, 0], math.nan)
        if bool(usable.all()) and x.size(0) > 0:
            predicted = self.core(x)
        elif bool(usable.any()):
            predicted[usable] = self.core(x[usable])
        if self.refuse_outside:
            inside = within(x, self.low, self.high)
            if bool(usable.any()):
                inside[usable] &= within(self.stream.whole(x[usable]), self.feature_low, self.feature_high)
            predicted = torch.where(inside, predicted, torch.full_like(predicted, math.nan))
        return predicted

    def usable(self, x: Tensor) -> Tensor:
        """(T, C) -> (T,) bool: rows of finite numbers, later than all such rows before them."""
        finite = torch.isfinite(x).all(dim=1)
        time = torch.where(finite, x[:, 0], torch.full_like(x[:, 0], -math.inf))
        if x.size(0) < 2:
            return finite
        latest = torch.cummax(time, dim=0)[0]
        return finite & torch.cat([torch.ones_like(finite[:1]), time[1:] > latest[:-1]])

    @torch.jit.export
    def reset(self) -> None:
        """Forget the past: the next sample is the first of a run."""
        self.last = -math.inf
        self.stream.forget()
        self.core.forget()

    @torch.jit.export
    def step(self, x: Tensor) -> Tensor:
        """Predict the next sample, (C,) raw columns -> ()."""
        return self.advance(self.checked(x))[0]

    @torch.jit.export
    def step_checked(self, x: Tensor) -> tuple[Tensor, Tensor]:
        """The same, with (C,) bool: whether each number is within the trained range, and the time later than before.

        Of a row that is used, a number counts as within only with its rate and its lags.
        """
        x = self.checked(x)
        predicted, inside = self.advance(x)
        flags = torch.empty([len(inside)], dtype=torch.bool, device=x.device)
        for i, one in enumerate(inside):
            flags.select(0, i).fill_(one)
        return predicted, flags

    def checked(self, x: Tensor) -> Tensor:
        """The sample in double precision; another shape is refused."""
        if x.dim() != 1 or x.size(0) != len(self.inputs):
            raise ValueError("step takes (C,) raw columns, C as many as the attribute `inputs` names")
        return x.to(torch.float64)

    def advance(self, x: Tensor) -> tuple[Tensor, list[bool]]:
        """Use one sample, or leave it out; with whether each of its numbers is within the trained range, see `step_checked`."""
        now: list[float] = x.tolist()
        usable = True
        inside: list[bool] = []
        for i, value in enumerate(now):
            usable = usable and math.isfinite(value)
            inside.append(value >= self.low[i] and value <= self.high[i])
        later = now[0] > self.last and math.isfinite(now[0])
        inside[0] = inside[0] and later
        if not (usable and later):
            return torch.full([], math.nan, dtype=torch.float64, device=x.device), inside
        self.last = now[0]
        features = self.stream(now)
        for i, value in enumerate(features):
            column = self.stream.column[i]
            inside[column] = inside[column] and value >= self.feature_low[i] and value <= self.feature_high[i]
        predicted = self.core.step(x, features)
        if self.refuse_outside and not all(inside):
            predicted = torch.full_like(predicted, math.nan)
        return predicted, inside


def within(x: Tensor, low: list[float], high: list[float]) -> Tensor:
    """(T, C) and a range for each column -> (T,) bool: rows of which all numbers lie within; in the subset of Python that TorchScript takes."""
    inside = torch.ones([x.size(0)], dtype=torch.bool, device=x.device)
    for i, (lowest, highest) in enumerate(zip(low, high)):  # noqa: B905 (TorchScript's zip knows no `strict`)
        inside = inside & (x[:, i] >= lowest) & (x[:, i] <= highest)
    return inside


def _ends(names: list[str], ranges: Ranges) -> tuple[list[float], list[float]]:
    """Lowest and highest value that is taken for trained, by name."""
    found = limits(names, ranges)
    return [low for low, _ in found], [high for _, high in found]


def to_torchscript(model: Model, unit: str, x: Tensor, ranges: Ranges, refuse_outside: bool = False) -> bytes:
    """The file ``model.ts``.

    Args:
        model: trained; not changed.
        unit: of its prediction.
        x: (T, C) raw columns of a record like those it will see, some thousand rows.
        ranges: within which it was trained.
        refuse_outside: see `Exported`.

    Raises:
        InputError: a model of this kind cannot be exported.
        WorkError: TorchScript does not take it.
    """
    file = io.BytesIO()
    with _quiet():
        try:
            torch.jit.save(torch.jit.script(Exported(still(model), unit, x, ranges, refuse_outside).eval()), file)
        except RuntimeError as error:
            if isinstance(error, WorkError):
                raise
            raise WorkError(f"{type(model).__name__}: TorchScript does not take it: {str(error).strip().splitlines()[0]}") from error
    return _without_sources(file.getvalue())


def _core(model: Model, x: Tensor, features: int) -> Core:
    if isinstance(model, FeatureModel) and is_static(model):
        return FeatureCore(model, features)
    first, following = in_pieces(model, x)
    with torch.no_grad():
        state = first(x[:1])[1]
        one, many = _traced(following, x[1:2], state), _traced(following, x[1 : 1 + CHUNK], state)
        return CarriedCore(_traced(first, x[:1]), one, many, CHUNK)


def _traced(module: nn.Module, *arguments: Tensor) -> nn.Module:
    traced: nn.Module = torch.jit.trace(module.eval(), arguments, check_trace=False)  # what the whole file says is compared with the model later
    return traced


def _with_constants(model: FeatureModel, features: int) -> Any:
    """The head for one sample, with the weights as constants: what depends on nothing else is computed once. Only a function's trace has them so."""

    def head(values: Tensor) -> Tensor:
        return model.head(values)

    return torch.jit.trace(head, torch.zeros(features, dtype=torch.float64), check_trace=False)


def _without_sources(file: bytes) -> bytes:
    """The same less the records that say from which file of this machine each line of code comes."""
    kept = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(file)) as old, zipfile.ZipFile(kept, "w", zipfile.ZIP_STORED) as new:
        for record in old.infolist():
            if not record.filename.endswith(".debug_pkl"):
                new.writestr(record, old.read(record))
    return kept.getvalue()


def load_torchscript(file: bytes) -> Any:
    """What `to_torchscript` made, as a module."""
    with _quiet():
        return torch.jit.load(io.BytesIO(file))


@contextmanager
def _quiet() -> Iterator[None]:
    """Without torch's remarks that TorchScript has a successor, and that a trace holds for chunks of one length only."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", category=DeprecationWarning, module="torch")
        warnings.filterwarnings("ignore", message=".*torch.jit.*")
        warnings.filterwarnings("ignore", category=TracerWarning)
        yield
