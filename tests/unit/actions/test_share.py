"""One file holds the whole page, and leads nowhere else."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from pipeline.actions import share as stage
from pipeline.actions.share import alone, share
from pipeline.cli import cli
from pipeline.errors import CannotComputeError
from pipeline.records.comparison import Comparison, Side
from pipeline.report.comparison_page import comparison_page
from pipeline.report.html import placed, write_page


@pytest.fixture
def page(tmp_path: Path) -> Path:
    """A page of the report with scripts beside it."""
    side = Side(name="a", kind="vehicle", vehicle="boat", holds=("boat.yaml",))
    record = Comparison(a=side, b=side, comparable=True, verdict="Nothing differs.")
    path = tmp_path / "reports/boat/runs/first.html"
    write_page(comparison_page(record, placed(tmp_path / "reports/assets", path)), path)
    return path


def test_a_page_is_found_by_its_name_and_stands_alone(page: Path, tmp_path: Path) -> None:
    to = tmp_path / "mail.html"
    told = CliRunner().invoke(
        cli, ["share", "first", "--to", str(to), "--out", str(tmp_path), "--json"]
    )
    assert told.exit_code == 0, told.output
    text = to.read_text(encoding="utf-8")
    assert "Nothing differs." in text
    assert "<script src" not in text.replace("defer ", "")
    assert "script-src 'unsafe-inline'" in text
    assert len(text) > len(page.read_text(encoding="utf-8")) + 1_000_000  # the plotting library


def test_links_to_other_pages_become_text_and_pictures_are_taken_in(tmp_path: Path) -> None:
    (tmp_path / "p.png").write_bytes(b"png")
    text = alone(
        '<a href="../index.html">All</a> <a href="#top">up</a> <a href="https://a.org">web</a> '
        '<img alt="x" src="p.png">',
        tmp_path,
    )
    assert text == (
        '<span>All</span> <a href="#top">up</a> <a href="https://a.org">web</a> '
        '<img alt="x" src="data:image/png;base64,cG5n">'
    )


def test_what_cannot_be_shared_is_said(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = CliRunner()
    out = ["--out", str(tmp_path)]
    none = run.invoke(cli, ["share", "nothing", "--to", "a.html", *out])
    assert none.exit_code == 2
    assert 'no page "nothing"' in none.output
    assert run.invoke(cli, ["share", "first", "--to", "a.doc", *out]).exit_code == 2
    assert run.invoke(cli, ["share", "first", "--to", str(page), *out]).exit_code == 2
    monkeypatch.setattr(stage, "find_spec", lambda _name: None)
    with pytest.raises(CannotComputeError, match=r"pip install 'rig2sea\[pdf\]'"):
        share(page, tmp_path / "a.pdf")


def test_pdf_begins_with_the_first_screen(page: Path, tmp_path: Path) -> None:
    pytest.importorskip("weasyprint", reason="an optional extra, not installed")
    share(page, tmp_path / "a.pdf")
    assert (tmp_path / "a.pdf").read_bytes().startswith(b"%PDF")
