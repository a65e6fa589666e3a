"""Broken, disguised and wrong files through the real command: one message each, the rest is done.

Every bad file is checked alone (``rig2sea check``), and all of them together are run once beside
good ones (``rig2sea run``).
"""

import contextlib
import json
import re
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import hostile_files as bad
import openpyxl
import pytest
from click.testing import CliRunner
from shared_runs import digests, once, rig2sea
from synthetic_bench import Bench, digest, make_moored, make_vehicle

from pipeline.cli import cli

#: File -> (severity, what the message must say). An error leaves the table out and fails the
#: command; a warning leaves a row or a sheet's points out of the fits.
EXPECTED = {
    "load_test/truncated.xlsx": ("error", r": the workbook is damaged or truncated"),
    "load_test/encrypted.xlsx": ("error", r": the workbook is encrypted"),
    "load_test/old_excel.xlsx": ("error", r": this is an old Excel file"),
    "load_test/zip_bomb.xlsx": ("error", r": .*zip bomb"),
    "load_test/formulas.xlsx": (
        "error",
        r', sheet "Code 31", row 1, column B: torque .*18 formula cell\(s\) hold no stored value',
    ),
    "load_test/text.xlsx": (
        "warning",
        r', sheet "Code 41", row 7, column B: torque "1,2,3" is not a number',
    ),
    "load_test/wrong_unit.xlsx": (
        "error",
        r', sheet "Code 51", row 1, column B: .*"N" is a unit of force, not of torque',
    ),
    "load_test/no_unit.xlsx": (
        "error",
        r', sheet "Code 61", row 1, column B: .*no unit is stated',
    ),
    "load_test/code_twice.xlsx": (
        "warning",
        r', sheet "Code 71 \(2\)": this table gives 1.2\d times the shaft speed of the others',
    ),
    "load_test/negative_torque.xlsx": (
        "error",
        r', sheet "Code 81", row 2, column B: the torque has the opposite sign',
    ),
    "load_test/all_nan.xlsx": (
        "error",
        r', sheet "Code 91", row 1, column B: torque .*holds no number',
    ),
    "mooring/truncated.xlsx": ("error", r": the workbook is damaged or truncated"),
    "mooring/encrypted.xlsx": ("error", r": the workbook is encrypted"),
    "mooring/formulas.xlsx": (
        "error",
        r', sheet "Bollard", row 1, column B: thrust .*25 formula cell\(s\) hold no stored value',
    ),
    "mooring/text.xlsx": (
        "warning",
        r', sheet "Bollard", row 20, column B: thrust "обрыв" is not a number',
    ),
    "mooring/all_nan.xlsx": (
        "error",
        r', sheet "Bollard", row 1, column B: thrust .*holds no number',
    ),
    "mooring/wrong_unit.xlsx": (
        "error",
        r', sheet "Bollard", row 1, column B: .*"N m" is a unit of torque, not of force',
    ),
    "mooring/no_unit.xlsx": (
        "error",
        r', sheet "Bollard", row 1, column B: .*no unit is stated',
    ),
    "open_water/not_text.csv": ("error", r": this is not a text file"),
    "open_water/text.csv": ("warning", r', row 3, column B: thrust coefficient "abc"'),
    "open_water/all_nan.csv": ("error", r", row 1, column B: .*holds no number"),
    "open_water/no_unit.csv": ("error", r', row 1, column B: shaft speed "n": no unit is stated'),
}
#: A message in the text that is printed: severity, place and fault, then what to do about it.
MESSAGE = re.compile(r"^(error|warning): ((?:.+\n?)+)", re.MULTILINE)


def messages(text: str, about: str) -> list[tuple[str, str]]:
    """(severity, message) of every message about a file."""
    found = [(match[1], match[2].strip()) for match in MESSAGE.finditer(text)]
    return [(severity, said) for severity, said in found if said.startswith(about)]


def named(folder: Path, name: str) -> Path:
    """Name a copied vehicle after its folder."""
    path = folder / "vehicle.yaml"
    path.write_text(
        path.read_text(encoding="utf-8").replace("name: boat", f"name: {name}"), "utf-8"
    )
    return path


def fill(raw: Path) -> None:
    """Good files beside bad ones, one code, curves that never meet, two with nothing wrong."""
    for name in ("boat", "one_code", "adrift"):
        make_vehicle(raw / name)
        named(raw / name, name)
    for name in ("sound", "blocked"):  # what their mooring test alone gives takes no time
        make_moored(raw / name)
        named(raw / name, name)
    for name, write in bad.LOAD_TEST.items():
        write(raw / "boat/load_test" / f"{name}.xlsx")
    for kind, files in (("mooring", bad.MOORING), ("open_water", bad.OPEN_WATER)):
        for name, write in files.items():
            write(raw / "boat" / kind / name)
    bad.one_code(raw / "one_code/load_test/drive 1.xlsx")
    bad.torque_that_does_not_fall(raw / "adrift/load_test/drive 1.xlsx")
    path = raw / "adrift/vehicle.yaml"
    path.write_text(
        path.read_text("utf-8").replace("diameter_m: 0.14", "diameter_m: 0.05"), "utf-8"
    )


@dataclass(frozen=True)
class Ran:
    """All bad files run at once."""

    root: Path

    @property
    def bench(self) -> Bench:
        return Bench(self.root)

    @cached_property
    def said(self) -> dict[str, Any]:
        """Exit code, what was printed, and the digests of the raw files before the run."""
        body: dict[str, Any] = json.loads((self.root / "said.json").read_text(encoding="utf-8"))
        return body

    @property
    def text(self) -> str:
        return str(self.said["out"])


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    def build(root: Path) -> None:
        fill(root / "raw")
        (root / "reports").mkdir()
        (root / "reports/blocked").write_text("in the way", encoding="utf-8")
        before = digests(root / "raw")
        done = rig2sea(root, "run", "--cores", "1")
        said = {"code": done.returncode, "out": done.stdout, "err": done.stderr, "raw": before}
        (root / "said.json").write_text(json.dumps(said), encoding="utf-8")

    return Ran(once(tmp_path_factory, "hostile", build))


@pytest.fixture(scope="module")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same files, to be checked and not run."""
    return once(tmp_path_factory, "hostile_unrun", lambda root: fill(root / "raw"))


def test_the_list_is_complete() -> None:
    files = {f"load_test/{name}.xlsx" for name in bad.LOAD_TEST}
    files |= {f"mooring/{name}" for name in bad.MOORING}
    files |= {f"open_water/{name}" for name in bad.OPEN_WATER}
    assert set(EXPECTED) == files


@pytest.mark.parametrize("file", EXPECTED)
def test_check_says_one_thing_about_a_bad_file(hostile: Path, file: str) -> None:
    severity, expected = EXPECTED[file]
    name = f"raw/boat/{file}"
    before = digest(hostile / name)
    with contextlib.chdir(hostile):
        done = CliRunner().invoke(cli, ("check", name), prog_name="rig2sea")
    assert done.exit_code == (1 if severity == "error" else 0), done.stdout
    assert "Traceback" not in done.stdout + done.stderr
    assert done.stderr == ""
    ((said_severity, said),) = MESSAGE.findall(done.stdout)
    assert said_severity == severity
    assert re.match(re.escape(name) + expected, said), said
    assert "\nExpected " in said
    assert len(said.strip().splitlines()) >= 3, "what to do is missing"
    assert digest(hostile / name) == before
    assert not (hostile / "processed").exists()


def test_run_says_the_same_once_for_every_file(ran: Ran) -> None:
    assert ran.said["code"] == 1
    assert "Traceback" not in ran.said["out"] + ran.said["err"]
    assert "fault of rig2sea itself" not in ran.text
    for file, (severity, expected) in EXPECTED.items():
        found = messages(ran.text, f"raw/boat/{file}")
        assert [one for one, _ in found] == [severity], (file, found)
        assert re.match(re.escape(f"raw/boat/{file}") + expected, found[0][1]), found[0][1]


def test_raw_files_are_as_they_were(ran: Ran) -> None:
    assert digests(ran.root / "raw") == ran.said["raw"]


def test_every_good_file_is_used(ran: Ran) -> None:
    tables = ran.bench.envelope("tables")
    assert all(tables[f"table{i}"] is not None for i in (1, 2, 3, 4))
    record = ran.bench.envelope("load_test")["record"]
    assert isinstance(record, dict)
    path = ran.root / "raw/boat/load_test/drive 1.xlsx"
    rows = sum(sheet.max_row - 1 for sheet in openpyxl.load_workbook(path).worksheets)
    name = "boat/load_test/drive 1.xlsx"
    good = [p for p in record["points"] if p["source"]["file"] == name]
    assert len(good) == rows > 100
    assert all(not p["marks"] for p in good)
    for stage, file in (("mooring", "bollard.csv"), ("open_water", "screw.csv")):
        other = ran.bench.envelope(stage)["record"]
        assert isinstance(other, dict)
        assert {p["source"]["file"] for p in other["points"]} >= {f"boat/{stage}/{file}"}


def test_other_vehicles_are_done(ran: Ran) -> None:
    assert ran.bench.envelope("tables", "sound")["table3"] is not None
    index = (ran.root / "reports/index.html").read_text(encoding="utf-8")
    assert all(f"{name}/index.html" in index for name in ("boat", "one_code", "adrift", "sound"))


def test_a_place_that_one_vehicle_cannot_write_does_not_stop_the_others(ran: Ran) -> None:
    ((severity, said),) = [(s, m) for s, m in MESSAGE.findall(ran.text) if "blocked" in m]
    assert severity == "error"
    assert said.startswith("reports/blocked: cannot be written")
    assert (ran.root / "reports/blocked").read_text(encoding="utf-8") == "in the way"
    assert ran.bench.envelope("tables", "sound")["table3"] is not None


def test_every_message_stands_in_the_report(ran: Ran) -> None:
    page = (ran.root / "reports/boat/index.html").read_text(encoding="utf-8")
    assert [file for file in EXPECTED if Path(file).name not in page] == []


def test_one_code_gives_no_family(ran: Ran) -> None:
    (said,) = messages(ran.text, "raw/one_code/")
    assert said[0] == "error"
    assert "there is one code only (90)" in said[1]
    assert ran.bench.envelope("drive", "one_code")["record"] is None
    tables = ran.bench.envelope("tables", "one_code")
    assert [tables[f"table{i}"] is None for i in (1, 2, 3, 4)] == [False, True, False, True]


def test_curves_that_never_meet_are_explained(ran: Ran) -> None:
    (error,) = [said for severity, said in MESSAGE.findall(ran.text) if "adrift, " in said]
    assert "the propeller's torque meets the drive's at no code at rest" in error
    needed, given = (
        float(number) for number in re.findall(r"([\d.]+) N m", error.partition("bench)")[2])[:2]
    )
    rps = float(re.findall(r"and (\d+) rpm", error)[0]) / 60
    assert needed == pytest.approx(0.0171 * 1000 * rps**2 * 0.05**5, rel=0.02)
    assert given == pytest.approx(0.0126 * 127, rel=0.03)
    assert "diameter" in error
    tables = ran.bench.envelope("tables", "adrift")
    assert [tables[f"table{i}"] is None for i in (1, 2, 3, 4)] == [False, True, False, True]


def test_second_run_repeats_the_messages_and_does_nothing(ran: Ran) -> None:
    again = rig2sea(ran.root, "run")
    assert again.returncode == 1
    assert "Nothing to do: every result is up to date." in again.stdout
    assert sorted(MESSAGE.findall(again.stdout)) == sorted(MESSAGE.findall(ran.text))


# --- The machine is hostile: places that cannot be written; tests/faults has more ----------------


@pytest.mark.parametrize("taken", ["processed", "reports", "reports/boat", "processed/boat"])
def test_a_file_where_a_folder_should_be(fresh_moored: Bench, taken: str) -> None:
    bench = fresh_moored
    place = bench.root / taken
    place.parent.mkdir(exist_ok=True)
    place.write_text("in the way", encoding="utf-8")
    before = bench.raw_contents()
    done = bench.run()
    assert done.returncode == 1
    text = done.stdout + done.stderr
    assert "Traceback" not in text
    ((severity, said),) = MESSAGE.findall(text)
    assert severity == "error"
    assert said.startswith(f"{taken}")
    assert "cannot be written" in said
    assert len(said.strip().splitlines()) == 3
    assert place.read_text(encoding="utf-8") == "in the way", "it is not ours to remove"
    assert bench.raw_contents() == before


def test_export_to_a_file(moored: Bench) -> None:
    (moored.root / "firmware").write_text("in the way", encoding="utf-8")
    done = rig2sea(moored.root, "export", "boat", "--to", "firmware")
    assert done.returncode in (1, 2)
    assert "Traceback" not in done.stdout + done.stderr
    assert "firmware" in done.stderr
