"""A network and physical effects, trained together: each predicts what the other cannot."""

from __future__ import annotations

from typing import Any

from torch import Tensor

from zoo.effects.base import Effect
from zoo.errors import InputError
from zoo.models.base import Model
from zoo.models.graybox import GrayBox


class Hybrid(Model):
    """Error = network + Σ effects, the effects at the temperatures of the places where they live.

    Attributes:
        network: any model that is a static map of features.
        physics: the effects.
        columns: where the network's inputs stand among the raw columns.
    """

    fitted_by = "alternating"

    def __init__(self, network: Model, effects: dict[str, Effect], inputs: list[str], in_motion: bool = False) -> None:
        """Put together.

        Args:
            network: the part without physics.
            effects: by name, in the order of the report.
            inputs: raw columns of `forward`; ``time_s`` and ``temperature_c`` first, ``reference_<unit>`` last.
            in_motion: see `GrayBox`.

        Raises:
            InputError: the network or an effect needs a column that is not there, or there is no effect.
        """
        super().__init__()
        if not effects:
            raise InputError("effects=[]: a hybrid is a network and at least one effect, such as effects=[hysteresis]")
        lacking = [column for column in network.inputs if column not in inputs]
        if lacking:
            raise InputError(f"the hybrid's network needs the column {', '.join(lacking)}; the runs have {', '.join(inputs)}")
        self.network = network
        self.physics = GrayBox(effects, inputs, in_motion)
        self.inputs = list(inputs)
        self.columns = [self.inputs.index(column) for column in network.inputs]

    def formula(self) -> dict[str, Any]:
        """``{"equation": …, "network": …, "effects": …, "places": …}``, see those of the two parts."""
        return self.physics.formula() | {"equation": "network + Σ of the effects, see the formulas of these", "network": self.network.formula()}

    def forward(self, x: Tensor) -> Tensor:
        """Predict the error, see `Model.forward`."""
        predicted: Tensor = self.network(x[:, self.columns]) + self.physics(x)
        return predicted
