"""The workflow on tiny inputs: complete, idle when nothing changed, and hard to upset."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from synthetic_bench import Bench, make_vehicle, write_open_water

from pipeline.errors import InputError
from pipeline.workflow.lock import only_run

STAGES = (
    "load_test", "mooring", "open_water", "propeller", "drive", "static", "inverse", "allocation",
    "validation", "tables", "firmware", "vehicle_page",
)  # fmt: skip
AFTER_OPEN_WATER = sorted(
    [("boat", s) for s in STAGES if s not in ("load_test", "mooring", "drive")]
    + [("", "index_page")]
)


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


def test_results_hold_no_time_and_no_absolute_path(finished: Bench, fresh: Bench) -> None:
    assert fresh.run("--cores", "1").returncode == 0
    assert fresh.contents() == finished.contents()


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


def test_change_is_noticed_without_the_memory_of_the_engine(
    finished: Bench, age: Callable[[Path], None]
) -> None:
    shutil.rmtree(finished.root / ".snakemake")
    path = finished.root / "raw/boat/mooring/bollard.csv"
    path.write_text(path.read_text().replace("127,35", "127,36"))
    age(path)
    finished.run()
    assert ("boat", "mooring") in finished.stages_run()
    assert ("boat", "inverse") in finished.stages_run()
    assert ("boat", "static") not in finished.stages_run()


def test_new_and_removed_files_are_noticed(finished: Bench, age: Callable[[Path], None]) -> None:
    before = finished.contents()
    second = finished.root / "raw/boat/open_water/second.csv"
    write_open_water(second, scale=1.01)
    age(second)
    finished.run()
    assert finished.stages_run() == AFTER_OPEN_WATER
    second.unlink()
    finished.run()
    assert finished.stages_run() == AFTER_OPEN_WATER
    assert finished.contents() == before


def test_half_written_results_are_made_again(finished: Bench) -> None:
    before = finished.contents()
    names = (
        "processed/boat/static.json",
        "processed/boat/tables.json",
        "processed/boat/firmware/boat_thruster.c",
        "reports/boat/index.html",
    )
    for name in names:
        path = finished.root / name
        os.truncate(path, path.stat().st_size // 2)
    (finished.root / "processed/boat/.rest.json.abc.part").write_text("{")
    done = finished.run()
    assert done.returncode == 0, done.stdout
    assert finished.contents() == before


@pytest.mark.parametrize("name", ["reports/boat/index.html", "processed/boat/firmware.json"])
def test_edited_or_lost_result_alone_is_made_again(finished: Bench, name: str) -> None:
    before = finished.contents()
    (finished.root / name).unlink()
    assert finished.run().returncode == 0
    assert finished.contents() == before
    assert ("boat", "static") not in finished.stages_run()


def test_broken_files_are_named_and_the_rest_is_done(finished: Bench) -> None:
    before = finished.contents()
    (finished.root / "raw/boat/load_test/broken.xlsx").write_bytes(b"PK\x03\x04 cut short")
    (finished.root / "raw/boat/mooring/empty.csv").touch()
    (finished.root / "raw/boat/mooring/{code}.csv").touch()
    for _ in range(2):  # the second run has nothing to do and still says what is wrong
        done = finished.run()
        assert done.returncode == 1
        assert "error: raw/boat/load_test/broken.xlsx" in done.stdout
        assert "error: raw/boat/mooring/empty.csv" in done.stdout
        assert "error: raw/boat/mooring/{code}.csv: the file's name holds" in done.stdout
        assert "Traceback" not in done.stdout + done.stderr
    assert finished.envelope("tables")["table4"] is not None
    page = (finished.root / "reports/boat/index.html").read_text(encoding="utf-8")
    assert "broken.xlsx" in page
    for name in ("broken.xlsx", "empty.csv", "{code}.csv"):
        next((finished.root / "raw").rglob(name)).unlink()
    assert finished.run().returncode == 0
    assert finished.contents() == before


def test_vehicle_that_cannot_be_read_does_not_stop_the_others(finished: Bench) -> None:
    before = finished.contents()
    make_vehicle(finished.root / "raw/other")
    bad = finished.root / "raw/other/vehicle.yaml"
    bad.write_text(bad.read_text().replace("density_kgpm3", "density"))
    (finished.root / "raw/third/mooring").mkdir(parents=True)
    done = finished.run()
    assert done.returncode == 1
    assert "raw/other/vehicle.yaml" in done.stdout
    assert 'unknown key "density"' in done.stdout
    assert "raw/third: has mooring but no vehicle.yaml." in done.stdout
    assert finished.contents() == before


def test_mooring_alone_gives_what_it_can(fresh: Bench) -> None:
    for kind in ("load_test", "open_water"):
        shutil.rmtree(fresh.root / "raw/boat" / kind)
    done = fresh.run()
    assert done.returncode == 0
    tables = fresh.envelope("tables")
    assert tables["table1"] is None
    assert tables["table3"] is not None
    assert "There are no open-water files in raw/boat/open_water." in done.stdout
    assert done.stdout.count("There are no load-test files in raw/boat/load_test.\n") == 1


def test_vehicle_by_path_and_other_folders(fresh: Bench, tmp_path: Path) -> None:
    for kind in ("load_test", "open_water"):
        shutil.rmtree(fresh.root / "raw/boat" / kind)
    elsewhere = tmp_path / "bench of today/launch"
    elsewhere.parent.mkdir()
    shutil.copytree(fresh.root / "raw/boat", elsewhere)
    raw = fresh.raw_contents()
    done = fresh.run(str(elsewhere), "--out", "results of today")
    assert done.returncode == 0, done.stdout
    out = fresh.root / "results of today"
    assert (out / "reports/launch/index.html").exists()
    text = (out / "processed/launch/mooring.json").read_text()
    assert "raw/launch/mooring/bollard.csv" in text
    assert str(tmp_path) not in text
    # a second vehicle joins; the index leads to both, and the first is not run again
    done = fresh.run("boat", "--out", "results of today")
    assert done.returncode == 0, done.stdout
    index = (out / "reports/index.html").read_text()
    assert "boat/index.html" in index
    assert "launch/index.html" in index
    assert {vehicle for vehicle, _ in Bench(out).stages_run()} == {"", "boat"}
    assert fresh.raw_contents() == raw
    assert not (fresh.root / "processed").exists()


def test_second_run_in_the_same_folder_is_refused(finished: Bench) -> None:
    with only_run(finished.root / "processed/.rig2sea/lock"):
        done = finished.run()
        assert done.returncode == 1
        assert f"another rig2sea is at work here (process {os.getpid()})" in done.stderr
    assert finished.run().returncode == 0


def test_lock_of_a_dead_process_blocks_nobody(tmp_path: Path) -> None:
    lock = tmp_path / "lock"
    lock.write_text("1\n")
    with only_run(lock), pytest.raises(InputError, match="another rig2sea"), only_run(lock):
        pass


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_run_killed_half_way_is_completed_by_the_next(
    fresh: Bench, finished: Bench, number: signal.Signals
) -> None:
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
    run.send_signal(number)
    _, said = run.communicate(timeout=60)
    assert run.returncode == (-number if number == signal.SIGKILL else 1)
    assert "Traceback" not in said
    _until_nothing_is_at_work(fresh.root)
    stages = [json.loads(line) for line in journal.read_text().splitlines()]
    assert 0 < sum(event["what"] == "done" for event in stages) < len(STAGES)

    done = fresh.run()
    assert done.returncode == 0, done.stdout + done.stderr
    assert fresh.contents() == finished.contents()


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


def test_place_that_cannot_be_written_is_one_message(fresh: Bench) -> None:
    (fresh.root / "reports").write_text("in the way")
    done = fresh.run()
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.startswith("error: reports")
    assert "cannot be written" in done.stderr
    assert "Traceback" not in done.stderr


def test_folder_in_the_place_of_a_result_is_one_message(fresh: Bench) -> None:
    (fresh.root / "processed/boat/mooring.json/in the way").mkdir(parents=True)
    done = fresh.run()
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr.startswith("error: processed/boat/mooring.json: cannot be written")


def test_force_redoes_everything(finished: Bench) -> None:
    before = finished.contents()
    assert finished.run("--force").returncode == 0
    assert finished.stages_run() == sorted([("boat", s) for s in STAGES] + [("", "index_page")])
    assert finished.contents() == before


def test_export_copies_the_firmware(finished: Bench, tmp_path: Path) -> None:
    def export(*arguments: str) -> "subprocess.CompletedProcess[str]":
        return subprocess.run(
            [sys.executable, "-m", "pipeline", "export", *arguments],
            cwd=finished.root,
            capture_output=True,
            text=True,
            check=False,
        )

    to = tmp_path / "to"
    done = export("boat", "--to", str(to))
    assert done.returncode == 0, done.stdout + done.stderr
    source = finished.root / "processed/boat/firmware"
    assert {p.name: p.read_bytes() for p in to.iterdir()} == {
        p.name: p.read_bytes() for p in source.iterdir()
    }
    assert {path.suffix for path in to.iterdir()} == {".h", ".c", ".json", ".csv"}

    shutil.rmtree(finished.root / "raw/boat/mooring")
    shutil.rmtree(finished.root / "raw/boat/open_water")
    done = export("boat", "--to", str(tmp_path / "none"))
    assert done.returncode == 1
    assert "boat has no firmware tables." in done.stderr
    assert not (tmp_path / "none").exists()
