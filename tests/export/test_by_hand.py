"""What the metadata say is enough to write the model anew, row by row, in any language: here in Python's own numbers."""

from __future__ import annotations

import math
from typing import Any

import pytest
import torch

from zoo.models.features import Features

NAMES = ["temperature", "temperature_rate", "temperature_outer_lag90", "supply_v"]
Row = dict[str, float]


class ByHand:
    """One feature, as its definition says."""

    def __init__(self, definition: dict[str, Any]) -> None:
        self.column, self.kind, self.tau = definition["column"], definition["kind"], definition.get("tau_s")
        self.before: Row | None = None

    def __call__(self, row: Row) -> float:
        """The next row's feature; the recurrences of `recurrence`."""
        u = row[self.column]
        if self.tau is None:
            return u
        if self.before is None:
            self.x, self.r = u, 0.0
        else:
            h, was = row["time_s"] - self.before["time_s"], self.before[self.column]
            a, b = math.exp(-h / self.tau), (u - was) / h
            m = (1 - a) * self.tau / h
            self.r = a * self.r + (1 - a) * b - a * h / self.tau**2 * (self.x - was + b * self.tau)
            self.x = a * self.x + (m - a) * was + (1 - m) * u
        self.before = row
        return 60 * self.r if self.kind == "rate" else self.x


def terms(coefficients: dict[str, float], feature: Row) -> float:
    """Sum of coefficient × feature^power, the constant under 1."""
    parts = [(name.partition("^")[0], int(name.partition("^")[2] or 1), value) for name, value in coefficients.items() if name != "1"]
    return coefficients["1"] + sum(value * feature[name] ** power for name, power, value in parts)


def evaluated(formula: dict[str, Any], feature: Row) -> float:
    """One row's prediction, as `equation` says."""
    if "coefficients" in formula:
        return terms(formula["coefficients"], feature)
    if "segments" in formula:
        first = next(iter(formula["segments"][0]))
        own = next(one for one in formula["segments"] if one[first][1] is None or feature[first] < one[first][1])
        z, found = (feature[first] - own["centred"]["middle"]) / own["centred"]["half"], terms(own["coefficients"], feature)
        assert terms(own["centred"]["coefficients"], feature | {"z": z}) == pytest.approx(found, rel=1e-9, abs=1e-12)
        return found
    if "rules" in formula:
        exponents = [-sum(((feature[k] - c) / one["width"][k]) ** 2 / 2 for k, c in one["centre"].items()) for one in formula["rules"]]
        shares = [math.exp(one - max(exponents)) for one in exponents]
        return sum(share * terms(one["consequent"], feature) for share, one in zip(shares, formula["rules"], strict=True)) / sum(shares)
    sums = [one["bias"] + sum(weight * feature[k] for k, weight in one["inputs"].items()) for one in formula["neurons"]]
    shape = (lambda u: math.cos(1.75 * u) * math.exp(-(u**2) / 2)) if "cos(1.75·" in formula["equation"] else math.tanh
    linear = sum(weight * feature[k] for k, weight in formula.get("linear", {}).items())
    return formula["constant"] + linear + sum(one["weight"] * shape(u) for one, u in zip(formula["neurons"], sums, strict=True))


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        ("polynomial", {"order": 3, "rate_order": 2}),
        ("piecewise_polynomial", {"edges": [0.0, 20.0], "order": 2}),
        ("piecewise_polynomial", {"edges": [0.0, 20.0], "continuous": True}),
        ("bp", {}),
        ("wavelet", {"linear": True}),
        ("wavelet", {}),
        ("takagi_sugeno", {}),
    ],
)
def test_the_formula_and_the_features_are_the_model(network, record, kind, settings) -> None:
    model = network(kind, features=NAMES, smoothing_s=45.0, **settings)
    assert isinstance(model.extract, Features)
    x, formula, definitions = record(model.inputs, 300), model.formula(), model.extract.definitions()
    made = {name: ByHand(definition) for name, definition in definitions.items()}
    found = []
    for numbers in x.tolist():
        row = dict(zip(model.inputs, numbers, strict=True))
        found.append(evaluated(formula, {name: one(row) for name, one in made.items()}))
    with torch.no_grad():
        wanted = model(x)
    torch.testing.assert_close(torch.tensor(found, dtype=torch.float64), wanted, rtol=0, atol=1e-10 * float(wanted.abs().max()))
    assert formula["equation"]
    assert {one["kind"] for one in definitions.values()} == {"column", "rate", "lag"}
