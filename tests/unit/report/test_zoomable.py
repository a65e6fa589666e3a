"""Curves with zoom: a still picture without scripts, peaks kept, nothing smuggled in, small."""

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest

from pipeline.errors import InputError
from pipeline.report import html
from pipeline.report.panels import Panel, Resolution, Trace, thinned
from pipeline.report.plotly_data import plotly_figure
from pipeline.report.sections.diagnosis_curves import resolution
from pipeline.report.sections.diagnosis_gap import MOST_DRAWN
from pipeline.report.zoomable import zoomable_figure
from pipeline.types import FloatArray

EVIL = '</script><img src=x onerror="alert(1)">&<b>'


def unpacked(packed: dict[str, str]) -> FloatArray:
    return np.frombuffer(base64.b64decode(packed["bdata"]), "<f4").astype(float)


def peaked() -> tuple[FloatArray, FloatArray]:
    time_s = np.arange(30_000) / 50.0
    values = np.sin(time_s)
    values[12_345], values[12_346] = 9.0, -9.0
    values[20_000:24_000] = np.nan
    return time_s, values


def test_peaks_and_gaps_survive_in_the_data() -> None:
    time_s, values = peaked()
    trace = plotly_figure([Panel("u", (Trace("measured", time_s, values, "#000"),))], "t", 200)
    shown_s = unpacked(trace["data"][0]["x"])
    shown = unpacked(trace["data"][0]["y"])
    assert shown.size <= 600
    assert (np.nanmax(shown), np.nanmin(shown)) == (9.0, -9.0)
    assert shown_s[np.nanargmax(shown)] == pytest.approx(12_345 / 50, abs=1e-3)
    assert np.isnan(shown[(shown_s > 405) & (shown_s < 475)]).all()


def test_the_still_picture_keeps_the_peaks_too() -> None:
    time_s, values = peaked()
    figure = zoomable_figure(
        "f", "See.", "Curve.", [Panel("u", (Trace("m", time_s, values, "#123456"),))],
        x_label="t", resolution=Resolution(still=50, zoom=100),
    )  # fmt: skip
    svg = str(figure.svg)
    assert 'role="img"' in svg
    assert 'aria-label="Curve."' in svg
    assert "<script" not in svg
    curve = max(re.findall(r'<path d="([^"]*)"', svg), key=len)
    heights = [float(y) for y in re.findall(r"[ML] [\d.-]+ ([\d.-]+)", curve)]
    inner = np.sort(heights)[2:-2]
    # two readings of thirty thousand stand far out of the sine
    assert min(heights) < inner.min() - 20
    assert max(heights) > inner.max() + 20


def test_windows_stay_apart_where_points_are_left_out() -> None:
    time_s = np.arange(3_000) / 50.0
    values = np.sin(20.0 * time_s)
    values[::300] = np.nan
    _, shown = thinned(time_s, values, 60)
    assert np.isnan(shown).sum() == 9
    assert shown.size <= 250


def test_texts_cannot_leave_the_data_block_or_become_markup() -> None:
    x = np.arange(4.0)
    figure = zoomable_figure(
        "f", EVIL, EVIL, [Panel(EVIL, (Trace(EVIL, x, x, "#000"),))], x_label=EVIL
    )
    block = str(figure.zoom)
    inside = block.removeprefix('<script type="application/json" class="zoom-data">')
    inside = inside.removesuffix("</script>")
    assert "<" not in inside
    assert "&" not in inside
    # plotly.js reads a few tags in its texts: they are escaped once more
    assert "<" not in json.loads(inside)["data"][0]["name"]
    assert "<img" not in str(figure.svg)


def test_curves_of_one_name_share_a_line_of_the_legend() -> None:
    x = np.arange(4.0)
    both = [Panel(label, (Trace("before", x, x, "#000"),), band=1.0) for label in "ab"]
    found = plotly_figure(both, "t")
    assert [one["showlegend"] for one in found["data"]] == [True, False]
    assert [one["yaxis"] for one in found["data"]] == ["y", "y2"]
    upper, lower = found["layout"]["yaxis"]["domain"], found["layout"]["yaxis2"]["domain"]
    assert lower[0] == 0.0 < lower[1] < upper[0] < upper[1] == 1.0


def test_what_is_written_at_an_end_stands_in_both_drawings() -> None:
    x, values = np.arange(4.0), np.array([1.0, 2.0, 3.0, np.nan])
    figure = zoomable_figure(
        "f", "", "", [Panel("u", ()), Panel("v", (Trace("", x, values, "#000", end="code 80"),))],
        x_label="t",
    )  # fmt: skip
    assert ">code 80<" in str(figure.svg)
    inside = str(figure.zoom).partition(">")[2].removesuffix("</script>")
    (end,) = json.loads(inside)["layout"]["annotations"]
    assert [end[key] for key in ("text", "x", "y", "yref")] == ["code 80", 2.0, 3.0, "y2"]


@pytest.mark.parametrize("count", [1, 12, MOST_DRAWN])
def test_a_page_of_many_long_figures_stays_below_3_mb(count: int) -> None:
    generator = np.random.default_rng(0)
    x = np.arange(9_000) / 50.0

    def traces(names: str) -> tuple[Trace, ...]:
        return tuple(Trace(name, x, generator.standard_normal(9_000), "#000") for name in names)

    panels = [Panel("u", traces("abc")), Panel("e", traces("bc"))]
    detail = resolution(count)
    one = zoomable_figure("f", "", "", panels, x_label="t", resolution=detail)
    assert count * (len(one.svg) + len(one.zoom)) < 2.5e6


def test_scripts_are_written_once_and_fetch_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(html, "_library", lambda: b"// library")
    folder = tmp_path / "reports" / "assets"
    html.write_assets(folder)
    before = {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert set(before) == {"plotly.min.js", "zoom.js", "filter.js"}
    html.write_assets(folder)
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir()} == before
    (folder / "plotly.min.js").write_bytes(b"half")
    html.write_assets(folder)
    assert (folder / "plotly.min.js").read_bytes() == b"// library"
    script = (folder / "zoom.js").read_text()
    assert not re.search(r"https?:|fetch\(|XMLHttpRequest|eval\(", script)
    page = tmp_path / "reports" / "v" / "diagnoses" / "a" / "index.html"
    assert html.placed(folder, page) == "../../../assets"
    assert html.placed(None, page) == ""


def test_a_folder_that_cannot_be_written_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(html, "_library", lambda: b"// library")
    (tmp_path / "assets").write_text("a file")
    with pytest.raises(InputError, match="scripts of the pages cannot be written"):
        html.write_assets(tmp_path / "assets")


def test_a_library_that_is_missing_is_asked_for_where_there_is_no_makefile(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(html, "find_spec", lambda _: None)
    with pytest.raises(InputError, match="pip install plotly"):
        html._library()


def test_the_library_comes_with_its_package() -> None:
    pytest.importorskip("plotly", reason="plotly is not installed")
    content = html._library()
    assert 1e6 < len(content) < 8e6
    assert b"Licensed under the MIT license" in content[:400]
