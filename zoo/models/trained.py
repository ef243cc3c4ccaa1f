"""A trained model as one term of a sum of effects: what it predicts, and what it could take over by moving its weights."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from zoo.effects.base import Effect, History, Parameter
from zoo.measurements.run import Run
from zoo.models.base import Model
from zoo.models.prediction import raw_columns
from zoo.models.tangent import Tangent

SHARE = Parameter("share", 1.0, "1", 0.0, 2.0, source="as trained", meaning="share of the prediction that is kept")
TIME, MAIN = "time_s", "temperature_c"
SHIFT_S = 7200.0


class Trained(Effect):
    """Error a·p + Σ b_k·∂p/∂w·v_k of a model p with weights w, linearised where its training ended.

    Beside it in a sum, another effect is judged, and its size determined, by what the model could not represent with other weights, to first order.
    What an effect declares for its class, this one declares for each model.
    """

    name = "network"
    place = "housing"
    amplitudes = (SHARE,)
    formula = "a·p + Σ b·∂p/∂w"
    source = "the model's training"
    signature = "whatever the model learnt"

    def __init__(self, name: str, model: Model, runs: Sequence[Run], also: Sequence[Model] = ()) -> None:
        """Linearise a model.

        Args:
            name: of this term in the sum.
            model: trained; not changed.
            runs: that the sum will be fitted to.
            also: the same model with other weights, near which it is linearised as well.

        Raises:
            InputError: a run lacks a column that the model takes.
        """
        tangent = Tangent(model, runs, also)
        steps = tuple(Parameter(f"direction_{k + 1}", 0.0, "unit", -10.0, 10.0, meaning="RMS of a change of weights") for k in range(tangent.size))
        needs = tuple(column for column in model.inputs if column not in {TIME, MAIN} and not column.startswith("reference_"))
        clock = (TIME,) if _tells_the_time(tangent, runs[0]) else ()
        vars(self).update(name=name, amplitudes=(SHARE, *steps), needs=(*clock, *needs))
        super().__init__()
        self.tangent = tangent
        with torch.no_grad():
            self.amplitude[0] = 1.0

    def columns(self, history: History, shape: Tensor) -> Tensor:
        """Prediction and directions (T, 1+K), see `Effect.columns`; the temperatures are the recorded ones, wherever the effect lives."""
        del shape
        recorded = {TIME: history.time, MAIN: history.thermometer, **history.inputs}
        table = torch.stack([recorded.get(column, history.reference) for column in self.tangent.model.inputs], dim=-1)
        return self.tangent.columns(table, int(history.run))


def _tells_the_time(tangent: Tangent, run: Run) -> bool:
    """Whether a model's prediction depends on when a record starts."""
    table = raw_columns(tangent.model, run.to("cpu"))
    later = table.clone()
    later[:, 0] += SHIFT_S
    return not torch.allclose(tangent.predict(later), tangent.predict(table), rtol=1e-6, atol=1e-9 * float(run.error.abs().max()))
