"""What Lightning costs over a raw loop for the smallest net of the zoo: python benchmarks/lightning_overhead.py [blocks] [epochs]"""

import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import torch
from lightning.pytorch import Trainer
from torch.utils.data import DataLoader, TensorDataset

from zoo.measurements.datamodule import RunsDataModule
from zoo.measurements.run import Run
from zoo.models.bp import BP
from zoo.models.prediction import block_features
from zoo.training import run as training_run
from zoo.training.module import Training
from zoo.training.quiet import quiet_lightning
from zoo.training.weights import reset

FEATURES = ["temperature", "temperature_rate"]
ADAM = partial(torch.optim.Adam, lr=0.02)


def one_run(blocks: int) -> Run:
    time_s = 50.0 + 100.0 * torch.arange(blocks, dtype=torch.float64)
    temperature = 20 + 40 * torch.sin(time_s / 4000)
    table, error = torch.stack([time_s, temperature, 0 * temperature], dim=-1), torch.tanh(temperature / 20)
    return Run("run", "dph", 100.0, ("time_s", "temperature_c", "reference_dph"), table, error, 1 + 0 * time_s, torch.arange(blocks))


def raw(model: BP, data: RunsDataModule, epochs: int) -> None:
    features, error = data.fitted
    scale = float(error.std())
    optimizer = ADAM(model.parameters())
    for _ in range(epochs):
        optimizer.zero_grad()
        ((model.head(features) - error) / scale).square().mean().backward()
        optimizer.step()


def defaults(model: BP, data: RunsDataModule, epochs: int, out: Path) -> None:
    features, error = data.fitted
    loader = DataLoader(TensorDataset(features, error), batch_size=len(error))
    with quiet_lightning():
        Trainer(max_epochs=epochs, accelerator="cpu", default_root_dir=out).fit(Training(model, ADAM, float(error.std())), loader)


def seconds(work) -> float:
    started = time.process_time(), time.perf_counter()
    work()
    print(f"  {time.process_time() - started[0]:7.2f} s CPU {time.perf_counter() - started[1]:7.2f} s wall", file=sys.stderr)
    return time.perf_counter() - started[1]


def main() -> None:
    blocks, epochs = [int(text) for text in sys.argv[1:3]] if len(sys.argv) > 2 else (350, 1000)
    torch.set_num_threads(1)
    run, best = one_run(blocks), {}
    with tempfile.TemporaryDirectory() as name:
        for _ in range(3):
            for label in ("raw loop", "zoo.training.train", "Lightning at defaults"):
                model = BP(FEATURES)
                data = RunsDataModule([run], [], partial(block_features, model))
                model.standardise(*data.fitted)
                reset(model, torch.Generator().manual_seed(1))
                ways = {
                    "raw loop": partial(raw, model, data, epochs),
                    "zoo.training.train": partial(training_run.train, model, [run], optimizer=ADAM, epochs=epochs, out=Path(name)),
                    "Lightning at defaults": partial(defaults, model, data, epochs, Path(name)),
                }
                best[label] = min(best.get(label, float("inf")), seconds(ways[label]))
    for label, took in best.items():
        print(f"{label:24s} {took:7.3f} s for {epochs} epochs of {blocks} blocks   {took / best['raw loop']:5.2f} x")


if __name__ == "__main__":
    main()
