"""One chamber run as tensors: what every model is fitted to and every score is computed from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import torch
from torch import Tensor

from zoo.measurements.averager import Averager
from zoo.measurements.schema import Source
from zoo.units import convert

OUTPUT = "output"
"""Name under which a model takes what the gyro showed, like a column."""
PIECES = 10
"""Pieces that a run is cut into where some of it is held out."""
HELD_OUT = " (held out)"
"""What the name of these pieces has behind that of the run."""
SHARES = (0.5 / PIECES, 1 - 0.5 / PIECES)
"""The smallest and the largest share that one piece, or all but one, stand for."""


@dataclass(frozen=True, eq=False)
class Run:
    """One recording on two time grids.

    Effects with memory (lags, hysteresis) are computed on the fine grid of T samples; residuals are judged on N block means of `average_s`,
    so a ramp that starts inside a block is not smeared before the lag is applied. A block never straddles a gap.

    Attributes:
        name: the file's stem, unique among the runs read together.
        unit: suffix of the output's unit, such as ``"dph"``.
        average_s: block length [s].
        columns: names of the columns of `table`, first ``time_s`` and ``temperature_c``, then other thermometers and inputs, last
            ``reference_<unit>``.
        table: (T, C) the raw columns in the file's units, in time order, float64.
        error: (T,) output − reference [unit].
        count: (T,) recorded rows behind each fine sample.
        block: (T,) int64, index of the block each sample belongs to, −1 for the samples of a block too thin to keep.
        rows: rows read from the file.
        notes: what reading noticed (gaps, dropped rows), one sentence each.
        recorded: what the file calls time, thermometers, inputs, reference and output, and their units there; empty where there is no file.
        read: (T, C) the table as it was read, where its thermometers were drawn smooth since, see `zoo.measurements.steady`.
    """

    name: str
    unit: str
    average_s: float
    columns: tuple[str, ...]
    table: Tensor
    error: Tensor
    count: Tensor
    block: Tensor
    rows: int = 0
    notes: tuple[str, ...] = field(default=())
    recorded: tuple[Source, ...] = ()
    read: Tensor | None = None

    @property
    def time(self) -> Tensor:
        """(T,) time as recorded [s]."""
        return self.table[:, 0]

    @property
    def span_s(self) -> tuple[float, float]:
        """When its first and its last row were recorded [s], as well as even rows tell: samples have the mean time of theirs."""
        if len(self.time) < 2:
            return float(self.time[0]), float(self.time[-1])
        steps, rows = self.time.diff(), self.count.to(self.time)
        apart = torch.minimum(steps.median() / rows.median(), steps[[0, -1]] / rows[[0, -1]])  # the latter where they become rarer
        before, after = (0.5 * (rows[[0, -1]] - 1.0) * apart).tolist()
        return float(self.time[0]) - before, float(self.time[-1]) + after

    @property
    def temperature(self) -> Tensor:
        """(T,) main thermometer [°C]."""
        return self.table[:, 1]

    @property
    def output(self) -> Tensor:
        """(T,) what the gyro showed [unit]: reference and error."""
        return self.table[:, -1] + self.error

    @property
    def as_read(self) -> Run:
        """The run with its thermometers as they were read."""
        return self if self.read is None else replace(self, table=self.read, read=None)

    @property
    def blocks(self) -> int:
        """N, the number of block means."""
        return int(self.block.max()) + 1 if self.block.numel() else 0

    @property
    def thermometers(self) -> tuple[str, ...]:
        """Names of the thermometers' columns, the main one first."""
        return tuple(name for name in self.columns if name.startswith("temperature_"))

    @property
    def truth(self) -> str | None:
        """What its file calls the true input; None where that is not recorded."""
        return next((one.column for one in self.recorded if one.name.startswith("reference_")), None)

    @property
    def known(self) -> tuple[str, ...]:
        """Names of the columns that its file has: without the true input where that was only given, or taken as 0."""
        return self.columns if self.truth or not self.recorded else self.columns[:-1]

    def column(self, name: str) -> Tensor:
        """(T,) one raw column, or the `output`.

        Raises:
            KeyError: the run has no such column.
        """
        if name == OUTPUT:
            return self.output
        if name not in self.columns:
            raise KeyError(name)
        return self.table[:, self.columns.index(name)]

    def select(self, names: tuple[str, ...] | list[str]) -> Tensor:
        """(T, len(names)) raw columns in the order asked for."""
        return torch.stack([self.column(name) for name in names], dim=-1)

    def block_mean(self, value: Tensor) -> Tensor:
        """Means over the blocks, each fine sample weighted by its count of recorded rows.

        Args:
            value: (..., T) on the fine grid.

        Returns:
            (..., N).
        """
        return self.block_mean_columns(value.unsqueeze(-1)).squeeze(-1)

    def block_mean_columns(self, value: Tensor) -> Tensor:
        """The same for columns: (..., T, K) -> (..., N, K)."""
        return self.averager(value.movedim(-2, 0)).movedim(0, -2)

    @cached_property
    def averager(self) -> Averager:
        """Means over the blocks, each fine sample weighted by its count of recorded rows."""
        return Averager.weighted(self.block, self.count.to(self.table.dtype))

    def block_share(self) -> Tensor:
        """(N,) recorded rows behind each block mean over those of the fullest block."""
        keep = self.block >= 0
        rows = torch.zeros(self.blocks, dtype=self.table.dtype, device=self.table.device).index_add(
            0, self.block[keep], self.count[keep].to(self.table.dtype)
        )
        return rows / rows.max()

    def to(self, device: torch.device | str) -> Run:
        """The run with its tensors on a device."""
        tensors = {name: getattr(self, name).to(device) for name in ("table", "error", "count", "block")}
        return replace(self, read=None if self.read is None else self.read.to(device), **tensors)

    def in_unit(self, unit: str) -> Run:
        """The run as if its output had been recorded in another unit of the same quantity.

        Args:
            unit: suffix.

        Raises:
            InputError: it is of another quantity.
        """
        if unit == self.unit:
            return self
        reference = convert(self.table[:, -1:], self.unit, unit)
        columns, table = (*self.columns[:-1], f"reference_{unit}"), torch.cat([self.table[:, :-1], reference], dim=1)
        return replace(self, unit=unit, columns=columns, table=table, error=convert(self.error, self.unit, unit))

    def split(self, share: float) -> tuple[Run, Run]:
        """The run less some of ten equal pieces, and those pieces, spread evenly; the whole past is known to both.

        Args:
            share: of the blocks that go into the second part, within `SHARES`; the nearest number of pieces is taken.
        """
        wanted = max(1, min(PIECES - 1, round(share * PIECES)))
        held = torch.tensor([int((k + 0.5) / wanted * PIECES) for k in range(wanted)])
        piece = (torch.arange(self.blocks, device=self.block.device) * PIECES).div(max(self.blocks, 1), rounding_mode="floor")
        apart = torch.isin(piece, held.to(piece))
        return self.with_blocks(~apart, self.name), self.with_blocks(apart, f"{self.name}{HELD_OUT}")

    def with_blocks(self, keep: Tensor, name: str) -> Run:
        """The run with some of its blocks, numbered anew; the whole past is still known.

        Args:
            keep: (N,) which.
            name: of the result.
        """
        number = torch.where(keep, keep.cumsum(0) - 1, -1)
        return replace(self, name=name, block=torch.where(self.block >= 0, number[self.block], -1))
