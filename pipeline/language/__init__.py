"""The reader's language: what is said to a person is translated where it is said, and only there.

Records, logs and every file that a machine reads stay English, whatever the language. The texts
are written in English all over the program; `translate` finds the template that a text was made
from in the catalogue (``<language>.po``) and says it again in the language chosen.
"""

from functools import cache, lru_cache
from pathlib import Path

from pipeline.language.catalogue import Catalogue
from pipeline.language.po import read_po
from pipeline.reader_language import (
    ENGLISH,
    LANGUAGES,
    VARIABLE,
    as_it_is,
    current,
    use,
    wanted,
    without_marks,
)

__all__ = ["ENGLISH", "LANGUAGES", "VARIABLE", "as_it_is", "current", "translate", "use", "wanted"]


def translate(text: str) -> str:
    """Say an English text, of any number of lines, in the language of this process.

    >>> translate("row 3")
    'row 3'
    """
    language = current()
    # a name may have been marked, and kept, when another language was chosen
    return without_marks(text) if language == ENGLISH or not text else _said(text, language)


@lru_cache(maxsize=20_000)
def _said(text: str, language: str) -> str:
    return without_marks(catalogue(language).say(text))


@cache
def catalogue(language: str) -> Catalogue:
    """Return the catalogue of a language, read once."""
    text = Path(__file__).with_name(f"{language}.po").read_text(encoding="utf-8")
    return Catalogue(read_po(text))
