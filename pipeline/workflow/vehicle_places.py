"""Where each vehicle lay: one whose raw folder was deleted is not listed in the index for ever.

Its results and pages are nobody's to delete but the user's. What goes is the receipt by which the
index knows a vehicle; it comes back with the vehicle. A vehicle may be run from any folder, so
where each was is remembered; two of one name in one place of results are told of.
"""

import json
from collections.abc import Sequence
from pathlib import Path

from pipeline.plan import VEHICLE_FILE, VehicleFolder, is_vehicle_name, processed_file
from pipeline.provenance import write_atomically

_MEMORY = "places.json"


def forget_gone(state: Path, out: Path, here: Sequence[VehicleFolder]) -> tuple[str, ...]:
    """Remove the receipts of vehicles that are not where they were, and the index that lists them.

    Parameters
    ----------
    state : Path
        Folder of the workflow's memory.
    out : Path
        The folder of ``processed/`` and ``reports/``.
    here : sequence of VehicleFolder
        The vehicles of this execution; their places are kept in mind.

    Returns
    -------
    tuple of str
        Names of the vehicles that went.
    """
    places = _remembered(state / _MEMORY) | {one.name: one.folder for one in here}
    gone = tuple(
        sorted(
            name for name, folder in places.items() if not _is_there(out / folder / VEHICLE_FILE)
        )
    )
    kept = {name: folder for name, folder in places.items() if name not in gone}
    for name in gone:
        (out / processed_file(name, "vehicle_page")).unlink(missing_ok=True)
    if gone:
        (out / "reports" / "index.html").unlink(missing_ok=True)
    text = json.dumps(kept, indent=1, sort_keys=True)
    if gone or text != _text(state / _MEMORY):
        write_atomically(state / _MEMORY, text)
    return gone


def taken_over(
    state: Path, out: Path, here: Sequence[VehicleFolder]
) -> tuple[tuple[str, str], ...]:
    """Vehicles whose results are those of a namesake in another raw folder, which is still there.

    To be asked before `forget_gone`, which remembers the new places. A folder that was moved or
    renamed is no namesake.

    Returns
    -------
    tuple of (str, str)
        Name, and the folder whose results are there.
    """
    places = _remembered(state / _MEMORY)
    return tuple(
        (one.name, places[one.name])
        for one in here
        if one.name in places
        and _is_there(out / places[one.name] / VEHICLE_FILE)
        and (out / one.folder).resolve() != (out / places[one.name]).resolve()
        and (out / "processed" / one.name).exists()
    )


def _is_there(path: Path) -> bool:
    """Tell whether a file exists; one behind a folder that may not be read counts as there."""
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    except OSError:
        return True
    return True


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, ValueError):
        return ""


def _remembered(path: Path) -> dict[str, str]:
    """Read the memory; without it, or with a broken one, no vehicle is missed."""
    try:
        body = json.loads(_text(path) or "{}")
    except (ValueError, RecursionError):
        return {}
    if not isinstance(body, dict):
        return {}
    return {
        name: folder
        for name, folder in body.items()
        if isinstance(folder, str) and is_vehicle_name(name)
    }
