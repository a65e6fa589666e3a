"""The same tables for programs that are not firmware: JSON and CSV."""

import csv
import io
import json

from pipeline.errors import CannotComputeError
from pipeline.export.c_source import Identity
from pipeline.export.fixed_point import Q16_ONE, Q30_ONE, FixedBranch, fixed_tables
from pipeline.records.fits import FirmwareCharacteristic

#: A spreadsheet takes a cell that starts with one of these for a formula, or drops the character.
_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r", "\n")
_COLUMNS = ("vehicle", "tables_digest", "speed_mps", "fraction", "thrust_n", "code")


def render_json(
    identity: Identity,
    characteristic: FirmwareCharacteristic,
    tables: dict[str, object] | None,
) -> str:
    """Return the text of ``<vehicle>_thruster.json``: keys sorted, numbers at full precision.

    Parameters
    ----------
    identity : Identity
        Vehicle, digest of the tables, version of the tool.
    characteristic : FirmwareCharacteristic
        The grid; it is written as it is and as the fixed-point source holds it.
    tables : dict or None
        Tables 1-4 of the vehicle, carried along under ``tables``.

    Raises
    ------
    CannotComputeError
        When `tables` holds a number that is not finite or a value that JSON does not know.
    """
    fixed = fixed_tables(characteristic)
    content = {
        "vehicle": identity.vehicle,
        "identifier": identity.identifier,
        "tables_digest": identity.tables_digest,
        "tool_version": identity.tool_version,
        "firmware": characteristic.model_dump(mode="json"),
        "fixed_point": {
            "code_min": fixed.code_min,
            "code_max": fixed.code_max,
            "one": {
                "code": Q16_ONE,
                "fraction": Q30_ONE,
                "speed_mps": Q16_ONE,
                "thrust_n": Q16_ONE,
            },
            "thrust_dead": fixed.thrust_dead_q16,
            "positive": _fixed_branch(fixed.positive),
            "negative": _fixed_branch(fixed.negative),
        },
        "tables": tables,
    }
    try:
        return json.dumps(content, allow_nan=False, indent=1, sort_keys=True) + "\n"
    except (TypeError, ValueError) as error:
        raise CannotComputeError(
            f"The tables of {identity.vehicle} cannot be written as JSON: {error}."
        ) from error


def _fixed_branch(branch: FixedBranch) -> dict[str, object]:
    return {
        "speed_mps": branch.speed_q16.tolist(),
        "thrust_max_n": branch.thrust_max_q16.tolist(),
        "fraction": branch.fraction_q30.tolist(),
        "code": branch.code_q16.tolist(),
    }


def render_csv(identity: Identity, characteristic: FirmwareCharacteristic) -> str:
    """Return the text of ``<vehicle>_thruster.csv``: one row an entry of the grid.

    `speed_mps` is the vehicle's speed along the thruster's positive direction, so it is negative
    or zero where thrust and code are; `fraction` is thrust / T_max(V). Text that a spreadsheet
    would run as a formula is preceded by an apostrophe.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_COLUMNS)
    names = [neutral_cell(identity.vehicle), neutral_cell(identity.tables_digest)]
    for branch in (characteristic.negative, characteristic.positive):
        sign = float(branch.sign)
        rows = zip(branch.speed_mps, branch.thrust_max_n, branch.code, strict=True)
        for speed, largest, codes in rows:
            for fraction, code in zip(branch.fraction, codes, strict=True):
                numbers = (sign * speed, fraction, sign * fraction * largest, sign * code)
                # Adding zero turns a negative zero into zero.
                writer.writerow([*names, *(repr(number + 0.0) for number in numbers)])
    return text.getvalue()


def neutral_cell(text: str) -> str:
    """Return text that a spreadsheet shows instead of running.

    Examples
    --------
    >>> neutral_cell("=1+1"), neutral_cell("mmt300")
    ("'=1+1", 'mmt300')
    """
    return f"'{text}" if text.startswith(_FORMULA_STARTS) else text
