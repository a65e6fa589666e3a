"""The same tables for programs that are not firmware: JSON and CSV."""

import csv
import io
import json
from collections.abc import Iterator, Sequence
from typing import Any

from pipeline.errors import CannotComputeError, reason
from pipeline.export.allocator_layout import AllocatorLayout
from pipeline.export.c_source import Identity, VoltageTables
from pipeline.export.fixed_point import Q16_ONE, Q30_ONE, FixedBranch, fixed_tables
from pipeline.records.fits import FirmwareCharacteristic

#: A spreadsheet takes a cell that starts with one of these for a formula, or drops the character.
_FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r", "\n")
_COLUMNS = ("vehicle", "tables_digest", "speed_mps", "fraction", "thrust_n", "code")


def render_json(
    identity: Identity,
    characteristic: FirmwareCharacteristic,
    tables: dict[str, object] | None,
    layout: AllocatorLayout | None = None,
    voltages: VoltageTables = (),
) -> str:
    """Return the text of ``<vehicle>_thruster.json``: keys sorted, numbers at full precision.

    The grid is written as it is, as the fixed-point source holds it, and at each supply voltage;
    Tables 1-4 are carried along under ``tables``, thrusters, B and portions under ``allocator``.

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
        "voltages": [
            {"voltage_v": volts, "firmware": one.model_dump(mode="json")} for volts, one in voltages
        ],
        "tables": tables,
        "allocator": None if layout is None else _allocator(layout),
    }
    try:
        return json.dumps(content, allow_nan=False, indent=1, sort_keys=True) + "\n"
    except (TypeError, ValueError) as error:
        raise CannotComputeError(
            f"The tables of {identity.vehicle} cannot be written as JSON: {reason(error)}."
        ) from error


def _allocator(layout: AllocatorLayout) -> dict[str, object]:
    return {
        "thrusters": list(layout.names),
        "position_m": layout.position_m.tolist(),
        "direction": layout.direction.tolist(),
        "gain": layout.gain.tolist(),
        "dead_zone_code": layout.corrections.lost_code.tolist(),
        "matrix": layout.allocation.matrix.tolist(),
        "inverse": layout.allocation.inverse.tolist(),
        "geometry": None if layout.paper is None else layout.paper.model_dump(mode="json"),
    }


def render_tables_csv(
    identity: Identity, tables: dict[str, object] | None, layout: AllocatorLayout | None
) -> str:
    """Return the text of ``<vehicle>_tables.csv``: one row a number of Tables 1-4, B, portions.

    Columns: vehicle, tables_digest, table, row (a speed [m/s], a sign, an axis), name, value,
    ci95_low, ci95_high; coefficients in the units of the paper's tables.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow((*_COLUMNS[:2], "table", "row", "name", "value", "ci95_low", "ci95_high"))
    names = [neutral_cell(identity.vehicle), neutral_cell(identity.tables_digest)]
    for table in ("table1", "table2", "table3", "table4"):
        found = (tables or {}).get(table)
        for row, name, value, interval in _numbers(found if isinstance(found, dict) else {}):
            writer.writerow([*names, table, row, name, value, *interval])
    if layout is not None:
        for axis, values in zip("XYZKMN", layout.allocation.matrix.tolist(), strict=True):
            for name, value in zip(layout.names, values, strict=True):
                writer.writerow([*names, "B", axis, neutral_cell(name), value + 0.0, "", ""])
        for name, both, lost in zip(
            layout.names, layout.gain.tolist(), layout.corrections.lost_code.tolist(), strict=True
        ):
            own = {"gain_ahead": both[0], "gain_reverse": both[1], "dead_zone_code": lost}
            for key, value in own.items():
                writer.writerow([*names, "thrusters", neutral_cell(name), key, value, "", ""])
        if layout.paper is not None:
            for name, portion in layout.paper.portions.model_dump().items():
                writer.writerow([*names, "portions", "", name, portion, "", ""])
    return text.getvalue()


def _numbers(table: dict[str, Any]) -> Iterator[tuple[object, str, float, Sequence[object]]]:
    """Every number of one of the tables with its row, name and interval."""
    speeds, intervals = table.get("speed_mps"), table.get("ci95") or {}
    for key, values in table.items():
        if key in {"speed_mps", "ci95"} or not isinstance(values, list):
            continue
        known = intervals.get(key) or [None] * len(values)
        for place, (value, interval) in enumerate(zip(values, known, strict=True)):
            row, name = (speeds[place], key) if speeds else (key, f"{key}{place}")
            yield row, name, value, interval or ("", "")


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

    >>> neutral_cell("=1+1"), neutral_cell("mmt300")
    ("'=1+1", 'mmt300')
    """
    return f"'{text}" if text.startswith(_FORMULA_STARTS) else text
