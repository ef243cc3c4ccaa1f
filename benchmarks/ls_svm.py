"""The least-squares support vector machine beside scikit-learn's kernel ridge and Gaussian process: python benchmarks/ls_svm.py [seeds]

Accuracy on data that nobody fitted and time to choose the kernel and fit, all in one run on one thread; medians over simulated gyros.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np
import torch
from sklearn.compose import TransformedTargetRegressor
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sklearn.kernel_ridge import KernelRidge
from sklearn.model_selection import GridSearchCV, KFold
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from threadpoolctl import threadpool_limits

from zoo.measurements.read import read_runs
from zoo.measurements.run import Run
from zoo.models.ls_svm import LsSvm
from zoo.models.prediction import block_features
from zoo.training.dual_solve import DualSolve
from zoo.training.kernel_search import GAMMAS, WIDTHS

SIMULATE = Path(__file__).resolve().parents[1] / "scripts" / "simulate.py"
TEMPERATURE_AND_RATE, TEMPERATURE_AND_INPUT = ["temperature", "temperature_rate"], ["temperature", "reference_dph"]
Predict = Callable[[np.ndarray], np.ndarray]
Fit = Callable[[LsSvm, list[Run], np.ndarray, np.ndarray], Predict]


def ours(model: LsSvm, runs: list[Run], features: np.ndarray, error: np.ndarray, folds: str = "auto") -> Predict:
    DualSolve(folds).fit(model, runs, torch.Generator().manual_seed(1))
    return lambda points: model.head(torch.from_numpy(points)).numpy()


def standardised(estimator) -> TransformedTargetRegressor:
    return TransformedTargetRegressor(make_pipeline(StandardScaler(), estimator), transformer=StandardScaler())


def kernel_ridge(model: LsSvm, runs: list[Run], features: np.ndarray, error: np.ndarray) -> Predict:
    """Over the grid that our search starts from, by five-fold cross-validation."""
    inner = "regressor__kernelridge__"
    grid = {f"{inner}alpha": (0.5**GAMMAS).numpy(), f"{inner}gamma": (0.25**WIDTHS).numpy()}
    search = GridSearchCV(standardised(KernelRidge(kernel="rbf")), grid, scoring="neg_mean_squared_error", cv=KFold(5, shuffle=True, random_state=1))
    return search.fit(features, error).predict


def gaussian_process(model: LsSvm, runs: list[Run], features: np.ndarray, error: np.ndarray) -> Predict:
    """A width for each feature and the noise by marginal likelihood."""
    kernel = ConstantKernel(1.0, (1e-3, 1e6)) * RBF(np.ones(features.shape[1]), (1e-2, 1e3)) + WhiteKernel(0.1, (1e-12, 10.0))
    return standardised(GaussianProcessRegressor(kernel, random_state=1)).fit(features, error).predict


PEERS: dict[str, Fit] = {
    "fogzoo ls_svm": ours,
    "… folds=sample": partial(ours, folds="sample"),  # leaves out single samples, as the folds of the next one do
    "KernelRidge, GridSearchCV": kernel_ridge,
    "GaussianProcessRegressor": gaussian_process,
}


def simulated(gyro: str, seed: int, folder: str) -> list[Run]:
    out = f"{folder}/{gyro}_{seed}"
    command = [sys.executable, SIMULATE, f"gyro={gyro}", f"seed={seed}", "pictures=false", f"hydra.run.dir={out}"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return read_runs(sorted(Path(out).glob("run_*.csv")))


def points(run: Run, index: torch.Tensor) -> Run:
    """Some of a run's block means."""
    number = torch.full((run.blocks,), -1)
    number[index.sort().values] = torch.arange(len(index))
    return replace(run, block=torch.where(run.block >= 0, number[run.block.clamp_min(0)], -1))


def drawn_points(run: Run, seed: int) -> tuple[list[Run], list[Run]]:
    """448 points to fit and 200 to check on, as in liu2010."""
    order = torch.randperm(run.blocks, generator=torch.Generator().manual_seed(seed))
    return [points(run, order[:448])], [points(run, order[448:648])]


def arrays(model: LsSvm, runs: list[Run]) -> tuple[np.ndarray, np.ndarray]:
    return torch.cat([block_features(model, run) for run in runs]).numpy(), torch.cat([run.block_mean(run.error) for run in runs]).numpy()


def compare(title: str, names: list[str], cases: list[tuple[list[Run], list[Run]]]) -> None:
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in PEERS}
    for runs, check in cases:
        for name, fit in PEERS.items():
            model = LsSvm(names)
            features, error = arrays(model, runs)
            unseen, wanted = arrays(model, check)
            started = time.perf_counter()
            predict = fit(model, runs, features, error)
            took = time.perf_counter() - started
            found[name].append((float(np.sqrt(np.mean((predict(unseen) - wanted) ** 2))), took))
    print(f"{title}: {len(error)} fitted, {len(wanted)} checked, {len(cases)} gyros")
    rms = median(one[0] for one in found["fogzoo ls_svm"])
    took = median(one[1] for one in found["fogzoo ls_svm"])
    for name, values in found.items():
        accuracy, seconds = median(one[0] for one in values), median(one[1] for one in values)
        print(f"  {name:26s} check RMS {accuracy:9.5f} °/h ({accuracy / rms:5.3f} x)   {seconds:7.2f} s ({seconds / took:5.2f} x)", flush=True)


def main(seeds: int) -> None:
    torch.set_num_threads(1)
    with tempfile.TemporaryDirectory() as folder, threadpool_limits(1), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        qiu = [simulated("qiu2023", seed, folder) for seed in range(1, seeds + 1)]
        liu = [simulated("liu2010", seed, folder) for seed in range(1, seeds + 1)]
        compare("liu2010, drawn points", TEMPERATURE_AND_INPUT, [drawn_points(runs[0], seed) for seed, runs in enumerate(liu)])
        compare("qiu2023, one run for the other two", TEMPERATURE_AND_RATE, [(runs[:1], runs[1:]) for runs in qiu])
        compare("qiu2023, two runs for the third", TEMPERATURE_AND_RATE, [(runs[:2], runs[2:]) for runs in qiu])


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
