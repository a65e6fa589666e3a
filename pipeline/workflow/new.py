"""``rig2sea new``: write the raw folder of a vehicle that is to be filled in."""

from pathlib import Path

from pipeline.bundled.new_vehicle import new_vehicle_files
from pipeline.errors import InputError, Place, Problem
from pipeline.plan import NAME_EXPECTED, UsageError, is_vehicle_name


def write_new_vehicle(name: str, raw: Path) -> list[Path]:
    """Write a vehicle's raw folder; nothing that is there is touched.

    Parameters
    ----------
    name : str
        Name of the vehicle.
    raw : Path
        The raw folder, made when it is not there.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    UsageError
        When the name cannot be a vehicle's name.
    InputError
        When there is something of that name already, or the folder cannot be written.
    """
    if not is_vehicle_name(name):
        shown = "".join(c if c.isprintable() else "?" for c in name[:80])
        raise UsageError(f'"{shown}" cannot be the name of a vehicle. Expected {NAME_EXPECTED}')
    folder = raw / name
    written = []
    try:
        raw.mkdir(parents=True, exist_ok=True)
        folder.mkdir()
        for file, content in new_vehicle_files(name).items():
            path = folder / file
            path.parent.mkdir(exist_ok=True)
            with path.open("xb") as stream:
                stream.write(content)
            written.append(path)
    except FileExistsError:
        raise InputError.at(
            Place(str(folder if folder.exists() or folder.is_symlink() else raw)),
            "is there already; nothing was written.",
            expected="a name that is not taken.",
            remedy="Choose another name, or move what is there away.",
        ) from None
    except OSError as error:
        raise InputError(
            Problem(
                "error",
                Place(str(folder)),
                f"cannot be written: {error.strerror or error}.",
                "a folder with write permission and free space.",
                "Mend that or choose another folder with --raw.",
            )
        ) from error
    return written
