"""Pieces of C source: identifiers, string literals, comments and tables of constants.

Names and texts come from files that people write, so nothing goes into the source unescaped.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from pipeline.errors import CannotComputeError
from pipeline.export.grid_check import largest_negative
from pipeline.records.fits import FirmwareBranch, FirmwareCharacteristic

Float32Array = npt.NDArray[np.float32]

#: Line length of generated source.
WIDTH = 100
_INDENT = "    "


@dataclass(frozen=True)
class SingleBranch:
    """One sign of thrust, every number rounded to single precision."""

    speed_mps: Float32Array
    thrust_max_n: Float32Array
    fraction: Float32Array
    code: Float32Array
    drag_n: Float32Array


@dataclass(frozen=True)
class SingleTables:
    """Both signs; `thrust_dead_n` is rounded down so that `>` decides as in real numbers."""

    thrust_dead_n: np.float32
    code_min: int
    code_max: int
    tested_mps: np.float32
    positive: SingleBranch
    negative: SingleBranch


def single_tables(characteristic: FirmwareCharacteristic) -> SingleTables:
    """Round a characteristic that `check_characteristic` accepted to single precision."""
    dead = np.float32(characteristic.thrust_dead_n)
    if float(dead) > characteristic.thrust_dead_n:
        dead = np.nextafter(dead, np.float32(-np.inf))
    return SingleTables(
        thrust_dead_n=dead,
        code_min=characteristic.code_min,
        code_max=characteristic.code_max,
        tested_mps=np.float32(characteristic.fastest_tested_mps),
        positive=_single_branch(characteristic.positive, characteristic.code_max),
        negative=_single_branch(characteristic.negative, largest_negative(characteristic)),
    )


def _single_branch(branch: FirmwareBranch, code_max: int) -> SingleBranch:
    return SingleBranch(
        speed_mps=np.asarray(branch.speed_mps, np.float32),
        thrust_max_n=np.asarray(branch.thrust_max_n, np.float32),
        fraction=np.asarray(branch.fraction, np.float32),
        code=np.clip(branch.code, 0.0, code_max).astype(np.float32),
        drag_n=np.asarray(branch.drag_n or np.zeros(len(branch.speed_mps)), np.float32),
    )


def c_identifier(name: str) -> str:
    """Return the C identifier for a vehicle's name: ``_`` for ``-``.

    Raises
    ------
    CannotComputeError
        When the name could not be part of a file name and an identifier: 1 to 48 letters, digits,
        ``_`` and ``-``, the first a letter, are expected.

    >>> c_identifier("mmt-300")
    'mmt_300'
    """
    if re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,47}", name, flags=re.ASCII) is None:
        raise CannotComputeError(
            f"Firmware source cannot be named after the vehicle {name!r}: expected 1 to 48 of the "
            "letters A-Z and a-z, digits, _ and -, the first a letter. Rename it in vehicle.yaml."
        )
    return name.replace("-", "_")


def c_string(text: str) -> str:
    r"""Return a C string literal; anything but printable ASCII becomes octal escapes of UTF-8.

    A question mark is escaped too, so that no trigraph arises.

    >>> print(c_string('a"b\\'))
    "a\"b\\"
    """
    plain = {byte: chr(byte) for byte in range(0x20, 0x7F) if chr(byte) not in '"\\?'}
    escaped = {ord('"'): '\\"', ord("\\"): "\\\\", ord("?"): "\\?"}
    body = "".join(
        plain.get(byte) or escaped.get(byte) or f"\\{byte:03o}" for byte in text.encode("utf-8")
    )
    return f'"{body}"'


def c_string_size(text: str) -> int:
    """Return the number of bytes that `c_string` takes in memory, the final zero included."""
    return len(text.encode("utf-8")) + 1


def c_comment(text: str) -> str:
    """Return text that cannot end the comment it stands in, nor start a line.

    >>> c_comment("a */ b")
    'a * / b'
    """
    printable = "".join(c if 0x20 <= ord(c) < 0x7F else "?" for c in text)
    # backslashes first: the stroke that one becomes may end the comment as well
    plain = printable.replace("\\", "/").replace("*/", "* /").replace("/*", "/ *")
    return re.sub(r"\?(?=\?)", "? ", plain)


def float_literal(value: float) -> str:
    """Return the shortest literal that C reads as this value in single precision.

    >>> float_literal(0.1), float_literal(127)
    ('0.1f', '127.0f')
    """
    return f"{np.float32(value)!s}f"


def double_literal(value: float) -> str:
    """Return the shortest literal that C reads as this double.

    >>> double_literal(-0.0)
    '0.0'
    """
    return repr(float(value) + 0.0)


def unsigned_literal(value: int) -> str:
    """Return an unsigned literal.

    >>> unsigned_literal(65536)
    '65536U'
    """
    return f"{int(value)}U"


def c_array(
    ctype: str, name: str, rows: Sequence[tuple[str, Iterable[str]]], *, comment: str
) -> str:
    """Return ``static const ctype name[n] = {...};`` with a comment above and one before each row.

    `rows` have a comment each (may be empty) and their literals.
    """
    lines: list[str] = []
    count = 0
    for title, literals in rows:
        if title:
            lines.append(f"{_INDENT}/* {title} */")
        line = _INDENT
        for literal in literals:
            count += 1
            if len(line) + len(literal) + 1 > WIDTH:
                lines.append(line.rstrip())
                line = _INDENT
            line += f"{literal}, "
        lines.append(line.rstrip())
    body = "\n".join(lines)
    return f"/* {comment} */\nstatic const {ctype} {name}[{count}] = {{\n{body}\n}};"
