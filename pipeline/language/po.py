"""Catalogues as gettext keeps them: the part of the ``.po`` format that is used here."""

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass

_KEYWORD = re.compile(r'^(msgid|msgid_plural|msgstr(?:\[(\d)\])?) (".*")$')


@dataclass(frozen=True)
class Entry:
    """A message and its translation; `forms` are several for a message that counts.

    `where` names the modules that say it, `notes` explain its fields to the translator.
    """

    message: str
    plural: str = ""
    forms: tuple[str, ...] = ("",)
    where: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def translated(self) -> bool:
        """Whether every form is there."""
        return all(self.forms)


def read_po(text: str) -> list[Entry]:
    r"""Read a catalogue.

    Parameters
    ----------
    text : str
        Of the file.

    Returns
    -------
    list of Entry
        In the order of the file, the head (of the empty message) among them.

    Raises
    ------
    ValueError
        When a line is none of the format.

    Examples
    --------
    >>> read_po('#: a.py\nmsgid "row {0}"\nmsgstr "строка {0}"\n')[0].forms
    ('строка {0}',)
    """
    entries: list[Entry] = []
    for number, block in enumerate(re.split(r"\n[ \t]*\n", text), start=1):
        fields: dict[str, str] = {}
        where: list[str] = []
        notes: list[str] = []
        at = ""
        for line in block.splitlines():
            if line.startswith("#: "):
                where.append(line[3:])
            elif line.startswith("#. "):
                notes.append(line[3:])
            elif line.startswith("#") or not line.strip():
                continue
            elif found := _KEYWORD.match(line):
                at = found[1]
                fields[at] = _text(found[3], number)
            elif line.startswith('"') and at:
                fields[at] += _text(line, number)
            else:
                raise ValueError(f"entry {number} of the catalogue: {line!r}")
        if "msgid" in fields:
            forms = tuple(value for name, value in fields.items() if name.startswith("msgstr"))
            entries.append(
                Entry(
                    fields["msgid"],
                    fields.get("msgid_plural", ""),
                    forms or ("",),
                    tuple(where),
                    tuple(notes),
                )
            )
    return entries


def write_po(entries: Iterable[Entry]) -> str:
    """Return the text of a catalogue; the same entries give the same text."""
    return "\n".join(_block(entry) for entry in entries)


def _block(entry: Entry) -> str:
    lines = [f"#. {note}" for note in entry.notes] + [f"#: {place}" for place in entry.where]
    lines.append(f"msgid {_quoted(entry.message)}")
    if entry.plural:
        lines.append(f"msgid_plural {_quoted(entry.plural)}")
        lines += [f"msgstr[{i}] {_quoted(form)}" for i, form in enumerate(entry.forms)]
    else:
        lines.append(f"msgstr {_quoted(entry.forms[0])}")
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    plain = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n").replace("\t", "\\t")
    return f'"{plain}"'


def _text(quoted: str, number: int) -> str:
    try:
        value = json.loads(quoted)  # of all its escapes gettext and JSON agree on those used here
    except ValueError:
        raise ValueError(f"entry {number} of the catalogue: {quoted!r}") from None
    return str(value)
