"""Still pictures as inline SVG."""

import numpy as np
import pytest

from pipeline.reader_language import use
from pipeline.report import plotting
from pipeline.report.plotting import Canvas, Frame, Scale, path


def draw() -> str:
    canvas = Canvas(100.0)
    frame = Frame(canvas, Scale(0.0, 2.0, 40.0, 300.0), Scale(0.0, 4.0, 80.0, 5.0))
    x = np.array([0.0, 1.0, 2.0])
    frame.inside.line(path(frame.x.at(x), frame.y.at(x**2)), plotting.BLUE)
    frame.close("<x>  [m]", "y  [N]")
    return str(canvas.finish('with "quotes" & <tags>'))


def test_a_picture_has_its_curve_where_the_scales_say_and_is_cut_at_the_frame() -> None:
    picture = draw()
    assert picture == draw()
    assert '<path d="M40 80L170 61.2L300 5"' in picture
    assert '<svg x="40" y="5" width="260" height="75" viewBox="40 5 260 75">' in picture


def test_texts_are_escaped() -> None:
    assert 'aria-label="with &#34;quotes&#34; &amp; &lt;tags&gt;"' in draw()
    assert "&lt;x&gt;" in draw()


@pytest.mark.parametrize(
    ("low", "high", "texts"),
    [
        (0.0, 127.0, ["0", "50", "100"]),
        (-0.03, 0.05, ["\u22120.02", "0.00", "0.02", "0.04"]),
        (5.0, -5.0, ["\u22125", "0", "5"]),
        (1690.2, 1690.3, ["1690.20", "1690.25", "1690.30"]),
        (3.0e-7, 9.0e-7, ["4.00\u00b710\u207b\u2077"]),
    ],
)
def test_ticks_are_round_and_at_least_two(low: float, high: float, texts: list[str]) -> None:
    ticks = Scale(low, high, 0.0, 1.0).ticks(4)
    assert 2 <= len(ticks) <= 5
    room = 1e-6 * abs(high - low)
    assert all(min(low, high) - room <= v <= max(low, high) + room for v, _ in ticks)
    assert [text for _, text in ticks][: len(texts)] == texts


def test_ticks_of_a_logarithm_and_of_another_language() -> None:
    assert [value for value, _ in Scale(0.15, 3.0, 0.0, 1.0, log=True).ticks(4)] == [
        0.2, 0.5, 1.0, 2.0,
    ]  # fmt: skip
    use("ru")
    try:
        assert Scale(0.0, 1.0, 0.0, 1.0).ticks(4)[1][1] == "0,5"
    finally:
        use("en")


def test_ordered_colours_are_distinct_and_grow_lighter() -> None:
    def lightness(colour: str) -> float:
        red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    shades = [lightness(colour) for colour in plotting.ordered_colours(12)]
    assert shades == sorted(shades)
    assert len(set(shades)) == 12
