"""What files of a folder say of each other, and numbers that no machine gives."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bench_workbooks import vehicle

from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water

CODE = 127.0 * np.linspace(-1.0, 1.0, 21)
THRUST = 40.0 * np.sign(CODE) * np.clip((np.abs(CODE) / 127.0 - 0.06) / 0.94, 0.0, None) ** 1.8
AHEAD = CODE >= 0.0
J = np.linspace(0.0, 0.6, 13)
K_T, K_Q = 0.45 - 0.5 * J, 0.06 - 0.05 * J


def table(head: str, *columns: Any) -> str:  # noqa: ANN401  numbers or texts
    rows = zip(*(np.asarray(one, object) for one in columns), strict=True)
    return "\n".join([head, *(";".join(map(str, row)) for row in rows)]) + "\n"


def read(tmp_path: Path, reader: Callable[..., Any], **files: str) -> Any:  # noqa: ANN401
    paths: list[Path] = []
    for name, text in files.items():
        paths.append(tmp_path / f"{name}.csv")
        paths[-1].write_text(text, encoding="utf-8")
    return reader(paths, vehicle(), tmp_path)


def said(record: Any, severity: str = "warning") -> str:  # noqa: ANN401  of any kind
    return "\n".join(one.what for one in record.problems if one.severity == severity)


def bollard(factor: float, step: int = 1) -> str:
    return table("Code;Thrust (N)", CODE[::step], np.round(factor * THRUST[::step], 4))


def test_files_that_differ_are_told(tmp_path: Path) -> None:
    record = read(tmp_path, read_mooring_tables, a=bollard(1.0), b=bollard(1.18, 2))
    assert "1.18 times the thrust of the others" in said(record)


@pytest.mark.parametrize("factor", [1 / 9.80665, 1 / 800])
def test_of_two_files_a_factor_apart_none_is_fitted(factor: float, tmp_path: Path) -> None:
    record = read(tmp_path, read_mooring_tables, a=bollard(1.0), b=bollard(factor))
    assert "times the thrust of the others" in said(record, "error")
    assert all("contradicts other tables" in one.marks for one in record.points)


def test_of_three_files_the_one_apart_is_left_out(tmp_path: Path) -> None:
    files = {"a": bollard(1.0), "b": bollard(1 / 9.80665), "c": bollard(1.02)}
    record = read(tmp_path, read_mooring_tables, **files)
    odd = {one.source.file for one in record.points if "contradicts other tables" in one.marks}
    assert odd == {"b.csv"}


def test_files_of_one_thruster_are_not_suspected(tmp_path: Path) -> None:
    record = read(tmp_path, read_mooring_tables, a=bollard(1.0), b=bollard(1.06), c=bollard(0.97))
    assert "of the others" not in said(record)


def drive(torque: float, speed: float, volts: float = 24.0) -> str:
    load = np.tile(np.linspace(0.01, 0.4, 6), 2)
    code = np.repeat([60.0, 120.0], 6)
    rpm = 20.0 * code * (1.0 - 0.8 * load)
    return table("Code;RPM;Torque (Nm);U (V)", code, rpm * speed, load * torque, 0 * load + volts)


@pytest.mark.parametrize(("torque", "speed"), [(10.197, 1.0), (1.0, 1.4), (1.0, 1.0 / 60.0)])
def test_drives_that_differ_are_told(torque: float, speed: float, tmp_path: Path) -> None:
    record = read(tmp_path, read_load_tests, a=drive(1.0, 1.0), b=drive(torque, speed))
    assert "times the shaft speed of the others" in said(record) + said(record, "error")


def test_a_drive_at_another_voltage_is_not_suspected(tmp_path: Path) -> None:
    record = read(tmp_path, read_load_tests, a=drive(1.0, 1.0), b=drive(1.0, 0.5, 12.0))
    assert "of the others" not in said(record)


def propeller(factor: float) -> str:
    return table("J;KT;KQ", J, factor * K_T, factor * K_Q)


def test_two_propellers_in_a_folder_are_told(tmp_path: Path) -> None:
    record = read(tmp_path, read_open_water, a=propeller(1.0), b=propeller(1.5))
    assert "1.50 times the K_T of the others" in said(record)


@pytest.mark.parametrize("names", [("fwd", "rev"), ("t200 pos", "t200 neg"), ("ход_пх", "ход_зх")])
def test_directions_that_part_the_names_of_files(names: Sequence[str], tmp_path: Path) -> None:
    ahead = table("Code;Thrust (N)", CODE[AHEAD], THRUST[AHEAD])
    astern = table("Code;Thrust (N)", CODE[AHEAD], 0.8 * THRUST[AHEAD])
    record = read(tmp_path, read_mooring_tables, **dict(zip(names, (ahead, astern), strict=True)))
    points = [one for one in record.points if not one.marks]
    assert min(one.code for one in points) == -127.0
    assert min(one.thrust_n for one in points) == pytest.approx(-32.0)


def test_revisions_are_no_directions(tmp_path: Path) -> None:
    ahead = table("Code;Thrust (N)", CODE[AHEAD], THRUST[AHEAD])
    again = table("Code;Thrust (N)", CODE[AHEAD], 1.01 * THRUST[AHEAD])
    record = read(tmp_path, read_mooring_tables, **{"rev 2": ahead, "rev 3": again})
    assert min(one.code for one in record.points) == 0.0


@pytest.mark.parametrize("head", ["Total thrust of 4 thrusters (N)", "Тяга двух движителей, Н"])
def test_a_sum_over_thrusters_asks_for_its_factor(head: str, tmp_path: Path) -> None:
    record = read(tmp_path, read_mooring_tables, a=table(f"Code;{head}", CODE, THRUST))
    assert not record.points
    assert "several thrusters" in said(record, "error")


def test_a_sensor_at_the_end_of_its_range(tmp_path: Path) -> None:
    clipped = table("Code;Thrust (N)", CODE, np.clip(THRUST, -40.0, 20.0))
    record = read(tmp_path, read_mooring_tables, a=clipped)
    assert "exactly 20 N at 4 codes" in said(record)


def test_the_thrust_of_a_duct_is_part_of_the_whole(tmp_path: Path) -> None:
    parts = (0.6 * K_T, 0.4 * K_T)
    record = read(tmp_path, read_open_water, a=table("V/nD;KTP;KTN;KTT;KQ", J, *parts, K_T, K_Q))
    found = [one.thrust_coefficient for one in record.points]
    assert found == pytest.approx(K_T.tolist())


def test_parts_of_a_thrust_alone_are_asked_for(tmp_path: Path) -> None:
    parts = (0.6 * K_T, 0.4 * K_T)
    record = read(tmp_path, read_open_water, a=table("J;KTP;KTD;KQ", J, *parts, K_Q))
    assert '"KTP"' in said(record, "error")
    assert "unit:" not in record.problems[0].remedy


def test_loadings_are_no_coefficients(tmp_path: Path) -> None:
    loading = 8.0 / np.pi / np.maximum(J, 0.05) ** 2
    record = read(tmp_path, read_open_water, a=table("J;CTh;CQ", J, loading * K_T, loading * K_Q))
    assert {one.marks for one in record.points} == {("coefficient beyond any propeller",)}
    assert "beyond any propeller" in said(record, "error")
