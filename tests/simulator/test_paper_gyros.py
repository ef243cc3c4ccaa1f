"""The gyros of the papers have, before any compensation, the figures that the papers print."""

from __future__ import annotations

from collections.abc import Callable

import pytest
import torch
from torch import Tensor

from zoo.catalog import build
from zoo.models.features import Features
from zoo.scoring.rate_windows import rate_windows
from zoo.scoring.stages import bias_stability
from zoo.simulator.gyros.presets import PRESETS
from zoo.simulator.recorded import Recorded
from zoo.simulator.simulate import simulate

# Electronics Optics & Control 30(7), 2023, table 1: bias stability in °/h of the stages of samples 1 to 3, and of the whole runs.
STAGES = [
    (0.0079, 0.0117, 0.0102), (0.0540, 0.0543, 0.0561), (0.0084, 0.0101, 0.0078), (0.0632, 0.0612, 0.0627), (0.0110, 0.0092, 0.0085),
    (0.0696, 0.0687, 0.0669), (0.0090, 0.0074, 0.0082), (0.0620, 0.0558, 0.0564), (0.0089, 0.0083, 0.0098), (0.0381, 0.0403, 0.0436),
    (0.0079, 0.0089, 0.0097),
]  # fmt: skip
WHOLE = (0.0514, 0.0559, 0.0549)
# Table 2: what the polynomial y = k1 + k2·T + k3·dT/dt (eq. 7), fitted to sample 1, leaves of the ramps and of the whole runs.
LEFT = [
    (0.0244, 0.0354, 0.0358),
    (0.0176, 0.0149, 0.0164),
    (0.0149, 0.0144, 0.0140),
    (0.0150, 0.0091, 0.0097),
    (0.0249, 0.0208, 0.0209),
    (0.0199, 0.0246, 0.0228),
]
BEST = 0.0098
"""Mean of what its best network, ACO-BP, leaves of the whole runs in table 2."""
TENTH_OF_THE_RAMPS = 0.02
"""A hold is where the thermometer moves at less than this, a tenth of the ramps' 0.2 K/min."""


def recorded(name: str, effects: list[str], runs: int, seed: int, **settings: object) -> list[Recorded]:
    chosen = {one: build("effects", one) for one in effects}
    return simulate(build("gyro", name), build("profile", name), chosen, build("noise", "gyro"), runs=runs, seed=seed, **settings).runs


def block_means(run: Recorded, rows: int = 10) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    """Time, temperature, its rate [K/min] and error in means over ten rows, which are 100 s."""
    table = run.table
    rate = Features(["temperature_rate"])(torch.stack([table["time_s"], table["temperature_c"]], dim=1)).squeeze(1)
    each = (table["time_s"], table["temperature_c"], rate, table["rate_dph"] - table["reference_dph"])
    whole = len(each[0]) // rows * rows
    return tuple(one[:whole].reshape(-1, rows).mean(1) for one in each)


def qiu2023(seed: int) -> tuple[Tensor, float]:
    """Ratios of simulated to printed bias stability: of the 11 stages, means of three samples, and of the whole runs."""
    stages, whole = [], []
    for run in recorded("qiu2023", ["static_bias", "shupe", "mohr", "rate_temperature_coupling"], 3, seed):
        time, temperature, _, error = block_means(run)
        stages.append(torch.tensor([bias_stability(error[one]) for one in rate_windows(time, temperature, TENTH_OF_THE_RAMPS)]))
        whole.append(bias_stability(error))
    return torch.stack(stages).mean(0) / torch.tensor(STAGES).mean(1), sum(whole) / sum(WHOLE)


def test_qiu2023_has_the_stages_of_its_table() -> None:
    ratios, whole = qiu2023(1)
    assert ratios.shape == (11,)
    assert ratios.tolist() == pytest.approx([1.0] * 11, abs=0.3)
    assert whole == pytest.approx(1.0, abs=0.2)


def test_qiu2023_has_them_on_average_over_seeds_and_its_ramps_in_each() -> None:
    """A hold is 12 to 40 means of white noise, so that its own figure is uncertain to a fifth."""
    each = [qiu2023(seed) for seed in range(2, 18)]
    ratios = torch.stack([stages for stages, _ in each])
    assert ratios.mean(0).tolist() == pytest.approx([1.0] * 11, abs=0.3)
    assert float((ratios[:, 1::2] - 1).abs().max()) < 0.3
    assert all(abs(whole - 1) < 0.2 for _, whole in each)


def test_qiu2023_leaves_a_polynomial_and_a_network_what_its_second_table_says() -> None:
    """The network's figure was not fitted: a smooth function of T and dT/dt comes to it once the polynomial's are right."""
    samples = [block_means(run) for run in recorded("qiu2023", ["static_bias", "shupe", "mohr", "rate_temperature_coupling"], 3, 1)]
    stages = [[*rate_windows(time, temperature, TENTH_OF_THE_RAMPS)[1::2], slice(None)] for time, temperature, _, _ in samples]
    error = [each for *_, each in samples]

    def left(columns: Callable[[Tensor, Tensor], Tensor]) -> Tensor:
        """(3, 6) of the ramps and the whole run, with coefficients from sample 1."""
        own = [columns((temperature - 10) / 50, rate) for _, temperature, rate, _ in samples]
        fitted = torch.linalg.lstsq(own[0], error[0].unsqueeze(1)).solution
        rest = [each - (rows @ fitted).squeeze(1) for rows, each in zip(own, error, strict=True)]
        return torch.tensor([[bias_stability(one[stage]) for stage in cut] for one, cut in zip(rest, stages, strict=True)])

    def seventh(temperature: Tensor, rate: Tensor) -> Tensor:
        return torch.stack([torch.ones_like(rate), temperature, rate], dim=1)

    def smooth(temperature: Tensor, rate: Tensor) -> Tensor:
        powers, slope = temperature.unsqueeze(1) ** torch.arange(6), rate.unsqueeze(1)
        return torch.cat([powers, powers * slope, powers[:, :4] * slope**2], dim=1)

    assert (left(seventh).mean(0) / torch.tensor(LEFT).mean(1)).tolist() == pytest.approx([1.0] * 6, abs=0.25)
    assert float(left(smooth)[:, -1].mean()) == pytest.approx(BEST, rel=0.15)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_tong2019_has_its_mean_and_standard_deviation(seed: int) -> None:
    (run,) = recorded("tong2019", ["static_bias", "shupe", "mohr", "polarization"], 1, seed)
    *_, error = block_means(run)
    assert float(error.mean()) == pytest.approx(-6.90e-2, rel=0.1)
    assert float(error.std()) == pytest.approx(1.5317e-2, rel=0.1)


def test_tong2019_turns_where_its_segments_meet() -> None:
    chosen = {one: build("effects", one) for one in ("static_bias", "polarization")}
    (run,) = simulate(build("gyro", "tong2019"), build("profile", "tong2019"), chosen, build("noise", "none"), runs=1).runs
    temperature, drift = run.truth["temperature_coil_c"], run.truth["sum_dph"].diff()
    turns = temperature[1:-1][drift[1:] * drift[:-1] < 0]
    assert turns.tolist() == pytest.approx([0.0, 15.0, 30.0, 37.0], abs=0.5)


def test_liu2010_has_its_largest_error_and_its_spread() -> None:
    """What the paper prints as the error's variance can only be its standard deviation: of two of its methods it exceeds the maximum squared."""
    (run,) = recorded("liu2010", ["static_bias", "scale_factor", "scale_factor_nonlinearity"], 1, 1, sample_s=600.0)
    turning = run.table["reference_dph"] != 0
    error = ((run.table["rate_dph"] - run.table["reference_dph"]) / 3600)[turning]
    assert int(turning.sum()) == 19 * 36
    assert float(error.abs().max()) == pytest.approx(11.5764, rel=0.1)
    assert float(error.std()) == pytest.approx(4.61936, rel=0.1)


@pytest.mark.parametrize("name", ["qiu2023", "tong2019", "liu2010"])
def test_a_papers_gyro_is_one_gyro_and_says_where_its_numbers_are_from(name: str) -> None:
    gyro = PRESETS[name]
    spans = {key: value for key, value in vars(gyro).items() if hasattr(value, "source")}
    assert len(spans) > 20
    assert all(span.low == span.high and span.source for span in spans.values())


@pytest.mark.parametrize("name", ["qiu2023", "tong2019", "liu2010"])
def test_what_the_user_asks_for_goes_before_what_the_paper_fixes(name: str) -> None:
    effect = next(iter(PRESETS[name].fixed))
    asked = build("gyro", name, effects={effect: 0.123})
    done = simulate(asked, build("profile", "cycle"), {effect: build("effects", effect)}, runs=1, sample_s=60.0, reference_dph=10.0)
    assert 0.123 in {abs(value) for value, _ in done.shares[effect].parameters().values()}
