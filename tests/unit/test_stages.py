"""A stage reads, computes, writes; without data it writes the reason, and the next passes it on."""

import errno
from pathlib import Path

import pytest

from pipeline.errors import CannotComputeError, InputError, Place
from pipeline.plan import RECORD_STAGES
from pipeline.provenance import Envelope, file_digest, read_raw_envelope, write_envelope
from pipeline.records.base import Record
from pipeline.records.fits import Check, DriveFit
from pipeline.stages import bench_fits, bench_records
from pipeline.stages.job import Job, NotMeasuredError, leave_record

VEHICLE = """\
name: a
title: a
water: {density_kgpm3: 1000.0, gravity_mps2: 9.81}
propellers: {p: {diameter_m: 0.1}}
drives: {d: {code_min: -127, code_max: 127}}
tables: {propeller: p, drive: d}
"""
CHECK = Check(name="rises", passed=True, text="")


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An output folder as working folder, with one vehicle in raw/."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "raw/a").mkdir(parents=True)
    (tmp_path / "raw/a/vehicle.yaml").write_text(VEHICLE)
    return tmp_path


def job(stage: str, *more: str) -> Job:
    paths = (Path("raw/a/vehicle.yaml"), *map(Path, more))
    return Job(stage, "a", "c0", paths, Path(f"processed/a/{stage}.json"))


def written(stage: str) -> dict[str, object]:
    return read_raw_envelope(Path(f"processed/a/{stage}.json"), stage)


@pytest.mark.usefixtures("here")
def test_absence_is_told_once_along_the_chain() -> None:
    bench_records.run(job("open_water"))
    bench_fits.run(job("propeller", "processed/a/open_water.json"))
    reason = str(written("propeller")["why_not"])
    assert written("open_water")["why_not"] == "There are no open-water files in raw/a/open_water."
    assert reason == (
        "There is no open-water test: there are no open-water files in raw/a/open_water."
    )
    assert written("propeller")["record"] is None
    assert written("propeller")["problems"] == []

    late = job("static", "processed/a/propeller.json")
    with pytest.raises(NotMeasuredError) as missing:
        late.needed("propeller", DriveFit)
    assert str(missing.value) == reason


def test_absent_files_are_said_to_be_absent_where_the_vehicle_lies(here: Path) -> None:
    vehicle = here / "bench/boat/vehicle.yaml"
    vehicle.parent.mkdir(parents=True)
    vehicle.write_text(VEHICLE)
    for path, shown in (
        (vehicle, f"{here}/bench/boat"),
        (Path("bench/boat/vehicle.yaml"), "bench/boat"),
    ):
        bench_records.run(Job("mooring", "a", "c0", (path,), Path("processed/a/mooring.json")))
        assert written("mooring")["why_not"] == f"There are no mooring files in {shown}/mooring."


@pytest.mark.parametrize(("is_error", "severities"), [(False, []), (True, ["error"])])
@pytest.mark.usefixtures("here")
def test_result_that_does_not_follow_is_recorded_with_its_reason(
    is_error: bool, severities: list[str]
) -> None:
    def compute() -> Record:
        raise CannotComputeError("the curves never meet")

    text = leave_record(job("static"), compute, failure_is_error=is_error)
    assert "the curves never meet" in text
    assert written("static")["record"] is None
    problems = written("static")["problems"]
    assert isinstance(problems, list)
    assert [problem["severity"] for problem in problems] == severities


@pytest.mark.usefixtures("here")
def test_refused_file_is_recorded_as_an_error() -> None:
    def compute() -> Record:
        raise InputError.at(Place("a.xlsx", row=3), "is odd.")

    leave_record(job("mooring"), compute)
    (problem,) = written("mooring")["problems"]  # type: ignore[misc]
    assert (problem["severity"], problem["place"]["row"]) == ("error", 3)


@pytest.mark.parametrize("code", [errno.ENOSPC, errno.EROFS, errno.EFBIG])
@pytest.mark.parametrize("suppressed", [True, False])
@pytest.mark.usefixtures("here")
def test_full_disk_never_becomes_a_result(code: int, *, suppressed: bool) -> None:
    """It would be believed when there is room again."""

    def write() -> None:
        raise OSError(code, "odd")

    def compute() -> Record:
        refusal = InputError.at(Place("a.html"), "cannot be written.")
        try:
            write()
        except OSError as error:
            raise refusal from (None if suppressed else error)

    with pytest.raises(InputError, match="cannot be written"):
        leave_record(job("static"), compute)
    assert not Path("processed/a/static.json").exists()


@pytest.mark.usefixtures("here")
def test_fault_of_our_own_is_not_taken_for_missing_data() -> None:
    def compute() -> Record:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        leave_record(job("static"), compute)
    assert not Path("processed/a/static.json").exists()


def test_inputs_are_named_alike_on_every_machine(here: Path) -> None:
    (here / "raw/a/mooring").mkdir()
    (here / "raw/a/mooring/run 1.csv").write_text("x")
    relative = job("mooring", "raw/a/mooring/run 1.csv", "processed/a/drive.json")
    absolute = Job(
        "mooring",
        "a",
        "c0",
        tuple(here / path for path in relative.inputs[:2]) + relative.inputs[2:],
        relative.output,
    )
    digests = relative.input_digests()
    assert set(digests) == {
        "raw/a/vehicle.yaml",
        "raw/a/mooring/run 1.csv",
        "processed/a/drive.json",
    }
    assert digests["raw/a/mooring/run 1.csv"] == file_digest(here / "raw/a/mooring/run 1.csv")
    assert absolute.input_digests() == digests


def test_mooring_stage_reads_what_is_good_and_names_what_is_not(here: Path) -> None:
    folder = here / "raw/a/mooring"
    folder.mkdir()
    rows = [f"{code},{0.002 * code * abs(code):.3f}" for code in range(-120, 121, 20)]
    (folder / "good.csv").write_text("code,thrust (N)\n" + "\n".join(rows) + "\n")
    (folder / "bad.xlsx").write_bytes(b"PK\x03\x04 cut short")
    bench_records.run(job("mooring", "raw/a/mooring/bad.xlsx", "raw/a/mooring/good.csv"))
    record = written("mooring")["record"]
    assert isinstance(record, dict)
    assert {point["source"]["file"] for point in record["points"]} == {"a/mooring/good.csv"}
    errors = [p for p in record["problems"] if p["severity"] == "error"]
    assert [p["place"]["file"] for p in errors] == ["a/mooring/bad.xlsx"]


@pytest.mark.usefixtures("here")
def test_tables_say_what_is_missing() -> None:
    for stage in RECORD_STAGES:
        envelope = Envelope[Record](stage, "a", {}, "c0", None, f"There is no {stage} today.")
        write_envelope(Path(f"processed/a/{stage}.json"), envelope)
    inputs = [f"processed/a/{stage}.json" for stage in ("propeller", "static", "inverse")]
    this = job("tables", *inputs)
    bench_fits.run(this)
    body = this.__class__("firmware", "a", "c0", (this.output,), Path("x")).tables()
    assert body["table1"] is None
    assert body["not_computed"]["static"] == "There is no static today."
    assert set(body["provenance"]["inputs"]) == {"raw/a/vehicle.yaml", *inputs}


@pytest.mark.usefixtures("here")
def test_drive_stage_refuses_a_half_written_input() -> None:
    Path("processed/a").mkdir(parents=True)
    Path("processed/a/load_test.json").write_text('{"schema": "rig2sea/load_te')
    bench_fits.run(job("drive", "processed/a/load_test.json"))
    assert "half-written" in str(written("drive")["why_not"])


def test_copy_fetched_from_a_storage_has_the_name_of_the_result(tmp_path: Path) -> None:
    raw = tmp_path / ".snakemake/storage/s3/bucket/raw/boat"
    result = tmp_path / ".snakemake/storage/s3/bucket/processed/boat/drive.json"
    for path in (raw / "vehicle.yaml", result):
        path.parent.mkdir(parents=True)
        path.touch()
    job = Job("static", "boat", "", (raw / "vehicle.yaml", result), tmp_path / "static.json")
    assert set(job.input_digests()) == {"raw/boat/vehicle.yaml", "processed/boat/drive.json"}
