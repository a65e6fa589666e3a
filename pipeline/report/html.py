"""Templates to text to file, and what lies beside the pages: addresses, scripts."""

import os
import re
from collections.abc import Callable
from functools import cache
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import quote

import jinja2
from markupsafe import Markup, escape

from pipeline.errors import InputError, Place, writing_remedy
from pipeline.language import ENGLISH, current, translate
from pipeline.language.numerals import UNITS
from pipeline.whole_file import whole_file

# only the symbols of the papers, and not inside a file's name: what is copied must stay right
_SYMBOL = re.compile(
    r"(?<![\w/\\.-])(?:(K)_([TMQFN]\d{0,2}i?|\d)|(T)_(max)|([FM])_([xyz])|(Π)_([xφψ])|(L)_([sb])"
    r"|(T)_([na]?[xyz]|[na])|(R)_([xyz])|(M)_(o)|(A)_([E0])|(p)_([0v]))"
    r"(?![\w/\\-]|\.\w)"
)
_POWER = re.compile(r"\b([xynNV])\^([0-9ij])")
_UNIT = re.compile(
    r"(?<=\d) (?=(?:%|N\b|mN\b|m/s|rpm\b|codes?\b|V\b|м?Н\b|м/с|об/мин|ед\.|В\b))|(?<=N) (?=m\b)"
)
_NO_BREAK = "\N{NO-BREAK SPACE}"


def symbols(text: str) -> Markup:
    """Translate and escape a text, set K_T0 with a subscript, keep numbers with their units.

    >>> symbols("K_T0 < 1 and T_max")
    Markup('K<sub>T0</sub> &lt; 1 and T<sub>max</sub>')
    """
    escaped = str(escape(translate(text)))
    escaped = _UNIT.sub(_NO_BREAK, escaped)
    escaped = _SYMBOL.sub(
        lambda own: "{}<sub>{}</sub>".format(*filter(None, own.groups())), escaped
    )
    return Markup(_POWER.sub(r"\1<sup>\2</sup>", escaped))  # noqa: S704 - escaped two lines above


def render(template: str, **context: object) -> str:
    """Fill a template; every value is escaped unless it is `Markup`."""
    text = _environment().get_template(template).render(language=current(), **context)
    return text.rstrip() + "\n"


def unit(cell: str) -> str:
    """Translate a cell that holds a unit; one letter says what it is only here.

    >>> unit("N")
    'N'
    """
    return cell if current() == ENGLISH else UNITS.get(cell, cell)


def write_page(text: str, path: Path) -> None:
    """Write a page so that a killed run leaves no half of it; raises as `put_in_place`."""
    put_in_place(text.encode(), path, lambda why: f"the report cannot be written: {why}.")


def put_in_place(content: bytes, path: Path, said: Callable[[str | None], str]) -> None:
    """Write a file, whole or not at all; `said` makes of the reason what is wrong otherwise."""
    try:
        with whole_file(path) as stream:
            stream.write(content)
    except OSError as error:
        raise InputError.at(
            Place(str(path)),
            said(error.strerror),
            expected="a folder with write permission and free space.",
            remedy=writing_remedy(
                error, "Free the folder, or choose another one with --out or --to."
            ),
        ) from None


@cache
def _environment() -> jinja2.Environment:
    root = files("pipeline.report")
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("pipeline.report", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["symbols"] = symbols
    environment.filters["t"] = translate
    environment.filters["unit"] = unit
    environment.globals["_"] = translate
    style = root.joinpath("style.css").read_text(encoding="utf-8")
    environment.globals["style"] = Markup(style)  # noqa: S704 - our own file
    return environment


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


def crumbs(
    page: Path, *after: tuple[str, Path | str], index: Path | str = "reports/index.html"
) -> tuple[tuple[str, str], ...]:
    """Return the way back from a page: label and address of the index and what lies between."""
    return tuple(
        (name, address_from(page, file)) for name, file in (("All vehicles", index), *after)
    )


LIBRARY, ZOOM, FILTER = "plotly.min.js", "zoom.js", "filter.js"


def write_assets(folder: Path) -> None:
    """Write the plotting library and our scripts into a folder, unless they are there already.

    Raises
    ------
    InputError
        If plotly is not installed, or the folder cannot be written to.
    """
    room = files("pipeline.report").joinpath("scripts")
    own = [(name, room.joinpath(name).read_bytes()) for name in (ZOOM, FILTER)]
    for name, content in ((LIBRARY, _library()), *own):
        target = folder / name
        if not (target.is_file() and target.read_bytes() == content):
            put_in_place(
                content, target, lambda why: f"the scripts of the pages cannot be written: {why}."
            )


def placed(folder: Path | None, page: Path) -> str:
    """Write the scripts for a page; return the folder's address from there, none without one."""
    if folder is None:
        return ""
    write_assets(folder)
    return address_from(page, folder)


def _library() -> bytes:
    # the file alone is used: importing the package would cost a second
    found = find_spec("plotly")
    places = found.submodule_search_locations if found is not None else None
    path = Path(next(iter(places))) / "package_data" / LIBRARY if places else None
    if path is None or not path.is_file():
        raise InputError.at(
            Place("plotly"),
            "the plotting library of the pages is not installed",
            expected="the Python package plotly",
            remedy="Install it: pip install plotly; in a clone of the repository run make.",
        )
    return path.read_bytes()
