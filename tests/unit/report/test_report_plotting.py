"""Figures as inline SVG."""

import re

from pipeline.report import plotting


def draw(name: str) -> str:
    def paint(figure) -> None:  # noqa: ANN001 - matplotlib is imported late
        axes = figure.subplots()
        axes.plot([0, 1, 2], [0, 1, 4], "o", label="points")
        axes.scatter(range(5), range(5), rasterized=True)
        axes.set(xlabel="x  [m]", ylabel="y  [N]", xlim=(0, 1))
        figure.legend(*axes.get_legend_handles_labels())

    return str(plotting.draw(name, 'with "quotes" & <tags>', paint))


def test_svg_is_the_same_each_time_and_carries_no_date() -> None:
    assert draw("a") == draw("a")
    assert "date" not in draw("a").lower()
    assert "<metadata" not in draw("a")


def test_ids_are_the_figures_own_and_every_reference_is_met() -> None:
    first, second = draw("a"), draw("b")
    ids = set(re.findall(r' id="([^"]+)"', first))
    used = set(re.findall(r'(?:href="|url\()#([^")]+)', first))
    assert used
    assert used == ids
    assert not ids & set(re.findall(r' id="([^"]+)"', second))


def test_description_is_escaped() -> None:
    assert 'aria-label="with &#34;quotes&#34; &amp; &lt;tags&gt;"' in draw("a")


def test_ordered_colours_are_distinct_and_grow_lighter() -> None:
    def lightness(colour: str) -> float:
        red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    shades = [lightness(colour) for colour in plotting.ordered_colours(12)]
    assert shades == sorted(shades)
    assert len(set(shades)) == 12
