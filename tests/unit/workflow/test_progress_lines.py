"""One line a stage, whatever the stream; a bar on a terminal only; a summary without repetition."""

import io
import json
from pathlib import Path

import pytest

from pipeline.errors import CannotComputeError, Place, Problem
from pipeline.journal import VARIABLE, Event, Reader, note
from pipeline.language import use
from pipeline.plan import VehicleFolder
from pipeline.provenance import Envelope, write_envelope
from pipeline.records.base import Record
from pipeline.stages.job import FirmwareFiles
from pipeline.workflow import one_result
from pipeline.workflow.outcome import Outcome, Result, faults_behind, outcome_of, summary
from pipeline.workflow.progress import Progress
from pipeline.workflow.run import RunRequest

STARTED = Event("started", "boat", "static")
DONE = Event("done", "boat", "static", "", 1.25)
FAILED = Event("failed", "boat", "drive", "the disk is full.")


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def test_one_plain_line_a_stage() -> None:
    stream = io.StringIO()
    progress = Progress(stream, total=2)
    for event in (STARTED, DONE, FAILED):
        progress.take(event)
    progress.close()
    assert stream.getvalue() == (
        "boat: static characteristic (Table 2): done (1.2 s)\n"
        "boat: drive characteristic: failed. the disk is full.\n"
    )
    assert progress.done == 2
    assert progress.failed == [FAILED]
    assert progress.running == {}


def test_a_vehicle_is_called_what_it_is_called_in_every_language() -> None:
    """A name may be a word of the catalogue; the reason is a sentence of its own."""
    why = "left out. vehicle.yaml has no model: section, so there is no vehicle to fly."
    no_file = "left out. There are no load-test files in raw/sound/load_test."
    stream = io.StringIO()
    use("ru")
    try:
        progress = Progress(stream)
        for text in ("", why, no_file):
            progress.take(Event("done", "sound", "validation", text))
    finally:
        use("en")
    done, *left_out = stream.getvalue().splitlines()
    assert done == "sound: полёт распределителя упоров в модели: готово (0,0 с)"
    assert "в vehicle.yaml нет раздела model:, поэтому лететь нечему." in left_out[0]
    assert "В raw/sound/load_test нет файлов: нагрузочные испытания." in left_out[1]


def test_terminal_gets_a_bar_that_goes_away() -> None:
    stream = Terminal()
    progress = Progress(stream, total=2)
    progress.take(STARTED)
    assert "0/2 static characteristic" in stream.getvalue()
    progress.take(DONE)
    assert "[############............] 1/2" in stream.getvalue()
    progress.close()
    assert stream.getvalue().endswith("\r\x1b[2K")


def test_quiet_run_says_nothing() -> None:
    stream = Terminal()
    progress = Progress(stream, quiet=True, total=1)
    progress.take(DONE)
    progress.close()
    assert stream.getvalue() == ""


def test_journal_gives_whole_lines_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "journal.jsonl"
    reader = Reader(path)
    assert list(reader.new_events()) == []
    monkeypatch.setenv(VARIABLE, str(path))
    note(STARTED)
    note(DONE)
    assert list(reader.new_events()) == [STARTED, DONE]
    line = json.dumps({"what": "failed", "vehicle": "boat", "stage": "drive", "text": "x"})
    with path.open("a") as file:
        file.write(line)
    assert list(reader.new_events()) == []
    with path.open("a") as file:
        file.write("\n")
    assert [event.what for event in reader.new_events()] == ["failed"]


def test_stage_without_a_journal_is_silent(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    monkeypatch.chdir(tmp_path)
    note(DONE)
    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []


def result(*outcomes: Outcome, done: int = 0, refused: tuple[Problem, ...] = ()) -> Result:
    names = tuple(outcome.vehicle for outcome in outcomes)
    return Result(names, refused, outcomes, (), done, complete=True)


def test_summary_gives_each_reason_once_and_errors_in_full(tmp_path: Path) -> None:
    absent = "There are no load-test files in raw/boat/load_test."
    outcome = Outcome(
        "boat",
        (
            Problem("error", Place("raw/boat/mooring/a.xlsx", row=3), "is odd.", "even.", "Mend."),
            *(Problem("warning", Place("b.csv", row=i), "doubtful") for i in range(20)),
            Problem("note", Place("b.csv"), "by the way"),
        ),
        (
            ("load test", absent),
            ("drive characteristic", f"There is no load test: t{absent[1:]}"),
        ),
    )
    text = "\n".join(summary(result(outcome, done=3), tmp_path))
    assert text.count(absent) == 1
    assert "boat: left out: load test, drive characteristic." in text
    assert "error: raw/boat/mooring/a.xlsx, row 3: is odd.\nExpected even.\nMend." in text
    assert text.count("warning: b.csv") == 12
    assert "and 8 more warnings" in text
    assert "by the way" not in text
    assert "Nothing to do" not in text


def test_failure_is_told_by_the_title_of_its_stage(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    of_a_run = Event("failed", "boat", "run_trial", "the disk is full.", item="dive1")
    stopped = Result(("boat",), (), (Outcome("boat", (), ()),), (of_a_run,), 1, complete=False)
    told = "boat, dive1, pool run against simulation: the disk is full."
    (text,) = summary(stopped, tmp_path)
    log = tmp_path / "processed/boat/logs/run_trial/dive1.log"
    assert text == f"error: {told}\nIts log: {log}"
    monkeypatch.setattr(one_result, "run", lambda *_: stopped)
    monkeypatch.setattr(one_result, "choose", lambda *_: None)
    for call in (
        lambda: one_result.export_firmware(RunRequest(("boat",)), tmp_path),
        lambda: one_result.validated("boat", tmp_path, tmp_path),
    ):
        with pytest.raises(CannotComputeError) as caught:
            call()
        assert str(caught.value) == told


def test_reason_that_is_an_error_is_not_said_twice(tmp_path: Path) -> None:
    why = "The curves never meet."
    outcome = Outcome(
        "boat", (Problem("error", Place("boat"), why),), (("static characteristic", why),)
    )
    text = "\n".join(summary(result(outcome), tmp_path))
    assert text.count(why) == 1
    assert result(outcome).code == 1


def test_exit_code_is_1_for_errors_only() -> None:
    warned = Outcome("boat", (Problem("warning", Place("a"), "x"),), ())
    assert result(warned).code == 0
    assert result(warned, refused=(Problem("error", Place("a"), "x"),)).code == 1
    assert Result(("boat",), (), (warned,), (FAILED,), 1, complete=False).code == 1


def test_outcome_shows_paths_that_can_be_opened(tmp_path: Path) -> None:
    envelope = Envelope[Record](
        "mooring",
        "boat",
        {},
        "c0",
        None,
        "no",
        (Problem("error", Place("boat/mooring/a.csv"), "x"), Problem("note", Place("other"), "y")),
    )
    write_envelope(tmp_path / "processed/boat/mooring.json", envelope)
    outcome = outcome_of(VehicleFolder("boat", "raw/boat"), tmp_path)
    assert [problem.place.file for problem in outcome.problems] == [
        str(tmp_path / "raw/boat/mooring/a.csv"),
        "other",
    ]
    assert outcome.left_out == (("mooring test", "no"),)


def test_what_every_stage_met_is_said_once(tmp_path: Path) -> None:
    gone = Problem("error", Place("boat/vehicle.yaml"), "there is no such file.")
    for stage in ("load_test", "mooring"):
        envelope = Envelope[Record](stage, "boat", {}, "c0", None, "no", (gone,))
        write_envelope(tmp_path / f"processed/boat/{stage}.json", envelope)
    assert len(outcome_of(VehicleFolder("boat", "raw/boat"), tmp_path).problems) == 1


def test_a_run_tells_of_links_and_folders_that_nothing_reads(tmp_path: Path) -> None:
    """A link that leads round stopped the whole run with a fault of the program."""
    folder = tmp_path / "raw/boat"
    (folder / "pool/2024").mkdir(parents=True)
    (folder / "pool/2024/base.mcap").touch()
    (folder / "mooring").mkdir()
    (folder / "mooring/loop.csv").symlink_to("loop.csv")
    (folder / "mooring/a.csv").touch()
    vehicle = VehicleFolder("boat", "raw/boat")
    assert vehicle.raw_files("mooring", tmp_path) == ("raw/boat/mooring/a.csv",)
    outcome = outcome_of(vehicle, tmp_path)
    assert outcome.failed
    assert [(one.severity, one.place.file) for one in outcome.problems] == [
        ("error", str(folder / "mooring/loop.csv")),
        ("warning", str(folder / "pool/2024")),
    ]


def test_job_that_is_tried_again_counts_once() -> None:
    progress = Progress(io.StringIO(), total=1)
    failed = Event("failed", "boat", "static", "the node was lost.")
    for event in (STARTED, failed, STARTED, DONE):
        progress.take(event)
    assert (progress.failed, progress.done, progress.running) == ([], 1, {})


def test_lines_that_machines_wrote_over_each_other_are_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "journal.jsonl"
    path.write_text('{"what": "done", "veh{"what":\n[1]\n', encoding="utf-8")
    with path.open("a", encoding="utf-8") as file:
        file.write('{"what": "done", "vehicle": "boat", "stage": "static"}\n')
    assert [event.stage for event in Reader(path).new_events()] == ["static"]


GAP = {"name": "mooring test agrees", "passed": False, "text": "up to +1.85 N at code -60"}
CHECKED = {"checks": [GAP, {"name": "round trip", "passed": True, "text": "0.2 N"}]}


class Checked(Record):
    """A record with checks, as the fits have them."""

    checks: list[dict[str, object]]


def test_failed_checks_are_told_and_are_no_error(tmp_path: Path) -> None:
    envelope = Envelope("inverse", "boat", {}, "c0", Checked.model_validate(CHECKED))
    (tmp_path / "processed/boat").mkdir(parents=True)
    write_envelope(tmp_path / "processed/boat/inverse.json", envelope)
    found = outcome_of(VehicleFolder("boat", "raw/boat"), tmp_path)
    assert not found.failed
    assert result(found).code == 0
    (text,) = [one for one in summary(result(found, done=1), tmp_path) if "check failed" in one]
    assert text.startswith("check failed: boat, inverse characteristic")
    assert text.endswith(": mooring test agrees\n  up to +1.85 N at code -60")
    assert "round trip" not in text


def test_export_tells_the_failed_checks_behind_the_firmware(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "processed/boat"
    (folder / "firmware").mkdir(parents=True)
    (folder / "firmware/boat.h").write_text("/* */")
    inverse, firmware = "processed/boat/inverse.json", "processed/boat/firmware.json"
    write_envelope(
        tmp_path / inverse, Envelope("inverse", "boat", {}, "c0", Checked.model_validate(CHECKED))
    )
    receipt = Envelope(
        "firmware",
        "boat",
        {inverse: "0"},
        "c0",
        FirmwareFiles(files={"processed/boat/firmware/boat.h": "0"}),
    )
    write_envelope(tmp_path / firmware, receipt)
    boat = VehicleFolder("boat", "raw/boat")
    behind = faults_behind(boat, "firmware", tmp_path)
    made = one_result.OneResult(boat, tmp_path / firmware, receipt.record, *behind)
    monkeypatch.setattr(one_result, "one_result", lambda *_: made)
    _, refused = one_result.export_firmware(RunRequest(("boat",), out=tmp_path), tmp_path / "to")
    assert refused == ()
    assert (tmp_path / "to/boat.h").is_file()
    told = capsys.readouterr().err
    assert "check failed: boat, inverse characteristic" in told
    assert "up to +1.85 N at code -60" in told
