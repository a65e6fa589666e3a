"""The page in a real browser: no complaints, and nothing wider than the screen."""

import html
import importlib.util
import json
import re
import shutil
import subprocess
from pathlib import Path
from types import ModuleType

import pytest

from pipeline.report import index_entry, write_index, write_vehicle_page

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-extensions",
    "--enable-logging=stderr",
    "--window-size=1600,1200",
)
#: A frame of the wanted width around the page: a browser's own window cannot be as narrow as a
#: telephone. What is measured is written into the wrapper and read back with --dump-dom.
WRAPPER = """<!doctype html>
<iframe id="frame" style="border:0;width:{width}px;height:900px" srcdoc="{page}"></iframe>
<pre id="measured"></pre>
<script>
onload = () => {{
  const view = document.getElementById("frame").contentWindow;
  const page = view.document;
  for (const fold of page.querySelectorAll("details")) fold.open = true;
  const root = page.documentElement;
  const held = (one) => one.closest(".wide, svg") !== null;
  const over = [...page.querySelectorAll("body *")]
    .filter((one) => !held(one) && one.getBoundingClientRect().right > view.innerWidth + 0.5)
    .map((one) => one.tagName + "." + one.className);
  const plots = [...page.querySelectorAll("svg.plot")];
  document.getElementById("measured").textContent = JSON.stringify({{
    scroll: root.scrollWidth,
    inner: view.innerWidth,
    over: over,
    plots: plots.length,
    unnamed: [...page.querySelectorAll("img:not([alt]), svg:not([aria-label])")].length,
    flat: plots.filter((plot) => plot.getBoundingClientRect().height < 100).length,
    headings: page.querySelectorAll("h2").length,
    title: page.title,
  }});
}};
</script>
"""


@pytest.fixture(scope="module")
def browser() -> str:
    for name in BROWSERS:
        found = shutil.which(name)
        if found:
            return found
    pytest.skip("no chromium on this machine: the report was not looked at in a browser")


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("reports")
    records = _synthetic_records()
    results = records.full_results()
    pages = {
        "vehicle": folder / "synthetic" / "index.html",
        "index": folder / "index.html",
    }
    write_vehicle_page(results, pages["vehicle"])
    write_index([index_entry(results, "synthetic/index.html")], pages["index"])
    return pages


@pytest.mark.parametrize("kind", ["vehicle", "index"])
@pytest.mark.parametrize("width", [360, 1440])
def test_page_fits_the_screen_and_the_browser_has_no_complaints(
    browser: str, pages: dict[str, Path], tmp_path: Path, kind: str, width: int
) -> None:
    wrapper = tmp_path / "wrapper.html"
    page = html.escape(pages[kind].read_text(encoding="utf-8"))
    wrapper.write_text(WRAPPER.format(width=width, page=page), encoding="utf-8")
    done = subprocess.run(
        [
            browser,
            *FLAGS,
            f"--user-data-dir={tmp_path / 'profile'}",
            "--dump-dom",
            wrapper.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    )
    found = re.search(r'<pre id="measured">(.*?)</pre>', done.stdout, re.DOTALL)
    assert found, done.stderr
    measured = json.loads(html.unescape(found[1]))
    assert measured["inner"] == width
    assert measured["scroll"] <= width
    assert measured["over"] == []
    assert measured["unnamed"] == 0
    assert measured["flat"] == 0
    assert measured["headings"] >= 1
    assert measured["plots"] == (16 if kind == "vehicle" else 0)
    assert "CONSOLE" not in done.stderr


def _synthetic_records() -> ModuleType:
    path = Path(__file__).parents[1] / "unit" / "report" / "synthetic_records.py"
    spec = importlib.util.spec_from_file_location("synthetic_records_for_browser", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
