"""Finite volumes of a hollow cylinder and of a slab against analytic solutions of the heat equation."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import pytest
import torch
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import j0, j1, y0, y1
from torch import Tensor

from zoo.physics.cells import Cells, across, along

F64 = torch.float64
K, CAPACITY = 0.3, 1.7e6
INNER, OUTER = 0.045, 0.053
FILMS = (200.0, 30.0)


def number(value: float) -> Tensor:
    return torch.tensor(value, dtype=F64)


def cylinder(layers: int) -> Cells:
    return across(number(INNER), number((OUTER - INNER) / layers), layers)


def slab(turns: int) -> Cells:
    return along(number((OUTER - INNER) / turns), turns)


def response(cells: Cells, films: tuple[float, float] = FILMS) -> tuple[Tensor, Tensor]:
    """Conductance matrix and what one kelvin behind each film brings to the nodes."""
    stiffness = cells.stiffness(number(K), torch.tensor(films, dtype=F64))
    flow = torch.zeros(len(cells.volume), 2, dtype=F64)
    flow[0, 0], flow[-1, 1] = films[0] * cells.area[0], films[1] * cells.area[1]
    return stiffness, flow


Profile = Callable[[float], tuple[tuple[float, float], tuple[float, float]]]
"""A particular solution and the other shape that no heat flows from, at a place; their slopes."""


def constants(profile: Profile, ends: tuple[float, float], outside: tuple[float, float]) -> Callable[[float], float]:
    """The solution p + A·s + B, with A and B such that both films carry what the solid conducts."""
    rows, right = [], []
    for place, sign, film, air in zip(ends, (1.0, -1.0), FILMS, outside, strict=True):
        (particular, shape), (slope, steep) = profile(place)
        rows.append([K * sign * steep - film * shape, -film])
        right.append(film * particular - K * sign * slope - film * air)
    a, b = torch.linalg.solve(torch.tensor(rows, dtype=F64), torch.tensor(right, dtype=F64)).tolist()
    return lambda x: profile(x)[0][0] + a * profile(x)[0][1] + b


@pytest.mark.parametrize("layers", [1, 2, 36])
def test_steady_flow_through_a_cylinder_is_exact(layers) -> None:
    cells = cylinder(layers)
    stiffness, flow = response(cells)
    found = torch.linalg.solve(stiffness, flow @ torch.tensor([60.0, -40.0], dtype=F64))
    exact = constants(lambda r: ((0.0, math.log(r)), (0.0, 1 / r)), (INNER, OUTER), (60.0, -40.0))
    assert found.tolist() == pytest.approx([exact(r) for r in cells.node.tolist()], rel=1e-10)


@pytest.mark.parametrize("turns", [1, 2, 48])
def test_steady_flow_through_a_slab_is_exact(turns) -> None:
    cells = slab(turns)
    stiffness, flow = response(cells)
    found = torch.linalg.solve(stiffness, flow @ torch.tensor([60.0, -40.0], dtype=F64))
    exact = constants(lambda x: ((0.0, x), (0.0, 1.0)), (0.0, OUTER - INNER), (60.0, -40.0))
    assert found.tolist() == pytest.approx([exact(x) for x in cells.node.tolist()], rel=1e-10)


@pytest.mark.parametrize("count", [1, 2, 36])
@pytest.mark.parametrize("shape", ["cylinder", "slab"])
def test_the_parabola_of_a_steady_ramp_is_exact(count, shape) -> None:
    """Everything warms at 1 K/min; T is what solves k∇²T = ρc·rate, late behind the air by the films' and the solid's own delay."""
    warming = CAPACITY / 60.0 / K
    cells = cylinder(count) if shape == "cylinder" else slab(count)
    stiffness, flow = response(cells)
    found = torch.linalg.solve(stiffness, flow.sum(1) * 20.0 - CAPACITY * cells.volume / 60.0)
    if shape == "cylinder":
        exact = constants(lambda r: ((warming * r * r / 4, math.log(r)), (warming * r / 2, 1 / r)), (INNER, OUTER), (20.0, 20.0))
    else:
        exact = constants(lambda x: ((warming * x * x / 2, x), (warming * x, 1.0)), (0.0, OUTER - INNER), (20.0, 20.0))
    assert found.tolist() == pytest.approx([exact(x) for x in cells.node.tolist()], rel=1e-10)


def slowest(cells: Cells, which: int) -> float:
    """Decay of the mode of this number [1/s]."""
    stiffness, _ = response(cells)
    root = (CAPACITY * cells.volume).sqrt()
    return float(torch.linalg.eigvalsh(stiffness / root / root.unsqueeze(1))[which])


def slab_decay(which: int) -> float:
    """From tan βd = β(h₁ + h₂)k/(β²k² − h₁h₂) (Carslaw & Jaeger 1959, §3.11), decay aβ²."""
    (first, last), thick = FILMS, OUTER - INNER

    def zero(beta: float) -> float:
        return (beta**2 * K**2 - first * last) * math.sin(beta * thick) - beta * K * (first + last) * math.cos(beta * thick)

    return K / CAPACITY * roots(zero, which) ** 2


def cylinder_decay(which: int) -> float:
    """J₀ and Y₀ with a film on both faces (Carslaw & Jaeger 1959, §7.10), decay aβ²."""

    def zero(beta: float) -> float:
        inside = [FILMS[0] * one(beta * INNER) + K * beta * two(beta * INNER) for one, two in ((j0, j1), (y0, y1))]
        outside = [FILMS[1] * one(beta * OUTER) - K * beta * two(beta * OUTER) for one, two in ((j0, j1), (y0, y1))]
        return inside[0] * outside[1] - inside[1] * outside[0]

    return K / CAPACITY * roots(zero, which) ** 2


def roots(zero: Callable[[float], float], which: int) -> float:
    places = [1.0 + 20.0 * step for step in range(500)]
    brackets = [(one, two) for one, two in pairwise(places) if zero(one) * zero(two) < 0]
    return float(brentq(zero, *brackets[which], xtol=1e-13, rtol=1e-14))


@pytest.mark.parametrize(("make", "exact"), [(slab, slab_decay), (cylinder, cylinder_decay)])
@pytest.mark.parametrize("which", [0, 1, 2])
def test_decay_of_a_mode_converges_with_the_second_order(make, exact, which) -> None:
    counts = [32, 64, 128, 256]
    errors = torch.tensor([abs(slowest(make(count), which) / exact(which) - 1) for count in counts], dtype=F64)
    order = -torch.diff(errors.log()) / math.log(2)
    assert order.mean() == pytest.approx(2.0, abs=0.1)
    extrapolated = (4 * slowest(make(1024), which) - slowest(make(512), which)) / 3
    assert extrapolated == pytest.approx(exact(which), rel=1e-6)


def slab_shape(beta: float) -> Callable[[float], float]:
    """Solution of φ″ + β²φ = 0 that fits the film at x = 0."""
    return lambda x: math.cos(beta * x) + FILMS[0] / (K * beta) * math.sin(beta * x)


def cylinder_shape(beta: float) -> Callable[[float], float]:
    """Solution of Bessel's equation that fits the film on the inner face."""
    first, second = (FILMS[0] * one(beta * INNER) + K * beta * two(beta * INNER) for one, two in ((j0, j1), (y0, y1)))
    return lambda r: j0(beta * r) * second - y0(beta * r) * first


def mean_after_a_step(make: Callable[[int], Cells], count: int, seconds: float) -> float:
    """Mean over the body, warmed from 0 by air that steps to 1."""
    cells = make(count)
    stiffness, _ = response(cells)
    root = (CAPACITY * cells.volume).sqrt()
    decay, vectors = torch.linalg.eigh(stiffness / root / root.unsqueeze(1))
    left = vectors @ (torch.exp(-decay * seconds) * (vectors.mT @ root))
    return 1 - float(root @ left / root.square().sum())


@pytest.mark.parametrize(
    ("make", "decay_of", "shape_of", "weight", "ends"),
    [
        (slab, slab_decay, slab_shape, lambda x: 1.0, (0.0, OUTER - INNER)),
        (cylinder, cylinder_decay, cylinder_shape, lambda r: r, (INNER, OUTER)),
    ],
)
def test_a_step_of_the_air_warms_as_the_series_says(make, decay_of, shape_of, weight, ends) -> None:
    """1 − Σ (∫wφ)²/(∫w·∫wφ²)·e^(−λt) over the eigenfunctions; twenty of them, from 5 s on."""
    decays, shares = [decay_of(which) for which in range(20)], []
    for decay in decays:
        shape = shape_of(math.sqrt(decay * CAPACITY / K))
        parts = [quad(lambda x, power=power: weight(x) * shape(x) ** power, *ends, limit=400, epsabs=1e-14, epsrel=1e-10)[0] for power in (0, 1, 2)]  # noqa: B023
        shares.append(parts[1] ** 2 / parts[0] / parts[2])
    assert sum(shares) == pytest.approx(1.0, abs=5e-3)
    for seconds in (5.0, 30.0, 120.0, 600.0):
        exact = 1 - sum(share * math.exp(-decay * seconds) for share, decay in zip(shares, decays, strict=True))
        fine, coarse = mean_after_a_step(make, 512, seconds), mean_after_a_step(make, 256, seconds)
        assert (4 * fine - coarse) / 3 == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize(("make", "whole"), [(slab, OUTER - INNER), (cylinder, math.pi * (OUTER**2 - INNER**2))])
def test_cells_fill_the_body(make, whole) -> None:
    for count in (1, 7, 36):
        assert float(make(count).volume.sum()) == pytest.approx(whole, rel=1e-13)
        assert bool((make(count).volume > 0).all())


def test_a_thin_cylinder_is_a_slab() -> None:
    thin = across(number(1000.0), number(1e-4), 20)
    flat = along(number(1e-4), 20)
    assert (thin.volume / 2 / math.pi / 1000.0).tolist() == pytest.approx(flat.volume.tolist(), rel=1e-5)
    assert (thin.link / 2 / math.pi / 1000.0).tolist() == pytest.approx(flat.link.tolist(), rel=1e-5)
