"""Blocks and noise in words."""

from __future__ import annotations

import pytest

from zoo.report.sampled import known_noise, sampled_facts
from zoo.report.wording import Scale

SCALE = Scale.of("dph", 0.008, 0.07)
NOISE = {"white": 0.00732, "flicker": 0.0102, "walk": 0.00586}


@pytest.mark.parametrize(
    ("worth", "said"), [(13.24, "1296, worth 13 independent ones"), (100.3, "1296, worth 100 independent ones"), (1295.9, "1296")]
)
def test_how_many_blocks_and_what_they_are_worth(worth: float, said: str) -> None:
    assert dict(sampled_facts({"samples": 1296, "effective_samples": worth}, SCALE)) == {"Blocks": said}


def test_every_colour_has_its_unit() -> None:
    assert dict(sampled_facts({"noise": NOISE}, SCALE)) == {"Noise": "white 0.0073 °/h, flicker B 0.010 °/h, random walk K 0.0059 °/h/√h"}


def test_what_is_unexplained_counts_as_noise() -> None:
    assert sampled_facts({"noise": NOISE, "verdict": "unknown"}, SCALE)[0][1].endswith("°/h/√h; what is unexplained is counted as noise here")


def test_colours_in_the_scale_of_the_page() -> None:
    scale = Scale.of("rad_per_s", 3.9e-8, 3.4e-7)
    assert dict(sampled_facts({"noise": {"white": 3.9e-8}}, scale)) == {"Noise": "white 39 nrad/s"}


def test_nothing_is_said_where_nothing_is_known() -> None:
    assert sampled_facts({}, SCALE) == []
    assert sampled_facts({"samples": None, "effective_samples": None, "noise": None, "verdict": "unknown"}, SCALE) == []


def test_white_noise_is_told_as_angle_random_walk_whatever_the_blocks() -> None:
    """IEEE Std 952: 0.0073 °/h in means over 100 s is 0.0073·√(100/3600) °/√h, and so is a half of it in means over 400 s."""
    for white, block in ((0.0073, 100.0), (0.00365, 400.0)):
        assert ("Angle random walk", "N 0.0012 °/√h") in sampled_facts({"noise": {"white": white}, "average_s": block}, SCALE)
    inertial = sampled_facts({"noise": {"white": 3.9e-8}, "average_s": 3600}, Scale.of("rad_per_s", 3.9e-8, 3.4e-7))
    assert ("Angle random walk", "N 39 nrad/s·√h") in inertial


def test_where_something_stays_unexplained_only_the_white_noise_is_known() -> None:
    assert known_noise({"noise": NOISE, "noise_floor": 0.002, "verdict": "unknown"}) == {"white": 0.002}
    assert known_noise({"noise": NOISE, "noise_floor": 0.002, "verdict": "missing"}) == NOISE
