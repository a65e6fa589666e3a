"""The workflow on tiny inputs: complete, idle when nothing changed, and hard to upset."""

import json
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from synthetic_bench import Bench, make_vehicle, write_mooring, write_open_water

from pipeline.errors import InputError
from pipeline.workflow.start import only_run

STAGES = (
    "load_test", "mooring", "open_water", "propeller", "drive", "static", "inverse", "allocation",
    "validation", "tables", "firmware", "vehicle_page",
)  # fmt: skip
EVERYTHING = sorted([("boat", stage) for stage in STAGES] + [("", "index_page")])
AFTER_OPEN_WATER = [one for one in EVERYTHING if one[1] not in ("load_test", "mooring", "drive")]
AFTER_MOORING = [
    one
    for one in EVERYTHING
    if one[1] not in ("load_test", "open_water", "propeller", "drive", "static")
]


def test_complete_run_leaves_every_result(finished: Bench, printed: str) -> None:
    for stage in STAGES[:8]:
        envelope = finished.envelope(stage)
        assert envelope["schema"] == f"rig2sea/{stage}/1"
        assert envelope["record"] is not None, envelope["why_not"]
    tables = finished.envelope("tables")
    assert {"vehicle", "table1", "table2", "table3", "table4", "quality", "published"} < set(tables)
    assert tables["table1"]["KT"][0] == pytest.approx(0.139, rel=0.01)  # type: ignore[index]
    names = set(finished.results())
    assert "reports/index.html" in names
    assert "reports/boat/index.html" in names
    assert "processed/boat/firmware/boat_thruster.h" in names
    for stage in ("load test", "report", "index of reports"):
        assert sum(line.startswith((f"boat: {stage}", stage)) for line in printed.split("\n")) == 1
    assert printed.rstrip().endswith("Report: reports/index.html")


def test_second_run_does_nothing(finished: Bench) -> None:
    before, raw = finished.results(), finished.raw_contents()
    done = finished.run()
    assert done.returncode == 0
    assert "Nothing to do: every result is up to date." in done.stdout
    assert finished.stages_run() == []
    assert finished.results() == before
    assert finished.raw_contents() == raw


def test_touched_file_is_not_a_changed_file(finished: Bench) -> None:
    os.utime(finished.root / "raw/boat/open_water/screw.csv")
    assert "Nothing to do" in finished.run().stdout


@pytest.mark.slow
def test_changed_file_redoes_what_depends_on_it(
    finished: Bench, age: Callable[[Path], None]
) -> None:
    path = finished.root / "raw/boat/open_water/screw.csv"
    write_open_water(path, scale=1.02)
    age(path)  # a copy that keeps its old time is a change too
    assert finished.run().returncode == 0
    assert finished.stages_run() == AFTER_OPEN_WATER
    tables = finished.envelope("tables")
    assert tables["table1"]["KT"][0] == pytest.approx(0.139 * 1.02, rel=0.002)  # type: ignore[index]


def test_new_and_removed_files_are_noticed_without_the_memory_of_the_engine(
    moored: Bench, age: Callable[[Path], None]
) -> None:
    before = moored.contents()
    second = moored.root / "raw/boat/mooring/second.csv"
    write_mooring(second)
    second.write_text(second.read_text().replace("127,35", "127,36"))
    age(second)
    shutil.rmtree(moored.root / ".snakemake")
    moored.run()
    assert moored.stages_run() == AFTER_MOORING
    assert moored.contents() != before
    second.unlink()
    moored.run()
    assert moored.stages_run() == AFTER_MOORING
    assert moored.contents() == before


def test_half_written_and_lost_results_are_made_again(moored: Bench) -> None:
    before = moored.contents()
    names = (
        "processed/boat/inverse.json",
        "processed/boat/tables.json",
        "processed/boat/firmware/boat_thruster.c",
        "reports/boat/index.html",
    )
    for name in names:
        path = moored.root / name
        os.truncate(path, path.stat().st_size // 2)
    (moored.root / "processed/boat/.rest.json.abc.part").write_text("{")
    (moored.root / "processed/boat/firmware.json").unlink()
    done = moored.run()
    assert done.returncode == 0, done.stdout
    assert moored.contents() == before
    assert ("boat", "inverse") in moored.stages_run()
    assert ("boat", "mooring") not in moored.stages_run()


def test_vehicle_that_cannot_be_read_does_not_stop_the_others(moored: Bench) -> None:
    before = moored.contents()
    make_vehicle(moored.root / "raw/other")
    bad = moored.root / "raw/other/vehicle.yaml"
    bad.write_text(bad.read_text().replace("density_kgpm3", "density"))
    (moored.root / "raw/third/mooring").mkdir(parents=True)
    done = moored.run()
    assert done.returncode == 1
    assert "raw/other/vehicle.yaml" in done.stdout
    assert 'unknown key "density"' in done.stdout
    assert "raw/third: has mooring but no vehicle.yaml." in done.stdout
    assert moored.contents() == before


def test_mooring_alone_gives_what_it_can(moored: Bench, moored_printed: str) -> None:
    tables = moored.envelope("tables")
    assert tables["table1"] is None
    assert tables["table3"] is not None
    assert "There are no open-water files in raw/boat/open_water." in moored_printed
    assert moored_printed.count("There are no load-test files in raw/boat/load_test.\n") == 1


def test_vehicle_by_path_and_other_folders(moored: Bench, tmp_path: Path) -> None:
    elsewhere = tmp_path / "bench of today/launch"
    elsewhere.parent.mkdir()
    shutil.copytree(moored.root / "raw/boat", elsewhere)
    out = moored.root / "results of today"
    out.mkdir()
    for top in ("processed", "reports"):
        (moored.root / top).rename(out / top)
    shutil.rmtree(out / "processed/.rig2sea")  # which remembers where the vehicle was
    raw = moored.raw_contents()
    done = moored.run(str(elsewhere), "--out", "results of today")
    assert done.returncode == 0, done.stdout
    assert (out / "reports/launch/index.html").exists()
    text = (out / "processed/launch/mooring.json").read_text()
    assert "raw/launch/mooring/bollard.csv" in text
    assert str(tmp_path) not in text
    # the index leads to both, and the first is not run again
    index = (out / "reports/index.html").read_text()
    assert "boat/index.html" in index
    assert "launch/index.html" in index
    # by the names of their folders: both vehicle files say boat
    assert '<p class="sub">boat</p>' in index
    assert '<p class="sub">launch</p>' in index
    assert "Earlier pages" not in index
    assert {vehicle for vehicle, _ in Bench(out).stages_run()} == {"", "launch"}
    assert moored.raw_contents() == raw
    assert not (moored.root / "processed").exists()
    # it is deleted: it leaves the list of vehicles, its page stays and is told apart
    shutil.rmtree(elsewhere)
    done = moored.run("boat", "--out", "results of today")
    assert done.returncode == 0, done.stdout
    assert Bench(out).stages_run() == [("", "index_page")]
    listed, _, earlier = (out / "reports/index.html").read_text().partition('id="earlier"')
    assert "boat/index.html" in listed
    assert "launch" not in listed
    assert "launch/index.html" in earlier
    assert (out / "reports/launch/index.html").exists()


def test_second_run_in_the_same_folder_is_refused(moored: Bench) -> None:
    with only_run(moored.root / "processed/.rig2sea/lock"):
        done = moored.run()
        assert done.returncode == 1
        assert f"another rig2sea is at work here (process {os.getpid()})" in done.stderr
    assert moored.run().returncode == 0


def test_lock_of_a_dead_process_blocks_nobody(tmp_path: Path) -> None:
    lock = tmp_path / "lock"
    lock.write_text("1\n")
    with only_run(lock), pytest.raises(InputError, match="another rig2sea"), only_run(lock):
        pass


def test_run_ended_half_way_is_completed_by_the_next(fresh_moored: Bench, moored: Bench) -> None:
    """By the signal that asks; `tests/faults` kills it."""
    fresh = fresh_moored
    journal = fresh.root / "processed/.rig2sea/journal.jsonl"
    run = subprocess.Popen(
        [sys.executable, "-m", "pipeline", "run"],
        cwd=fresh.root,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    while not (journal.exists() and '"done"' in journal.read_text()):
        assert run.poll() is None, "the run ended before it could be killed"
        time.sleep(0.02)
    run.terminate()
    _, said = run.communicate(timeout=60)
    assert run.returncode == 1
    assert "Traceback" not in said
    _until_nothing_is_at_work(fresh.root)
    stages = [json.loads(line) for line in journal.read_text().splitlines()]
    assert 0 < sum(event["what"] == "done" for event in stages) < len(STAGES)

    done = fresh.run()
    assert done.returncode == 0, done.stdout + done.stderr
    assert fresh.contents() == moored.contents()


def _until_nothing_is_at_work(folder: Path) -> None:
    """Wait for the processes that work in the folder to be gone; they must go by themselves."""
    end = time.monotonic() + 20
    while time.monotonic() < end:
        if not any(_works_in(process, folder) for process in Path("/proc").glob("[0-9]*")):
            return
        time.sleep(0.05)
    pytest.fail("stages went on after the run was killed")


def _works_in(process: Path, folder: Path) -> bool:
    try:
        return (process / "cwd").resolve(strict=True) == folder.resolve()
    except OSError:
        return False


def test_place_that_cannot_be_written_is_one_message(fresh_moored: Bench) -> None:
    (fresh_moored.root / "reports").write_text("in the way")
    done = fresh_moored.run()
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.startswith("error: reports")
    assert "cannot be written" in done.stderr
    assert "Traceback" not in done.stderr


def test_folder_in_the_place_of_a_result_is_one_message(fresh_moored: Bench) -> None:
    (fresh_moored.root / "processed/boat/mooring.json/in the way").mkdir(parents=True)
    done = fresh_moored.run()
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.startswith("error: processed/boat/mooring.json: cannot be written")


def test_export_copies_the_firmware(moored: Bench, tmp_path: Path) -> None:
    def export(*arguments: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            [sys.executable, "-m", "pipeline", "export", *arguments],
            cwd=moored.root,
            capture_output=True,
            text=True,
            check=False,
        )

    to = tmp_path / "to"
    done = export("boat", "--to", str(to))
    assert done.returncode == 0, done.stdout + done.stderr
    source = moored.root / "processed/boat/firmware"
    assert {p.name: p.read_bytes() for p in to.iterdir()} == {
        p.name: p.read_bytes() for p in source.iterdir()
    }
    assert {path.suffix for path in to.iterdir()} == {".h", ".c", ".json", ".csv"}
    assert done.stderr == ""

    # tables that a refused file is missing from are written, and it is said
    (moored.root / "raw/boat/mooring/cut.xlsx").write_bytes(b"PK\x03\x04 cut short")
    without = tmp_path / "without"
    done = export("boat", "--to", str(without))
    assert done.returncode == 1
    assert "error: raw/boat/mooring/cut.xlsx" in done.stderr
    assert done.stderr.count("error:") == 1
    assert "firmware tables: done" in done.stderr
    assert {path.name for path in without.iterdir()} == {path.name for path in to.iterdir()}
    assert done.stdout.splitlines() == [str(without / path.name) for path in sorted(to.iterdir())]

    shutil.rmtree(moored.root / "raw/boat/mooring")
    done = export("boat", "--to", str(tmp_path / "none"))
    assert done.returncode == 1
    assert "boat has no firmware tables." in done.stderr
    assert not (tmp_path / "none").exists()
