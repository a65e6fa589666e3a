"""The pages in a real browser: no complaints, nothing wider than the screen, an order to hear."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from headless_browser import browse
from report_site import KINDS

WIDTHS = (360, 1440)
#: Figures of each page; of these, those that can be zoomed.
FIGURES = {
    "index": (0, 0), "vehicle": (10, 10), "run": (10, 10), "trial": (1, 1), "diagnosis": (5, 5),
    "design": (3, 3),
}  # fmt: skip

#: Of a fault, before the name.
SIGN = "\N{HEAVY MULTIPLICATION X}"

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
    crossed: lives.flatMap((one) => {
      const found = (what) => [...one.querySelectorAll(what)];
      const boxes = (what) => found(what).map((own) => own.getBoundingClientRect());
      const met = (a, b) =>
        a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom && b.top < a.bottom;
      const ticks = boxes(".ytick text");
      const titles = boxes('[class*="ytitle"]');
      return titles.filter((a) => ticks.some((b) => met(a, b))).map(() => one.parentElement.id);
    }),
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


#: Screens of a table and of a telephone, and the pages that begin with what is the matter.
SCREENS = {1440: 900, 400: 800}
FIRST = ("vehicle", "run", "trial", "diagnosis")
PLACE = """
const measure = async (view) => {
  const page = view.document;
  const told = [...page.querySelectorAll(".told > *, .told li")];
  const figure = page.querySelector(".glance figure svg.plot");
  return {
    lowest: Math.max(...told.map((one) => one.getBoundingClientRect().bottom)),
    picture: figure ? figure.getBoundingClientRect().top : 0,
    wide: page.documentElement.scrollWidth,
    sign: page.querySelector(".told .light").textContent.trim().split(/\\s+/),
  };
};
"""


@pytest.fixture(scope="module")
def placed(
    browser: str, pages: dict[str, Path], tmp_path_factory: pytest.TempPathFactory
) -> dict[str, Any]:
    """Where the last line of each first screen ends."""
    wanted = [
        {"name": f"{kind} {width}", "width": width, "address": pages[kind].as_uri()}
        for kind in FIRST
        for width in SCREENS
    ]
    return browse(browser, wanted, PLACE, tmp_path_factory.mktemp("place"))[0]


@pytest.mark.parametrize("kind", FIRST)
@pytest.mark.parametrize("width", SCREENS)
def test_what_is_the_matter_fits_one_screen(placed: dict[str, Any], kind: str, width: int) -> None:
    found = placed[f"{kind} {width}"]
    assert found["lowest"] <= SCREENS[width]
    assert found["picture"] <= SCREENS[width]
    assert found["wide"] <= width
    assert len(found["sign"]) == 2, "a sign and a word beside the colour"


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
    return browse(browser, wanted, LAYOUT, tmp_path_factory.mktemp("layout"))


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
    assert found["crossed"] == [], "a label of an axis over its numbers"
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
    measured, complaints = browse(browser, wanted, FILTER, tmp_path)
    found = measured["i"]
    assert "CONSOLE" not in complaints
    shown, said = found["heave 2026-05-03"]
    # the run, under its day and its vehicle
    assert [one.split()[0] for one in shown] == ["Synthetic", SIGN, SIGN]
    assert said.startswith("1 of ")
    assert found["RAFT"][0] == ["tether (80 %);"]
    assert found["no such thing"][0] == []
    assert found[""][0] == found["all"]
