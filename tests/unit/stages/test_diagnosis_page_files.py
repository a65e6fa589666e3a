"""Where the page of a diagnosis goes, and that the index leads to it."""

from pathlib import Path

import pytest

from pipeline.records.diagnosis import DiagnosisRecord
from pipeline.report import assets
from pipeline.stages import diagnosis_page
from pipeline.stages.diagnosis_links import RECEIPT, diagnosis_links, diagnosis_name
from pipeline.stages.diagnosis_page import write_page


@pytest.fixture
def record(monkeypatch: pytest.MonkeyPatch) -> DiagnosisRecord:
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "report"))
    import diagnosis_records

    monkeypatch.setattr(assets, "_library", lambda: b"// library")
    monkeypatch.setattr(diagnosis_page, "write_diagnosis_page", _short_page)
    return diagnosis_records.diagnosis(channels=("w",), windows=1)


def _short_page(_record: DiagnosisRecord, path: Path, _assets: Path | None, **more: object) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(repr(more), encoding="utf-8")


def test_the_index_leads_to_a_diagnosis(record: DiagnosisRecord, tmp_path: Path) -> None:
    (tmp_path / "a b.json").write_text("{}")
    page = write_page(record, tmp_path, None, (tmp_path / "a b.json", tmp_path / "absent.yaml"))
    index = (tmp_path / "reports" / "index.html").read_text(encoding="utf-8")
    address = page.relative_to(tmp_path / "reports").as_posix()
    assert f'href="{address}"' in index
    assert "residual buoyancy (96" in index
    text = page.read_text()
    assert "../../../../a%20b.json" in text
    assert "absent" not in text
    again = write_page(record, tmp_path, None)
    assert again == page
    assert len(diagnosis_links(tmp_path / "reports")["mmt300"]) == 1
    (page.parent / RECEIPT).write_text('{"of": "another version"}')
    assert diagnosis_links(tmp_path / "reports") == {}


def test_a_folder_that_was_asked_for_gets_the_page_alone(
    record: DiagnosisRecord, tmp_path: Path
) -> None:
    page = write_page(record, tmp_path / "out", tmp_path / "mine")
    assert page == tmp_path / "mine" / "diagnosis.html"
    assert not (tmp_path / "out").exists()


def test_names_are_safe_and_tell_questions_apart() -> None:
    first = diagnosis_name(["../x/ü run"], [], [])
    assert first.replace("-", "").isalnum()
    assert first.isascii()
    assert first != diagnosis_name(["../x/ü run"], [], ["healthy"])
    assert diagnosis_name(["b", "a"], [], []) == diagnosis_name(["a", "b"], [], [])
