"""Kinds of bench tables that were read wrongly, or refused although they are clear."""

from pathlib import Path

import numpy as np
import pytest
from bench_workbooks import vehicle, write_workbook

from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.records.measurements import LoadTestRecord, MooringRecord
from pipeline.vehicle.schema import Vehicle

SHARE = np.linspace(-1.0, 1.0, 21)
CODE = 127.0 * SHARE
THRUST = 40.0 * np.sign(SHARE) * np.clip((np.abs(SHARE) - 0.06) / 0.94, 0.0, None) ** 1.8
COUNT = np.arange(1.0, 22.0)


def table(head: str, *columns: object) -> str:
    rows = zip(*(np.asarray(one, object) for one in columns), strict=True)
    return "\n".join([head, *(";".join(f"{cell}" for cell in row) for row in rows)])


def mooring(tmp_path: Path, text: str) -> MooringRecord:
    (tmp_path / "a.csv").write_text(text + "\n", encoding="utf-8")
    return read_mooring_tables([tmp_path / "a.csv"], vehicle(), tmp_path)


def load(tmp_path: Path, head: str, speed: object) -> LoadTestRecord:
    torque = np.tile(np.linspace(0.05, 0.4, 6), 2)
    text = table(head, np.repeat([60.0, 120.0], 6), speed, torque)
    (tmp_path / "a.csv").write_text(text + "\n", encoding="utf-8")
    return read_load_tests([tmp_path / "a.csv"], vehicle(), tmp_path)


def errors(record: MooringRecord | LoadTestRecord) -> str:
    return "\n".join(one.what for one in record.problems if one.severity == "error")


READ = {
    "a counter n is no speed": table("n;Code;Thrust (N)", COUNT, CODE, THRUST),
    "N by tens": table("N;PWM (us);Thrust (N)", 10 * COUNT, 1500 + 400 * SHARE, THRUST),
    "counts of the sensor": table("Code;Load cell;Thrust (N)", CODE, 8e6 + 900 * THRUST, THRUST),
    "a letter without a unit": table("Code;T;F, N", CODE, 18 + 0.1 * COUNT, THRUST),
    "per cent in the cells": table(
        "Throttle;Thrust (N)", [f"{100 * one:g}%" for one in SHARE], THRUST
    ),
    "reverse yes or no": table(
        "Code;Reverse;Thrust (N)", abs(CODE), np.where(CODE < 0, "yes", "no"), abs(THRUST)
    ),
    "apostrophes part thousands": table(
        "Code;Thrust (mN)", CODE, [f"{1000 * one:,.0f}".replace(",", "'") for one in THRUST]
    ),
    "a blank after the minus": table(
        "Code;Thrust (daN)", CODE, [f"{one / 10:.4f}".replace("-", "- ") for one in THRUST]
    ),
    "net beside raw": table("Code;Raw thrust (N);Net thrust (N)", CODE, THRUST + 4, THRUST),
    "readings and their mean": table(
        "Code;Run 1 (N);Run 2 (N);Mean (N)", CODE, 1.01 * THRUST, 0.99 * THRUST, THRUST
    ),
}


@pytest.mark.parametrize("text", READ.values(), ids=READ)
def test_what_is_clear_is_read(text: str, tmp_path: Path) -> None:
    record = mooring(tmp_path, text)
    assert not errors(record)
    points = [one for one in record.points if one.code != 0.0]
    assert np.array([one.code for one in points]) == pytest.approx(CODE[CODE != 0.0], abs=0.1)
    thrust = np.array([one.thrust_n for one in points])
    assert thrust == pytest.approx(THRUST[CODE != 0.0], abs=0.01)


AHEAD = SHARE >= 0.0
REFUSED = {
    "F1 (N)": table("Code;F1 (N);F2 (N);F3 (N)", CODE, *(0.33 * THRUST,) * 3),
    "rest is not at code 0": table("Throttle (%);Thrust (N)", 50 + 50 * SHARE, THRUST),
    "as a duty cycle does": table("Duty (%);Thrust (N)", 7.5 + 2 * SHARE[AHEAD], THRUST[AHEAD]),
    "speaks of a lever, a gear": "Коромысло 1:2\n\n" + table("Код;Сила, Н", CODE, THRUST),
    "Values x10": "Values x10\n\n" + table("Code;Thrust (N)", CODE, THRUST),
}


def test_a_code_against_its_pulse_width(tmp_path: Path) -> None:
    text = table("Code;PWM (us);Thrust (N)", CODE, 1500 - 400 * SHARE, THRUST)
    assert "code may be" in errors(mooring(tmp_path, text))


@pytest.mark.parametrize("said", REFUSED)
def test_what_is_not_clear_is_refused(said: str, tmp_path: Path) -> None:
    record = mooring(tmp_path, REFUSED[said])
    assert said in errors(record)
    assert not record.points


@pytest.mark.parametrize(
    "head", ["Motor speed el. (rpm)", "Обороты эл., об/мин", "Field speed (rpm)", "Elec speed, rpm"]
)
def test_a_field_turns_faster_than_its_shaft(head: str, tmp_path: Path) -> None:
    speed = 7 * np.repeat([1500.0, 3000.0], 6)
    assert "pole pairs" in errors(load(tmp_path, f"Code;{head};Torque (N m)", speed))


def test_a_power_called_n(tmp_path: Path) -> None:
    speed = np.repeat([1500.0, 3000.0], 6)
    rows = table("Код;n;M", np.repeat([60.0, 120.0], 6), speed, np.linspace(0.1, 0.4, 12)).split(
        "\n"
    )
    power = [f"{row};{at + 3.5}" for at, row in enumerate(rows[1:])]
    text = "\n".join([f"{rows[0]};N", ";об/мин;Н·м;Вт", *power])
    (tmp_path / "b.csv").write_text(text + "\n", encoding="utf-8")
    record = read_load_tests([tmp_path / "b.csv"], vehicle(), tmp_path)
    assert {one.code for one in record.points} == {60.0, 120.0}


@pytest.mark.parametrize("head", ["Flow (kn)", "Течение (см/с)"])
def test_readings_in_a_flow_are_not_at_rest(head: str, tmp_path: Path) -> None:
    record = mooring(tmp_path, table(f"Code;{head};Thrust (N)", CODE, 60.0 + 0.0 * CODE, THRUST))
    assert {one.marks for one in record.points} == {("not at rest",)}


def test_a_sheet_that_is_called_a_fit(tmp_path: Path) -> None:
    rows = {
        name: [["Code", "Thrust (N)"], *np.stack([CODE, part * THRUST], axis=1).tolist()]
        for name, part in (("Data", 1.0), ("Fit", 1.2))
    }
    record = read_mooring_tables([write_workbook(tmp_path / "a.xlsx", rows)], vehicle(), tmp_path)
    assert {one.source.sheet for one in record.points} == {"Data"}
    assert "calculated, not measured" in "\n".join(one.what for one in record.problems)


def test_sheets_of_several_thrusters(tmp_path: Path) -> None:
    sheets = {
        f"unit {at}": [
            ["Code", "Thrust (N)"],
            *zip(CODE.tolist(), (part * THRUST).tolist(), strict=True),
        ]
        for at, part in enumerate((1.0, 0.98, 0.7), start=1)
    }
    path = write_workbook(tmp_path / "a.xlsx", sheets)
    record = read_mooring_tables([path], vehicle(), tmp_path)
    assert "gives 0.71 times the thrust" in "\n".join(one.what for one in record.problems)


@pytest.mark.parametrize(
    ("head", "part", "said"),
    [
        ("J;KT (%);10KQ", 100.0, ""),
        ("J;KT;10KQ", -1.0, "the sign of the thrust sensor"),
        ("J;KT;10KQ;T (N);n (rpm)", 1.0, "the thrust gives"),
    ],
)
def test_coefficients(head: str, part: float, said: str, tmp_path: Path) -> None:
    j = np.linspace(0.0, 0.7, 8)
    k_t, k_q = 0.4 * (1 - j / 0.95), 0.048 * (1 - j / 0.95) + 0.004
    columns = [j, part * k_t, 10 * k_q, 900 * k_t, np.full(8, 600.0)][: head.count(";") + 1]
    (tmp_path / "a.csv").write_text(table(head, *columns) + "\n", encoding="utf-8")
    record = read_open_water([tmp_path / "a.csv"], vehicle(), tmp_path)
    assert said in "\n".join(one.what for one in record.problems if one.severity != "note")
    if not said:
        found = [one.thrust_coefficient for one in record.points]
        assert found == pytest.approx(k_t)


def test_one_column_is_stated_by_its_letter(tmp_path: Path) -> None:
    stated = vehicle().model_dump()
    stated["columns"]["mooring"] = {"code": {"header": "column A"}}
    (tmp_path / "a.csv").write_text(table("Speed cmd;Thrust (N)", CODE, THRUST) + "\n")
    own = Vehicle.model_validate(stated)
    record = read_mooring_tables([tmp_path / "a.csv"], own, tmp_path)
    assert max(one.code for one in record.points) == 127.0


def test_columns_by_their_letters_have_their_scale(tmp_path: Path) -> None:
    stated = vehicle().model_dump()
    thrust = {"header": "column B", "unit": "N", "scale": 0.5, "plus": ["column C"]}
    stated["columns"]["mooring"] = {"code": {"header": "column A"}, "thrust": thrust}
    (tmp_path / "a.csv").write_text(table("", CODE, THRUST, THRUST).lstrip("\n") + "\n")
    own = Vehicle.model_validate(stated)
    record = read_mooring_tables([tmp_path / "a.csv"], own, tmp_path)
    assert max(one.thrust_n for one in record.points) == pytest.approx(40.0)
