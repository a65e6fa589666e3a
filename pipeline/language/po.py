"""Catalogues as gettext keeps them: the part of the ``.po`` format that is used here."""

import json
import re
from dataclasses import dataclass

_KEYWORD = re.compile(r'^(msgid|msgid_plural|msgstr(?:\[(\d)\])?) (".*")$')


@dataclass(frozen=True)
class Entry:
    """A message and its translation; `forms` are several for a message that counts."""

    message: str
    plural: str = ""
    forms: tuple[str, ...] = ("",)

    @property
    def translated(self) -> bool:
        """Whether every form is there."""
        return all(self.forms)


def read_po(text: str) -> list[Entry]:
    r"""Read a catalogue: its entries in order, the head (of the empty message) among them.

    Raises ValueError when a line is none of the format.

    >>> read_po('#: a.py\nmsgid "row {0}"\nmsgstr "строка {0}"\n')[0].forms
    ('строка {0}',)
    """
    entries: list[Entry] = []
    for number, block in enumerate(re.split(r"\n[ \t]*\n", text), start=1):
        fields: dict[str, str] = {}
        at = ""
        for line in block.splitlines():
            if line.startswith("#") or not line.strip():
                continue
            if found := _KEYWORD.match(line):
                at = found[1]
                fields[at] = _text(found[3], number)
            elif line.startswith('"') and at:
                fields[at] += _text(line, number)
            else:
                raise ValueError(f"entry {number} of the catalogue: {line!r}")
        if "msgid" in fields:
            forms = tuple(value for name, value in fields.items() if name.startswith("msgstr"))
            entries.append(Entry(fields["msgid"], fields.get("msgid_plural", ""), forms or ("",)))
    return entries


def _text(quoted: str, number: int) -> str:
    try:
        value = json.loads(quoted)  # of all its escapes gettext and JSON agree on those used here
    except ValueError:
        raise ValueError(f"entry {number} of the catalogue: {quoted!r}") from None
    return str(value)
