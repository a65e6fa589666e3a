"""Where the page of a diagnosis goes, and that the index leads to it."""

from pathlib import Path

import pytest

from pipeline.actions import diagnosis_page
from pipeline.actions.diagnosis_page import write_page
from pipeline.errors import InputError
from pipeline.provenance import write_atomically
from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.report import html
from pipeline.stages.index_page import RECEIPT, Question, diagnosis_links

ASKED = Question(("raw/mmt300/pool/dive.mcap",))


@pytest.fixture
def record(monkeypatch: pytest.MonkeyPatch) -> DiagnosisRecord:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "report"))
    import diagnosis_records

    monkeypatch.setattr(html, "_library", lambda: b"// library")
    monkeypatch.setattr(diagnosis_page, "diagnosis_page", _short_page)
    return diagnosis_records.diagnosis(channels=("w",), windows=1)


def _short_page(_record: DiagnosisRecord, **more: object) -> str:
    return repr(more)


def test_the_index_leads_to_a_diagnosis(record: DiagnosisRecord, tmp_path: Path) -> None:
    (tmp_path / "a b.json").write_text("{}")
    files = (tmp_path / "a b.json", tmp_path / "absent.yaml")
    page = write_page(record, ASKED, tmp_path, None, files)
    index = (tmp_path / "reports" / "index.html").read_text(encoding="utf-8")
    address = page.relative_to(tmp_path / "reports").as_posix()
    assert f'href="{address}"' in index
    assert "residual buoyancy (96" in index
    text = page.read_text()
    assert "'a%20b.json'" in text
    assert "absent" not in text
    again = write_page(record, ASKED, tmp_path, None)
    assert again == page
    assert len(diagnosis_links(tmp_path / "reports")["mmt300"]) == 1
    (page.parent / RECEIPT).write_text('{"of": "another version"}')
    assert diagnosis_links(tmp_path / "reports") == {}


def test_a_folder_that_was_asked_for_gets_the_page_alone(
    record: DiagnosisRecord, tmp_path: Path
) -> None:
    page = write_page(record, ASKED, tmp_path / "out", tmp_path / "mine")
    assert page == tmp_path / "mine" / "diagnosis.html"
    assert not (tmp_path / "out").exists()


def test_each_log_is_named_after_its_run(record: DiagnosisRecord, tmp_path: Path) -> None:
    logs = [tmp_path / f"{run}_with_effect.mcap" for run in ("dive 1", "dive 2")]
    for log in logs:
        log.touch()
    text = write_page(record, ASKED, tmp_path / "out", tmp_path / "mine", logs).read_text()
    for run in ("dive 1", "dive 2"):
        assert f"Log of {run}: measured, and simulated with the effect" in text
    assert "before" not in text


def test_each_page_keeps_the_files_of_its_own_answer(
    record: DiagnosisRecord, tmp_path: Path
) -> None:
    processed = tmp_path / "processed"
    files = [processed / name for name in ("diagnosis.json", "vehicle_corrected.yaml")]
    files.append(processed / "dive_with_effect.mcap")

    def answer(day: str, names: list[Path], text: str) -> Path:
        for file in names:
            write_atomically(file, text)
        return write_page(record, Question((f"{day}/dive.mcap",)), tmp_path, None, names).parent

    monday = answer("mon", files, "monday")
    tuesday = answer("tue", files[:1], "tuesday")
    assert monday != tuesday, "runs of one name, of two days"
    assert {file.name: (monday / file.name).read_text() for file in files} == {
        file.name: "monday" for file in files
    }
    assert (tuesday / "diagnosis.json").read_text() == "tuesday"
    assert not (tuesday / "vehicle_corrected.yaml").exists()
    # the same question with another answer
    assert answer("mon", files[:1], "again") == monday
    left = sorted(path.name for path in monday.iterdir())
    assert left == ["diagnosis.json", "index.html", RECEIPT]


def test_what_is_kept_stays_when_the_file_is_edited_in_its_place(
    record: DiagnosisRecord, tmp_path: Path
) -> None:
    files = [tmp_path / name for name in ("diagnosis.json", "vehicle_corrected.yaml")]
    files.append(tmp_path / "dive_with_effect.mcap")
    for file in files:
        file.write_text("as found")
    kept = write_page(record, ASKED, tmp_path, None, files).parent
    for file in files[:2]:
        with file.open("r+") as stream:
            stream.write("EDITED")
    assert [(kept / file.name).read_text() for file in files[:2]] == ["as found"] * 2
    assert files[2].samefile(kept / files[2].name), "a log is not copied"


def test_what_cannot_be_taken_away_is_named(record: DiagnosisRecord, tmp_path: Path) -> None:
    page = write_page(record, ASKED, tmp_path, None)
    (page.parent / "dive_with_effect.mcap").mkdir()
    with pytest.raises(InputError, match=r"dive_with_effect\.mcap"):
        write_page(record, ASKED, tmp_path, None)


def test_names_are_safe_and_tell_questions_apart() -> None:
    first = Question(("../x/ü run.mcap",)).name
    assert first.replace("-", "").isalnum()
    assert first.isascii()
    assert first != Question(("../x/ü run.mcap",), (), ("healthy.mcap",)).name
    assert Question(("b", "a")).name == Question(("a", "b")).name
    assert Question(("mon/a.mcap",)).name != Question(("tue/a.mcap",)).name
