"""Fuzzy models of an open-loop gyro's error over temperature and rate (liu2010): ours beside pyFUME, anfis-toolbox and scikit-learn.

OMP_NUM_THREADS=1 python benchmarks/takagi_sugeno.py 5        how many splits (default 5)

448 points train and 200 check, as in the paper. pyFUME asks for NumPy 1.24 and works with later ones:
pip install anfis-toolbox==0.2.2 scikit-learn && pip install --no-deps pyFUME==0.3.4 simpful==2.12.0 fst-pso==1.9.0 miniful==0.0.6
"""

from __future__ import annotations

import contextlib
import io
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from torch import Generator

from zoo.models.takagi_sugeno import TakagiSugeno
from zoo.training.damped_steps import descend
from zoo.training.gustafson_kessel import clustered_weights
from zoo.training.weights import reset

FIT, CHECK = 448, 200
NOISE = 0.0062
"""White noise of the points as a share of the error's σ: what liu2010's own fuzzy model leaves."""
STEPS = 100
Predict = Callable[[np.ndarray], np.ndarray]
Learn = Callable[[np.ndarray, np.ndarray, int], Predict]


def points() -> tuple[np.ndarray, np.ndarray]:
    """Temperature and measured rate (M, 2), and the error (M,), of all turning points of the paper's table program."""
    with tempfile.TemporaryDirectory() as name:
        command = [sys.executable, "-c", "import sys; from zoo.cli import run; sys.exit(run('simulate', sys.argv[1:]))"]
        subprocess.run([*command, "gyro=liu2010", "pictures=false", f"hydra.run.dir={name}"], check=True, stdout=subprocess.DEVNULL)
        table = pd.read_csv(Path(name) / "run_1.csv")
    table = table[table["reference_dph"] != 0]
    return table[["temperature_c", "rate_dph"]].to_numpy(), (table["rate_dph"] - table["reference_dph"]).to_numpy()


def ours(start: str, steps: int, rules: int, features: np.ndarray, error: np.ndarray, seed: int) -> Predict:
    model, chance = TakagiSugeno(["temperature", "rate"], rules), Generator().manual_seed(seed)
    x, y = torch.from_numpy(features), torch.from_numpy(error)
    model.standardise(x, y)
    if start == "clusters":
        clustered_weights(model, x, y, chance)
    else:
        reset(model, chance)
    if steps:
        descend(model, x, y, lambda columns: columns, steps)
    return lambda asked: model.head(torch.from_numpy(asked)).detach().numpy()


def pyfume(rules: int, features: np.ndarray, error: np.ndarray, seed: int) -> Predict:
    from pyfume import simpfulfier
    from pyfume.pyfume import pyFUME

    simpfulfier.np = np  # it runs code that it has written, where NumPy 2 writes numbers as np.float64(…)
    np.random.seed(seed)  # noqa: NPY002 (pyFUME draws from there)
    table = pd.DataFrame({"a": features[:, 0], "b": features[:, 1], "y": error})
    with contextlib.redirect_stdout(io.StringIO()):
        model = pyFUME(dataframe=table, nr_clus=rules, cluster_method="gk", percentage_training=1.0, setnes_threshold=1.0, save_simpful_code=False)

    def predict(asked: np.ndarray) -> np.ndarray:
        return np.asarray(model.predict_label(asked)).ravel()

    return predict


def anfis(memberships: int, features: np.ndarray, error: np.ndarray, seed: int) -> Predict:
    from anfis_toolbox import ANFISRegressor

    model = ANFISRegressor(n_mfs=memberships, random_state=seed).fit(features, error)
    return lambda asked: np.asarray(model.predict(asked)).ravel()


def kernel_ridge(features: np.ndarray, error: np.ndarray, seed: int) -> Predict:
    from sklearn.kernel_ridge import KernelRidge
    from sklearn.model_selection import GridSearchCV, KFold

    grid = {"alpha": np.logspace(-10, 0, 11), "gamma": np.logspace(-2, 1, 7)}
    folds = KFold(5, shuffle=True, random_state=seed)
    return GridSearchCV(KernelRidge(kernel="rbf"), grid, cv=folds, scoring="neg_mean_squared_error").fit(features, error).predict


WAYS: dict[str, tuple[str, Learn]] = {
    "ours, 4 rules": ("", partial(ours, "clusters", 0, 4)),
    "ours, 8 rules": ("", partial(ours, "clusters", 0, 8)),
    "ours, 12 rules": ("", partial(ours, "clusters", 0, 12)),
    "ours, 4 rules, then steps": ("", partial(ours, "clusters", STEPS, 4)),
    "ours, 8 rules, then steps": ("", partial(ours, "clusters", STEPS, 8)),
    "ours, random, then steps, 4": ("", partial(ours, "random", STEPS, 4)),
    "pyFUME, GK, 4 rules": ("pyfume", partial(pyfume, 4)),
    "pyFUME, GK, 12 rules": ("pyfume", partial(pyfume, 12)),
    "anfis-toolbox, 2x2 rules": ("anfis_toolbox", partial(anfis, 2)),
    "anfis-toolbox, 4x4 rules": ("anfis_toolbox", partial(anfis, 4)),
    "kernel ridge, grid search": ("sklearn", kernel_ridge),
}
"""What each needs, and how it learns from standardised features and error."""


def judged(learn: Learn, features: np.ndarray, error: np.ndarray, split: int) -> tuple[float, float]:
    """Seconds of learning, and RMS on the check points as a share of the error's σ."""
    order = np.random.default_rng(split).permutation(len(error))
    fit, check = order[:FIT], order[FIT : FIT + CHECK]
    x = (features - features[fit].mean(axis=0)) / features[fit].std(axis=0)
    y = (error - error[fit].mean()) / error[fit].std()
    started = time.perf_counter()
    predict = learn(x[fit], y[fit], split)
    taken = time.perf_counter() - started
    return taken, float(np.sqrt(np.mean((predict(x[check]) - y[check]) ** 2)))


def main(splits: int) -> None:
    torch.set_num_threads(1)
    features, error = points()
    noisy = error + NOISE * error.std() * np.random.default_rng(0).standard_normal(len(error))
    print(f"{FIT} points fitted, {CHECK} checked, median of {splits} splits; what is left of the check points' error, in % of its σ [least … most]")
    print(f"{'':30s}{'s':>8s}{'as simulated':>28s}{f'with noise of {100 * NOISE:.2f} %':>28s}")
    for name, (needs, learn) in WAYS.items():
        try:
            # pyFUME writes the data that it was given into the working directory.
            with tempfile.TemporaryDirectory() as own, contextlib.chdir(own):
                results = [[judged(learn, features, y, split) for split in range(splits)] for y in (error, noisy)]
        except ModuleNotFoundError as missing:
            print(f"{name:30s}{'not here':>8s}   {needs} ({missing}); see the top of this file for what to install")
            continue
        cells = "".join(f"{_spread([100 * left for _, left in result]):>28s}" for result in results)
        print(f"{name:30s}{np.median([taken for result in results for taken, _ in result]):8.3f}{cells}", flush=True)


def _spread(values: list[float]) -> str:
    return f"{np.median(values):.3g} [{min(values):.3g} … {max(values):.3g}]"


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
