"""Addresses of links, relative to the page that they stand on."""

import os
from pathlib import Path
from urllib.parse import quote


def safe_link(path: str) -> str:
    """Quote a relative path for an address; a colon is quoted too, so no scheme can be smuggled.

    >>> safe_link("../processed/mmt300/firmware/mmt300_thruster.c")
    '../processed/mmt300/firmware/mmt300_thruster.c'
    >>> safe_link("javascript:alert(1)")
    'javascript%3Aalert%281%29'
    """
    return quote(path, safe="/._-")


def address_from(page: Path, file: Path | str) -> str:
    """Return the address of a file or folder relative to a page, quoted.

    >>> address_from(Path("reports/boat/runs/a.html"), "reports/index.html")
    '../../index.html'
    """
    return safe_link(Path(os.path.relpath(file, page.parent)).as_posix())
