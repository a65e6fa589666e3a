"""Catalogues as files."""

import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

from evaluation.messages import FoundMessage, write_po
from pipeline.language.po import Entry, read_po

TEXT = st.text(
    alphabet=string.printable.replace("\r", "").replace("\x0b", "").replace("\x0c", "") + "жΔ«»"
)


@given(st.lists(st.tuples(TEXT.filter(bool), TEXT, st.tuples(TEXT) | st.tuples(TEXT, TEXT, TEXT))))
def test_what_is_written_is_read(texts: list[tuple[str, str, tuple[str, ...]]]) -> None:
    entries = [
        Entry(message, plural if len(forms) > 1 else "", forms if plural else forms[:1])
        for message, plural, forms in texts
    ]
    found = [FoundMessage(e.message, e.plural, e.forms, ("a.py",), ("{0}: n",)) for e in entries]
    assert read_po(write_po(found)) == entries


def test_a_text_over_several_lines_is_one() -> None:
    (entry,) = read_po('#, fuzzy\nmsgid ""\n"row "\n"{0}"\nmsgstr "строка {0}"\n')
    assert entry.message == "row {0}"
    assert entry.translated


@pytest.mark.parametrize("text", ["msgid row", 'msgid "a"\nnonsense', 'msgid "a\\q"\nmsgstr ""'])
def test_a_broken_file_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="entry 1"):
        read_po(text)
