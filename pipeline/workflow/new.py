"""``rig2sea new``: write the raw folder of a vehicle: a form to fill in, or the example."""

import shutil
from pathlib import Path

import pipeline
from pipeline.bundled.new_vehicle import new_vehicle_files
from pipeline.errors import InputError, Place
from pipeline.plan import NAME_EXPECTED, VEHICLE_FILE, UsageError, is_vehicle_name, printable

#: Vehicles that travel with the program, data and all.
EXAMPLES = ("mmt300",)


def write_new_vehicle(name: str, raw: Path, *, example: bool = False) -> list[Path]:
    """Write a vehicle's raw folder; nothing that is there is touched.

    Parameters
    ----------
    name : str
        Name of the vehicle.
    raw : Path
        The raw folder, made when it is not there.
    example : bool
        Write the example vehicle of that name with its raw files instead of forms.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    UsageError
        When the name cannot be a vehicle's name, or no example has it.
    InputError
        When there is something of that name already, or the folder cannot be written.
    """
    if not is_vehicle_name(name):
        shown = printable(name[:80])
        raise UsageError(f'"{shown}" cannot be the name of a vehicle. Expected {NAME_EXPECTED}')
    folder = raw / name
    files = example_files(name) if example else new_vehicle_files(name)
    written = []
    made = False
    try:
        raw.mkdir(parents=True, exist_ok=True)
        folder.mkdir()
        made = True
        for file, content in files.items():
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
        if made:  # a half of it would be in the way of the next try
            shutil.rmtree(folder, ignore_errors=True)
        raise InputError.at(
            Place(str(folder)),
            f"cannot be written: {error.strerror or error}.",
            expected="a folder with write permission and free space.",
            remedy="Mend that or choose another folder with --raw.",
        ) from error
    return written


def example_files(name: str) -> dict[str, bytes]:
    """Return the files of an example vehicle.

    Parameters
    ----------
    name : str
        One of `EXAMPLES`.

    Returns
    -------
    dict of str to bytes
        Path relative to the vehicle's folder -> contents.

    Raises
    ------
    UsageError
        When there is no example of that name.
    InputError
        When the installation lacks it.
    """
    if name not in EXAMPLES:
        raise UsageError(f'there is no example vehicle "{name}". There is: {", ".join(EXAMPLES)}.')
    package = Path(pipeline.__file__).resolve().parent
    for room in (package / "examples", package.parent / "raw"):  # installed; source tree
        folder = room / name
        if (folder / VEHICLE_FILE).is_file():
            return {
                path.relative_to(folder).as_posix(): path.read_bytes()
                for path in sorted(folder.rglob("*"))
                if path.is_file()
            }
    raise InputError.at(
        Place(str(package / "examples" / name)),
        "the example vehicle is missing from the installation.",
        remedy="Install rig2sea again.",
    )
