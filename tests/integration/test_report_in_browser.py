"""The pages in a real browser: no complaints, nothing wider than the screen, usable by all."""

import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from http.server import BaseHTTPRequestHandler, HTTPServer
from importlib import resources
from itertools import pairwise
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from types import ModuleType
from typing import Any

import pytest

from pipeline.bundled.design import design_example
from pipeline.report import index_entry, write_index, write_vehicle_page
from pipeline.report.day_results import DayResults
from pipeline.report.design_page import write_design_page
from pipeline.report.diagnosis_page import write_diagnosis_page
from pipeline.report.results import TrialDayLink, VehicleResults
from pipeline.report.run_page import write_run_page
from pipeline.report.trial_page import write_day_page
from pipeline.stages.design import DesignRequest, compute_design

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
    # so that the wrapper may look into the pages in its frames
    "--allow-file-access-from-files",
    # keeps the browser open until it is told to end
    "--remote-debugging-port=0",
)
KINDS = ("index", "vehicle", "run", "trial", "diagnosis", "design")
WIDTHS = (360, 1440)
#: Figures of each page; of these, those that can be zoomed.
FIGURES = {
    "index": (0, 0), "vehicle": (17, 1), "run": (9, 9), "trial": (1, 1), "diagnosis": (5, 3),
    "design": (3, 0),
}  # fmt: skip

#: Pages in frames of the wanted width, one after the other: a browser's own window cannot be as
#: narrow as a telephone. What is measured is sent back. Not with --dump-dom: its time stands still
#: between frames, and what waits for a figure to come near the screen waits forever.
WRAPPER = """<!doctype html>
<script>
const wanted = {wanted};
const found = {{}};
const next = () => {{
  const one = wanted.shift();
  if (!one) {{
    const body = JSON.stringify(found);
    fetch("http://127.0.0.1:{port}", {{ method: "POST", mode: "no-cors", body }});
    return;
  }}
  const frame = document.createElement("iframe");
  frame.style = `border:0;width:${{one.width}}px;height:900px`;
  frame.onload = () => setTimeout(() => {{
    measure(frame.contentWindow, one).then((result) => {{
      found[one.name] = result;
      frame.remove();
      next();
    }});
  }}, 300);
  frame.src = one.address;
  document.body.append(frame);
}};
{measure}
onload = next;
</script>
"""
LAYOUT = """
const measure = async (view) => {
  const page = view.document;
  for (const fold of page.querySelectorAll("details")) fold.open = true;
  const frame = () => new Promise((done) => view.requestAnimationFrame(done));
  for (const data of page.querySelectorAll("script.zoom-data")) {
    const figure = data.parentElement;
    data.previousElementSibling.scrollIntoView();
    for (let n = 0; n < 600 && !figure.querySelector(".zoomed .main-svg"); n++) await frame();
  }
  const root = page.documentElement;
  const held = (one) => one.closest(".wide, svg, .skip, .modebar") !== null;
  const plots = [...page.querySelectorAll("svg.plot")];
  const lives = [...page.querySelectorAll(".zoomed")];
  const ids = [...page.querySelectorAll("[id]")].map((one) => one.id);
  return {
    scroll: root.scrollWidth,
    inner: view.innerWidth,
    over: [...page.querySelectorAll("body *")]
      .filter((one) => !held(one) && one.getBoundingClientRect().right > view.innerWidth + 0.5)
      .map((one) => one.tagName + "." + one.className),
    plots: plots.length,
    zoomed: lives.filter((one) => one.getBoundingClientRect().height > 100).length,
    still: [...page.querySelectorAll("script.zoom-data")]
      .filter((one) => !one.parentElement.querySelector(".zoomed .main-svg"))
      .map((one) => one.parentElement.id),
    flat: plots
      .filter((one) => !one.classList.contains("replaced"))
      .filter((one) => one.getBoundingClientRect().height < 100).length,
    unnamed: [...page.querySelectorAll("img:not([alt]), svg.plot:not([aria-label])")].length,
    headings: [...page.querySelectorAll("h1, h2, h3, h4")].map((one) => Number(one.tagName[1])),
    lost: [...page.querySelectorAll('a[href^="#"]')]
      .map((one) => decodeURIComponent(one.hash.slice(1)))
      .filter((one) => !ids.includes(one)),
    landmarks: ["main", "header", "a.skip"].map((one) => page.querySelectorAll(one).length),
    scopes: [...page.querySelectorAll("table th:not([scope])")]
      .filter((one) => !one.closest(".zoomed")).length,
    twice: ids.filter((one, at) => ids.indexOf(one) !== at && !/^(clip|legend|g[0-9])/.test(one)),
  };
};
"""
FILTER = """
const measure = async (view, one) => {
  const page = view.document;
  const field = page.querySelector("#filter");
  const shown = () => [...page.querySelectorAll("[data-entry]")]
    .filter((entry) => entry.getClientRects().length)
    .map((entry) => entry.textContent.trim().split(/\\s+/).slice(0, 3).join(" "));
  const found = { all: shown() };
  for (const words of one.words) {
    field.value = words;
    field.dispatchEvent(new view.Event("input"));
    found[words] = [shown(), page.querySelector("#found").textContent];
  }
  return found;
};
"""
AXE_RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"]
#: What the rules of axe-core call wrong at level AA of WCAG 2.1.
AXE = """
const measure = async (view, one) => {
  const page = view.document;
  for (const fold of page.querySelectorAll("details")) fold.open = true;
  const { violations, passes } = await view.axe.run(
    { exclude: [[".zoomed"], ["svg.plot"]] },
    { runOnly: one.rules, resultTypes: ["violations"] },
  );
  const faults = violations.map((one) => [
    one.id, one.help, ...one.nodes.slice(0, 3).map((node) => node.target.join(" ")),
  ]);
  return { faults, passes: passes.length };
};
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
    """Every kind of page from small records, where the workflow would put it."""
    reports = tmp_path_factory.mktemp("site") / "reports"
    own = reports / "synthetic"
    found = {
        "index": reports / "index.html",
        "vehicle": own / "index.html",
        "run": own / "runs/zig-zag.html",
        "trial": own / "trials/2026-05-04.html",
        "diagnosis": own / "diagnoses/a/index.html",
        "design": reports / "design/pilgrim-balance.html",
    }
    assets = reports / "assets"
    up = (("All vehicles", "../../index.html"), ("synthetic", "../index.html"))
    results, day = _results()
    write_vehicle_page(results, found["vehicle"], assets=assets)
    run = _module("run_records").run_results(results.vehicle)
    write_run_page(run, found["run"], up, assets)
    write_day_page(day, found["trial"], up, assets)
    diagnosis = _module("diagnosis_records").diagnosis(channels=("w", "psi", "z"), windows=6)
    write_diagnosis_page(diagnosis, found["diagnosis"], assets)
    write_design_page(_design(reports.parent), found["design"], (("Index", "../index.html"),))
    entry = index_entry(results, "synthetic/index.html")
    more = {
        "days": tuple(_from_index(one) for one in reversed(results.trials)),
        "trend_href": "synthetic/index.html#trend",
        "diagnoses": (("residual buoyancy (96 %); pool-1", "synthetic/diagnoses/a/index.html"),),
    }
    write_index(
        [type(entry)(**{**entry.__dict__, **more})],
        found["index"],
        [("raft", (("tether (80 %); r-1", "raft/diagnoses/b/index.html"),))],
        designs=(("Pilgrim: steady motion", "design/pilgrim-balance.html"),),
        assets=assets,
    )
    return found


@pytest.fixture(scope="module")
def measured(
    browser: str, pages: dict[str, Path], tmp_path_factory: pytest.TempPathFactory
) -> tuple[dict[str, Any], str]:
    """What one browser found on all pages at all widths, and what it complained of."""
    wanted = [
        {"name": f"{kind} {width}", "width": width, "address": pages[kind].as_uri()}
        for kind in KINDS
        for width in WIDTHS
    ]
    return _browse(browser, wanted, LAYOUT, tmp_path_factory.mktemp("layout"))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("width", WIDTHS)
def test_page_fits_the_screen(measured: tuple[dict[str, Any], str], kind: str, width: int) -> None:
    found = measured[0][f"{kind} {width}"]
    assert found["inner"] == width
    assert found["scroll"] <= width
    assert found["over"] == []
    assert found["unnamed"] == 0
    assert found["flat"] == 0
    assert found["still"] == []
    assert (found["plots"], found["zoomed"]) == FIGURES[kind]


@pytest.mark.parametrize("kind", KINDS)
def test_page_has_an_order_for_those_who_hear_it(
    measured: tuple[dict[str, Any], str], kind: str
) -> None:
    found = measured[0][f"{kind} 1440"]
    levels = found["headings"]
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    assert found["landmarks"] == [1, 1, 1]
    assert found["scopes"] == 0
    assert found["lost"] == []
    assert found["twice"] == []


def test_browser_has_no_complaints(measured: tuple[dict[str, Any], str]) -> None:
    assert "CONSOLE" not in measured[1]


def test_index_is_filtered_by_words(browser: str, pages: dict[str, Path], tmp_path: Path) -> None:
    words = ["heave 2026-05-03", "RAFT", "no such thing", ""]
    wanted = [{"name": "i", "width": 900, "address": pages["index"].as_uri(), "words": words}]
    measured, complaints = _browse(browser, wanted, FILTER, tmp_path)
    found = measured["i"]
    assert "CONSOLE" not in complaints
    shown, said = found["heave 2026-05-03"]
    # the run, under its day and its vehicle
    assert [one.split()[0] for one in shown] == ["Synthetic", "Trial", "heave-steps:"]
    assert said.startswith("1 of ")
    assert found["RAFT"][0] == ["tether (80 %);"]
    assert found["no such thing"][0] == []
    assert found[""][0] == found["all"]


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_fault(
    browser: str, pages: dict[str, Path], tmp_path: Path, scheme: str
) -> None:
    if importlib.util.find_spec("axe_core_python") is None:
        pytest.skip("axe-core-python is not installed: accessibility was not checked by axe-core")
    axe = resources.files("axe_core_python").joinpath("axe.min.js").read_text(encoding="utf-8")
    # colours alone differ in the dark
    rules = ["color-contrast"] if scheme == "dark" else AXE_RULES
    wanted = []
    for kind in KINDS:
        text = pages[kind].read_text(encoding="utf-8")
        # the page's own policy lets no foreign script in
        text = re.sub(r"<meta http-equiv=.Content-Security-Policy[^>]*>", "", text)
        copy = pages[kind].with_name(f"axe-{scheme}-{pages[kind].name}")
        copy.write_text(text.replace("</body>", f"<script>{axe}</script></body>"), encoding="utf-8")
        wanted.append({"name": kind, "width": 1200, "address": copy.as_uri(), "rules": rules})
    dark = ["--blink-settings=preferredColorScheme=0"] if scheme == "dark" else []
    measured, _ = _browse(browser, wanted, AXE, tmp_path, *dark)
    assert {kind: one["faults"] for kind, one in measured.items()} == {kind: [] for kind in KINDS}
    assert all(one["passes"] >= (1 if scheme == "dark" else 15) for one in measured.values())


def _browse(
    browser: str, wanted: list[dict[str, Any]], measure: str, folder: Path, *flags: str
) -> tuple[dict[str, Any], str]:
    answers: Queue[bytes] = Queue()

    class Listener(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            answers.put(self.rfile.read(int(self.headers["Content-Length"])))
            self.send_response(204)
            self.end_headers()

        def log_message(self, *_: object) -> None:
            pass

    said = folder / "stderr.txt"
    wrapper = folder / "wrapper.html"
    with HTTPServer(("127.0.0.1", 0), Listener) as server, said.open("w") as stderr:
        Thread(target=server.serve_forever, daemon=True).start()
        text = WRAPPER.format(wanted=json.dumps(wanted), measure=measure, port=server.server_port)
        wrapper.write_text(text, encoding="utf-8")
        own = f"--user-data-dir={folder / 'profile'}"
        with subprocess.Popen(
            [browser, *FLAGS, *flags, own, wrapper.as_uri()],
            stderr=stderr,
            start_new_session=True,
        ) as process:
            try:
                answer = answers.get(timeout=240)
            except Empty:
                answer = b""
            finally:
                # the browser is a script that starts another process, on some systems
                os.killpg(process.pid, signal.SIGTERM)
        server.shutdown()
    complaints = said.read_text(encoding="utf-8", errors="replace")
    assert answer, complaints
    return json.loads(answer), complaints


def _results() -> tuple[VehicleResults, DayResults]:
    """Return the synthetic vehicle with two trial days, and the later of them."""
    results = _module("synthetic_records").full_results()
    trials = _module("test_trial_pages")
    day = trials.day(results, 15.0, 10.2)
    runs = {"2026-05-03": "heave-steps", "2026-05-04": "zig-zag"}
    links = tuple(
        TrialDayLink(
            name=name,
            title=f"Trial day {name}",
            line="1 run; no warnings",
            href=f"trials/{name}.html",
            runs=((f"{run}: 60 s; depth to the bottom and back", f"runs/{run}.html"),),
            parameters=(trials.parameter(value),),
        )
        for (name, run), value in zip(runs.items(), (10.2, 15.0), strict=True)
    )
    return type(results)(**{**results.__dict__, "trials": links}), day


def _from_index(day: TrialDayLink) -> TrialDayLink:
    runs = tuple((label, f"synthetic/{address}") for label, address in day.runs)
    return TrialDayLink(day.name, day.title, day.line, f"synthetic/{day.href}", runs)


def _design(folder: Path) -> Any:  # noqa: ANN401 - one of three records
    path = folder / "pilgrim.yaml"
    path.write_bytes(design_example("balance", "pilgrim").read_bytes())
    return compute_design(DesignRequest("balance", path))


def _module(name: str) -> ModuleType:
    """Load a module of records that stands beside the unit tests of the pages."""
    folder = Path(__file__).parents[1] / "unit/report"
    known = f"{name}_for_browser"
    if known in sys.modules:
        return sys.modules[known]
    spec = importlib.util.spec_from_file_location(known, folder / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[known] = module
    spec.loader.exec_module(module)
    return module
