"""Finding the columns: default names, foreign names, units from names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from zoo.errors import InputError
from zoo.measurements.read import read_runs
from zoo.measurements.schema import keep_shared, layout, overruled
from zoo.measurements.write import write_measurements

HERE = Path("a.csv")
PLAIN = ("time_s", "temperature_c", "rate_dph")


def names(*columns: str, **given: object) -> list[str]:
    return [source.name for source in layout(HERE, columns, **given).sources]  # type: ignore[arg-type]


def test_standard_names_need_no_mapping() -> None:
    found = layout(HERE, (*PLAIN, "temperature_outer_c", "supply_v", "field_ut", "reference_dph", "operator"))
    assert [source.name for source in found.inputs] == ["time_s", "temperature_c", "temperature_outer_c", "supply_v", "field_ut"]
    assert (found.output.column, found.unit) == ("rate_dph", "dph")
    assert found.reference
    assert not found.notes


@pytest.mark.parametrize(
    ("column", "unit"),
    [("rate_dps", "dps"), ("rate_rad_per_s", "rad_per_s"), ("accel_ug", "ug"), ("accel_m_per_s2", "m_per_s2"), ("pulses", "pulses")],
)
def test_the_output_is_known_by_its_name(column: str, unit: str) -> None:
    found = layout(HERE, ("time_s", "temperature_c", column))
    assert (found.output.column, found.unit) == (column, unit)


def test_what_compensation_adds_is_no_output() -> None:
    assert layout(HERE, (*PLAIN, "predicted_error_dph", "rate_dph_compensated")).output.column == "rate_dph"


def test_foreign_names_are_mapped() -> None:
    mapping = {"time": "t", "temperature": "imu_temp", "output": "gz", "supply_v": "vcc", "temperature_case": "case", "reference": None}
    found = layout(HERE, ("t", "imu_temp", "gz", "vcc", "case"), mapping, "rad/s")
    assert [(source.name, source.column) for source in found.inputs] == [
        ("time_s", "t"),
        ("temperature_c", "imu_temp"),
        ("temperature_case_c", "case"),
        ("supply_v", "vcc"),
    ]
    assert (found.output.column, found.unit) == ("gz", "rad_per_s")


def test_a_mapped_thermometer_is_not_read_twice() -> None:
    assert names("time_s", "temperature_coil_c", "rate_dph", columns={"temperature": "temperature_coil_c"}) == [
        "time_s",
        "temperature_c",
        "output",
    ]


def test_the_outputs_unit_is_in_its_name_and_may_be_said_again() -> None:
    columns = ("time_s", "temperature_c", "gyro_x_rad_per_s")
    for said in (None, "rad/s"):
        assert layout(HERE, columns, {"output": "gyro_x_rad_per_s"}, said).unit == "rad_per_s"


def test_a_column_more_is_kept_by_the_name_that_an_effect_asks_for() -> None:
    found = layout(HERE, (*PLAIN, "air m/s", "supply_v"), {"airflow": "air m/s"})
    assert [(source.name, source.column) for source in found.inputs][2:] == [("supply_v", "supply_v"), ("airflow", "air m/s")]


def test_times_and_temperatures_in_other_units_are_converted(tmp_path: Path) -> None:
    rows = np.arange(200.0)
    data = {"t_ms": 1000 * rows, "spool_k": 293.15 + rows / 10, "rate_dph": np.sin(rows)}
    run = read_runs(write_measurements(tmp_path / "a.csv", data), {"time": "t_ms", "temperature": "spool_k"}, average_s=None)[0]
    assert np.allclose(run.time, rows)
    assert np.allclose(run.temperature, 20 + rows / 10)
    assert run.notes == ("t_ms is converted from ms to s", "spool_k is converted from K to °C")


@pytest.mark.parametrize("name", ["reference", "Reference_dph", "reference_deg_per_h", "reference table"])
def test_what_is_called_a_reference_and_is_not_taken_for_it_is_told(name: str) -> None:
    found = layout(HERE, (*PLAIN, name))
    assert found.reference is None
    (note,) = found.notes
    assert note.startswith(f"{name} is not used")
    assert "data.columns.reference=" in note
    assert layout(HERE, (*PLAIN, name), {"reference": name}).reference, "and what it says to do is possible"


@pytest.mark.parametrize(("name", "unit"), [("reference_m_per_s2", "m/s²"), ("reference_c", "°C")])
def test_a_reference_of_another_quantity_is_told_to_be_one(name: str, unit: str) -> None:
    assert layout(HERE, (*PLAIN, name)).notes == (f"{name} is not used, as it is in {unit}, the output in °/h",)


def test_a_second_reference_or_a_word_that_begins_alike_is_not_told() -> None:
    assert not layout(HERE, (*PLAIN, "reference_dph", "reference_old")).notes
    assert not layout(HERE, (*PLAIN, "references", "preference")).notes


def test_a_given_reference_that_the_recorded_one_overrules_is_told() -> None:
    recorded = layout(HERE, (*PLAIN, "reference_dph"))
    assert overruled(recorded, 9.66) == ["data.reference=9.66 is not used, as reference_dph is recorded"]
    assert not overruled(recorded, 0.0)
    assert not overruled(layout(HERE, PLAIN), 9.66)


def test_inputs_that_not_all_runs_have_are_left_out_with_a_note() -> None:
    both = keep_shared([layout(HERE, (*PLAIN, "supply_v", "temperature_case_c")), layout(Path("b.csv"), (*PLAIN, "temperature_case_c"))])
    assert [[source.name for source in one.inputs] for one in both] == [["time_s", "temperature_c", "temperature_case_c"]] * 2
    assert both[0].notes == ("supply_v is not used, as not all the runs have it",)
    assert not both[1].notes


def test_thermometers_come_as_in_the_first_header_whatever_they_are_called() -> None:
    """The last one stands for the housing: a name must not decide that."""
    assert names(*PLAIN, "temperature_pcb_c", "temperature_flange_c")[2:4] == ["temperature_pcb_c", "temperature_flange_c"]
    mapping = {"temperature_b": "second", "temperature_a": "first"}
    assert names(*PLAIN, "first", "temperature_pcb_c", "second", columns=mapping)[2:5] == ["temperature_pcb_c", "temperature_b_c", "temperature_a_c"]
    headers = ("supply_v", "temperature_pcb_c", "temperature_flange_c"), ("temperature_flange_c", "supply_v", "temperature_pcb_c")
    first, other = keep_shared([layout(HERE, (*PLAIN, *more)) for more in headers])
    assert [source.name for source in first.inputs] == [source.name for source in other.inputs]
    assert [source.name for source in other.inputs][2:4] == ["temperature_pcb_c", "temperature_flange_c"]


@pytest.mark.parametrize(
    ("columns", "mapping", "unit", "message"),
    [
        (
            ("temperature_c", "rate_dph"),
            {},
            None,
            r"a\.csv: no column 'time_s'; its columns: temperature_c, rate_dph\n.*data\.columns\.time=NAME",
        ),
        (("time_s", "rate_dph"), {}, None, r"no column 'temperature_c'.*\n.*data\.columns\.temperature=NAME"),
        (("time_s", "temperature_c", "gz"), {}, None, r"no column is called rate_UNIT.*data\.columns\.output=time_s\|temperature_c\|gz"),
        (("time_s", "temperature_c", "g_dps"), {}, None, r"data\.columns\.output=g_dps$"),
        ((*PLAIN, "accel_ug"), {}, None, r"several columns can be the output.*data\.columns\.output=rate_dph\|accel_ug"),
        (PLAIN, {"output": "gz"}, None, r"no column 'gz' \(data\.columns\.output=gz\); its columns: time_s"),
        (("time_s", "temperature_c", "gz"), {"output": "gz"}, None, r"unit of 'gz' is not known; say data\.output_unit=dph\|dps"),
        (PLAIN, {}, "furlong", r"data\.output_unit=furlong: unknown unit 'furlong'; possible: dph"),
        (PLAIN, {"output": "rate_dph"}, "rad/s", r"a\.csv: 'rate_dph' is in °/h by its name, but data\.output_unit=rad/s"),
        (PLAIN, {"tmie": "time_s"}, None, r"data\.columns\.tmie: no such role; did you mean time"),
        (PLAIN, {"suply_v": "rate_dph"}, None, r"data\.columns\.suply_v: no such role; did you mean supply_v"),
        (PLAIN, {"air flow": "rate_dph"}, None, r"data\.columns\.air flow: no such role"),
        (PLAIN, {"airflow": "rate_dph"}, None, r"'rate_dph' is both data\.columns\.airflow and output"),
        (PLAIN, {"airflow": "air"}, None, r"no column 'air' \(data\.columns\.airflow=air\)"),
        (
            PLAIN,
            {"output": "rate_dph", "temperature": "rate_dph"},
            None,
            r"'rate_dph' is both data\.columns\.output and data\.columns\.temperature",
        ),
        ((*PLAIN, "ref_ug"), {"reference": "ref_ug"}, None, r"data\.columns\.reference=ref_ug is in µg, the output in °/h"),
    ],
)
def test_what_cannot_be_found_is_said(columns: tuple[str, ...], mapping: dict[str, str], unit: str | None, message: str) -> None:
    with pytest.raises(InputError, match=message):
        layout(HERE, columns, mapping, unit)


def test_runs_in_different_units_are_both_named() -> None:
    with pytest.raises(InputError, match=r"a\.csv is in °/h \(rate_dph\), b\.csv is in rad/s \(rate_rad_per_s\)"):
        keep_shared([layout(HERE, PLAIN), layout(Path("b.csv"), ("time_s", "temperature_c", "rate_rad_per_s"))])


def test_other_thermometers_are_taken_in_their_units() -> None:
    found = layout(HERE, ("time_s", "temperature_k", "temperature_outer_k", "temperature_case_f", "rate_dph"), {"temperature": "temperature_k"})
    assert [source.name for source in found.inputs] == ["time_s", "temperature_c", "temperature_outer_c", "temperature_case_c"]
    assert [source.given for source in found.inputs[1:]] == ["k", "k", "f"]
    both = layout(HERE, (*PLAIN, "temperature_outer_c", "temperature_outer_k"))
    assert [source.column for source in both.inputs][2:] == ["temperature_outer_c"]
