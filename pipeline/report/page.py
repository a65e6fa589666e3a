"""What every page is made of: head, first screen, chapters, what is folded, what is not there."""

import re
from dataclasses import dataclass

from markupsafe import Markup

from pipeline.language import translate
from pipeline.records.glance import Glance, Light
from pipeline.report.blocks import Figure, Paragraph, Section
from pipeline.report.html import render

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
    notes: tuple[Paragraph, ...] = ()
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
    if glance.fly_next:
        lines.append(f"  {translate('To fly next')}: {translate(glance.fly_next)}")
    if glance.last_advice:
        lines.append(f"  {translate('The last advice')}: {translate(glance.last_advice)}")
    return "\n".join(lines)
