"""Change numbers in a vehicle file's text, and nothing else: comments, order and layout stay.

The places of the values are found with a YAML parser and only their characters are replaced, so
that a comparison of both files shows the changed numbers and the note on top.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from pipeline.errors import CannotComputeError
from pipeline.vehicle.estimates import KEYS, Estimate

Value = float | int | str | Sequence[float] | Estimate
#: Sections that a file may leave out, whole or with the keys that are given.
_OPTIONAL = (
    *("model.wake_fraction.", "model.thrust_deduction.", "model.supply."),
    *("model.lumped_tether.", "model.lift."),
)
_Tree = dict[str, "Value | _Tree"]
#: Digits of a number that is written, and of the ends of its interval.
_DIGITS, _END_DIGITS = 7, 4


def updated_vehicle_text(original_text: str, changes: Mapping[str, Value], note: str) -> str:
    """Text of a vehicle file with some values changed, and a `note` on top as a comment.

    `changes` are new values by dotted path, an element of a list by its place from 0:
    ``{"model.damping.linear.0": 2.4}``. A list is written element by element; an `Estimate` with
    its interval and source. A key that the file leaves out is put into its section, which must be
    there unless it is one that a file may leave out whole; a list that it leaves out takes all of
    its elements. A byte-order mark at the beginning is left out.

    Raises
    ------
    CannotComputeError
        When a path leads nowhere, or to a section where a value is meant.

    >>> print(updated_vehicle_text("a: {b: 1.0} # stays", {"a.b": 2.5}, "changed"))
    # changed
    a: {b: 2.5} # stays
    """
    # imported here: the command line answers --help without it
    from ruamel.yaml import YAML

    # below the note the mark would be a character that no reader of YAML takes
    text = original_text.removeprefix("\ufeff")
    root = YAML(typ="rt", pure=True).compose(text)
    edits: list[tuple[int, int, str]] = []
    made: dict[str, _Tree] = {}
    for path, value in changes.items():
        lacking = path.startswith(_OPTIONAL) or path.rpartition(".")[2].isdigit()
        section = _lacking_section(root, path) if lacking else None
        if section is None:
            edits += _edits(root, path, value)
            continue
        *between, key = path.removeprefix(f"{section}.").split(".")
        tree = made.setdefault(section, {})
        for part in between:
            below = tree.setdefault(part, {})
            assert isinstance(below, dict)  # noqa: S101 - no path is the beginning of another
            tree = below
        tree[key] = value
    for section, tree in made.items():
        edits += _edits(root, section, tree)
    for begin, end, new in sorted(edits, reverse=True):
        text = text[:begin] + new + text[end:]
    if not note:
        return text
    head = "".join(f"# {line}".rstrip() + "\n" for line in note.splitlines())
    return head + text


def _lacking_section(root: Any, path: str) -> str | None:  # noqa: ANN401
    """First section on the way to a key that is not there; None where only the key may lack."""
    node, parts = root, path.split(".")
    for depth, part in enumerate(parts[:-1]):
        node = _child(node, part)
        if node is None:
            return ".".join(parts[: depth + 1])
    return None


def _edits(root: Any, path: str, value: "Value | _Tree") -> list[tuple[int, int, str]]:  # noqa: ANN401
    """Begin, end and new text of every place that one change touches."""
    node, parts = root, path.split(".")
    for depth, part in enumerate(parts):
        child = _child(node, part)
        if child is None:
            if depth == len(parts) - 1 and hasattr(node, "flow_style") and _is_mapping(node):
                return [_inserted(node, part, value)]
            raise CannotComputeError(
                f"the vehicle file has no {'.'.join(parts[: depth + 1])}, so {path} cannot be "
                "written back"
            )
        node = child
    if isinstance(value, Sequence) and not isinstance(value, str):
        items = node.value if isinstance(node.value, list) else []
        if len(items) != len(value) or any(isinstance(i, tuple) for i in items):
            raise CannotComputeError(
                f"{path} of the vehicle file is no list of {len(value)} numbers"
            )
        pairs = zip(items, value, strict=True)
        return [(*_span(item), _written(one)) for item, one in pairs]
    if isinstance(node.value, list) and not _is_estimate(node):
        raise CannotComputeError(f"{path} of the vehicle file is a section, not a value")
    return [(*_span(node), _written(value))]


def _is_estimate(node: Any) -> bool:  # noqa: ANN401 - nodes of the parser have no types
    """Whether a section stands for a number; see `pipeline.vehicle.estimates`."""
    return _is_mapping(node) and {key.value for key, _ in node.value} <= KEYS


def _is_mapping(node: Any) -> bool:  # noqa: ANN401 - nodes of the parser have no types
    return bool(node.id == "mapping")


def _child(node: Any, part: str) -> Any:  # noqa: ANN401
    if node is None or not isinstance(node.value, list):
        return None
    if _is_mapping(node):
        return next((value for key, value in node.value if key.value == part), None)
    if part.isdigit() and int(part) < len(node.value):
        return node.value[int(part)]
    return None


def _span(node: Any) -> tuple[int, int]:  # noqa: ANN401
    if _is_mapping(node) and not node.flow_style:
        # its end mark is where the next key begins
        return node.start_mark.index, _span(node.value[-1][1])[1]
    return node.start_mark.index, node.end_mark.index


def _inserted(node: Any, key: str, value: "Value | _Tree") -> tuple[int, int, str]:  # noqa: ANN401
    """Put a key before the first of its section, in an entry of a list after that."""
    begin = node.start_mark.index
    if node.flow_style:
        more = ", " if node.value else ""
        return begin + 1, begin + 1, f"{key}: {_written(value)}{more}"
    own = [name for name, _ in node.value]
    # a thruster's name stays at its head
    first = own[1 if own[0].value == "name" and len(own) > 1 else 0].start_mark
    return first.index, first.index, f"{key}: {_written(value)}\n" + " " * first.column


def _written(value: "Value | _Tree") -> str:
    if isinstance(value, Estimate):
        return _estimate_written(value)
    if isinstance(value, dict):
        if all(key.isdigit() for key in value):
            inside, ends = [_written(value[key]) for key in sorted(value, key=int)], "[]"
        else:
            inside, ends = [f"{key}: {_written(one)}" for key, one in value.items()], "{}"
        return ends[0] + ", ".join(inside) + ends[1]
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, Sequence):
        return "[" + ", ".join(_written(one) for one in value) + "]"
    if isinstance(value, int):
        # true and false are integers here
        return str(value).lower()
    return _number(value, _DIGITS)


def _estimate_written(one: Estimate) -> str:
    assert one.value is not None  # noqa: S101 - what is written has a value
    text = _written(one.value)
    parts = [f"value: {text}"]
    if one.ci95 is not None:
        # rounded ends must go on holding the value
        low, high = (_number(end, _END_DIGITS) for end in one.ci95)
        low = text if float(low) > float(text) else low
        high = text if float(high) < float(text) else high
        parts.append(f"ci95: [{low}, {high}]")
    if one.source:
        parts.append(f"from: {_written(one.source)}")
    return "{" + ", ".join(parts) + "}" if len(parts) > 1 else text


def _number(value: float, digits: int) -> str:
    text = f"{value:.{digits}g}"
    # 1e-05 is text to some readers of YAML; a point makes it a number for all of them
    return text if "." in text or "e" not in text else text.replace("e", ".0e", 1)


def with_columns(text: str, wanted: Mapping[str, Mapping[str, str]]) -> str:
    r"""Put columns into a vehicle file's `columns` section; every other line stays as it is.

    `wanted` are values as YAML by kind of test and quantity.

    Raises
    ------
    CannotComputeError
        When `columns`, or a section of it, is no section.

    >>> print(with_columns("name: v\n", {"mooring": {"thrust": "{header: T}"}}))
    name: v
    columns:
      mooring:
        thrust: {header: T}
    <BLANKLINE>
    """
    from ruamel.yaml import YAML

    for kind, lines in wanted.items():
        columns = _child(YAML(typ="rt", pure=True).compose(text), "columns")
        section = _child(columns, kind)
        missing = {k: v for k, v in lines.items() if _child(section, k) is None}
        if not missing:
            continue
        for node, name in ((columns, "columns"), (section, f"columns: {kind}")):
            if node is not None and not (_is_mapping(node) and node.value):
                raise CannotComputeError(
                    f"{name} of the vehicle file holds no keys; delete the line, then this can "
                    "be written."
                )
        text = _with_section(text, columns, section, (kind, missing))
    return text


def _with_section(
    text: str,
    columns: Any,  # noqa: ANN401 - nodes of the parser have no types
    section: Any,  # noqa: ANN401
    wanted: tuple[str, Mapping[str, str]],
) -> str:
    kind, lines = wanted
    node = section if section is not None else columns
    if node is None:
        body = "".join(f"    {key}: {line}\n" for key, line in lines.items())
        end = "" if not text or text.endswith("\n") else "\n"
        return f"{text}{end}columns:\n  {kind}:\n{body}"
    flow = ", ".join(f"{key}: {line}" for key, line in lines.items())
    if node.flow_style:
        at = node.start_mark.index + 1
        new = f"{flow}, " if section is not None else f"{kind}: {{{flow}}}, "
        return text[:at] + new + text[at:]
    first = node.value[0][0].start_mark
    pad = " " * first.column
    if section is not None:
        new = "".join(f"{key}: {line}\n{pad}" for key, line in lines.items())
    else:
        body = "".join(f"{pad}  {key}: {line}\n" for key, line in lines.items())
        new = f"{kind}:\n{body}{pad}"
    return text[: first.index] + new + text[first.index :]
