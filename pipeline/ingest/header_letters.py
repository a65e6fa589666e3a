"""Why a heading that looks right is not known: letters of two alphabets, or a wrong encoding."""

import re
from collections.abc import Iterable

_WORD = re.compile(r"[^\W\d_]+")
_LATIN = re.compile(r"[A-Za-z]")
_CYRILLIC = re.compile(r"[\u0400-\u04ff]")
#: Encodings of old Russian programs whose bytes were read as Windows-1251.
_OLD_ENCODINGS = ("koi8_r", "cp866")


def odd_letters(texts: Iterable[str]) -> str:
    """Say in one sentence what is odd about the letters of headings; empty where nothing is.

    Examples
    --------
    >>> odd_letters(["\u0441ode", "thrust (N)"])
    'In "\u0441ode" Cyrillic letters (\u0441) stand among Latin ones'
    >>> odd_letters(["код", "тяга, Н", "thrust (N)"])
    ''
    """
    texts = list(texts)
    for text in texts:
        for word in _WORD.findall(text):
            latin, cyrillic = _LATIN.findall(word), _CYRILLIC.findall(word)
            if not latin or not cyrillic:
                continue
            if len(latin) >= len(cyrillic):
                few = "".join(dict.fromkeys(cyrillic))
                return f'In "{word}" Cyrillic letters ({few}) stand among Latin ones'
            few = "".join(dict.fromkeys(latin))
            return f'In "{word}" Latin letters ({few}) stand among Cyrillic ones'
    for encoding in _OLD_ENCODINGS:
        read = [_read_as(text, encoding) for text in texts]
        if sum(_lower_cyrillic(text) for text in read) > sum(map(_lower_cyrillic, texts)):
            shown = ", ".join(f'"{text}"' for text in read[:4])
            name = encoding.replace("_", "-").upper()
            return f"In the encoding {name} they would be {shown}: save the file as UTF-8"
    return ""


def _read_as(text: str, encoding: str) -> str:
    """Read the bytes of a text again."""
    try:
        return text.encode("cp1251").decode(encoding)
    except UnicodeError:
        return text


def _lower_cyrillic(text: str) -> int:
    """Count the small Cyrillic letters; of words read in a wrong encoding few are."""
    return sum("а" <= letter <= "я" for letter in text)
