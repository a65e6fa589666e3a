"""A raw folder to fill in: a commented ``vehicle.yaml``, a form for each kind of test, what to do.

The forms have names and units and no number: a reader knows a blank one by its first cell. Notes of
pool runs have a template beside where the logs go.
"""

from pathlib import Path

from pipeline.bundled.workbook_bytes import SheetContents, workbook_bytes
from pipeline.vehicle.forms import FORM_MARK

#: File of the vehicle's folder -> its form.
_TEXTS = {
    "vehicle.yaml": "vehicle.yaml",
    "README.md": "README.md",
    "pool/README.md": "pool_README.md",
}
#: Kind of test -> (name, unit) of each column; the readers need the first three (mooring: two).
COLUMNS: dict[str, tuple[tuple[str, str | None], ...]] = {
    "load_test": (
        ("Code", None),
        ("Shaft speed", "rpm"),
        ("Torque", "N m"),
        ("Current", "A"),
        ("Voltage", "V"),
        ("Status", None),
    ),
    "mooring": (
        ("Code", None),
        ("Thrust", "N"),
        ("Shaft speed", "rpm"),
        ("Voltage", "V"),
        ("Current", "A"),
        ("Remarks", None),
    ),
    "open_water": (("J", None), ("KT", None), ("KM", None), ("Remarks", None)),
}
_WIDTH = 14
#: Before what a vehicle file has from the bundled vehicle @LIKE@.
LIKE_HEAD = """\
# Vehicle file of @NAME@. It began as that of the bundled vehicle @LIKE@: replace each number by
# yours, and its comment with it. All keys with their meaning: docs/formats.md.
name: "@NAME@"
title: "@NAME@, like @LIKE@"
data_note: Model and sensors of the bundled vehicle @LIKE@, to be replaced by those of @NAME@.

"""


def new_vehicle_files(name: str) -> dict[str, bytes]:
    """Return the files of a new vehicle's raw folder.

    Parameters
    ----------
    name : str
        Name of the vehicle, already checked.

    Returns
    -------
    dict of str to bytes
        Path relative to the vehicle's folder -> contents; the same for the same name.

    Examples
    --------
    >>> list(new_vehicle_files("boat"))[:3]
    ['vehicle.yaml', 'README.md', 'pool/README.md']
    """
    forms = Path(__file__).parent / "forms"
    texts = {
        file: (forms / form).read_text(encoding="utf-8").replace("@NAME@", name).encode()
        for file, form in _TEXTS.items()
    }
    return texts | {f"{kind}/{kind}.xlsx": _form(kind) for kind in COLUMNS}


def _form(kind: str) -> bytes:
    columns = COLUMNS[kind]
    heading = f"{FORM_MARK}: one row a point, see README.md"
    rows = ((heading,), [name for name, _ in columns], [unit for _, unit in columns])
    return workbook_bytes([SheetContents(kind, rows, widths=[_WIDTH] * len(columns))])
