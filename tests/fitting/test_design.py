"""The fast way to columns (shared work, chunks, block means, whitening) gives what the plain way gives."""

from __future__ import annotations

import pytest
import torch
from torch import Generator, Tensor

from zoo.catalog import build, names
from zoo.effects.base import Effect, History, Parameter, spread
from zoo.effects.bounds import to_physical
from zoo.fitting.design import Design, close_starts, coarse_starts
from zoo.fitting.noise import blocks_of, noise_of
from zoo.measurements.run import Run
from zoo.models.graybox import GrayBox
from zoo.scoring.noise import NoiseModel, Whitener

INPUTS = ("time_s", "temperature_c", "temperature_outer_c", "supply_v", "field_ut", "humidity_pct", "pressure_kpa", "reference_dph")
EFFECTS = names("effects")
STEP_S, BLOCK = 20.0, 5


def recorded(seed: int, samples: int = 600, inputs: tuple[str, ...] = INPUTS) -> Run:
    """A lively run; one of its blocks is too thin to keep."""
    chance = Generator().manual_seed(seed)
    time = torch.arange(samples, dtype=torch.float64) * STEP_S
    others = [20 + 20 * torch.sin(time / (800 + 90 * i) + i * seed) - 20 * torch.sin(torch.tensor(float(i * seed))) for i in range(len(inputs) - 1)]
    error = 0.01 * torch.randn(samples, generator=chance, dtype=torch.float64) + 0.01 * others[0]
    block = torch.arange(samples) // BLOCK
    block = torch.where(block == 7, -1, block - (block > 7).long())
    count = 1 + (torch.arange(samples) % 3 == 0).long()
    return Run(f"run_{seed}", "dph", STEP_S * BLOCK, inputs, torch.stack([time, *others], -1), error, count, block)


RUNS = [recorded(1), recorded(2, 400), recorded(4, 660)]


def whitener(runs: list[Run], noise: NoiseModel | None = None) -> Whitener:
    return Whitener(noise or noise_of(runs), blocks_of(runs))


def design(effects: list[str], runs: list[Run] = RUNS, numbers: list[int] | None = None) -> Design:
    inputs = list(runs[0].columns)
    return Design(GrayBox({name: build("effects", name) for name in effects}, inputs), runs, whitener(runs), numbers)


def drawn(model: GrayBox, count: int, seed: int = 1) -> Tensor:
    return torch.rand(count, len(model.parameters_of_theta()), generator=Generator().manual_seed(seed), dtype=torch.float64)


def around(theta: Tensor) -> Tensor:
    """θ and one step of each parameter, as a Jacobian asks for."""
    return torch.cat([theta.unsqueeze(0), theta + 1e-4 * torch.eye(len(theta), dtype=torch.float64)])


def plainly(made: Design, theta: Tensor) -> Tensor:
    """(N, K) block means of one θ's columns, run after run."""
    parts = []
    for run, number in zip(made.runs, made.numbers, strict=True):
        parts.append(run.block_mean_columns(made.model.columns(run.select(made.model.inputs), theta.unsqueeze(0), number)[0].detach()))
    return torch.cat(parts)


@pytest.mark.parametrize("effects", [[name] for name in EFFECTS] + [EFFECTS, EFFECTS[::-1]], ids=lambda value: "+".join(value)[:20])
def test_shared_work_changes_nothing(effects) -> None:
    made = design(effects)
    batch = around(drawn(made.model, 1)[0])
    found = made.plain_columns(batch)
    assert found.shape == (len(batch), len(made.error), sum(len(one.amplitudes) for _, one in made.model.named_effects()))
    assert found.dtype == torch.float64
    for theta, columns in zip(batch, found, strict=True):
        torch.testing.assert_close(columns, plainly(made, theta), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("effects", [[name] for name in EFFECTS])
def test_runs_recorded_at_other_times_are_what_each_is_alone(effects) -> None:
    """RUNS are computed together; these are not, and a run among them is what it is among those."""
    late = recorded(2, 400)
    late.table[200:, 0] += 7.0
    made, batch = design(effects, [recorded(1), late]), around(drawn(design(effects).model, 1)[0])
    assert [len(one.stacks) for one in (design(effects), made)] == [1, 2]
    for theta, columns in zip(batch, made.plain_columns(batch), strict=True):
        torch.testing.assert_close(columns, plainly(made, theta), rtol=1e-9, atol=1e-9)
    first = made.runs[0].blocks
    torch.testing.assert_close(made.plain_columns(batch)[:, :first], design(effects).plain_columns(batch)[:, :first], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("effects", [[name] for name in EFFECTS])
def test_a_last_mean_of_fewer_rows_that_no_block_takes_keeps_no_runs_apart(effects) -> None:
    """Of an odd number of rows the last mean of two is one of one, and half a step early."""

    def early(seed: int, samples: int) -> Run:
        run = recorded(seed, samples)
        run.block[run.block == run.block.max()], run.table[-1, 0] = -1, run.table[-1, 0] - 0.5 * STEP_S
        return run

    made = design(effects, [early(2, 401), recorded(1), early(4, 661)])
    assert len(made.stacks) == 1
    batch = around(drawn(made.model, 1)[0])
    for theta, columns in zip(batch, made.plain_columns(batch), strict=True):
        torch.testing.assert_close(columns, plainly(made, theta), rtol=1e-9, atol=1e-9)
    early_within = recorded(2, 401)
    early_within.table[-1, 0] -= 0.5 * STEP_S
    assert len(design(effects, [early_within, recorded(1)]).stacks) == 2


def test_a_short_run_is_not_drawn_out_to_the_length_of_a_long_one() -> None:
    assert len(design(["mohr"], [recorded(1), recorded(2, 100)]).stacks) == 2
    assert len(design(["mohr"], [recorded(1), recorded(2, 250)]).stacks) == 1


class Own(Effect):
    """As somebody may write one: it takes its history for that of one run."""

    name = "own"
    amplitudes = (Parameter("size", 0.0, "unit", -1.0, 1.0, source="test"),)
    needs = ("supply_v",)

    def columns(self, history: History, shape: Tensor) -> Tensor:
        column = history.inputs["supply_v"][0] + history.run * (history.thermometer - history.thermometer[0])
        return spread((column if history.run == 2 else 2 * column).unsqueeze(-1), shape)


def test_an_effect_that_does_not_say_that_it_takes_runs_together_sees_one_at_a_time() -> None:
    made = Design(GrayBox({"static_bias": build("effects", "static_bias"), "own": Own()}, list(INPUTS)), RUNS, whitener(RUNS))
    theta = drawn(made.model, 1)[0]
    found = made.plain_columns(theta.unsqueeze(0))[0]
    torch.testing.assert_close(found, plainly(made, theta), rtol=1e-12, atol=1e-12)
    of_one = made.effect_columns(Own(), made.places(theta), torch.zeros(1, 0, dtype=torch.float64), lambda columns: columns)[0]
    torch.testing.assert_close(of_one, found[:, -1:], rtol=1e-12, atol=1e-12)
    at_means = made.effect_columns_at_means(Own(), made.places(theta), torch.zeros(1, 0, dtype=torch.float64))[0]
    assert at_means.shape == of_one.shape


def test_another_model_of_the_same_runs_takes_over_what_was_computed_but_no_column_of_another_class() -> None:
    """Two forms of an unknown effect may have one name; its class says what its columns are."""

    class Other(Own):
        def columns(self, history: History, shape: Tensor) -> Tensor:
            return 3.0 * super().columns(history, shape)

    first = design(["static_bias", "mohr"])
    theta = drawn(first.model, 1)
    first.plain_columns(theta)
    for kind in (Own, Other, Own):
        model = GrayBox({"static_bias": build("effects", "static_bias"), "own": kind()}, list(INPUTS))
        made, alone = first.of(model), Design(model, RUNS, first.whitener)
        assert made.stacks is first.stacks
        batch = drawn(model, 3)
        torch.testing.assert_close(made.plain_columns(batch), alone.plain_columns(batch), rtol=1e-12, atol=1e-12)
        torch.testing.assert_close(made.cost(batch), alone.cost(batch))
    torch.testing.assert_close(first.plain_columns(theta), design(["static_bias", "mohr"]).plain_columns(theta), rtol=1e-12, atol=1e-12)


def test_histories_are_those_of_each_run() -> None:
    """As long as it is, with its own number and inputs, whether runs are computed together or not."""
    made = design(["static_bias", "supply_voltage"])
    theta = drawn(made.model, 1)[0]
    coil = made.model.coil_value.detach().clone()
    coil.copy_(to_physical(theta, [one for _, one in made.model.parameters_of_theta()])[: len(coil)])
    for run, number, here in zip(made.runs, made.numbers, made.histories(theta), strict=True):
        alone = made.model.histories(run.select(made.model.inputs), coil, number)
        for place, history in alone.items():
            assert here[place].run == number
            for field in ("time", "temperature", "rate", "gradient", "thermometer", "reference"):
                torch.testing.assert_close(getattr(here[place], field), getattr(history, field), rtol=1e-9, atol=1e-9)
            torch.testing.assert_close(here[place].inputs["supply_v"], history.inputs["supply_v"])


def test_a_random_batch_and_its_repetitions_keep_their_order() -> None:
    made = design(["static_bias", "hysteresis", "warm_up", "bias_step"])
    batch = drawn(made.model, 4)[[2, 0, 3, 0, 1, 2]]
    for theta, columns in zip(batch, made.plain_columns(batch), strict=True):
        torch.testing.assert_close(columns, plainly(made, theta), rtol=1e-9, atol=1e-9)


def test_chunks_change_nothing(monkeypatch) -> None:
    made = design(["static_bias", "shupe", "aging"])
    batch = drawn(made.model, 7)
    whole = made.plain_columns(batch)
    monkeypatch.setattr("zoo.fitting.design.CHUNK_ELEMENTS", 600 * 6 * 2)
    torch.testing.assert_close(made.plain_columns(batch), whole, rtol=1e-12, atol=1e-12)


def test_columns_are_whitened_as_the_target_is() -> None:
    made = design(["static_bias", "mohr"])
    batch = drawn(made.model, 3)
    torch.testing.assert_close(made.columns(batch), made.whitener(made.plain_columns(batch)))
    error = torch.cat([run.block_mean(run.error) for run in RUNS])
    torch.testing.assert_close(made.error, error)
    torch.testing.assert_close(made.target, made.whitener(error.unsqueeze(-1))[:, 0])
    dense = torch.block_diag(*[whitener(RUNS).factors[i] for i in range(len(RUNS))])
    torch.testing.assert_close(made.target, dense @ error)


@pytest.mark.parametrize("name", EFFECTS)
def test_many_shapes_of_one_effect_at_a_fixed_coil(name) -> None:
    made = design(["static_bias", "mohr"])
    theta = drawn(made.model, 1)[0]
    effect = build("effects", name)
    shapes = effect.shapes_to_try(8000.0, 2)[:12]
    found = made.effect_columns(effect, made.places(theta), shapes)
    alone = Design(GrayBox({name: effect}, list(INPUTS)), RUNS, made.whitener)
    for i in (0, len(shapes) - 1):
        coil = len(made.model.coil_parameters)
        effect.shape_value.data = shapes[i]
        expected = made.whitener(plainly(alone, torch.cat([theta[:coil], alone.model.theta()[coil:]])))
        torch.testing.assert_close(found[i], expected, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("runs", [RUNS[:1], RUNS], ids=["one", "several"])
@pytest.mark.parametrize("name", ["hysteresis", "polarization", "magnetic"])
def test_many_coils_at_once_are_each_of_them_by_itself(name, runs) -> None:
    made, effect = design(["static_bias", "mohr"], runs), build("effects", name)
    thetas, shapes = drawn(made.model, 4), effect.shapes_to_try(8000.0, 2)[:3]
    for theta, places in zip(thetas, made.each_place(thetas), strict=True):
        for columns in (made.effect_columns, made.effect_columns_at_means):
            tolerance = 1e-4 if columns(effect, places, shapes).dtype == torch.float32 else 1e-9
            torch.testing.assert_close(columns(effect, places, shapes), columns(effect, made.places(theta), shapes), rtol=tolerance, atol=tolerance)


def test_runs_keep_the_numbers_they_are_given() -> None:
    made = design(["bias_step"], RUNS[:2], numbers=[4, 2])
    step = dict(made.model.named_effects())["bias_step"]
    step.shape_value.data = torch.tensor([0.5, 2.0], dtype=torch.float64)
    columns = made.plain_columns(made.model.theta().unsqueeze(0))[0, :, 0]
    first = RUNS[0].blocks
    assert not bool(columns[:first].any())
    assert float(columns[-1]) == pytest.approx(1)


def test_coarse_starts_are_a_grid_over_lag_and_weight_and_leave_the_rest() -> None:
    made = design(["static_bias", "hysteresis"])
    base = drawn(made.model, 1)[0]
    starts = coarse_starts(made, base)
    assert starts.shape == (4**2, len(base))
    assert len(torch.unique(starts[:, :2], dim=0)) == 4**2
    torch.testing.assert_close(starts[:, 2:], base[2:].expand(len(starts), -1))
    assert float(starts.min()) >= 0
    assert float(starts.max()) <= 1
    lags = to_physical(starts, [one for _, one in made.model.parameters_of_theta()])[:, 0]
    assert 30 < float(lags.min()) < 200, "from minutes"
    assert 1800 < float(lags.max()) < 7200, "to an hour"
    assert bool(torch.isfinite(made.columns(starts)).all())


def one_thermometer() -> Design:
    inputs = tuple(name for name in INPUTS if name != "temperature_outer_c")
    return design(["static_bias", "shupe", "mohr"], [recorded(1, inputs=inputs), recorded(2, 400, inputs)])


def test_of_one_thermometer_no_start_is_where_its_lead_does_not_matter() -> None:
    made = one_thermometer()
    starts = coarse_starts(made)
    lag, lead = to_physical(starts, [one for _, one in made.model.parameters_of_theta()])[:, :2].T
    assert bool((lead + 2 * lag > 0).all())
    assert (float(lag.min()), float(lag.max())) == pytest.approx((20.0, 2500.0))
    moved = starts + torch.tensor([0.0, 1e-3, *[0.0] * (starts.shape[1] - 2)])
    assert bool(((made.columns(moved) - made.columns(starts)).abs().amax(dim=(1, 2)) > 0).all())


@pytest.mark.parametrize("several", [False, True])
def test_close_starts_move_the_coil_by_less_than_short_fringes(several: bool) -> None:
    """Some start has the coil within 2.5 K of wherever it is, half a short fringe, in runs that reach 1.5 K/min."""
    made = design(["static_bias", "shupe", "mohr"]) if several else one_thermometer()
    theta = made.model.theta()
    starts = close_starts(made, theta)
    torch.testing.assert_close(starts[:, len(made.model.coil_parameters) :], theta[len(made.model.coil_parameters) :].expand(len(starts), -1))
    near = [made.histories(start)[0]["coil"].temperature.detach() for start in starts]
    for lag, other in [(120.0, 0.3), (400.0, 0.6)] if several else [(120.0, -180.0), (400.0, -730.0)]:
        with torch.no_grad():
            made.model.coil_value[:2] = torch.tensor([lag, other], dtype=torch.float64)
        there = made.histories(made.model.theta())[0]["coil"].temperature.detach()
        assert min(float((one - there)[60:].square().mean().sqrt()) for one in near) < 2.5


def test_at_means_an_effect_without_memory_is_nearly_what_its_means_are() -> None:
    made = design(["static_bias", "shupe", "mohr"])
    fringes = build("effects", "polarization")
    shapes = torch.tensor([[20.0, 1.0, 1.0, 0.0], [30.0, 2.0, 3.0, 30.0]], dtype=torch.float64)
    places = made.places(made.model.theta())
    for one in range(2):
        exact = made.effect_columns(fringes, places, shapes[one : one + 1])
        quick = made.effect_columns_at_means(fringes, places, shapes[one : one + 1])
        assert quick.shape[2] == (2 if one == 0 else 6), "three lines in one place are one"
        torch.testing.assert_close(quick.double(), exact[..., : quick.shape[2]], rtol=0, atol=0.08 * float(exact.abs().max()))


SEARCHED = [name for name in EFFECTS if build("effects", name).shape and not build("effects", name).sharp]


@pytest.mark.parametrize("name", SEARCHED)
def test_at_means_what_is_searched_for_is_nearly_what_its_means_are_and_remembers_no_other_run(name: str) -> None:
    made, effect = design(["static_bias", "mohr"]), build("effects", name)
    slow = {"chamber_cycling": [12 * BLOCK * STEP_S]}  # several blocks a period
    shapes = torch.tensor([slow.get(name, effect.shape_value.tolist())], dtype=torch.float64)
    places = made.places(made.model.theta())
    exact = made.effect_columns(effect, places, shapes, lambda columns: columns)
    quick = made.effect_columns_at_means(effect, places, shapes, lambda columns: columns)
    assert quick.dtype == (torch.float32 if effect.instant else torch.float64), "what is brought from outside may insist on double precision"
    sizes, begun = [run.blocks for run in RUNS], 10  # within a first block that is in motion, a fast memory is not known
    apart = torch.cat([part[0, begun:] for part in (quick.double() - exact).split(sizes, dim=1)])
    assert bool((apart.square().mean(dim=0).sqrt() <= 0.1 * exact.square().mean(dim=(0, 1)).sqrt()).all())


def test_at_means_an_effect_may_look_at_all_that_was_recorded() -> None:
    made = design(["static_bias", "shupe", "mohr", "supply_voltage"])
    for name in ("supply_voltage", "scale_factor"):
        effect, places = build("effects", name), made.places(made.model.theta())
        shapes = torch.zeros(1, 0, dtype=torch.float64)
        exact, quick = made.effect_columns(effect, places, shapes), made.effect_columns_at_means(effect, places, shapes)
        torch.testing.assert_close(quick[..., :1].double(), exact[..., :1], rtol=0, atol=0.05 * float(exact[..., :1].abs().max()))


def test_the_noise_of_runs_is_that_of_their_block_means() -> None:
    """White noise of 0.01 in a sample, five of them (six or seven rows) in a block."""
    found = noise_of(RUNS)
    assert found.white == pytest.approx(0.01 / 5**0.5, rel=0.12)
    assert 0 < found.flicker < found.white
    quiet = recorded(3)
    quiet.error[:] = 0.5
    assert noise_of([quiet]).white > 0, "noiseless data must not divide by zero"


def test_runs_recorded_alike_share_a_root_of_their_noise() -> None:
    one, same, other = recorded(1), recorded(2), recorded(3, 400)
    alone, together = [Whitener(noise_of(RUNS), blocks_of(runs)) for runs in ([one], [one, other, same])]
    assert together.factors[0].data_ptr() == together.factors[2].data_ptr()
    torch.testing.assert_close(together.factors[0], alone.factors[0], rtol=0, atol=0)
    assert together.factors[1].data_ptr() == together.factors[0].data_ptr(), "of a run that ends earlier it is the first part"
    torch.testing.assert_close(together.factors[1], whitener([other], noise_of(RUNS)).factors[0], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("shapes", "lines"),
    [([[20.0, 1.0, 1.0, 0.0], [9.0, 1.0, 1.0, 30.0]], 1), ([[20.0, 1.0, 1.0, 0.0], [9.0, 2.0, 1.0, 0.0]], 2), ([[20.0, 2.0, 0.5, 0.0]], 3)],
)
def test_in_a_search_fringes_in_one_place_are_one(shapes, lines) -> None:
    """The lines that are left are the same to the last bit; means and whitening are matrix products, which BLAS rounds by their width."""
    made, tried = design(["static_bias", "shupe", "mohr"]), torch.tensor(shapes, dtype=torch.float64)
    fringes, places = build("effects", "polarization"), made.places(made.model.theta())
    for place in places:
        here = place[fringes.place]
        torch.testing.assert_close(fringes.distinct_columns(here, tried, tried), fringes.columns(here, tried)[..., : 2 * lines], rtol=0, atol=0)
    few, every = (made.effect_columns(fringes, places, tried, distinct=distinct)[..., : 2 * lines] for distinct in (True, False))
    torch.testing.assert_close(few, every, rtol=0, atol=1e-12 * float(every.abs().max()))


@pytest.mark.skipif(not torch.cuda.is_available(), reason="no CUDA device here")
def test_projection_and_whitening_work_on_a_gpu() -> None:
    from zoo.fitting.projection import project

    columns, target = drawn(design(["static_bias"]).model, 200).cuda(), torch.rand(200, dtype=torch.float64).cuda()
    assert project(columns, target).amplitudes.is_cuda
