"""YAML text from outside as a plain tree in which every node knows its line.

Only what a vehicle file needs is accepted: mappings with text keys, lists, plain scalars of the
YAML 1.2 core schema. Anchors, aliases, tags, several documents, duplicate keys, deep nesting and
numbers that are not finite are refused, so a file cannot grow in memory or build objects.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pipeline.errors import InputError, Place, reason

MAX_BYTES = 1_000_000
MAX_DEPTH = 12
MAX_NODES = 20_000

Scalar = None | bool | int | float | str

_INTEGER = re.compile(r"[-+]?[0-9]{1,18}")
_OTHER_BASE = re.compile(r"0o[0-7]{1,20}|0x[0-9a-fA-F]{1,15}")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
#: What YAML allows in no file (specification 1.2.2, section 5.1); lines are parted before.
_NOT_PRINTABLE = re.compile("[^\t\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_NULL = frozenset({"", "~", "null", "Null", "NULL"})
_BOOL = {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}


@dataclass(frozen=True)
class Node:
    """A value of the file.

    `line` is where it starts, `key_line` where its key stands (the same for a list item), both
    counted from 1 as an editor does.
    """

    value: "Scalar | list[Node] | dict[str, Node]"
    line: int
    key_line: int

    def plain(self) -> Any:  # noqa: ANN401 - the tree of a YAML file has no narrower type
        """Return the tree without the line numbers."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value


def parse(data: bytes, shown_as: str) -> Node:
    """Parse the bytes of a YAML file, `shown_as` in messages: its top mapping.

    Raises
    ------
    InputError
        If the file is too large, not UTF-8, not YAML, or uses what is refused here.

    >>> parse(b"water: {density_kgpm3: 1e3}", "a.yaml").plain()
    {'water': {'density_kgpm3': 1000.0}}
    """
    text = _decoded(data, shown_as)
    # Imported here: the command line answers --help without it.
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    events = YAML(typ="safe", pure=True).parse(text)
    builder = _Builder(shown_as)
    try:
        return builder.document(iter(events))
    except MarkedYAMLError as error:
        raise _syntax_error(error, text, shown_as) from None
    except (YAMLError, ValueError, OverflowError) as error:
        # ValueError: the scanner lets chr() refuse escapes such as "\U00110000".
        raise InputError.at(
            Place(shown_as, row=builder.line),
            f"not readable as YAML from here on: {reason(error)}.",
            expected="plain text in the layout of the vehicle file.",
            remedy="Look for an odd escape or character at or below this line.",
        ) from None


def _decoded(data: bytes, shown_as: str) -> str:
    """Return the text, checked for size, encoding and control characters."""
    if len(data) > MAX_BYTES:
        raise InputError.at(
            Place(shown_as),
            f"the file is larger than {MAX_BYTES // 1000} kB.",
            expected="a vehicle file of a few kilobytes.",
            remedy="Measured data belong into the folders beside it, not into this file.",
        )
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = data[: error.start].count(b"\n") + 1
        raise InputError.at(
            Place(shown_as, row=row),
            f"byte {data[error.start]:#04x} is not UTF-8 text.",
            expected="a text file in UTF-8.",
            remedy='Save the file again with the encoding "UTF-8".',
        ) from None
    for row, line in enumerate(text.split("\n"), start=1):
        bad = next(iter(_NOT_PRINTABLE.findall(line)), None)
        if bad is not None:
            raise InputError.at(
                Place(shown_as, row=row),
                f"control character {ord(bad):#04x} in the text.",
                expected="a text file in UTF-8.",
                remedy="Delete the character, or save the file again as plain text.",
            )
    return text


def _syntax_error(error: Any, text: str, shown_as: str) -> InputError:  # noqa: ANN401
    """Translate a scanner or parser error of ruamel.yaml."""
    mark = error.problem_mark or error.context_mark
    row = mark.line + 1 if mark is not None else 1
    lines = text.splitlines()
    line = lines[row - 1] if row <= len(lines) else ""
    if "\t" in line[: len(line) - len(line.lstrip())]:
        what, remedy = "a tab is used for indentation.", "Replace the tab by spaces."
    else:
        parts = [part for part in (error.context, error.problem) if part]
        what = f"not valid YAML: {', '.join(parts)}."
        remedy = "Look at this line and the one above: a bracket, a quote, a colon or the indent."
    return InputError.at(Place(shown_as, row=row), what, remedy=remedy)


class _Builder:
    """Build the tree from parser events; no constructor of the library runs."""

    def __init__(self, shown_as: str) -> None:
        self.shown_as = shown_as
        self.line = 1
        self._nodes = 0

    def document(self, events: Iterator[Any]) -> Node:
        """Return the one mapping that the stream holds."""
        from ruamel.yaml import events as kinds

        top: Node | None = None
        for event in events:
            self._look_at(event)
            if isinstance(event, kinds.DocumentStartEvent):
                if top is not None:
                    raise self._refused("a second YAML document starts here", "one document")
                top = self._node(next(events), events, self.line, 0)
        if top is None or top.value is None:
            raise InputError.at(
                Place(self.shown_as),
                "the file is empty.",
                expected="a vehicle description.",
                remedy="rig2sea new VEHICLE writes a commented one to start from.",
            )
        if not isinstance(top.value, dict):
            raise InputError.at(
                Place(self.shown_as, row=top.line),
                "the file does not hold keys with values.",
                expected='lines such as "name: mmt300" at the outermost level.',
            )
        return top

    def _look_at(self, event: Any) -> None:  # noqa: ANN401 - ruamel's events are untyped
        """Count the event and refuse what a vehicle file does not need."""
        self.line = event.start_mark.line + 1
        self._nodes += 1
        if self._nodes > MAX_NODES:
            raise self._refused("too many entries", f"at most {MAX_NODES} keys and values")
        if getattr(event, "anchor", None) is not None:
            name = str(event.anchor)[:40]
            raise self._refused(f'anchor or alias "{name}"', "each value written out")
        if getattr(event, "ctag", None) is not None:
            raise self._refused(f'tag "{str(event.tag)[:40]}"', "plain values without tags")

    def _refused(self, what: str, expected: str) -> InputError:
        return InputError.at(
            Place(self.shown_as, row=self.line),
            f"{what}, which is refused.",
            expected=f"{expected}.",
        )

    def _node(self, event: Any, events: Iterator[Any], key_line: int, depth: int) -> Node:  # noqa: ANN401
        from ruamel.yaml import events as kinds

        self._look_at(event)
        line = self.line
        if isinstance(event, kinds.ScalarEvent):
            return Node(self._scalar(event), line, key_line)
        if depth >= MAX_DEPTH:
            raise self._refused("nesting too deep", f"at most {MAX_DEPTH} levels")
        if isinstance(event, kinds.SequenceStartEvent):
            items: list[Node] = []
            while not isinstance(event := next(events), kinds.SequenceEndEvent):
                items.append(self._node(event, events, event.start_mark.line + 1, depth + 1))
            return Node(items, line, key_line)
        mapping: dict[str, Node] = {}
        while not isinstance(event := next(events), kinds.MappingEndEvent):
            self._look_at(event)
            if not isinstance(event, kinds.ScalarEvent):
                raise self._refused("a list or section as a key", "text as the key")
            key, line_of_key = self._text(event.value), self.line
            if key in mapping:
                raise InputError.at(
                    Place(self.shown_as, row=line_of_key),
                    f'key "{key[:60]}" stands twice, first in row {mapping[key].key_line}.',
                    expected="each key once in its section.",
                    remedy="Delete or rename one of the two.",
                )
            mapping[key] = self._node(next(events), events, line_of_key, depth + 1)
        return Node(mapping, line, key_line)

    def _text(self, text: str) -> str:
        if any(0xD800 <= ord(character) <= 0xDFFF for character in text):
            raise self._refused("half of a surrogate pair in the text", "characters of UTF-8")
        return text

    def _scalar(self, event: Any) -> Scalar:  # noqa: ANN401 - ruamel's events are untyped
        """Resolve a scalar by the YAML 1.2 core schema; quoted text stays text."""
        text = self._text(event.value)
        if not event.implicit[0]:
            return text
        if text in _NULL or text in _BOOL:
            return _BOOL.get(text)
        if _INTEGER.fullmatch(text) or _OTHER_BASE.fullmatch(text):
            return int(text, 0 if _OTHER_BASE.fullmatch(text) else 10)
        if _NOT_FINITE.fullmatch(text):
            raise self._refused(f'"{text}" as a value', "a finite number")
        if not _FLOAT.fullmatch(text):
            return text
        number = float(text)
        if not math.isfinite(number):
            raise self._refused(f"{text[:40]} is beyond the range of numbers", "a finite number")
        return number
