"""Rules from clusters: what is made of planes comes back, what is curved is followed, and a training starts from there."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial

import pytest
import torch
from omegaconf import OmegaConf
from torch import Generator, Tensor

from zoo.catalog import build, load
from zoo.errors import InputError
from zoo.models.takagi_sugeno import TakagiSugeno
from zoo.training.files import CHECKPOINT
from zoo.training.gustafson_kessel import ClusteredInit, Clustering, GustafsonKessel, clustered_weights
from zoo.training.run import train
from zoo.training.weights import weight_vector


def clustered(features: Tensor, error: Tensor, rules: int, seed: int = 1, **settings: float) -> TakagiSugeno:
    model: TakagiSugeno = build("model", "takagi_sugeno", features=["temperature", "supply_v"][: features.shape[1]], rules=rules)
    model.standardise(features, error)
    clustered_weights(model, features, error, Generator().manual_seed(seed), Clustering(**settings))  # type: ignore[arg-type]
    return model


def share_left(model: TakagiSugeno, features: Tensor, error: Tensor) -> float:
    return float((error - model.head(features)).detach().square().mean().sqrt() / error.std(correction=0))


def grid(noise: float = 0.0) -> tuple[Tensor, Tensor]:
    """Temperature and rate of turn on a table, and the error of an open-loop gyro, V·sin(SΩ)/S − Ω with S that falls by 0.035 %/K."""
    temperature, rate = torch.meshgrid(torch.linspace(-30, 60, 19).double(), torch.linspace(-180, 180, 37).double(), indexing="ij")
    features = torch.stack([temperature.flatten(), rate.flatten()], dim=-1)
    sagnac = 0.188 * torch.pi / 180 * (1 - 3.5e-4 * (features[:, 0] - 20))
    error = torch.sin(sagnac * features[:, 1]) / (0.188 * torch.pi / 180) - features[:, 1]
    return features, error + noise * torch.randn(len(error), generator=Generator().manual_seed(1), dtype=torch.float64)


def test_two_lines_that_meet_are_two_rules() -> None:
    """Clusters of a bent line are its halves, a rule each, with their slopes."""
    temperature = torch.linspace(-40, 60, 400).double().unsqueeze(1)
    error = torch.where(temperature[:, 0] < 10, 0.02 * (temperature[:, 0] - 10), -0.05 * (temperature[:, 0] - 10)) + 3
    rules = sorted(clustered(temperature, error, 2, overlap=0.5).formula()["rules"], key=lambda rule: rule["centre"]["temperature"])
    assert [rule["consequent"]["temperature"] for rule in rules] == pytest.approx([0.02, -0.05], rel=0.03)
    assert [rule["centre"]["temperature"] for rule in rules] == pytest.approx([-15, 35], abs=5)


@pytest.mark.parametrize("rules", [1, 3])
def test_what_is_a_plane_is_left_to_rounding_and_the_prior(rules: int) -> None:
    features, _ = grid()
    error = 0.4 - 0.02 * features[:, 0] + 1e-3 * features[:, 1]
    assert share_left(clustered(features, error, rules), features, error) < 1e-6


def test_more_rules_follow_the_gyro_more_closely() -> None:
    features, error = grid()
    left = [share_left(clustered(features, error, rules), features, error) for rules in (1, 4, 8, 12)]
    assert left[1] < 0.1 * left[0]
    assert left[2] < 0.5 * left[1]
    assert left[3] < 0.7 * left[2]


def test_the_best_overlap_is_at_least_as_good_as_that_of_the_paper() -> None:
    features, error = grid(noise=0.1)
    for seed in (1, 2, 3):
        assert share_left(clustered(features, error, 4, seed), features, error) < 0.5 * share_left(
            clustered(features, error, 4, seed, overlap=1.0), features, error
        )


def test_the_units_of_features_and_error_do_not_matter() -> None:
    features, error = grid()
    one = clustered(features, error, 4)
    factor = torch.tensor([1.8, 3600.0], dtype=torch.float64)
    two = clustered(factor * features + 32, 4.8e-6 * error, 4)
    torch.testing.assert_close(two.head(factor * features + 32) / 4.8e-6, one.head(features), rtol=1e-4, atol=1e-4)


def test_equal_seeds_give_equal_rules_and_restarts_settle_what_chance_leaves_open() -> None:
    features, error = grid()
    assert torch.equal(weight_vector(clustered(features, error, 4, 1)), weight_vector(clustered(features, error, 4, 1)))
    often = [sorted(clustered(features, error, 4, seed).centre.detach()[:, 1].tolist()) for seed in (1, 2)]
    assert often[0] == pytest.approx(often[1], abs=0.02)


def test_of_very_many_points_some_find_the_rules_and_all_the_planes() -> None:
    """Twenty times the same points: the same moments, so nearly the same rules, and the planes of all."""
    features, error = grid()
    many = clustered(features.repeat(20, 1), error.repeat(20), 4)
    assert share_left(many, features, error) < 2 * share_left(clustered(features, error, 4), features, error)
    target, columns = (error - many.scaler.error_centre) / many.scaler.error_scale, many.columns(features).detach()
    prior = (20 * Clustering().alpha) ** -0.5 * torch.eye(columns.shape[1], dtype=torch.float64)
    told = torch.cat([target, torch.zeros(len(prior), dtype=torch.float64)]).unsqueeze(1)
    planes = torch.linalg.lstsq(torch.cat([columns, prior]), told, driver="gelsd").solution
    torch.testing.assert_close(columns @ many.consequent.detach().flatten(), (columns @ planes).squeeze(1), rtol=0, atol=1e-8)


def test_a_training_fits_and_starts_where_the_fit_ends(make_run, tmp_path) -> None:
    runs = [make_run(bend=0.5, noise=0.01), make_run("run_2", high=30.0, bend=0.5, noise=0.01, seed=2)]
    fitted, started = (build("model", "takagi_sugeno") for _ in range(2))
    one = train(fitted, runs, optimizer=GustafsonKessel(), out=tmp_path / "fit", seed=3)
    two = train(started, runs, optimizer=partial(torch.optim.SGD, lr=0.0), init=ClusteredInit(seed=3), epochs=1, out=tmp_path / "init", seed=3)
    assert one["rms"] < 0.05 * one["rms_uncompensated"]
    assert two["rms"] == pytest.approx(one["rms"], rel=1e-9)
    adam = partial(torch.optim.Adam, lr=1e-3)
    better = train(build("model", "takagi_sugeno"), runs, optimizer=adam, init=ClusteredInit(seed=3), epochs=300, out=tmp_path / "adam", seed=3)
    assert better["rms"] < one["rms"]


def test_a_training_that_goes_on_is_not_started_anew(make_run, tmp_path) -> None:
    runs, adam = [make_run(bend=0.5)], partial(torch.optim.Adam, lr=1e-3)
    whole, again = build("model", "takagi_sugeno"), build("model", "takagi_sugeno")
    train(whole, runs, optimizer=adam, init=ClusteredInit(), epochs=100, out=tmp_path)
    train(build("model", "takagi_sugeno"), runs, optimizer=adam, init=ClusteredInit(), epochs=50, out=tmp_path)
    train(again, runs, optimizer=adam, init=ClusteredInit(), epochs=100, resume=tmp_path / CHECKPOINT, out=tmp_path)
    torch.testing.assert_close(weight_vector(again), weight_vector(whole), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("group", ["optimizer", "init"])
def test_the_catalogue_says_what_the_class_says(group: str) -> None:
    settings = OmegaConf.to_container(load(group, "gustafson_kessel"))
    assert {key: value for key, value in settings.items() if key not in {"_target_", "seed"}} == asdict(Clustering())  # type: ignore[union-attr]


def test_another_model_is_refused(make_run, tmp_path) -> None:
    run = make_run()
    with pytest.raises(InputError, match=r"model=takagi_sugeno; BP has none"):
        GustafsonKessel().fit(build("model", "bp"), [run], Generator())
    with pytest.raises(InputError, match=r"model=takagi_sugeno; BP has none"):
        train(build("model", "bp"), [run], optimizer=partial(torch.optim.Adam, lr=0.01), init=ClusteredInit(), epochs=3, out=tmp_path)
    with pytest.raises(InputError, match=rf"model\.rules=500: the runs have {run.blocks} block means"):
        GustafsonKessel().fit(build("model", "takagi_sugeno", rules=500), [run], Generator())


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"restarts": 0}, "restarts=0: a whole number from 1"),
        ({"iterations": 2.5}, "iterations=2.5: a whole number"),
        ({"fuzziness": 1}, "fuzziness=1: a number above 1"),
        ({"tolerance": 0}, "tolerance=0: a number between 0 and 1"),
        ({"regularisation": "little"}, "regularisation=little: a number between 0 and 1"),
        ({"alpha": -3}, "alpha=-3: a number above 0"),
        ({"overlap": 0}, "overlap=0: a number above 0"),
    ],
)
def test_impossible_settings_are_named(settings, message) -> None:
    with pytest.raises(InputError, match=rf"optimizer\.{message}"):
        GustafsonKessel(**settings)
    with pytest.raises(InputError, match=rf"init\.{message}"):
        ClusteredInit(**settings)
