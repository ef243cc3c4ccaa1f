"""The page's part on what nothing in the catalogue explains, and the class that goes with it."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from typing import Any

import pytest
import torch
import yaml

from zoo.diagnosis import forms
from zoo.diagnosis.forms import Form
from zoo.diagnosis.quantities import AT_THE_COIL, OUTER_RATE, RATE, Quantity, recorded
from zoo.effects.base import Effect, History
from zoo.effects.checks import check_effect
from zoo.report.page import write_report
from zoo.report.unknown_section import unknown_section
from zoo.report.unknown_stub import stub_line, stub_of, write_stub
from zoo.report.wording import Scale

SUPPLY = Quantity("the column supply_v", "supply_v", "V", recorded, needs=("supply_v",))
QUANTITIES = (*AT_THE_COIL, OUTER_RATE, SUPPLY)
FORMS = [one for one in vars(forms).values() if isinstance(one, Form)] + list(forms.POLYNOMIALS)
SCALE = Scale("°/h", 0, 4)


def written(quantity: Quantity, form: Form) -> dict[str, Any]:
    """The record of a form, as the diagnosis writes it."""
    effect = form.of(quantity, (-20.0, 60.0))
    declare = {"scale": "linear", "source": "engineering prior", "meaning": "", "grid": 8}
    shape = [vars(one) for one in effect.shape]
    return {
        "quantity": quantity.of.__name__,
        "columns": form.columns.__name__,
        "place": effect.place,
        "needs": list(effect.needs),
        "range": [-20.0, 60.0],
        "shape": shape,
        "amplitudes": [{"name": one.name, "default": 0.0, "unit": one.unit, "low": -5.0, "high": 5.0, **declare} for one in effect.amplitudes],
        "formula": effect.formula,
        "depends_on": quantity.words,
        "words": 'It grows with "it" <b>.',
        "parameters": {},
        "rms": 0.0083,
        "runs": ["run_1", "run_2"],
        "effects": ["static_bias"],
        "todo": False,
    }


@pytest.fixture
def record(diagnosis) -> dict[str, Any]:
    x = [-1.0 + 0.05 * i for i in range(41)]
    y = [0.05 * value**2 for value in x]
    points = {"x": x[::4], "y": y[::4], "error": [0.001] * len(x[::4])}
    curve = {"label": "", "x": x, "y": y, "low": [v - 0.002 for v in y], "high": [v + 0.002 for v in y], "points": points}
    words = "It grows with the size of the coil's temperature rate."
    entry = {"depends_on": RATE.words, "explains": 0.97, "words": words, "quantity": RATE.words, "unit": "K/min", "curves": [curve]}
    others = {"as_good": ["the outer thermometer's rate"], "by_run": {"run_1": 0.97}, "evidence": 300.0}
    return {
        **diagnosis,
        "verdict": "unknown",
        "missing": [],
        "unexplained": [entry | others],
        "unexplained_form": written(RATE, forms.EVEN),
        "unexplained_words": words,
    }


def loaded(path: Path) -> Effect:
    spec = importlib.util.spec_from_file_location("unexplained", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Unexplained()


def history() -> History:
    time = torch.arange(0, 7200, 60, dtype=torch.float64)
    rate = torch.sin(time / 600)
    reference, supply = torch.cos(time / 900), 5 + torch.sin(time / 700)
    return History(time, 20 + 10 * torch.cumsum(rate, 0) / 10, rate, 2 * rate, 20 + rate, reference, {"supply_v": supply})


@pytest.mark.parametrize("form", FORMS, ids=lambda form: f"{form.columns.__name__}_{len(form.amplitudes)}")
@pytest.mark.parametrize("quantity", QUANTITIES, ids=lambda quantity: quantity.key)
def test_the_class_that_is_written_is_the_form_that_was_tried(diagnosis, tmp_path, quantity, form) -> None:
    path = write_stub({**diagnosis, "unexplained_form": written(quantity, form)}, tmp_path)
    assert path is not None
    effect, tried = loaded(path), form.of(quantity, (-20.0, 60.0))
    check_effect(effect, "unexplained")
    shape = torch.tensor([one.default for one in tried.shape], dtype=torch.float64)
    assert torch.equal(effect.columns(history(), shape), tried.columns(history(), shape))
    assert (effect.place, effect.needs, effect.formula) == (tried.place, tried.needs, tried.formula)
    assert [one.grid for one in effect.shape] == [one.grid for one in tried.shape], "or a search looks elsewhere"
    assert effect.source == "found by fogzoo diagnose in run_1 and run_2"


@pytest.mark.parametrize("form", FORMS, ids=lambda form: f"{form.columns.__name__}_{len(form.amplitudes)}")
def test_no_word_of_a_formula_has_the_letter_that_the_quantity_takes_the_place_of(form) -> None:
    assert not re.search(r"[A-Za-z]x|x[A-Za-z]", form.formula)


def test_its_yaml_names_the_class(record, tmp_path) -> None:
    path = write_stub(record, tmp_path)
    assert yaml.safe_load((tmp_path / "conf/effects/unexplained.yaml").read_text()) == {"unexplained": {"_target_": "unexplained.Unexplained"}}
    assert path == tmp_path / "unexplained.py"
    assert str(path) in stub_line(path)


@pytest.mark.parametrize("where", ["effects", "left_out", "not_tried", "candidates"])
def test_a_second_class_has_a_name_of_its_own(record, tmp_path, where) -> None:
    """Beside what an earlier diagnosis has written."""
    taken = ["unexplained", "unexplained_2"]
    if where == "candidates":
        record["candidates"] = [{"effect": name} for name in taken]
    else:
        record[where] = [*record.get(where, []), *taken]
    path = write_stub(record, tmp_path)
    assert path == tmp_path / "unexplained_3.py"
    check_effect(loaded(path), "unexplained_3")
    told = yaml.safe_load((tmp_path / "conf/effects/unexplained_3.yaml").read_text())
    assert told == {"unexplained_3": {"_target_": "unexplained_3.Unexplained"}}
    assert stub_of(record).commands(tmp_path)[1].startswith("fogzoo refine add=unexplained_3 ")


def test_the_source_keeps_to_the_house(record) -> None:
    stub = stub_of(record)
    assert stub is not None
    compile(stub.source, "unexplained.py", "exec")
    assert "self: Any" not in stub.source
    assert max(len(line) for line in stub.source.splitlines() if "signature" not in line) <= 150
    assert "import torch\n" not in stub.source, "what is not used is not imported"


def test_the_commands_find_the_folder(record, tmp_path) -> None:
    stub = stub_of(record)
    assert stub is not None
    export, refine = stub.commands(tmp_path, ["fogzoo", "refine", "data.files=[run_*.csv]"])
    assert export == f"export PYTHONPATH={tmp_path}"
    assert refine.startswith("fogzoo refine add=unexplained 'data.files=[run_*.csv]' ")
    assert f"hydra.searchpath=[file://{tmp_path}/conf]" in refine


def test_a_search_path_of_the_users_own_is_kept(record, tmp_path) -> None:
    stub = stub_of(record)
    assert stub is not None
    export, refine = stub.commands(tmp_path, ["fogzoo", "refine", "seed=1", "hydra.searchpath=[file:///mine/conf,file:///ours/conf]"])
    assert export == f"export PYTHONPATH={tmp_path}:$PYTHONPATH"
    assert refine == f"fogzoo refine add=unexplained seed=1 'hydra.searchpath=[file:///mine/conf,file:///ours/conf,file://{tmp_path}/conf]'"


def test_the_page_says_it_of_the_past_where_effects_were_added_since(record, tmp_path) -> None:
    assert "<h2>What it looks like</h2>" in str(unknown_section(record, SCALE, tmp_path))
    assert "<h2>What was unexplained before anything was added</h2>" in str(unknown_section(record, SCALE, tmp_path, done=True))


def test_nothing_is_written_where_nothing_is_unexplained(diagnosis, tmp_path) -> None:
    assert write_stub(diagnosis, tmp_path) is None
    assert unknown_section(diagnosis, SCALE, tmp_path) is None
    assert not list(tmp_path.iterdir())


def test_the_whole_page_has_the_section_in_the_place_of_the_list(record, traces, tmp_path) -> None:
    write_report(tmp_path / "report.html", record, traces[:1], refine=["fogzoo", "refine", "data.files=[a.csv]"])
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.count('<section id="unknown">') == 1
    assert f"fogzoo refine add=unexplained &#39;data.files=[a.csv]&#39; &#39;hydra.searchpath=[file://{tmp_path}/conf]&#39;" in page
    assert "What remains unexplained" not in page
    assert "free smooth function of" not in page


def test_the_section_shows_curve_words_and_class(record, tmp_path) -> None:
    page = str(unknown_section(record, SCALE, tmp_path))
    assert "It grows with the size of the coil&#39;s temperature rate." in page
    assert "explains 97 %" in page
    assert "Unexplained [°/h]" in page
    assert "Coil's temperature rate [K/min]" in page
    assert "As good: the outer thermometer&#39;s rate." in page
    assert "class Unexplained(Effect):" in page
    assert page.count("<svg") == 1
    assert not re.search(r'(?:src|href)="(?!#)', page), "self-contained"
    assert "<b>." not in page, "text does not become markup"


def test_a_function_of_two_is_drawn_at_three_temperatures(record, tmp_path) -> None:
    entry = record["unexplained"][0]
    entry["curves"] = [{**entry["curves"][0], "label": f"at {value} °C"} for value in (-20, 20, 60)]
    page = str(unknown_section(record, SCALE, tmp_path))
    assert all(f"at {value} °C" in page for value in (-20, 20, 60))


def test_a_template_says_that_it_is_one(record, tmp_path) -> None:
    record["unexplained_form"]["todo"] = True
    stub = stub_of(record)
    assert stub is not None
    assert "TODO: nothing smooth explains the residual" in stub.source
    assert "An example of how columns are written" in str(unknown_section(record, SCALE, tmp_path))
