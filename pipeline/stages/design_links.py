"""Where the pages of design calculations are, and what the index says of them."""

import html
import re
from pathlib import Path

from pipeline.report.html import safe_link

#: The title stands before everything that is long.
_HEAD = 4000
_TITLE = re.compile(r"<title>(.{1,300}?)</title>", re.DOTALL)


def design_links(reports: Path) -> tuple[tuple[str, str], ...]:
    """Return label and address, from `reports`, of each page of a design calculation, by title."""
    found = []
    for page in reports.glob("design/*.html"):
        with page.open(encoding="utf-8", errors="replace") as text:
            title = _TITLE.search(text.read(_HEAD))
        label = html.unescape(title[1]).strip() if title else page.stem
        found.append((label, safe_link(page.relative_to(reports).as_posix())))
    return tuple(sorted(found))
