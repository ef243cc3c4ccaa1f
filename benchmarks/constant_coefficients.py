"""Where the heat solver's constant coefficients bite: gyros from the middle of their class against the same ones with coefficients that change.

python benchmarks/constant_coefficients.py 3        which gyros of the classes (default 1)
"""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np
import torch
from scipy.integrate import solve_ivp

from zoo.simulator.gyros.classes import MEDIUM, TACTICAL
from zoo.simulator.gyros.device import Device, draw
from zoo.simulator.gyros.paper_gyros import typical
from zoo.simulator.laboratory.program import Program
from zoo.simulator.thermal.changing_heat import Balance, balance
from zoo.simulator.thermal.coefficients import RADIATED, bite
from zoo.simulator.thermal.heat import Heat, heat
from zoo.simulator.thermal.winding_weights import coil_weight

STEP_S = 10.0
COLD, HOT = -40.0, 60.0
SHARES = (0.05, RADIATED, 0.5)
RATES = (0.5, 1.0, 5.0)
CLASSES = {one.name: one for one in (MEDIUM, TACTICAL)}


def marched(body: Balance, program: Program) -> tuple[torch.Tensor, Heat]:
    """Time and heat with coefficients that change, leg after leg."""
    state, states = np.full(body.device.gyro.layers + 4, program.legs[0][0]), []
    for begin, end, seconds in program.legs:

        def rates(time: float, columns: np.ndarray, begin: float = begin, slope: float = (end - begin) / seconds) -> np.ndarray:
            return body.rates(torch.from_numpy(columns.T), torch.tensor(begin + slope * time, dtype=torch.float64)).numpy().reshape(columns.T.shape).T

        rows = np.arange(round(seconds / STEP_S) + 1) * STEP_S
        found = solve_ivp(rates, (0.0, rows[-1]), state, "Radau", rows, vectorized=True, rtol=1e-7, atol=1e-7).y
        states.append(found[:, :-1])
        state = found[:, -1]
    time = torch.arange(sum(one.shape[1] for one in states), dtype=torch.float64) * STEP_S
    return time, body.seen(torch.from_numpy(np.concatenate(states, 1).T.copy()), program.asked(time))


def frozen(device: Device) -> None:
    """Prints what a ramp of 1 K/min does with the coefficients of −40, 20 and 60 °C."""
    print("radiated  at °C  slowest s  self-heating K  coil late s  housing leads K  outer - inner K  Shupe's edge °/h")
    for share in SHARES:
        for row in bite(device, radiated=share):
            numbers = f"{row.slowest_s:9.0f} {row.self_heating_k:15.2f} {row.delay_s:12.0f} {row.lead_k:16.2f} {row.across_k:16.3f}"
            print(f"{share:8.2f} {row.celsius:6.0f} {numbers} {row.shupe_dph:17.5f}")


def ramped(device: Device, rate: float) -> None:
    """Prints by how much coefficients of 20 °C are wrong on a ramp from −40 to 60 °C, the electronics' heat aside."""
    cool = replace(device, values={**device.values, "self_heating_k": 0.0})
    soak = STEP_S * round(10 * device["package_s"] / STEP_S)
    program = Program(((COLD, COLD, 600.0), (COLD, HOT, (HOT - COLD) / rate * 60), (HOT, HOT, soak)))
    time, body = marched(balance(cool), program)
    true, linear = asked(body, device), asked(heat([cool], time, body.air), device)
    end = round((program.seconds - soak) / STEP_S)
    wrong = linear - true
    late = int(wrong[0].abs().argmax())
    coil, pace, lead, shupe = wrong.abs().amax(1).tolist()
    edges = " ".join(f"{float(one[3, part].abs().max()):7.4f}" for part in (slice(end), slice(end, None)) for one in (true, linear))
    slope, mohr = (math.sqrt(math.prod(device.gyro.effects[name])) for name in ("static_bias", "mohr"))
    in_dph = f"{slope * coil:8.4f} {mohr * pace:9.4f} {shupe:8.4f} {device['flicker']:8.4f}"
    print(f"{rate:5.1f} {float(wrong[0, late]):7.2f} {float(true[0, late]):6.0f} {pace:9.3f} {lead:7.2f} {edges} {in_dph}")


def asked(body: Heat, device: Device) -> torch.Tensor:
    """(4, T) coil [°C], its rate [K/min], the housing's lead [K], Shupe's error [°/h]."""
    return torch.cat([body.coil, body.coil_rate, body.housing - body.coil, coil_weight(device) * body.shupe])


def main(seed: int) -> None:
    torch.set_num_threads(1)
    for name, gyro in CLASSES.items():
        device = draw(typical(gyro, name), seed)
        print(f"\n{name}, gyro {seed}: a ramp of 1 K/min with coefficients frozen")
        frozen(device)
        print("coefficients of 20 °C against ones that change, -40 to 60 °C: largest errors, and in °/h for the middle of the class")
        print("                                        Shupe cold      Shupe hot")
        print("K/min  coil K  at °C  rate K/min  lead K    true   20 °C    true   20 °C b_T·coil  C_M·rate    Shupe  flicker")
        for rate in RATES:
            ramped(device, rate)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
