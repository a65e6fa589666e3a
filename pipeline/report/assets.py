"""The scripts that pages with zoom share: one copy beside all of them."""

from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from pipeline.errors import InputError, Place
from pipeline.report.html import put_in_place
from pipeline.report.links import address_from

LIBRARY, ZOOM, FILTER = "plotly.min.js", "zoom.js", "filter.js"


def write_assets(folder: Path) -> None:
    """Write the plotting library and our scripts into a folder, unless they are there already.

    Parameters
    ----------
    folder : Path
        E.g. ``reports/assets``; pages refer to it by a relative address.

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
    """Write the scripts for a page; return the folder's address from there, none without one.

    Raises
    ------
    InputError
        As `write_assets`.
    """
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
