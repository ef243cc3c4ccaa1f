"""Single blocks chosen from runs: those that meet a condition, and of them some to fit and some only to check on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Generator, Tensor

from zoo.errors import InputError, in_brief
from zoo.given import check_number, check_seed
from zoo.measurements.run import OUTPUT, Run

_KEY = "data.points"


@dataclass(frozen=True)
class Points:
    """Which blocks are wanted.

    Attributes:
        where: condition on a block's means of the runs' columns and of the output, as pandas understands it; None for all blocks.
        fitted: how many of those that meet it are fitted; None for all that are not checked on.
        checked: how many are only checked on.
        seed: which ones.
    """

    where: str | None = None
    fitted: int | None = None
    checked: int = 0
    seed: int = 1

    def __post_init__(self) -> None:
        """Check every setting.

        Raises:
            InputError: names the key, what was given and what is possible.
        """
        if self.where is not None and not isinstance(self.where, str):
            raise InputError(f"{_KEY}.where={self.where}: a condition is needed, such as 'reference_dph != 0 and temperature_c > -20', or null")
        check_seed(f"{_KEY}.seed", self.seed)
        for key, least in (("fitted", 1), ("checked", 0)):
            if key != "fitted" or self.fitted is not None:
                check_number(f"{_KEY}.{key}", getattr(self, key), least, unit=", or null," if key == "fitted" else "", whole=True)

    @property
    def all(self) -> bool:
        """Whether every block is fitted."""
        return self.where is None and self.fitted is None and self.checked == 0

    def meeting(self, runs: Sequence[Run]) -> list[Run]:
        """The runs with those of their blocks that meet the condition.

        Raises:
            InputError: the condition cannot be understood, or no block of a run meets it.
        """
        return list(runs) if self.where is None else [one.with_blocks(_met(one, self.where), one.name) for one in runs]

    def drawn(self, runs: Sequence[Run]) -> tuple[list[Run], list[Run]]:
        """Blocks to fit and blocks to check on, drawn from all that the runs have; a run of which none is drawn is left out.

        Raises:
            InputError: there are not as many.
        """
        if self.fitted is None and self.checked == 0:
            return list(runs), []
        total = sum(one.blocks for one in runs)
        fitted = total - self.checked if self.fitted is None else self.fitted
        if fitted < 1 or fitted + self.checked > total:
            asked = f"{_KEY}.checked={self.checked}" if self.fitted is None else f"{_KEY}: fitted={fitted} and checked={self.checked}"
            raise InputError(f"{asked}: the runs have {total} blocks{'' if self.where is None else f' where {self.where}'}")
        order = torch.randperm(total, generator=Generator().manual_seed(self.seed))
        use = torch.zeros(total, dtype=torch.int64)
        use[order[:fitted]], use[order[fitted : fitted + self.checked]] = 1, 2
        parts = list(zip(runs, use.split([one.blocks for one in runs]), strict=True))
        return [one.with_blocks(part == 1, one.name) for one, part in parts if (part == 1).any()], [
            one.with_blocks(part == 2, f"{one.name} (checked)") for one, part in parts if (part == 2).any()
        ]


def _met(run: Run, condition: str) -> Tensor:
    """(N,) whether each block meets the condition."""
    import pandas as pd  # half a second where nobody asked for a condition

    means = run.block_mean_columns(torch.cat([run.table, run.output.unsqueeze(-1)], dim=-1))
    table = pd.DataFrame(means.cpu().numpy(), columns=[*run.columns, OUTPUT])
    try:
        found = table.eval(condition, engine="python")
    except Exception as error:  # pandas raises whatever Python's parser and its own operators do
        raise InputError(f"{_KEY}.where={condition}: {in_brief(error)}; {run.name} has {', '.join(table.columns)}") from error
    if not isinstance(found, pd.Series) or found.dtype != bool:
        raise InputError(f"{_KEY}.where={condition}: is no condition; one is 'reference_{run.unit} != 0'")
    if not found.any():
        raise InputError(f"{_KEY}.where={condition}: no block of {run.name} meets it")
    return torch.from_numpy(found.to_numpy(copy=True))
