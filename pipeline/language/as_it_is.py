"""Names that stay as they are within a text that is translated: an effect is ``current``, not ток.

A word may be a name in one sentence and plain English in the next, so whoever makes the text says
which it is. The marks lie in the private use area of Unicode, where no text has anything, and
`translate` takes them away.
"""

import re

from pipeline.reader_language import ENGLISH, current

_FIRST, _LAST = "\ue000", "\ue001"
MARKED = re.compile(f"{_FIRST}[^{_FIRST}{_LAST}]*{_LAST}")
_MARKS = str.maketrans("", "", _FIRST + _LAST)


def as_it_is(name: str) -> str:
    """Mark a name, for a text that is translated as a whole; English needs no mark.

    >>> as_it_is("current")
    'current'
    """
    return name if current() == ENGLISH else f"{_FIRST}{name}{_LAST}"


def without_marks(text: str) -> str:
    """Take the marks away, the names stay."""
    return text.translate(_MARKS)
