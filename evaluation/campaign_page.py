"""What pages of campaigns share: rates, pictures, and the part of a page that a command writes."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.blind.rates import Rate
from pipeline.blind.score import Confusion
from pipeline.campaign.campaign import CASES_FILE, HEADER_FILE, CampaignResult, S_co, read_lines
from pipeline.errors import InputError, Place, reason
from pipeline.provenance import write_atomically
from pipeline.report.plotting import BLUE, INK, ORANGE, SOFT, WIDTH, axes_at, draw

if TYPE_CHECKING:
    import matplotlib.figure


def stored(
    folder: Path, score: Callable[[Sequence[Mapping[str, Any]]], S_co]
) -> tuple[dict[str, Any], str, CampaignResult[S_co]]:
    """Read a campaign: its header, the option that asks for its cases, and what came out."""
    header = json.loads((folder / HEADER_FILE).read_text(encoding="utf-8"))
    done = sorted(read_lines(folder / CASES_FILE), key=lambda line: line["number"])
    numbers = [line["number"] for line in done]
    asked = f"--cases {len(numbers)}"
    if numbers != list(range(len(numbers))):
        asked = " ".join(f"--only {one}" for one in numbers)
    lines = tuple(line for line in done if "score" in line)
    not_made = len(done) - len(lines)
    result = CampaignResult(
        header["schema"], score(lines), lines, len(done), not_made, folder, header["code"]
    )
    return header, asked, result


def write_block(page: Path, name: str, title: str, text: str) -> None:
    """Put a text between ``<!-- name -->`` and ``<!-- end of name -->`` of a Markdown page.

    A page that is not there is begun, with a title.

    Raises
    ------
    InputError
        When the page has no such marks, or cannot be read or written.
    """
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    try:
        there = page.read_text(encoding="utf-8")
    except FileNotFoundError:
        there = f"# {title}\n\n{begin}\n{end}\n"
    except (OSError, UnicodeDecodeError) as error:
        raise InputError.at(
            Place(str(page)),
            f"the page cannot be read: {reason(error)}.",
            remedy="Give another page.",
        ) from None
    before, mark, rest = there.partition(begin)
    _, closing, after = rest.partition(end)
    if not (mark and closing):
        raise InputError.at(
            Place(str(page)),
            f"the page has no place for {name}.",
            expected=f"a line {begin} and, below it, a line {end}.",
            remedy="Put the two lines where the result is to stand, or give a page that is not "
            "there yet.",
        )
    write_atomically(page, f"{before}{begin}\n{text.strip()}\n{end}{after}")


def write_csv(path: Path, rows: Iterable[Sequence[str]]) -> None:
    """Write what is too long for a page beside it: comma-parted, whole or not at all."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    write_atomically(path, text.getvalue())


def write_pictures(page: Path, name: str, rates: Iterable[Rate], table: Confusion) -> None:
    """Draw rates that have a goal, and truth against answer, into `images` beside a page."""
    rows = [
        (f"{one.question}, {one.stratum}", one.share, one.low, one.high, one.met)
        for one in rates
        if one.share is not None and one.low is not None and one.high is not None
        if one.met is not None
    ]
    images = page.parent / "images"
    confusion = confusion_picture(table.truths, table.answers, table.counts)
    write_atomically(images / f"{name}-confusion.svg", confusion)
    write_atomically(images / f"{name}-rates.svg", rates_picture(rows))


def goal_table(rates: Iterable[Rate], title: str = "rate (95 %)", digits: int = 0) -> list[str]:
    """Tabulate rates with their bounds and goals."""
    rows = [
        f"| {one.stratum} | {one.question} | {_cell(one, digits)} | {one.goal} |"
        for one in rates
        if one.cases
    ]
    return [f"| cases | question | {title} | goal |", "|---|---|---|---|", *rows, ""]


def write_rates(page: Path, rates: Iterable[Rate]) -> list[str]:
    """Write rates by band, stratum and vehicle beside a page; returns the line that leads there."""
    table = page.with_name(f"{page.stem}_rates.csv")
    head = ("question", "cases are", "yes", "of", "share", "low", "high", "goal", "met")
    rows = [
        (
            one.question,
            one.stratum,
            str(one.yes),
            str(one.cases),
            *_bounds(one),
            one.goal,
            _met(one),
        )
        for one in rates
        if one.cases
    ]
    write_csv(table, [head, *rows])
    return [f"All rates, by size, stratum and vehicle: [{table.name}]({table.name}).", ""]


def _bounds(one: Rate) -> list[str]:
    return ["" if value is None else f"{value:.3f}" for value in (one.share, one.low, one.high)]


def _met(one: Rate) -> str:
    return {None: "", True: "met", False: "missed"}[one.met]


def _cell(one: Rate, digits: int) -> str:
    text = f"{one.yes} of {one.cases}"
    if one.share is not None and one.low is not None and one.high is not None:
        share = f"{100 * one.share:.{digits}f}"
        text += f" = {share} % ({100 * one.low:.0f} to {100 * one.high:.0f} %)"
    return text + {None: "", True: ", met", False: ", **missed**"}[one.met]


def confusion_picture(
    truths: Sequence[str], answers: Sequence[str], counts: Sequence[Sequence[int]]
) -> str:
    """Draw the confusion matrix as SVG; each row is shaded by its own shares."""
    table = np.array(counts, float).reshape(len(truths), len(answers))
    shares = table / np.maximum(table.sum(axis=1, keepdims=True), 1.0)
    left, top, cell = 12.0 + 3.2 * max(map(len, truths)), 8.0, 9.4
    low = top + cell * len(truths)

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = axes_at(figure, left, top, WIDTH - 4.0, low, "answer", "truth")
        axes.pcolormesh(shares, cmap="Blues", vmin=0.0, vmax=1.0)
        for i, j in zip(*np.nonzero(table), strict=True):
            axes.text(
                j + 0.5, i + 0.5, f"{table[i, j]:.0f}", ha="center", va="center", fontsize=5,
                color="white" if shares[i, j] > 0.6 else INK,
            )  # fmt: skip
        axes.set_xticks(np.arange(len(answers)) + 0.5, answers, rotation=90, fontsize=5.5)
        axes.set_yticks(np.arange(len(truths)) + 0.5, truths, fontsize=5.5)
        axes.yaxis.set_label_coords((12.0 - left) / (WIDTH - left), 0.5)
        axes.set_ylim(len(truths), 0)
        axes.grid(visible=False)

    height = low + 20.0 + 3.2 * max(map(len, answers))
    return draw("confusion", "Which answer each truth got.", height, paint)


def rates_picture(rows: Sequence[tuple[str, float, float, float, bool]]) -> str:
    """Draw rates with their bounds as SVG, one below the other; a missed goal is orange.

    A row is what it is, the rate, its lower and upper bound, and whether its goal is met.
    """
    names, share, low, high, met = zip(*rows, strict=True) if rows else ((),) * 5
    levels, whole = 10.0 * np.arange(len(rows)) + 6.0, 4.0 + 10.0 * max(len(rows), 1)
    left = min(12.0 + 3.0 * max(map(len, names), default=0), 0.6 * WIDTH)

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = axes_at(figure, left, 4.0, WIDTH - 8.0, whole + 4.0, "rate with 95 % bounds")
        axes.hlines(levels, low, high, color=SOFT, lw=1.2)
        axes.scatter(share, levels, 16, [BLUE if one else ORANGE for one in met], zorder=3, lw=0)
        axes.set_yticks(levels, names, fontsize=5)
        axes.set(xlim=(-0.02, 1.02), ylim=(whole, 0.0))
        axes.grid(visible=False, axis="y")

    return draw("rates", "Rates with their bounds.", whole + 34.0, paint)
