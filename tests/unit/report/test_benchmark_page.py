"""What a benchmark measured goes between its marks in a page, and nowhere else."""

import importlib
import sys
from pathlib import Path

import pytest

from benchmarks.page import update

BEGIN, END = "<!-- begin -->", "<!-- end -->"


def test_a_table_takes_the_place_of_the_one_before(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"# Title\n{BEGIN}\nold\n{END}\nwhat follows\n", encoding="utf-8")
    update(page, BEGIN, END, "new")
    assert page.read_text(encoding="utf-8") == f"# Title\n{BEGIN}\nnew\n{END}\nwhat follows\n"


@pytest.mark.parametrize(
    "marks", [(BEGIN,), (END,), (END, BEGIN), (BEGIN, BEGIN, END), (BEGIN, END, END), ()]
)
def test_a_page_without_its_marks_stays_as_it_is(tmp_path: Path, marks: tuple[str, ...]) -> None:
    page = tmp_path / "page.md"
    text = "\n".join(["# Title", *marks, "what follows"])
    page.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match="each once"):
        update(page, BEGIN, END, "new")
    assert page.read_text(encoding="utf-8") == text


def test_figures_of_a_quick_look_are_not_written(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "path", [*sys.path])  # the module changes it
    kernel = importlib.import_module("benchmarks.kernel")
    measured: list[object] = []
    monkeypatch.setattr(kernel, "measure", lambda *_, **__: measured.append(1))
    monkeypatch.setattr(kernel.page, "text", lambda _: "")
    monkeypatch.setattr(kernel.page, "update", lambda *_: None)
    monkeypatch.setattr(kernel.page, "plots", lambda *_: [])
    monkeypatch.setattr(sys, "argv", ["kernel.py", "--quick", "--write"])
    with pytest.raises(SystemExit) as stopped:
        kernel.main()
    assert stopped.value.code == 2
    assert "--quick" in capsys.readouterr().err
    assert measured == []
