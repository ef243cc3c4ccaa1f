"""The modal response is the exact solution of a linear system with inputs that are linear between samples."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
import torch
from torch import Tensor

from zoo.physics import modes as modes_file
from zoo.physics.decaying_sums import decaying_sums, divisible
from zoo.physics.lumps import Lumps
from zoo.physics.modes import CHUNK, Modes, respond


def drawn(*batch: int, modes: int = 6, inputs: int = 2, outputs: int = 3, seed: int = 0) -> Modes:
    """Time constants from a second to a day."""
    chance = torch.Generator().manual_seed(seed)

    def normal(*shape: int) -> Tensor:
        return torch.randn(*batch, *shape, generator=chance, dtype=torch.float64)

    rate = 10 ** (-5 + 5 * torch.rand(*batch, modes, generator=chance, dtype=torch.float64))
    return Modes(rate, normal(modes, inputs), normal(outputs, modes), normal(outputs, inputs))


def wander(*shape: int, seed: int = 1) -> Tensor:
    return torch.randn(*shape, generator=torch.Generator().manual_seed(seed), dtype=torch.float64).cumsum(-1)


@pytest.mark.parametrize("total", [1, 2, CHUNK - 1, CHUNK, CHUNK + 1, 3 * CHUNK + 5])
def test_sample_by_sample_gives_the_same(total) -> None:
    """A response may be cut anywhere and gone on with from the state: here at every sample, the state by its closed form."""
    modes, inputs, step = drawn(), wander(2, total), 7.0
    state = (modes.drive @ inputs[:, 0]) / modes.rate
    expected = [modes.observe @ state + modes.direct @ inputs[:, 0]]
    for k in range(1, total):
        before, slope = inputs[:, k - 1], (inputs[:, k] - inputs[:, k - 1]) / step
        # z' = −λz + b(u + st):  particular solution b(u + st)/λ − bs/λ²
        settled, tilt = modes.drive @ before / modes.rate, modes.drive @ slope / modes.rate
        state = settled + tilt * step - tilt / modes.rate + (state - settled + tilt / modes.rate) * torch.exp(-modes.rate * step)
        expected.append(modes.observe @ state + modes.direct @ inputs[:, k])
    torch.testing.assert_close(respond(modes, step, inputs), torch.stack(expected, -1), rtol=1e-8, atol=1e-8)


def test_a_step_and_a_ramp_have_their_closed_forms() -> None:
    rate, step = torch.tensor([1e-3, 0.02, 5.0], dtype=torch.float64), 10.0
    eye = torch.eye(3, dtype=torch.float64)
    modes = Modes(rate, rate.unsqueeze(1), eye, torch.zeros(3, 1, dtype=torch.float64))
    time = step * torch.arange(1000, dtype=torch.float64)
    decayed = torch.exp(-rate.unsqueeze(1) * time)
    up = respond(modes, step, torch.ones(1, 1000, dtype=torch.float64), torch.zeros(3, dtype=torch.float64))
    torch.testing.assert_close(up, 1 - decayed, rtol=1e-11, atol=1e-13)
    ramp = respond(modes, step, time.unsqueeze(0), torch.zeros(3, dtype=torch.float64))
    torch.testing.assert_close(ramp, time - (1 - decayed) / rate.unsqueeze(1), rtol=1e-10, atol=1e-8)
    free = respond(modes, step, torch.zeros(1, 1000, dtype=torch.float64), torch.ones(3, dtype=torch.float64))
    torch.testing.assert_close(free, decayed, rtol=1e-11, atol=1e-300)


def test_inserting_samples_on_the_straight_lines_changes_nothing() -> None:
    modes, coarse = drawn(), wander(2, 300)
    between = (coarse[:, 1:] + coarse[:, :-1]) / 2
    fine = torch.stack([coarse[:, :-1], between], -1).flatten(-2)
    fine = torch.cat([fine, coarse[:, -1:]], -1)
    torch.testing.assert_close(respond(modes, 5.0, fine)[:, ::2], respond(modes, 10.0, coarse), rtol=1e-9, atol=1e-9)


def test_a_steady_input_starts_at_rest() -> None:
    modes = drawn()
    found = respond(modes, 3.0, torch.ones(2, 500, dtype=torch.float64))
    torch.testing.assert_close(found, found[:, :1].expand(-1, 500), rtol=1e-9, atol=1e-6 * float(found.abs().max()))


def test_devices_in_a_batch_are_each_by_themselves() -> None:
    """With inputs of their own, or the same for all."""
    modes, inputs = drawn(4), wander(4, 2, 400)
    both, shared = respond(modes, 10.0, inputs), respond(modes, 10.0, inputs[0])
    for i in range(4):
        one = Modes(modes.rate[i], modes.drive[i], modes.observe[i], modes.direct[i])
        scale = float(both[i].abs().max())
        torch.testing.assert_close(both[i], respond(one, 10.0, inputs[i]), rtol=0, atol=1e-13 * scale)
        torch.testing.assert_close(shared[i], respond(one, 10.0, inputs[0]), rtol=0, atol=1e-13 * float(shared[i].abs().max()))


def test_it_agrees_with_the_exponential_of_the_matrix_that_the_modes_are_of() -> None:
    """Housing, coil and spool, all observed; stepped with the exponential of the whole system, input and its slope included."""
    capacity = torch.tensor([300.0, 80.0, 120.0], dtype=torch.float64)
    link = torch.tensor([[0.0, 0.4, 0.2], [0.4, 0.0, 0.9], [0.2, 0.9, 0.0]], dtype=torch.float64)
    body = Lumps(capacity, link, torch.tensor([[0.5], [0.0], [0.0]], dtype=torch.float64), torch.zeros(3, dtype=torch.float64))
    air, step, root = 20 + wander(2000) / 10, 10.0, capacity.sqrt()
    rate, vectors = torch.linalg.eigh(body.conductance() / root.unsqueeze(1) / root)
    modes = Modes(rate, vectors.mT @ (body.ambient / root.unsqueeze(1)), vectors / root.unsqueeze(1), torch.zeros(3, 1, dtype=torch.float64))
    joint = torch.zeros(5, 5, dtype=torch.float64)
    joint[:3, :3], joint[:3, 3:4], joint[3, 4] = -body.conductance() / capacity.unsqueeze(1), body.ambient / capacity.unsqueeze(1), 1.0
    leap, states = torch.linalg.matrix_exp(joint * step)[:3], [torch.full((3,), float(air[0]), dtype=torch.float64)]
    for now, after in pairwise(air):
        states.append(leap @ torch.cat([states[-1], torch.stack([now, (after - now) / step])]))
    torch.testing.assert_close(respond(modes, step, air.unsqueeze(0)), torch.stack(states, 1), rtol=0, atol=1e-9)


def test_gradients_are_those_of_finite_differences() -> None:
    modes, inputs = drawn(modes=3, outputs=1), wander(2, 2 * CHUNK + 9)
    rate = (1e-3 + modes.rate / 10).requires_grad_()

    def found(rate: Tensor, drive: Tensor, observe: Tensor, direct: Tensor) -> Tensor:
        return respond(Modes(rate, drive, observe, direct), 20.0, inputs)[:, ::10]

    given = (rate, *(value.clone().requires_grad_() for value in (modes.drive, modes.observe, modes.direct)))
    assert torch.autograd.gradcheck(found, given, rtol=1e-6, atol=1e-6, eps=1e-7 * math.sqrt(10))


def test_a_mode_that_never_decays_counts_and_one_that_is_gone_at_once_follows() -> None:
    rate = torch.tensor([0.0, 1e4], dtype=torch.float64)
    modes = Modes(rate, torch.tensor([[1.0], [1e4]], dtype=torch.float64), torch.eye(2, dtype=torch.float64), torch.zeros(2, 1, dtype=torch.float64))
    inputs, step = wander(1, 5 * CHUNK), 10.0
    found = respond(modes, step, inputs, torch.tensor([3.0, 7.0], dtype=torch.float64))
    counted = 3 + torch.nn.functional.pad(step * (inputs[0, 1:] + inputs[0, :-1]) / 2, (1, 0)).cumsum(0)
    torch.testing.assert_close(found[0], counted, rtol=1e-12, atol=1e-10)
    slope = torch.diff(inputs[0]) / step
    torch.testing.assert_close(found[1, 1:], inputs[0, 1:] - slope / 1e4, rtol=0, atol=1e-12)
    assert float(found[1, 0]) == 7.0


@pytest.mark.parametrize("own_inputs", [True, False])
def test_devices_in_turns_give_the_same_and_the_same_gradient(monkeypatch, own_inputs) -> None:
    modes, inputs = drawn(2, 3), wander(2, 3, 2, 100) if own_inputs else wander(2, 100)
    start = wander(3, 6)

    def answer() -> tuple[Tensor, Tensor, Tensor]:
        rate = modes.rate.clone().requires_grad_()
        followed = respond(Modes(rate, modes.drive, modes.observe, modes.direct), 5.0, inputs, start)
        followed.sin().sum().backward()
        return respond(modes, 5.0, inputs, start), followed.detach(), rate.grad

    whole = answer()
    monkeypatch.setattr(modes_file, "STATES_AT_ONCE", 4 * 6 * 5)
    monkeypatch.setattr(modes_file, "OUTPUTS_AT_ONCE", 2 * 3 * CHUNK * 5)
    assert whole[0].is_contiguous()
    for one, turn in zip(whole, answer(), strict=True):
        torch.testing.assert_close(turn, one, rtol=1e-10, atol=1e-10)
    torch.testing.assert_close(whole[0], whole[1], rtol=0, atol=0)


def test_forward_derivatives_are_those_backward() -> None:
    modes, inputs = drawn(modes=3, outputs=1), wander(2, 100)

    def found(rate: Tensor) -> Tensor:
        return respond(Modes(rate, modes.drive, modes.observe, modes.direct), 20.0, inputs)[0, ::10]

    forward = torch.func.jvp(found, (modes.rate,), (torch.ones_like(modes.rate),))[1]
    backward = torch.autograd.functional.jacobian(found, modes.rate).sum(-1)
    torch.testing.assert_close(forward, backward, rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize("steps", [1, 2, 3, 7, 50])
def test_decaying_sums_are_those_of_one_step_after_another_and_have_their_slopes(steps) -> None:
    """Also of what does not decay, and of what is gone after a step."""
    decay = torch.tensor([0.9, 0.3, 1.0, 0.0], dtype=torch.float64, requires_grad=True)
    added = wander(4, divisible(steps)).mT.contiguous().requires_grad_()
    expected = [added[0]]
    for one in added[1:]:
        expected.append(decay * expected[-1] + one)
    found, asked = decaying_sums(decay, added), torch.stack(expected)
    torch.testing.assert_close(found, asked, rtol=1e-12, atol=1e-12)
    torch.testing.assert_close(decaying_sums(decay.detach(), added.detach().clone()), found.detach(), rtol=0, atol=0)
    for one in (decay, added):
        slopes = [torch.autograd.grad(sums.sin().sum() + 0 * decay.sum(), one, retain_graph=True)[0] for sums in (found, asked)]
        torch.testing.assert_close(*slopes, rtol=1e-9, atol=1e-9)
