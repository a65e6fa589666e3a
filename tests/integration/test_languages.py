"""The same results, and pages in the language that was asked for; files that cannot be read."""

import subprocess
import sys

from synthetic_bench import Bench, digest


def run_in(bench: Bench, language: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-m", "pipeline", "run", "--cores", "1", "--language", language],
        cwd=bench.root,
        capture_output=True,
        text=True,
        check=False,
        timeout=300,
    )


def processed(bench: Bench) -> dict[str, str]:
    """Return the digest of every result but the page's receipt, which names the page's digest."""
    folder = bench.root / "processed/boat"
    return {
        path.name: digest(path)
        for path in folder.iterdir()
        if path.is_file() and path.name != "vehicle_page.json"
    }


def test_a_language_is_a_matter_of_pages_and_messages(moored: Bench) -> None:
    page = moored.root / "reports/boat/index.html"
    english = page.read_bytes()
    # files that cannot be read: named in Russian, kept in English; the rest is done
    (moored.root / "raw/boat/load_test").mkdir()
    (moored.root / "raw/boat/load_test/broken.xlsx").write_bytes(b"PK\x03\x04 cut short")
    (moored.root / "raw/boat/mooring/empty.csv").touch()
    (moored.root / "raw/boat/mooring/{code}.csv").touch()
    refused = run_in(moored, "ru")
    assert refused.returncode == 1
    assert "boat: отчёт: готово" in refused.stdout or "boat: страница" in refused.stdout
    assert "broken.xlsx: книга повреждена или обрезана" in refused.stdout
    assert "Отчёт: reports/index.html" in refused.stdout
    text = page.read_text(encoding="utf-8")
    assert '<html lang="ru">' in text
    assert "Таблица 3. N = K" in text
    assert "книга повреждена" in text
    assert "the workbook is damaged" in str(moored.envelope("load_test"))
    assert moored.envelope("tables")["table3"] is not None
    russian = processed(moored)

    again = run_in(moored, "ru")
    assert "Делать нечего: все результаты свежие." in again.stdout
    assert moored.stages_run() == []

    done = run_in(moored, "en")
    assert done.returncode == 1
    assert "error: raw/boat/load_test/broken.xlsx" in done.stdout
    assert "error: raw/boat/mooring/empty.csv" in done.stdout
    assert "error: raw/boat/mooring/{code}.csv: the file's name holds" in done.stdout
    assert "Traceback" not in refused.stdout + refused.stderr + done.stdout + done.stderr
    assert moored.stages_run() == [("", "index_page"), ("boat", "vehicle_page")]
    assert processed(moored) == russian
    assert b'<html lang="en">' in page.read_bytes()
    assert b"broken.xlsx" in page.read_bytes()
    assert b"Table 3. N = K" in english
