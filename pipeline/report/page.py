"""What every page is made of, and ``reports/index.html``, which leads to all of them."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from markupsafe import Markup

from pipeline.language import translate
from pipeline.records.base import Glance, Light, PageFile
from pipeline.report.blocks import Figure, Section, Text
from pipeline.report.glance import rank
from pipeline.report.html import FILTER, placed, render, write_page
from pipeline.report.numbers import plural

Labels = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Page:
    """One page of the reports.

    Sections in the open come first, folded ones behind them; of one that is not available the page
    says why in its last line. The same parts give the same text.
    """

    title: str
    under: tuple[str, ...]
    """Lines below the title."""
    sections: tuple[Section, ...]
    glance: Glance | None = None
    """What is told first."""
    word: str = ""
    """Beside the light, in place of the light's own word."""
    picture: Figure | None = None
    """Shows it."""
    notes: tuple[Text, ...] = ()
    data_note: str = ""
    tab: str = ""
    """Name of the window, where it says more than the title."""
    crumbs: Labels = ()
    """The way back: label and address, relative to the page and quoted."""
    assets: str = ""
    """Address of the folder with the scripts; without it no figure can be zoomed."""

    def html(self) -> str:
        """Return the page as HTML text."""
        there = [one for one in self.sections if one.is_there]
        return render(
            "chapters.html.j2",
            page=self,
            told=first_screen(self.glance, self.word),
            sections=sorted(there, key=lambda one: one.folded),
            absent=[f"{one.title}: {one.reason}" for one in self.sections if not one.is_there],
            assets=self.assets,
        )


_BEGIN, _END = "<!--glance-->", "<!--/glance-->"
_BLOCK = re.compile(f"{re.escape(_BEGIN)}.*?{re.escape(_END)}", re.DOTALL)
_SPARE = "<!--spare-->"
_PICTURE = re.compile("<!--picture-->.*?<!--/picture-->", re.DOTALL)
#: Light -> its sign and word, so that no colour has to be seen.
SIGNS: dict[Light, tuple[str, str]] = {
    "red": ("\N{HEAVY MULTIPLICATION X}", "Fault"),
    "amber": ("\N{BLACK UP-POINTING TRIANGLE}", "Look"),
    "green": ("\N{HEAVY CHECK MARK}", "No fault"),
}


def first_screen(glance: Glance | None, word: str = "") -> Markup:
    """Return the first screen's text between its marks; nothing without a glance.

    A word takes the place of that of the light, on a page that judges no vehicle.
    """
    if glance is None:
        return Markup("")
    sign, own = SIGNS[glance.light]
    text = render("first_screen.html.j2", glance=glance, sign=sign, word=word or own)
    return Markup(f"{_BEGIN}\n{text}{_END}")  # noqa: S704 - the template has escaped it


def with_glance(page: str, glance: Glance, picture: Figure | None = None) -> str:
    """Put another glance in the place of a page's own, and another picture where there is one."""
    told = _BLOCK.sub(lambda _: str(first_screen(glance)), page, count=1)
    if picture is None:
        return told
    drawn = render("picture.html.j2", picture=picture)
    former = _PICTURE.search(told)
    if former is None:
        return told
    told = _PICTURE.sub(lambda _: drawn, told, count=1)
    # what stood there goes where the page keeps a place for it
    return told.replace(_SPARE, former[0], 1)


def glance_text(name: str, glance: Glance) -> str:
    """Say first what is the matter, then what to do, what to fly and what became of the advice.

    >>> print(glance_text("boat", Glance(light="green", matter="Sound.", short="sound")))
    boat: ✔ No fault. Sound.
      To do: nothing.
    """
    sign, word = SIGNS[glance.light]
    lines = [f"{name}: {sign} {translate(word)}. {translate(glance.matter)}"]
    for number, one in enumerate(glance.do, start=1):
        command = f"  {one.command}" if one.command else ""
        lines.append(f"  {number}. {translate(one.text)}{command}")
    if not glance.do:
        lines.append(f"  {translate('To do: nothing.')}")
    more = (("To fly next", glance.fly_next), ("The last advice", glance.last_advice))
    lines += [f"  {translate(name)}: {translate(text)}" for name, text in more if text]
    return "\n".join(lines)


def counted(errors: int, warnings: int, failed_checks: int = 0, not_computed: int = 0) -> str:
    """Say in one line how a page stands.

    >>> counted(0, 2, 1)
    '2 warnings, 1 failed check'
    """
    parts = [
        (errors, plural(errors, "error")),
        (warnings, plural(warnings, "warning")),
        (failed_checks, plural(failed_checks, "failed check")),
        (not_computed, f"{plural(not_computed, 'result')} not computed"),
    ]
    return ", ".join(text for count, text in parts if count) or "no warnings"


def write_index(
    pages: Sequence[PageFile], path: Path, diagnosed: Mapping[str, Labels] = MappingProxyType({}),
    *, designs: Labels = (), earlier: Labels = (), assets: Path | None = None,
) -> None:  # fmt: skip
    """Write the index, with the vehicles that ask for attention first.

    `diagnosed` gives the diagnoses of each vehicle, the latest first; `earlier` are vehicles that
    are gone or could not be run: their pages are left as they were. Without `assets`, the folder of
    the scripts, the list cannot be filtered. Raises as `write_page`.
    """
    known = {one.name for one in pages}
    text = render(
        "index.html.j2",
        # in the order in which vehicles, and the days of each, ask for attention
        pages=[
            one.model_copy(update={"days": sorted(one.days, key=lambda day: rank(day.glance))})
            for one in sorted(pages, key=lambda one: rank(one.glance))
        ],
        counted=counted,
        signs=SIGNS,
        diagnosed=diagnosed,
        without_page=sorted((name, own) for name, own in diagnosed.items() if name not in known),
        designs=designs,
        earlier=earlier,
        assets=placed(assets, path),
        scripts=(FILTER,),
    )
    write_page(text, path)
