"""Still pictures as inline SVG."""

import re

import numpy as np
import pytest

from pipeline.reader_language import use
from pipeline.report import plotting
from pipeline.report.panels import Axis, Panel, Trace
from pipeline.report.zoomable import zoomable_figure

X = np.linspace(0.0, 2.0, 9)


def draw(name: str = "a", *, x_axis: Axis | None = None, **more: object) -> str:
    values = np.array([0.0, 0.25, np.nan, 1.0, np.nan, 1.5, 2.0, 3.0, 4.0])
    bars = np.array([values - 0.1, values + 0.1])
    curves = (
        Trace("<points>", X, values, plotting.BLUE, "points", bars=bars, end="end"),
        Trace("curve", X, values, plotting.ORANGE, band=bars),
    )
    panel = Panel("y  [N]", curves, band=0.5, limits=(3.0,), **more)  # type: ignore[arg-type]
    said = 'with "quotes" & <tags>'
    return str(zoomable_figure(name, "", said, [panel], x_label="$x$  [m]", x_axis=x_axis).svg)


def texts(picture: str) -> list[str]:
    return re.findall(r"<text[^>]*>([^<]*)</text>", picture)


def test_a_picture_is_the_same_each_time_and_carries_no_date() -> None:
    assert draw() == draw()
    assert not re.search(r"date|<metadata|<style|nan", draw(), re.IGNORECASE)


def test_a_picture_is_the_same_whatever_was_drawn_before() -> None:
    plotting._drawing.cache_clear()
    first = draw()
    draw("b", x_axis=Axis(ends=(5.0, -5.0)), y_range=(7.0, 6.0))
    draw("c", log=True)
    with pytest.raises(TypeError):
        plotting.draw("d", "", 100.0, lambda figure: plotting.axes_at(figure, 50, 9, 90, "x"))  # type: ignore[arg-type]
    assert draw() == first
    plotting._drawing.cache_clear()
    assert draw() == first


def test_a_picture_says_what_it_shows_and_names_axes_curves_and_round_values() -> None:
    found = texts(draw())
    assert {"y  [N]", "$x$  [m]", "&lt;points&gt;", "curve", "end"} < set(found)
    assert {"0.0", "0.5", "1.0", "2", "4"} < set(found)
    assert 'aria-label="with &#34;quotes&#34; &amp; &lt;tags&gt;"' in draw()


def test_ids_are_the_pictures_own_and_every_reference_is_met() -> None:
    first, second = draw("a"), draw("b")
    ids = set(re.findall(r' id="([^"]+)"', first))
    assert ids == set(re.findall(r'(?:href="|url\()#([^")]+)', first))
    assert ids
    assert not ids & set(re.findall(r' id="([^"]+)"', second))


def test_a_value_that_is_not_a_number_breaks_the_line() -> None:
    (curve,) = (
        one
        for one in re.findall(r'<path d="([^"]*)"[^>]*stroke: #e69f00', draw())
        if one.count("L") > 3
    )
    assert curve.count("M") == 3


def test_what_lies_beyond_is_cut_at_the_frame() -> None:
    picture = draw(x_axis=Axis(ends=(0.0, 1.0)), y_range=(0.0, 1.0))
    curves = re.findall(r"<path[^>]*stroke: #(?:e69f00|0072b2)[^>]*>", picture, re.DOTALL)
    cut = [one for one in curves if "clip-path" in one]
    assert len(cut) >= 2
    (box,) = re.findall(r"<clipPath[^>]*>\s*<rect ([^>]*)/>", picture)
    left, top, wide, tall = (
        float(re.search(rf'\b{one}="([\d.]+)"', box)[1])  # type: ignore[index]
        for one in ("x", "y", "width", "height")
    )
    assert left > 40
    assert left + wide < plotting.WIDTH
    width, height = map(float, re.findall(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', picture)[0])
    assert width == pytest.approx(plotting.WIDTH, abs=0.01)
    assert top + tall < height - 20
    assert "end" not in texts(picture)  # its point is outside


def test_a_logarithmic_axis_has_plain_numbers_and_leaves_out_what_it_cannot_show() -> None:
    found = texts(draw(log=True))
    assert "1" in found
    assert not [one for one in found if re.search(r"\de|10\^", one)]


def test_names_stand_in_the_place_of_numbers() -> None:
    found = texts(draw(x_axis=Axis(names=("upper thruster", "", "lower"))))
    assert {"upper thruster", "lower"} < set(found)
    assert "0.5" not in found


def test_decimals_in_another_language() -> None:
    use("ru")
    try:
        assert {"0,5", "1,0"} < set(texts(draw()))
    finally:
        use("en")


def test_ordered_colours_are_distinct_and_grow_lighter() -> None:
    def lightness(colour: str) -> float:
        red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    shades = [lightness(colour) for colour in plotting.ordered_colours(12)]
    assert shades == sorted(shades)
    assert len(set(shades)) == 12
