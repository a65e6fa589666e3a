"""A message with places for values, ``{0} points left out``, and how a text is told to be of it."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

_FIELD = re.compile(r"\{(\d+)\}")
_LETTER = re.compile(r"[A-Za-z]")
#: Fewer letters than this say little: the values must then be known, or names.
_FEW_LETTERS, _FEW_AT_END = 5, 12


def variants(text: str) -> Iterator[tuple[str, str]]:
    """Yield a text as it could stand in the catalogue, and what to add to the translation."""
    for one in (text, turned(text)):
        yield one, ""
        if one.endswith("."):
            yield one[:-1], "."


def turned(text: str) -> str:
    """Begin with a small letter instead of a capital, or the other way."""
    return text[:1].swapcase() + text[1:]


def as_begun(text: str, message: str, said: str) -> str:
    """Let a translation begin with a capital, or not, as the text does."""
    if text[:1] == message[:1] or text[:1].lower() != message[:1].lower():
        return said
    return said[:1].upper() + said[1:] if text[:1].isupper() else said[:1].lower() + said[1:]


@dataclass(frozen=True)
class Template:
    """What stands between the values, and their numbers in the order of the text.

    There is one literal more than there are values; the first or last may be empty.
    """

    literals: tuple[str, ...]
    order: tuple[int, ...]

    @classmethod
    def of(cls, message: str) -> "Template":
        """Take a message apart.

        >>> Template.of("row {0} of {1}")
        Template(literals=('row ', ' of ', ''), order=(0, 1))
        """
        parts = _FIELD.split(message)
        return cls(tuple(parts[::2]), tuple(int(number) for number in parts[1::2]))

    @property
    def letters(self) -> int:
        """How many letters it has, apart from the values: the more, the surer a match is."""
        return sum(len(_LETTER.findall(literal)) for literal in self.literals)

    @property
    def between(self) -> str:
        """What stands between its values."""
        return " ".join(self.literals)

    @property
    def is_weak(self) -> bool:
        """Whether it could fit by chance: it says little, or only at its end."""
        return self.letters < (_FEW_LETTERS if self.literals[0] else _FEW_AT_END)

    @property
    def first_word(self) -> str:
        """The first word in small letters, none if the message begins with a value."""
        head = self.literals[0]
        return head.split(" ", 1)[0].lower() if " " in head or len(self.literals) == 1 else ""

    def match(self, text: str) -> dict[int, str] | None:
        """Return the values of a text that was made from this, None for any other text.

        Each literal is taken where it comes first, without a way back, so a hostile text costs no
        more than a long one. The first letter may be a capital or not.

        >>> Template.of("Row {0} of {1}").match("row 3 of a.csv")
        {0: '3', 1: 'a.csv'}
        """
        head, *middle = self.literals
        if not middle:
            return {} if _alike(text, head) else None
        last = middle.pop()
        if not _alike(text[: len(head)], head) or not text.endswith(last):
            return None
        end = len(text) - len(last)
        at = len(head)
        values: dict[int, str] = {}
        for number, literal in zip(self.order[:-1], middle, strict=True):
            found = text.find(literal, at, end)
            if found < 0:
                return None
            values[number] = text[at:found]
            at = found + len(literal)
        if at > end:
            return None
        values[self.order[-1]] = text[at:end]
        return values


def _alike(text: str, literal: str) -> bool:
    return text[1:] == literal[1:] and text[:1].lower() == literal[:1].lower()


def fill(form: str, values: Sequence[str] | dict[int, str]) -> str:
    """Put values into a translation, which may leave some out and have them in another order.

    >>> fill("строка {0} ({1})", ["3", "a.csv"])
    'строка 3 (a.csv)'
    """
    return _FIELD.sub(lambda found: values[int(found[1])], form)
