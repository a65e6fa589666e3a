"""What the columns, codes and branches of a load test are called."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from pipeline.ingest.data_files import data_of
from pipeline.ingest.unit_text import fold_lookalikes
from pipeline.ingest.vocabulary import pattern_of, plain, words_of

Branch = Literal["loading", "unloading"]

REQUIRED = (("shaft_speed",), ("torque",))
BRANCH_WORDS = words_of("directions", "branches")
_UNLOADING, _LOADING, _WARM_UP, _OTHER_CODE = map(
    pattern_of, ("unloading", "loading", "warm_up", "other_code")
)
#: These are a branch only where nothing else stands beside them.
_BRANCH_ALONE: Mapping[str, Branch] = data_of("bench_words")["alone"]["branches"]

_NUMBER = r"(?P<number>\d{1,5}(?:[.,]\d+)?)(?![\d.,/\-…]*\d)\s*(?P<percent>%)?"
_SIGN = r"(?P<sign>[+\-\u2212\u2013]|minus\s+|plus\s+|минус\s+|плюс\s+)?"
_WORD = pattern_of("code_word").pattern
_CODE_WORD = re.compile(
    rf"(?<![a-zа-я]){_WORD}(?:[\s_]*\(?\bN\b\)?)?"
    # "code-40" may have a dash where "code -40" and "code: -40" have a sign.
    rf"(?:[\s_]*[=:№#]\s*|(?P<dash>-)(?=\d)|[\s_]+|(?=\d)){_SIGN}{_NUMBER}",
    re.IGNORECASE,
)
_CODE_SYMBOL = re.compile(rf"(?<![A-Za-zА-Яа-я])N\s*[=:]\s*(?P<dash>(?!))?{_SIGN}{_NUMBER}")
_CODE_ALONE = re.compile(rf"\s*(?P<dash>(?!))?{_SIGN}{_NUMBER}\s*(?:code|код)?\s*", re.IGNORECASE)
_COPY = re.compile(r"\s*\(\d{1,2}\)\s*$")
_CODE_LABEL = re.compile(rf"^\W*(?:{_WORD}|N)(?:\s*\(?N\)?)?\s*[=:,]?\s*$", re.IGNORECASE)


@dataclass(frozen=True)
class CodeText:
    """A control code found in a text. `doubtful_sign`: the hyphen may be a dash ("code-40")."""

    value: float
    percent: bool = False
    doubtful_sign: bool = False

    def in_codes(self, code_max: float) -> float:
        """Return the code; per cent are of the code at full command.

        >>> CodeText(50.0, percent=True).in_codes(127), CodeText(50.0).in_codes(127)
        (63.5, 50.0)
        """
        return self.value * code_max / 100.0 if self.percent else self.value


def code_in_text(text: str, *, alone: bool = False) -> CodeText | None:
    """Find a control code in a sheet's name, a file's name or a heading.

    None where it holds none, or two different ones. A number `alone` is a code too (sheet names).

    >>> [code_in_text(text).value for text in ("Код 90", "N=+127", "code_040", "Control code: -90")]
    [90.0, 127.0, 40.0, -90.0]
    >>> code_in_text("90"), code_in_text("-90", alone=True).value, code_in_text("error code 5")
    (None, -90.0, None)
    """
    text = _COPY.sub("", text)
    if _OTHER_CODE.search(text):
        return None
    found = list(_CODE_WORD.finditer(text)) or list(_CODE_SYMBOL.finditer(text))
    if not found and alone:
        whole = _CODE_ALONE.fullmatch(text)
        found = [] if whole is None else [whole]
    codes = {_read(match) for match in found}
    return codes.pop() if len(codes) == 1 else None


def _read(match: re.Match[str]) -> CodeText:
    sign = (match["sign"] or "").strip().casefold()
    negative = sign in {"-", "\u2212", "\u2013", "minus", "минус"}
    value = float(match["number"].replace(",", "."))
    return CodeText(
        -value if negative else value, match["percent"] is not None, match["dash"] is not None
    )


def is_code_label(text: str) -> bool:
    """Tell whether a cell announces a code in the next cell.

    >>> is_code_label("Control code:"), is_code_label("Код"), is_code_label("Torque")
    (True, True, False)
    """
    return _CODE_LABEL.match(text) is not None


def branch_in_text(text: str) -> Branch | None:
    """Return the branch that a text names.

    >>> branch_in_text("Unloading"), branch_in_text("Нагружение"), branch_in_text("Torque")
    ('unloading', 'loading', None)
    """
    words = " ".join(fold_lookalikes(word) for word in plain(text).split())
    if _UNLOADING.search(words):
        return "unloading"
    return "loading" if _LOADING.search(words) else _BRANCH_ALONE.get(words)


def is_warm_up(text: str) -> bool:
    """Tell whether a text marks a warm-up.

    >>> is_warm_up("warm-up"), is_warm_up("Прогрев 2 мин"), is_warm_up("steady")
    (True, True, False)
    """
    return _WARM_UP.search(plain(text)) is not None
