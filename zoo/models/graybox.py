"""The grey box: a sum of physical effects at temperatures that are estimated with them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import torch
from torch import Tensor, nn

from zoo.effects.base import Effect, History, Parameter
from zoo.effects.bounds import to_physical, to_unit
from zoo.effects.sum import Sum
from zoo.errors import InputError
from zoo.given import check_switch
from zoo.models.base import Model
from zoo.models.places import coil_parameters, histories, housing_last, in_words

UNSEEN = -1
"""Number of a run that was not fitted: what happened once in a fitted run does not happen in it."""


def check_inputs(inputs: object) -> None:
    """Refuse raw columns that are not told apart by their places: the time first, then a thermometer, the true input last.

    Raises:
        InputError: they are none, or in another order.
    """
    names = [str(name) for name in inputs] if isinstance(inputs, list | tuple) else []
    ordered = len(names) > 2 and names[0] == "time_s" and names[1].startswith("temperature_") and names[-1].startswith("reference_")
    if not ordered or len({*names}) < len(names):
        told = f"[{', '.join(names)}]" if names else inputs
        needed = "time_s, temperature_c, further columns and last reference_UNIT, each once"
        raise InputError(f"model.inputs={told}: needed are {needed}; or null, for all")


class GrayBox(Model):
    """Error = Σ effects, each at the place where it lives.

    Nonlinear parameters (the coil's lag and weights, the effects' shapes) lie in one vector θ with every bound at 0…1; amplitudes are linear.
    """

    fitted_by = "variable_projection"

    def __init__(self, effects: dict[str, Effect], inputs: list[str], in_motion: bool = False) -> None:
        """Assemble.

        Args:
            effects: by name, in the order of the report.
            inputs: raw columns of `forward`; ``time_s`` and ``temperature_c`` first, ``reference_<unit>`` last.
            in_motion: whether records start while the temperature moves, so that the coil's first temperature has to be fitted.

        Raises:
            InputError: an effect needs a column that is not there, or the columns are not given in this order.
        """
        super().__init__()
        check_switch("model.in_motion", in_motion)
        check_inputs(inputs)
        self.inputs = list(inputs)
        self.in_motion = in_motion
        self.thermometers = housing_last([name for name in inputs if name.startswith("temperature_")])
        self.effects = Sum(effects)
        for name, effect in effects.items():
            missing = [column for column in effect.needs if column not in inputs]
            if missing:
                raise InputError(f"effect '{name}' needs the column {', '.join(missing)}; the runs have {', '.join(inputs)}")
        self.coil_parameters = coil_parameters(self.thermometers, in_motion)
        self.coil_value = nn.Parameter(torch.tensor([p.default for p in self.coil_parameters], dtype=torch.float64))

    def named_effects(self) -> Iterator[tuple[str, Effect]]:
        """The effects with their names, in order."""
        return self.effects.named()

    @property
    def needs(self) -> frozenset[str]:
        """Recorded columns that the effects ask for."""
        return frozenset(column for _, effect in self.named_effects() for column in effect.needs)

    def parameters_of_theta(self) -> tuple[tuple[str, Parameter], ...]:
        """Owner (``"coil"`` or an effect) and declaration of every entry of θ."""
        own = [("coil", p) for p in self.coil_parameters]
        return (*own, *self.effects.shape)

    def theta(self) -> Tensor:
        """(P,) the present nonlinear parameters in 0…1."""
        physical = torch.cat([self.coil_value, *(effect.shape_value for _, effect in self.named_effects())]).detach()
        return to_unit(physical, [p for _, p in self.parameters_of_theta()])

    @torch.no_grad()
    def assign(self, theta: Tensor, amplitudes: Tensor) -> None:
        """Take over a fit: θ (P,) in 0…1 and amplitudes (K,)."""
        physical = to_physical(theta, [p for _, p in self.parameters_of_theta()])
        self.coil_value.copy_(physical[: len(self.coil_parameters)])
        at, column = len(self.coil_parameters), 0
        for _, effect in self.named_effects():
            effect.shape_value.copy_(physical[at : at + len(effect.shape)])
            effect.amplitude.copy_(amplitudes[column : column + len(effect.amplitudes)])
            at, column = at + len(effect.shape), column + len(effect.amplitudes)

    def histories(self, x: Tensor, coil_value: Tensor, run: int | Tensor = UNSEEN, housing: History | None = None) -> dict[str, History]:
        """The history at each place.

        Args:
            x: (T, C) raw columns, or (R, 1, T, C) of several runs recorded at the same times.
            coil_value: (..., P) the coil's parameters.
            run: its number, or theirs (R, 1, 1).
            housing: of the housing, where it is known already.
        """
        apart = {self.inputs[0], self.inputs[-1], *self.thermometers} - self.needs
        table = {name: x[..., i] for i, name in enumerate(self.inputs) if name not in apart}
        table["reference"] = x[..., -1]
        thermometers = torch.stack([x[..., self.inputs.index(name)] for name in self.thermometers], dim=-1)
        time = x[:, 0] if x.dim() == 2 else x[0, 0, :, 0]
        return histories(time, table, thermometers, coil_value, run, self.in_motion, housing)

    def columns(self, x: Tensor, theta: Tensor, run: int = UNSEEN) -> Tensor:
        """Columns of all effects for a batch of θ.

        Args:
            x: (T, C) raw columns of one run.
            theta: (B, P) in 0…1.
            run: number of the run, from 1; `UNSEEN` for one that was not fitted.

        Returns:
            (B, T, K).
        """
        physical = to_physical(theta, [p for _, p in self.parameters_of_theta()])
        coil, shape = physical.split([len(self.coil_parameters), physical.shape[1] - len(self.coil_parameters)], dim=1)
        return self.effects.columns(self.histories(x, coil, run), shape)

    def shares(self, x: Tensor, run: int = UNSEEN) -> dict[str, Tensor]:
        """(T,) error of each effect [output's unit] by name."""
        return self.effects.shares(self.histories(x, self.coil_value, run))

    def formula(self) -> dict[str, Any]:
        """Each effect's formula at its place, whose parameters stand elsewhere, under ``physical``.

        Returns:
            ``{"equation": …, "effects": {name: {"formula": …, "place": …, "source": …}}, "places": {place: …}}``.
        """
        return {
            "equation": "Σ of the effects, T, dT/dt [K/min] and gradient being those of its place; parameters, the coil's as well, under physical",
            "effects": {name: {key: getattr(effect, key) for key in ("formula", "place", "source")} for name, effect in self.named_effects()},
            "places": in_words(self.thermometers),
        }

    def forward(self, x: Tensor) -> Tensor:
        """Predict the error, see `Model.forward`."""
        return self.effects(self.histories(x, self.coil_value))
