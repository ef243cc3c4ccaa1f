"""What one sample costs in an exported model: python benchmarks/export_step.py [samples]

For every network of the catalogue, a grey box and a hybrid: `step` of model.ts beside the same model called row by row in Python with its memory
carried on, and `forward` of model.ts and model.pt2 by row. Medians of several rounds, one thread; wall and processor time of the calling process, as
other work on the machine lengthens the first only.
"""

import statistics
import sys
import time

import torch

from zoo.catalog import build, load, names
from zoo.export.program import load_program, to_programs
from zoo.export.torchscript import load_torchscript, to_torchscript
from zoo.models.base import Model
from zoo.models.example import example
from zoo.models.graybox import GrayBox
from zoo.models.hybrid import Hybrid
from zoo.models.streaming import continued
from zoo.training.weights import reset

ROUNDS = 5
EFFECTS = ("static_bias", "shupe", "mohr", "hysteresis", "glass_transition")


def network(name: str) -> Model:
    model = build("model", name)
    reset(model, torch.Generator().manual_seed(1))
    x = example(model.inputs, {})
    model.standardise(model.features(x), torch.sin(x[:, 0] / 3000))
    return model


def models() -> dict[str, Model]:
    effects = {name: build("effects", name) for name in EFFECTS}
    inputs = ["time_s", "temperature_c", "reference_dph"]
    physics = GrayBox(effects, inputs)
    physics.assign(physics.theta(), torch.ones(sum(len(one.amplitudes) for one in effects.values()), dtype=torch.float64))
    hybrid = Hybrid(network("bp"), effects, inputs)
    hybrid.physics = physics
    networks = {name: network(name) for name in names("model") if "inputs" not in load("model", name)}
    return networks | {f"grey box of {len(effects)} effects": physics, "hybrid of bp and these": hybrid}


def each_us(work, rows: int) -> tuple[float, float]:
    """Wall and processor time by row [µs], medians of the rounds."""
    walls, own = [], []
    for _ in range(ROUNDS):
        wall, used = time.perf_counter(), time.process_time()
        work()
        walls.append((time.perf_counter() - wall) / rows * 1e6)
        own.append((time.process_time() - used) / rows * 1e6)
    return statistics.median(walls), statistics.median(own)


def in_python(model: Model, rows: list[torch.Tensor]) -> None:
    states: list[torch.Tensor] = []
    for row in rows:
        _, states = continued(model, row.unsqueeze(0), states)


def stepped(script, rows: list[torch.Tensor]) -> None:
    script.reset()
    for row in rows:
        script.step(row)


def main() -> None:
    samples = int(sys.argv[1]) if len(sys.argv) > 1 else 20_000
    torch.set_num_threads(1)
    print(f"{samples} samples, {ROUNDS} rounds, µs a sample as wall (processor)")
    print(
        f"{'model':28s} {'model.ts step':>16s} {'row by row':>16s} {'ratio':>7s} {'model.ts forward':>17s} {'model.pt2':>16s} {'step − forward':>15s}"
    )
    with torch.no_grad():
        for name, model in models().items():
            made_up = example(model.inputs, {})
            script = load_torchscript(to_torchscript(model, "dph", made_up, {}))
            program = load_program(to_programs(model, made_up, {})[0]).module()
            x = made_up[torch.arange(samples) % len(made_up)]
            x[:, 0] = 0.1 * torch.arange(samples)
            rows, few = list(x.unbind(0)), list(x[: max(samples // 50, 10)].unbind(0))
            script(x), program(x), stepped(script, rows[:100])  # both compile at their first calls
            costs = [
                each_us(lambda: stepped(script, rows), samples),  # noqa: B023 (called at once)
                each_us(lambda: in_python(model, few), len(few)),  # noqa: B023
                each_us(lambda: script(x), samples),  # noqa: B023
                each_us(lambda: program(x), samples),  # noqa: B023
            ]
            script.reset()
            apart = float((torch.stack([script.step(row) for row in rows]) - script(x)).abs().max() / script(x).abs().max())
            step, slow, whole, graph = (f"{wall:.2f} ({own:.2f})" for wall, own in costs)
            print(f"{name:28s} {step:>16s} {slow:>16s} {costs[1][1] / costs[0][1]:6.0f} x {whole:>17s} {graph:>16s} {apart:>15.1e}")


if __name__ == "__main__":
    main()
