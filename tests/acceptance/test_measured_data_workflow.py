"""Measured files that nobody here wrote through ``rig2sea run``, with nothing but a vehicle.yaml.

Four vehicles in one run: a thruster with mooring tests alone (T200), a motor dynamometer without
control codes, and two propellers with open-water curves alone. What can be computed is compared
with numpy on the files themselves; what cannot must be missing with its reason.
"""

import csv
import ctypes
import json
import math
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from openpyxl import load_workbook
from shared_runs import digests, rig2sea
from workflow_runs import Finished, firmware_code, firmware_thrust, run_once

FloatArray = npt.NDArray[np.float64]

KGF_N = 9.80665
DEAD_N = 0.5
NO_OPEN_WATER = "no open-water files"
NO_LOAD_TEST = "no load-test files"
NO_MOORING = "no mooring files"
HERE = Path(__file__).parent
#: Vehicle -> folder of raw files -> files under the folder of measured data.
MEASURED = {
    "t200": {"mooring": ["t200_bollard/T200-Public-Performance-Data-10-20V-September-2019.xlsx"]},
    "motor_dyno": {
        "load_test": [
            "motor_dyno/odrive_data.csv",
            "motor_dyno/Motor_efficiency_data_handler.xlsx",
        ]
    },
    "pptc": {
        "open_water": ["propeller_open_water/pptc_vp1304/pptc_vp1304_open_water_measured.csv"]
    },
    "uiuc": {"open_water": ["propeller_open_water/uiuc_air/volume2_exp.csv"]},
}


@pytest.fixture(scope="session")
def measured(shared_data: Path, tmp_path_factory: pytest.TempPathFactory) -> Finished:
    """The measured data, each with nothing but a vehicle.yaml, run."""
    missing = [
        file
        for folders in MEASURED.values()
        for files in folders.values()
        for file in files
        if not (shared_data / file).is_file()
    ]
    if missing:
        pytest.skip(f"not in {shared_data}: {', '.join(missing)}")

    def fill(raw: Path) -> None:
        for vehicle, folders in MEASURED.items():
            (raw / vehicle).mkdir()
            shutil.copy(HERE / vehicle / "vehicle.yaml", raw / vehicle)
            for folder, files in folders.items():
                (raw / vehicle / folder).mkdir()
                for file in files:
                    shutil.copy(shared_data / file, raw / vehicle / folder)

    return run_once(tmp_path_factory, "measured", fill)


def without_result(run: Finished, vehicle: str) -> dict[str, str]:
    """Return stage -> reason of everything that was not computed."""
    stages = ("load_test", "mooring", "open_water", "propeller", "drive", "static", "inverse")
    envelopes = {stage: run.envelope(vehicle, stage) for stage in (*stages, "allocation")}
    return {stage: e["why_not"] for stage, e in envelopes.items() if e["record"] is None}


def test_the_run_ends_well_and_leaves_the_raw_files_alone(measured: Finished) -> None:
    assert measured.said["code"] == 0, measured.said["out"] + measured.said["err"]
    assert "Traceback" not in measured.said["out"] + measured.said["err"]
    assert digests(measured.root / "raw") == measured.said["raw"]
    index = (measured.root / "reports/index.html").read_text(encoding="utf-8")
    assert all(f"{name}/index.html" in index for name in ("t200", "motor_dyno", "pptc", "uiuc"))


@pytest.mark.parametrize("vehicle", ["t200", "motor_dyno", "pptc", "uiuc"])
def test_every_gap_stands_in_the_report_with_its_reason(measured: Finished, vehicle: str) -> None:
    page = measured.report(vehicle)
    for reason in without_result(measured, vehicle).values():
        assert any(reason in row for row in page.rows), reason


# --- T200: mooring tests at six supply voltages --------------------------------------------------


@pytest.fixture(scope="module")
def t200(measured: Finished) -> tuple[FloatArray, FloatArray]:
    """(code, thrust in newtons) of the sheet "16 V", read with another library."""
    (path,) = (measured.root / "raw/t200/mooring").glob("*.xlsx")
    sheet = load_workbook(path, data_only=True)["16 V"]
    rows = [r for r in sheet.iter_rows(min_row=2, values_only=True) if r[0] is not None]
    code = np.array([float(str(row[0])) - 1500.0 for row in rows])
    thrust = np.array([float(str(row[5])) * KGF_N for row in rows])
    assert len(rows) == 201
    return code, thrust


@pytest.fixture(scope="module")
def exported(measured: Finished, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that ``rig2sea export t200`` fills."""
    to = tmp_path_factory.mktemp("export")
    # another test process may be at work in the same folder; the lock would refuse the second
    root = tmp_path_factory.mktemp("t200")
    for part in ("raw/t200", "processed/t200", "reports/t200"):
        shutil.copytree(measured.root / part, root / part)
    done = rig2sea(root, "export", "t200", "--to", str(to))
    assert done.returncode == 0, done.stdout + done.stderr
    return to


@pytest.fixture(scope="module")
def firmware(exported: Path) -> dict[str, Any]:
    body: dict[str, Any] = json.loads((exported / "t200_thruster.json").read_text("utf-8"))
    characteristic: dict[str, Any] = body["firmware"]
    return characteristic


def test_t200_gets_what_follows_from_a_mooring_test(measured: Finished) -> None:
    tables = measured.envelope("t200", "tables")
    assert [tables[f"table{i}"] is None for i in (1, 2, 3, 4)] == [True, True, False, True]
    assert tables["firmware"]["positive"]["speed_mps"] == [0.0]
    reasons = without_result(measured, "t200")
    assert set(reasons) == {
        "load_test",
        "open_water",
        "propeller",
        "drive",
        "static",
        "allocation",
    }
    assert NO_LOAD_TEST in reasons["drive"]
    assert NO_OPEN_WATER in reasons["propeller"]
    assert NO_OPEN_WATER in reasons["static"]
    assert "allocator" in reasons["allocation"]
    text = measured.report("t200").text
    assert "Without the static family the tables hold at rest only" in text
    assert "nothing was measured under way" in text


@pytest.mark.parametrize(("sign", "name"), [(1, "positive"), (-1, "negative")])
def test_t200_table_3_is_the_least_squares_cubic(
    measured: Finished, t200: tuple[FloatArray, FloatArray], sign: int, name: str
) -> None:
    """Of the points over 0.5 N at 16 V that are not among the outliers named."""
    fit = measured.record("t200", "inverse")[f"table3_{name}"]
    outliers = [o["source"] for o in fit["quality"]["outliers"]]
    assert {source["sheet"] for source in outliers} <= {"16 V"}
    assert len(outliers) <= 4
    code, thrust = t200
    row = np.arange(2, 203)
    used = (sign * thrust > DEAD_N) & ~np.isin(row, [source["row"] for source in outliers])
    expected = np.polyfit(thrust[used], code[used], 3)[::-1]
    assert fit["quality"]["points"] == used.sum()
    np.testing.assert_allclose(fit["coefficients"], expected, rtol=1e-6)
    tables = measured.envelope("t200", "tables")
    assert tables["table3"][name] == fit["coefficients"]


def test_t200_code_to_thrust_to_code(firmware: dict[str, Any]) -> None:
    """Every whole code outside the dead zone comes back within 2, both signs."""
    code = np.arange(-400.0, 401.0)
    thrust = firmware_thrust(firmware, code, 0.0)
    live = np.abs(thrust) > DEAD_N
    assert (live & (code > 0)).sum() > 360
    assert (live & (code < 0)).sum() > 360
    back = np.round(firmware_code(firmware, thrust, 0.0))
    assert np.abs(back - code)[live].max() <= 2


def test_t200_measured_thrust_to_code(
    firmware: dict[str, Any], t200: tuple[FloatArray, FloatArray]
) -> None:
    """From the measured thrust back to the code that was sent.

    One code is 1 us, the steps of the data are 4 us, and one reading scatters by about 0.1 N or
    0.7 codes. The largest deviations found are 1.55 codes forward (at code 352, 0.30 N) and 1.70
    codes in reverse (at code -392, where the thrust levels off).
    """
    code, thrust = t200
    live = np.abs(thrust) > DEAD_N
    back = firmware_code(firmware, thrust, 0.0)
    for sign in (1, -1):
        mine = live & (np.sign(code) == sign)
        assert mine.sum() > 85
        assert np.abs(back - code)[mine].max() <= 2
        assert np.sqrt(np.mean((back - code)[mine] ** 2)) <= 1
    difference = firmware_thrust(firmware, code, 0.0) - thrust
    assert np.abs(difference)[live].max() <= 0.35


def test_t200_exported_c_does_the_same(
    exported: Path, firmware: dict[str, Any], t200: tuple[FloatArray, FloatArray], tmp_path: Path
) -> None:
    """The C source, compiled for this machine, on the measured thrusts."""
    compiler = shutil.which("gcc")
    if compiler is None:
        pytest.skip("no gcc")
    library = tmp_path / "t200.so"
    source = exported / "t200_thruster.c"
    flags = ["-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run([compiler, *flags, str(source), "-o", str(library)], check=True)
    function = ctypes.CDLL(str(library)).t200_code_from_thrust_f32
    function.argtypes, function.restype = [ctypes.c_float, ctypes.c_float], ctypes.c_int16
    code, thrust = t200
    live = np.abs(thrust) > DEAD_N
    sent = np.array([function(value, 0.0) for value in thrust.tolist()])
    assert np.abs(sent - firmware_code(firmware, thrust, 0.0)).max() <= 0.51
    assert np.abs(sent - code)[live].max() <= 2
    assert function(0.5, 0.0) == 0


# --- Motor dynamometer: speed and torque, no control codes ---------------------------------------


def test_dynamometer_is_read(measured: Finished) -> None:
    path = measured.root / "raw/motor_dyno/load_test/odrive_data.csv"
    lines = path.read_text(encoding="utf-8").splitlines()[3:]
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines])
    points = [
        p
        for p in measured.record("motor_dyno", "load_test")["points"]
        if p["source"]["file"] == "motor_dyno/load_test/odrive_data.csv"
    ]
    assert [p["source"]["row"] for p in points] == list(range(4, 348))
    torque = np.array([p["torque_nm"] for p in points])
    speed = np.array([p["shaft_speed_rpm"] for p in points])
    np.testing.assert_allclose(np.abs(torque), np.abs(rows[:, 9]) / 1000.0, atol=1e-9)
    np.testing.assert_allclose(np.abs(speed), np.abs(rows[:, 10]) * 30 / math.pi, rtol=1e-9)


def test_dynamometer_gives_no_family_and_says_why(measured: Finished) -> None:
    assert {p["code"] for p in measured.record("motor_dyno", "load_test")["points"]} == {None}
    reasons = without_result(measured, "motor_dyno")
    assert "no control code" in reasons["drive"]
    assert "columns.load_test.code" in reasons["drive"], "what to do belongs to it"
    assert NO_OPEN_WATER in reasons["static"]
    assert NO_MOORING in reasons["inverse"]
    assert "the family M(n, N) has no second variable" in measured.said["out"]
    tables = measured.envelope("motor_dyno", "tables")
    assert [tables[f"table{i}"] for i in (1, 2, 3, 4)] == [None] * 4
    assert not (measured.root / "processed/motor_dyno/firmware").exists()


# --- Propellers: open-water curves alone ---------------------------------------------------------


def open_water(measured: Finished, vehicle: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(row, J, [K_T, K_Q]) of a vehicle's CSV file, read with the csv module."""
    (path,) = (measured.root / "raw" / vehicle / "open_water").glob("*.csv")
    with path.open(encoding="utf-8") as stream:
        rows = list(enumerate(csv.DictReader(stream), start=2))
    if vehicle == "uiuc":
        rows = [(n, row) for n, row in rows if row["PropName"] == "apcff 4.2x4.0 - 2"]
        table = [(row["J"], row["CT"], float(row["CP"]) / (2 * math.pi)) for _, row in rows]
    else:
        names = {name.lower(): name for name in rows[0][1]}
        k_q = next(names[name] for name in names if "10k" in name)
        table = [(r[names["j"]], r[names["kt"]], float(r[k_q]) / 10) for _, r in rows]
    values = np.array(table, float)
    return np.array([n for n, _ in rows]), values[:, 0], values[:, 1:]


def leave_one_out(x: FloatArray, y: FloatArray, degree: int) -> float:
    keep = ~np.eye(len(x), dtype=bool)
    errors = [
        y[i] - np.polyval(np.polyfit(x[keep[i]], y[keep[i]], degree), x[i]) for i in range(len(x))
    ]
    return float(np.sqrt(np.mean(np.square(errors))))


@pytest.mark.parametrize("vehicle", ["pptc", "uiuc"])
@pytest.mark.parametrize(("column", "curve", "name"), [(0, "thrust", "KT"), (1, "torque", "KM")])
def test_table_1_is_the_least_squares_quadratic(
    measured: Finished, vehicle: str, column: int, curve: str, name: str
) -> None:
    """And the leave-one-out errors of all orders are those of fits made without each point."""
    fit = measured.record(vehicle, "propeller")[curve]
    outliers = [o["source"]["row"] for o in fit["quality"]["outliers"]]
    assert len(outliers) <= 2
    row, advance, values = open_water(measured, vehicle)
    used = ~np.isin(row, outliers)
    x, y = advance[used], values[used, column]
    assert fit["quality"]["points"] == used.sum()
    np.testing.assert_allclose(fit["coefficients"], np.polyfit(x, y, 2)[::-1], rtol=1e-6)
    assert measured.envelope(vehicle, "tables")["table1"][name] == fit["coefficients"]
    residual = y - np.polyval(np.polyfit(x, y, 2), x)
    spread = math.sqrt(float(residual @ residual) / (len(x) - 3))
    assert fit["quality"]["residual_std"] == pytest.approx(spread, rel=1e-6)
    scores = {s["order"]: s for s in fit["quality"]["orders"]}
    assert [order for order, score in scores.items() if score["chosen"]] == ["degree 2"]
    # a point is out of the comparison where every order finds it too far off
    assert any(
        all(
            score["leave_one_out_rmse"] == pytest.approx(leave_one_out(*points, int(order[-1])))
            for order, score in scores.items()
        )
        for points in ((x, y), (advance, values[:, column]))
    )


@pytest.mark.parametrize("curve", ["thrust", "torque"])
def test_what_a_quadratic_leaves_shows_in_the_scores(measured: Finished, curve: str) -> None:
    """102 points carry an order of more; that the quadratic was kept all the same is said."""
    quality = measured.record("uiuc", "propeller")[curve]["quality"]
    scores = {s["order"]: s for s in quality["orders"]}
    assert min(scores, key=lambda order: scores[order]["aicc"]) in ("degree 3", "degree 4")
    best = min(s["leave_one_out_rmse"] for s in quality["orders"])
    assert scores["degree 2"]["leave_one_out_rmse"] > 1.05 * best
    assert "AICc would prefer degree" in quality["order_reason"]
    assert quality["order_reason"] in measured.report("uiuc").text


def test_six_points_of_pptc_are_off_the_quadratic_by_more_than_their_last_digit(
    measured: Finished,
) -> None:
    """The points are given to 1e-4 in K_T; the quadratic misses them by 5e-4, the line by more."""
    quality = measured.record("pptc", "propeller")["thrust"]["quality"]
    scores = {s["order"]: s for s in quality["orders"]}
    assert quality["residual_std"] > 3 * 1e-4
    line, quadratic = scores["degree 1"], scores["degree 2"]
    assert line["leave_one_out_rmse"] > 2 * quadratic["leave_one_out_rmse"]
    assert quality["valid_range"] == [0.7985, 1.4594]


def test_physical_checks_of_the_propellers(measured: Finished) -> None:
    """The quadratic K_M of the UIUC propeller rises at small J, which the readings do not."""

    def outcome(vehicle: str) -> dict[str, bool]:
        checks = measured.record(vehicle, "propeller")["checks"]
        return {check["name"]: check["passed"] for check in checks}

    assert all(outcome("pptc").values())
    assert {name for name, passed in outcome("uiuc").items() if not passed} == {"K_M falls with J"}
    _, advance, values = open_water(measured, "uiuc")
    assert measured.record("uiuc", "propeller")["torque"]["coefficients"][1] > 0
    rest, low = advance < 0.05, np.abs(advance - 0.25) < 0.05
    assert values[rest, 1].mean() > values[low, 1].mean()
    assert any("K_M falls with J".replace("_", "") in row for row in measured.report("uiuc").rows)


@pytest.mark.parametrize("vehicle", ["pptc", "uiuc"])
def test_the_rest_is_missing_for_want_of_a_drive(measured: Finished, vehicle: str) -> None:
    reasons = without_result(measured, vehicle)
    assert NO_LOAD_TEST in reasons["drive"]
    assert NO_LOAD_TEST in reasons["static"]
    assert NO_MOORING in reasons["inverse"]
    tables = measured.envelope(vehicle, "tables")
    assert [tables[f"table{i}"] is None for i in (1, 2, 3, 4)] == [False, True, True, True]
    assert f"There are no load-test files in raw/{vehicle}/load_test." in measured.said["out"]
