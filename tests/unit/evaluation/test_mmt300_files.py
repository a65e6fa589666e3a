"""The committed raw files are what the generator makes, and hold what the README says."""

import io
import itertools
import zipfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from openpyxl import Workbook, load_workbook

from evaluation.bundled import mmt300_files
from evaluation.bundled import mmt300_truth as truth
from evaluation.bundled.mmt300_bench import WARM_UP_READINGS
from evaluation.bundled.mmt300_files import main, rig_files
from evaluation.bundled.mmt300_load_test import BROKEN, DEFECTS, NM_PER_KGF_CM, TORQUE_SCALE
from evaluation.bundled.mmt300_mooring import readings, sequence
from evaluation.bundled.mmt300_open_water import points
from evaluation.bundled.noise import Noise

HEADER_ROWS = {"drive-01": 6, "drive-02": 3}
UNIT = {"drive-01": NM_PER_KGF_CM, "drive-02": 1.0}


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    return rig_files()


@cache
def _workbook(data: bytes) -> Workbook:
    return load_workbook(io.BytesIO(data))


def workbook(files: dict[str, bytes], name: str) -> Workbook:
    return _workbook(files[name])


def number(cell: object) -> float | None:
    try:
        return float(str(cell).replace(",", "."))
    except ValueError:
        return None


def bench_rows(files: dict[str, bytes], drive: str, code: int) -> list[tuple[object, ...]]:
    sheet = workbook(files, f"load_test/{drive}.xlsx")[f"Код {code}"]
    return list(sheet.iter_rows(min_row=HEADER_ROWS[drive] + 1, values_only=True))


def test_committed_files_are_what_the_generator_makes(
    files: dict[str, bytes], repository: Path
) -> None:
    folder = repository / "raw" / "mmt300"
    for name, data in files.items():
        same = (folder / name).read_bytes() == data
        assert same, (
            f"raw/mmt300/{name}: run python -m evaluation.bundled.mmt300_files --to raw/mmt300"
        )
    present = {
        str(path.relative_to(folder))
        for path in folder.rglob("*")
        if path.is_file() and path.parent.name not in (folder.name, "pool")
    }
    assert present == set(files)


def test_the_command_writes_them(
    files: dict[str, bytes],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(mmt300_files, "rig_files", lambda: files)
    main(["--to", str(tmp_path)])
    assert len(capsys.readouterr().out.splitlines()) == len(files)
    for name, data in files.items():
        assert (tmp_path / name).read_bytes() == data


def test_archives_hold_no_clock_and_no_compression(files: dict[str, bytes]) -> None:
    for name, data in files.items():
        if name.endswith(".xlsx"):
            with zipfile.ZipFile(io.BytesIO(data)) as archive:
                assert {part.date_time[0] for part in archive.infolist()} == {1980}
                assert {part.compress_type for part in archive.infolist()} == {zipfile.ZIP_STORED}
                core = archive.read("docProps/core.xml").decode()
            assert core.count("1980-01-01T00:00:00Z") == 2


def test_all_files_together_stay_small(files: dict[str, bytes]) -> None:
    assert sum(len(data) for data in files.values()) < 1_000_000


@pytest.mark.parametrize("drive", ["drive-01", "drive-02"])
def test_load_test_scatters_about_the_family_by_the_stated_noise(
    files: dict[str, bytes], drive: str
) -> None:
    """Torque over that of the family: the exemplar's scale, with both branches apart."""
    branches: dict[str, list[float]] = {"loading": [], "unloading": []}
    for code in truth.BENCH_CODES:
        if code <= 30 or (drive, code) in DEFECTS:
            continue
        rows = bench_rows(files, drive, code)[WARM_UP_READINGS:]
        for index, row in enumerate(rows):
            rpm, torque = number(row[2]), number(row[3])
            assert rpm is not None
            assert torque is not None
            branch = "loading" if index < len(rows) // 2 else "unloading"
            ratio = torque * UNIT[drive] / float(truth.drive_torque(rpm, code))
            branches[branch].append(ratio)
    loading, unloading = (np.array(branches[name]) for name in ("loading", "unloading"))
    both = np.concatenate([loading, unloading])
    assert np.median(both) == pytest.approx(TORQUE_SCALE[drive], abs=0.001)
    assert np.median(unloading) - np.median(loading) == pytest.approx(0.005, abs=0.002)
    assert np.percentile(np.abs(both - TORQUE_SCALE[drive]), 68) < 0.015


def test_torques_and_speeds_are_positive_and_make_sense(files: dict[str, bytes]) -> None:
    for drive in HEADER_ROWS:
        for code in truth.BENCH_CODES:
            for row in bench_rows(files, drive, code)[WARM_UP_READINGS:]:
                if row[3] == BROKEN:
                    continue
                rpm, torque = number(row[2]), number(row[3])
                assert rpm is not None
                assert torque is not None
                assert torque > 0.0
                assert 250.0 < rpm < truth.SPEED_LIMIT_RPM + 10.0


def test_warm_up_rows_are_no_steady_points(files: dict[str, bytes]) -> None:
    for drive in HEADER_ROWS:
        rows = bench_rows(files, drive, 90)
        warm = [number(row[2]) for row in rows[:WARM_UP_READINGS]]
        steady = number(rows[WARM_UP_READINGS][2])
        assert steady is not None
        assert all(rpm is not None and rpm < 0.99 * steady for rpm in warm)
        assert number(rows[WARM_UP_READINGS - 1][1]) == 8.0


@pytest.mark.parametrize(("drive", "code"), list(DEFECTS))
def test_stated_defects_are_in_the_files(files: dict[str, bytes], drive: str, code: int) -> None:
    defects = DEFECTS[drive, code]
    rows = bench_rows(files, drive, code)
    assert ([row[3] for row in rows].count(BROKEN) == 1) == (defects.broken is not None)
    commented = [row for row in rows if str(row[0]).startswith("#")]
    assert len(commented) == (defects.commented is not None)
    twins = sum(a == b for a, b in itertools.pairwise(rows))
    assert twins == (defects.duplicated is not None)
    for index, factor in defects.outliers.items():
        row = rows[WARM_UP_READINGS + index]
        rpm, torque = number(row[2]), number(row[3])
        assert rpm is not None
        assert torque is not None
        ratio = torque * UNIT[drive] / float(truth.drive_torque(rpm, code))
        assert ratio == pytest.approx(factor, abs=0.05)


def test_powers_follow_from_the_other_columns(files: dict[str, bytes]) -> None:
    for row in bench_rows(files, "drive-01", 120):
        rpm, torque, current, voltage, power_in, power_out = (number(cell) for cell in row[2:8])
        assert None not in (rpm, torque, current, voltage, power_in, power_out)
        assert power_in == pytest.approx(current * voltage, rel=2e-3)  # type: ignore[operator]
        shaft_w = torque * NM_PER_KGF_CM * 2 * np.pi * rpm / 60  # type: ignore[operator]
        assert power_out == pytest.approx(shaft_w, rel=3e-3)


def test_mooring_passes_every_code_on_both_sweeps() -> None:
    codes = sequence()
    for size in (10, 60, 120):
        assert codes.count(size) == codes.count(-size) == 2
    assert codes[0] == codes[-1] == 0


def test_mooring_readings_follow_table_3_after_the_tare() -> None:
    found = readings(drift_n=0.18, noise=Noise("another test"))
    last = len(found) - 1
    residual = np.array(
        [
            row.thrust_n - 0.18 * index / last - truth.mooring_thrust(row.code)
            for index, row in enumerate(found)
        ]
    )
    assert abs(residual.mean()) < 0.06
    assert 0.05 < residual.std() < 0.25
    assert found[-1].thrust_n - found[0].thrust_n == pytest.approx(0.18, abs=0.1)


def test_mooring_workbooks_differ_in_unit_language_and_sign_of_speed(
    files: dict[str, bytes],
) -> None:
    russian = workbook(files, "mooring/bollard-01.xlsx")["Швартовы"]
    english = workbook(files, "mooring/bollard-02.xlsx")["Bollard"]
    in_kgf = {row[0]: row for row in russian.iter_rows(min_row=4, values_only=True)}
    in_n = {row[0]: row for row in english.iter_rows(min_row=3, values_only=True)}
    assert in_kgf[-127][1] * 9.80665 == pytest.approx(in_n[-127][1], abs=0.8)
    assert in_kgf[-127][2] < 0 < in_n[-127][2]
    assert sum(str(code).startswith("#") for code in in_n) == 1


def test_open_water_points_scatter_about_table_1() -> None:
    rows = np.array(points(list(np.linspace(0.0, 0.78, 200)), Noise("another test")))
    for column, printed in ((1, truth.KT), (2, truth.KM)):
        residual = rows[:, column] - np.polynomial.polynomial.polyval(rows[:, 0], printed)
        assert residual.std() / printed[0] == pytest.approx(0.004, rel=0.2)


def test_noise_has_mean_0_and_the_stated_deviation() -> None:
    noise = Noise("statistics")
    drawn = np.array([noise.normal(2.0) for _ in range(20_000)])
    assert abs(drawn.mean()) < 0.06
    assert drawn.std() == pytest.approx(2.0, rel=0.02)
    assert [Noise("x").normal(1.0), Noise("y").normal(1.0)] == pytest.approx(
        [Noise("x").normal(1.0), Noise("y").normal(1.0)], abs=0.0
    )
    assert Noise("x").normal(1.0) != Noise("y").normal(1.0)


def test_the_readme_tells_the_gap_at_rest_of_both_signs(repository: Path) -> None:
    told = (repository / "raw/mmt300/README.md").read_text(encoding="utf-8")
    measured = -truth.mooring_thrust(-60.0)
    assert "code -60 the mooring test gives 12.51 N" in told
    assert measured == pytest.approx(12.51, abs=0.06)
    assert "by up to 1.85 N at negative ones" in " ".join(told.split())
