"""Read ``vehicle.yaml``: one frozen `Vehicle`, or one message that names every fault in it."""

import difflib
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from pipeline.errors import InputError, Place, Problem
from pipeline.vehicle.estimates import with_plain_values
from pipeline.vehicle.expectation import (
    NAME_IN_WORDS,
    JsonSchema,
    Step,
    describe,
    keys_of,
    kind_key,
    schema_at,
    without_tags,
)
from pipeline.vehicle.frames import in_sname
from pipeline.vehicle.notes import vehicle_notes
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.yaml_text import MAX_BYTES, Node, parse

__all__ = ["VEHICLE_FILE", "load_checked", "load_vehicle", "validated", "vehicle_notes"]

Model = TypeVar("Model", bound=BaseModel)

VEHICLE_FILE = "vehicle.yaml"
_MAX_FAULTS_SHOWN = 20
#: More keys than so many, of which most belong nowhere and one that is needed is missing, are those
#: of another kind of file.
_FEW_KEYS = 3
_MAX_VALUE_SHOWN = 60
_NUMBER_IN_QUOTES = re.compile(r"\s*[-+]?[0-9]*\.?[0-9]+([eE][-+]?[0-9]+)?\s*")
_DECIMAL_COMMA = re.compile(r"\s*[-+]?[0-9]+,[0-9]+\s*")


def load_vehicle(path: Path) -> Vehicle:
    """Read and check a vehicle file, or that of a folder; messages show the path as given.

    Positions are in SNAME axes, whatever frame the file states.

    Raises
    ------
    InputError
        If the file cannot be read, is not YAML, or does not fit the schema. All faults of the
        schema are named in one message, each with its line.
    """
    path = Path(path)
    if path.is_dir():
        path = path / VEHICLE_FILE
    expected = f"a folder with {VEHICLE_FILE} in it."
    remedy = "Check the path; rig2sea new VEHICLE makes a folder with a commented file."
    return in_sname(load_checked(path, Vehicle, expected=expected, remedy=remedy))


def load_checked(path: Path, model: type[Model], *, expected: str, remedy: str) -> Model:
    """Read a YAML file of any schema, as strictly and with the same messages as a vehicle file.

    `expected` and `remedy` are told when there is no such file.

    Raises
    ------
    InputError
        As `load_vehicle`.
    """
    shown_as = str(path)
    return validated(model, parse(_read(path, shown_as, expected, remedy), shown_as), shown_as)


def validated(model: type[Model], root: Node, shown_as: str) -> Model:
    """Check a tree against a model; raises one `InputError` that names every fault."""
    if model is Vehicle:
        root, _ = with_plain_values(root, shown_as)
    plain = root.plain()
    try:
        # Strict, and by way of JSON: "1000" or true is not taken for a number, a list is a tuple.
        return model.model_validate_json(json.dumps(plain), strict=True, context=_context(plain))
    except ValidationError as error:
        schema = model.model_json_schema()
        known = list(schema.get("properties", {}))
        keys = list(plain) if isinstance(plain, dict) else []
        strange = [key for key in keys if key not in known]
        whole = set(schema.get("required", ())) <= set(keys)
        if 2 * len(strange) > len(keys) > _FEW_KEYS and not whole:
            what = (
                f"this is a file of another kind: {len(strange)} of its {len(keys)} keys do not "
                f"belong here ({', '.join(_short(one) for one in strange[:4])}, ...)."
            )
            expected = f"the keys {', '.join(known)}."
            raise InputError.at(Place(shown_as), what, expected=expected) from None
        faults = [
            _fault(dict(one), root, schema)
            for one in error.errors(include_url=False, include_input=False)
        ]
        raise _one_error(sorted(faults, key=lambda fault: fault.row), shown_as) from None


def _context(plain: object) -> dict[str, object]:
    """Return what checks of a section need to know of the rest of the file."""
    return {"frame": plain.get("frame")} if isinstance(plain, dict) else {}


def _read(path: Path, shown_as: str, expected: str, remedy: str) -> bytes:
    """Return at most one byte more than is allowed of a regular file."""
    place = Place(shown_as)
    if not path.exists():
        raise InputError.at(
            place,
            "there is no such file.",
            expected=expected,
            remedy=remedy,
        )
    if not path.is_file():
        raise InputError.at(place, "this is not a file.", expected="a text file.")
    try:
        with path.open("rb") as stream:
            return stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise InputError.at(
            place,
            f"the file cannot be read: {error.strerror or error}.",
            remedy="Check its permissions.",
        ) from None


@dataclass(frozen=True)
class _Fault:
    row: int
    what: str
    expected: str = ""
    remedy: str = ""


def _one_error(faults: Sequence[_Fault], shown_as: str) -> InputError:
    """Put all faults into one error."""
    if len(faults) == 1:
        only = faults[0]
        place = Place(shown_as, row=only.row)
        return InputError(Problem("error", place, only.what, only.expected, only.remedy))
    lines = []
    for fault in faults[:_MAX_FAULTS_SHOWN]:
        expected = f"Expected {fault.expected}" if fault.expected else ""
        text = " ".join(part for part in (fault.what, expected, fault.remedy) if part)
        lines.append(f"  row {fault.row}: {text}")
    if len(faults) > _MAX_FAULTS_SHOWN:
        lines.append(f"  and {len(faults) - _MAX_FAULTS_SHOWN} more.")
    what = f"{len(faults)} faults.\n" + "\n".join(lines)
    return InputError.at(Place(shown_as), what)


def _fault(error: dict[str, Any], root: Node, schema: JsonSchema) -> _Fault:
    """Translate one pydantic error."""
    kind: str = error["type"]
    stated = (error.get("ctx") or {}).get("path")
    tagged: tuple[Step, ...] = tuple(stated) if stated else tuple(error["loc"])
    path = without_tags(schema, tagged)
    if path and path[-1] == "[key]":
        name, where = path[-2], _dotted(path[:-2])
        found = _find(root, path[:-1])
        what = f'"{_short(name)}" in {where} is refused.'
        return _Fault(found.key_line, what, f"{NAME_IN_WORDS}.")
    if kind == "extra_forbidden":
        return _unknown_key(path, root, keys_of(schema_at(schema, tagged[:-1])))
    if kind.startswith("union_tag"):
        return _unknown_kind(path, root, schema_at(schema, tagged), schema)
    found = _find(root, path)
    dotted = _dotted(path)
    if kind == "missing":
        return _missing(path, tagged, found, schema)
    if kind in ("value_error", "vehicle"):
        cause = (error.get("ctx") or {}).get("error")
        text = str(cause if cause is not None else error["msg"])
        prefix = f"{dotted}: " if path and dotted not in text else ""
        return _Fault(found.key_line, f"{prefix}{text}.")
    at = schema_at(schema, tagged)
    what, remedy = f"{dotted} is {_value(found)}.", _remedy(found, at)
    return _Fault(_row(found), what, f"{describe(at, schema) or error['msg']}.", remedy)


def _missing(
    path: tuple[Step, ...], tagged: tuple[Step, ...], found: Node, schema: JsonSchema
) -> _Fault:
    holder = _dotted(path[:-1])
    if isinstance(path[-1], int):
        expected = describe(schema_at(schema, tagged[:-1]), schema)
        return _Fault(found.key_line, f"{holder} has too few entries.", f"{expected}.")
    expected = describe(schema_at(schema, tagged), schema)
    what = f'key "{path[-1]}" is missing{f" in {holder}" if holder else ""}.'
    return _Fault(found.key_line, what, f"{expected}." if expected else "")


def _unknown_kind(
    path: tuple[Step, ...], root: Node, section: JsonSchema | None, schema: JsonSchema
) -> _Fault:
    """Say that a section names no kind, or one that does not exist."""
    path = (*path, kind_key(section))
    found = _find(root, path)
    holder = _find(root, path[:-1])
    expected = f"{describe(section, schema)}."
    if found is holder:
        return _Fault(
            holder.key_line, f'key "{path[-1]}" is missing in {_dotted(path[:-1])}.', expected
        )
    return _Fault(_row(found), f"{_dotted(path)} is {_value(found)}.", expected)


def _unknown_key(path: tuple[Step, ...], root: Node, known: Sequence[str]) -> _Fault:
    key = str(path[-1])
    what = f'unknown key "{_short(key)}" in {_dotted(path[:-1])}.'
    near = difflib.get_close_matches(key, known, n=1, cutoff=0.5)
    remedy = f'Did you mean "{near[0]}"?' if near else "Delete it, or see docs/formats.md."
    found = _find(root, path)
    if key.isdigit() and found.value is None:
        # {density_kgpm3: 1000,6} reads as two entries.
        remedy = "If this is the rest of a number, write a decimal point instead of the comma."
    return _Fault(
        found.key_line,
        what if path[:-1] else f'unknown key "{_short(key)}".',
        f"one of {', '.join(known)}.",
        remedy,
    )


def _find(root: Node, path: Sequence[Step]) -> Node:
    """Return the node at `path`, or the innermost one on the way that exists."""
    here = root
    for step in path:
        value = here.value
        if isinstance(value, dict) and step in value:
            here = value[str(step)]
        elif isinstance(value, list) and isinstance(step, int) and step < len(value):
            here = value[step]
        else:
            break
    return here


def _row(node: Node) -> int:
    """Return the line to show for a wrong value: its key's, if it is empty or a section."""
    if node.value is None or isinstance(node.value, dict | list):
        return node.key_line
    return node.line


def _dotted(path: Sequence[Step]) -> str:
    """Return e.g. ``thrusters[1].position_m``; list entries are counted from 1."""
    text = ""
    for step in path:
        text += f"[{step + 1}]" if isinstance(step, int) else f".{_short(step)}"
    return text.removeprefix(".")


def _short(value: object) -> str:
    text = str(value)
    return text if len(text) <= _MAX_VALUE_SHOWN else text[: _MAX_VALUE_SHOWN - 3] + "..."


def _value(node: Node) -> str:
    """Return the value as the engineer would recognise it."""
    if isinstance(node.value, dict):
        return "a section"
    if isinstance(node.value, list):
        return f"a list of {len(node.value)}"
    if node.value is None:
        return "empty"
    return _short(json.dumps(node.value, ensure_ascii=False))


def _remedy(node: Node, schema: JsonSchema | None) -> str:
    kind = (schema or {}).get("type")
    if isinstance(node.value, str) and kind in ("number", "integer"):
        if _DECIMAL_COMMA.fullmatch(node.value):
            return f"Write a decimal point: {node.value.strip().replace(',', '.')}"
        if _NUMBER_IN_QUOTES.fullmatch(node.value):
            return "Remove the quotes."
    if isinstance(node.value, bool | int | float) and kind == "string":
        return f'Put it in quotes: "{json.dumps(node.value)}"'
    return ""
