"""What every page is made of: head, first screen, chapters, what is folded, what is not there."""

from dataclasses import dataclass

from pipeline.records.glance import Glance
from pipeline.report.blocks import Figure, Paragraph, Section
from pipeline.report.first_screen import first_screen
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
