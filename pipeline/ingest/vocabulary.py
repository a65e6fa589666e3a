"""What columns are called, in English and Russian, and how a header text is matched with it."""

import functools
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

from pipeline.ingest.data_files import data_of
from pipeline.ingest.unit_text import fold_lookalikes, normalise_unit, quantities_of

_PUNCTUATION = re.compile(r"[^\w%°]+|_")
_GROUPS = (re.compile(r"\[([^\[\]]*)\]"), re.compile(r"\(([^()]*)\)"), re.compile(r"\{([^{}]*)\}"))
_IN = re.compile(r"^(?:in|в|ед\.?\s*изм\.?:?|units?:?)\s+", re.IGNORECASE)
_LONGEST_HEADER = 150
#: Letters without a width, and signs of the width of a Chinese letter.
_UNSEEN = re.compile("[\u00ad\u200b-\u200f\u2060\ufeff]")
_WIDE = str.maketrans("（）［］，：", "()[],:")
_PREFERRED = 15
_LESS = 30
_BY_UNIT = 20


@dataclass(frozen=True)
class Words:
    """What a quantity is called.

    `unit_kind` is the quantity of `pipeline.ingest.unit_text`, None where a column has no unit
    (codes, coefficients, texts). `names` are phrases, ``*`` ends a stem; `symbols` must be the
    whole name, with this case. A column with a word of `prefer` goes before one without, one with
    a word of `less` goes last, one with a word of `never` is something else. `with_unit` are names
    that count only beside a unit of the right kind. `default_unit` is assumed where none is
    stated; None means that it must be stated.
    """

    unit_kind: str | None
    names: tuple[str, ...]
    symbols: tuple[str, ...] = ()
    prefer: tuple[str, ...] = ()
    less: tuple[str, ...] = ()
    never: tuple[str, ...] = ()
    with_unit: tuple[str, ...] = ()
    default_unit: str | None = None
    unit_words: Mapping[str, str] | None = None
    """Words in the name that tell the unit, e.g. {"rpm": "rpm"}."""
    by_unit: bool = False
    """Whether a unit tells the quantity where no list has the name."""


Vocabulary = Mapping[str, Words]


#: Keys of a quantity that are lists of words.
_LISTS = ("names", "symbols", "prefer", "less", "never", "with_unit")


def words_of(group: str, name: str) -> tuple[str, ...]:
    """Return a list of words.

    >>> words_of("directions", "forward")[:3]
    ('forward', 'forwards', 'fwd')
    """
    return tuple(_expanded(data_of("bench_words")[group][name]))


@functools.cache
def vocabulary_of(kind: str) -> Vocabulary:
    """Return what the columns of a kind of test are called, by quantity.

    >>> vocabulary_of("mooring")["thrust"].unit_kind
    'force'
    """
    return {
        quantity: Words(
            unit_kind=stated.get("unit"),
            default_unit=stated.get("default_unit"),
            unit_words=stated.get("unit_words"),
            by_unit=stated.get("by_unit", False),
            **{key: tuple(_expanded(stated.get(key, ()))) for key in _LISTS},
        )
        for quantity, stated in data_of("bench_words")[kind].items()
    }


def _expanded(words: Iterable[str]) -> Iterator[str]:
    """Put the words of a group in the place of its name, "@group"."""
    for word in words:
        if word.startswith("@"):
            yield from words_of("groups", word.removeprefix("@"))
        else:
            yield word


@functools.cache
def pattern_of(name: str) -> re.Pattern[str]:
    """Return a pattern of words.

    >>> pattern_of("warm_up").search("Прогрев 2 мин") is None
    False
    """
    return re.compile(data_of("bench_words")["patterns"][name], re.IGNORECASE)


FIRST_RANK = words_of("groups", "first_rank")
#: Units of more than one thing: an acceleration in g, a mass in kg.
MANY_MEANINGS = frozenset(map(normalise_unit, words_of("groups", "many_meanings")))


@dataclass(frozen=True)
class HeaderText:
    """A header cut into name and unit. `odd_unit` stands where a unit is due but is not known."""

    name: str
    unit: str | None = None
    odd_unit: str | None = None


@functools.lru_cache(maxsize=16384)
def plain(text: str) -> str:
    """Return a name in the form in which names are compared.

    >>> plain("  Output_Torque: "), plain("Код  управления")
    ('output torque', 'код управления')
    """
    text = _UNSEEN.sub("", unicodedata.normalize("NFKC", text)).casefold().replace("ё", "е")
    text = _PUNCTUATION.sub(" ", text).strip()
    return " ".join(fold_lookalikes(word) for word in text.split())


def read_unit_cell(text: str) -> str | None:
    """Return the unit text of a cell that holds a unit and nothing else, else None.

    >>> read_unit_cell("[N·m]"), read_unit_cell("в кгс·см"), read_unit_cell("Torque")
    ('N·m', 'кгс·см', None)
    """
    text = _IN.sub("", text.strip())
    if not quantities_of(text):
        return None
    return text[1:-1].strip() if text[:1] in "[({" and text[-1:] in "])}" else text


@functools.lru_cache(maxsize=4096)
def split_header(text: str) -> tuple[HeaderText, ...]:
    """Cut a header into name and unit; the readings that are possible, best first.

    >>> split_header("Torque, kg cm")
    (HeaderText(name='Torque', unit='kg cm', odd_unit=None),)
    >>> split_header("Torque (load cell) [N·mm]")[0].unit
    'N·mm'
    >>> split_header("Output Torque")
    (HeaderText(name='Output Torque', unit=None, odd_unit=None),)
    """
    text = " ".join(text.translate(_WIDE).lstrip("#").split())
    if len(text) > _LONGEST_HEADER:
        return (HeaderText(text),)
    return _split_brackets(text) or _split_comma(text) or _split_words(text)


def _split_brackets(text: str) -> tuple[HeaderText, ...]:
    """Find a unit in brackets; empty where there are none."""
    odd: HeaderText | None = None
    for pattern in _GROUPS:
        for group in reversed(list(pattern.finditer(text))):
            unit = read_unit_cell(group[1])
            name = (text[: group.start()] + " " + text[group.end() :]).strip(" ,;:")
            if unit is not None and name:
                return (HeaderText(name, unit),)
            if odd is None and name and group[1].strip():
                odd = HeaderText(name, None, group[1].strip())
    if odd is None:
        return ()
    within = split_header(odd.name)  # "Torque, N m (load cell)"
    return within if within[0].unit is not None else (odd, HeaderText(text))


def _split_comma(text: str) -> tuple[HeaderText, ...]:
    """Find a unit after the last comma or semicolon; empty where there is none."""
    odd: HeaderText | None = None
    for parting in (";", ","):
        name, found, tail = text.rpartition(parting)
        if found and name.strip() and tail.strip():
            unit = read_unit_cell(tail)
            if unit is not None:
                return (HeaderText(name.strip(" ,;:"), unit),)
            odd = HeaderText(name.strip(), None, tail.strip())
    return () if odd is None else (HeaderText(text), odd)


def _split_words(text: str) -> tuple[HeaderText, ...]:
    """Find a unit in the last words: "Torque kg cm", "torque_nm", "Torque / N m", "U in V"."""
    for parting in (r"\s+", r"[\s_]+", r"\s*/\s*"):
        words = re.split(f"({parting})", text)
        for start in range(2, len(words), 2):
            tail = "".join(words[start:])
            unit = read_unit_cell(tail.replace("_", " "))
            name = re.sub(r"\s(?:in|в)$", "", "".join(words[: start - 1])).strip(" ,;:/-–—_")
            if unit is None or not name or unit in {"-", "1"}:
                continue
            reading = HeaderText(name, unit)
            # "Drive A" may be a drive called A: one letter alone is not yet a unit. Nor is the KT
            # of "Thrust coefficient KT", read as knots.
            is_short = len(normalise_unit(unit).replace("*", "")) <= 2
            return (reading, HeaderText(text)) if is_short else (reading,)
    return (HeaderText(text),)


@functools.lru_cache(maxsize=512)
def _pattern(phrase: str) -> re.Pattern[str]:
    words = [
        re.escape(plain(word.rstrip("*"))) + (r"\w*" if word.endswith("*") else "")
        for word in phrase.split()
    ]
    return re.compile(r"(?<!\w)" + " ".join(words) + r"(?!\w)")


def _has(name: str, phrases: tuple[str, ...]) -> bool:
    return any(_pattern(phrase).search(name) for phrase in phrases)


def name_score(header: HeaderText, words: Words) -> int:
    """Return how well a name fits a quantity, 0 for not at all; units are not looked at.

    >>> torque = Words("torque", ("torque",), ("M",), never=("constant",), less=("absorber",))
    >>> [name_score(HeaderText(name), torque) for name in ("Torque", "M", "m", "Torque constant")]
    [100, 100, 0, 0]
    """
    name = plain(header.name)
    if not name or len(header.name) > 80 or _has(name, words.never):
        return 0
    bare = header.name.strip()
    if bare in words.symbols or fold_lookalikes(bare) in words.symbols:
        return 100
    best = 0
    # "thrust corrected" is no worse a name than "thrust"
    preferred = [found[0] for word in words.prefer for found in _pattern(word).finditer(name)]
    spare = sum(len(one) + 1 for one in preferred)
    phrases = [(phrase, 0) for phrase in words.names]
    phrases += [(phrase, _BY_UNIT) for phrase in words.with_unit if header.unit is not None]
    for phrase, less in phrases:
        found = _pattern(phrase).search(name)
        if found is not None:
            length = found.end() - found.start()
            rest = max(len(name) - length - spare, 0)
            score = 100 if rest == 0 else 50 + min(length, 40) // 2 - min(rest, 40) // 2
            best = max(best, score - less)
    if best == 0:
        indexed = re.sub(r"[\s_]*\d{1,2}$", "", bare)
        return 90 if indexed != bare and indexed in words.symbols else 0
    best += _PREFERRED if preferred else 0
    best -= _LESS if _has(name, words.less) else 0
    return max(best, 1)


def is_other(header: HeaderText, phrases: tuple[str, ...]) -> bool:
    """Tell whether a name has one of these phrases."""
    return _has(plain(header.name), phrases)


def unit_fits(unit: str, words: Words) -> bool:
    """Tell whether a unit text is one of the quantity.

    >>> unit_fits("N m", Words("torque", ())), unit_fits("V", Words("torque", ()))
    (True, False)
    """
    kinds = quantities_of(unit)
    return (words.unit_kind or "ratio") in kinds


#: A piece of a remark that ends with a unit: "all forces in kgf", "Thrust [gf]".
_IN_BRACKETS, _AFTER_IN = re.compile(r"[\[(]([^\[\]()]+)[\])]"), re.compile(r"\s(?:in|в)\s+\S+$")


def unit_in_text(text: str, words: Words) -> str | None:
    """Return the unit that a title or a remark states for all readings of a quantity.

    A size ("range 500 N") states none, nor does a letter that may be a name ("tank N").

    >>> force = Words("force", ("thrust", "force"), by_unit=True)
    >>> [unit_in_text(text, force) for text in ("Force in kg, time in s", "range 50 kgf", "lbf")]
    ['kg', None, 'lbf']
    """
    pieces = [piece.strip() for piece in re.split(r"[,;]|\.\s", text)]
    pieces += [f"in {piece.strip()}" for piece in _IN_BRACKETS.findall(text)]
    for piece in pieces:
        whole = read_unit_cell(piece)
        header = HeaderText("", whole) if whole else split_header(piece)[0]
        unit = header.unit
        if unit is None or not unit_fits(unit, words) or header.name[-1:].isdigit():
            continue
        is_long = len(unit) > 1 or piece.startswith("in ") or _AFTER_IN.search(piece) is not None
        is_plain = words.by_unit and not {"time", "speed"} & quantities_of(unit)  # min, kt
        is_plain &= normalise_unit(unit) not in MANY_MEANINGS
        is_said = is_long and (is_plain or (not whole and name_score(header, words) > 0))
        if is_said:
            return unit
    return None


def unit_told_by_name(header: HeaderText, words: Words) -> str | None:
    """Return the unit that the name itself tells ("RPM"), if any."""
    name = plain(header.name)
    for phrase, unit in (words.unit_words or {}).items():
        if _pattern(phrase).search(name):
            return unit
    return None


#: Factors in the name of a column, such as "Thrust x 10": they may multiply or divide.
_OF_TEN = r"10+(?:\s*(?:\^|\*\*)\s*[-\u2212+]?\d+|[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+|(?!\d|[.,]\d))"
_POWER = rf"(?:{_OF_TEN}|0[.,]0*1(?!\d))"
_FACTOR = re.compile(
    rf"(?<!\d)(?<!\d\s)[×·*⋅∙•]\s*{_POWER}"
    rf"|(?:(?<=[\s)\]_])|(?<=[KКCС][TТQMМ]))(?<!\d\s)[xXхХ]\s*{_POWER}"
    r"|10+\s*(?:(?:\^|\*\*)\s*[-\u2212+]?\d+|[⁻⁺]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)"
    r"|^\s*10+\s*[×·*⋅∙•](?=\s*[^\W\d])|(?<=[\s)\]])[/÷]\s*10+(?!\d|[.,]\d)"
    r"|(?<=[^\W\d_]{4})/\s*10+(?!\d|[.,]\d)"
)
_TENFOLD = re.compile(r"^\s*10+\s*[xXхХ]?\s*(?=[KСCК])")


def factor_in_name(header: str, quantity: str) -> str | None:
    """Return the factor that the name of a column holds, None where there is none.

    Coefficients may have a 10 in front.

    >>> [factor_in_name(name, "thrust") for name in ("Thrust x 10, N", "T x 0.1", "APC 10x10, N")]
    ['x 10', 'x 0.1', None]
    >>> factor_in_name("10KT", "thrust_coefficient"), factor_in_name("10 s mean", "thrust")
    ('10', None)
    """
    found = _FACTOR.search(header)
    if found is None and quantity.endswith("coefficient"):
        found = _TENFOLD.search(header)
    return None if found is None else found[0].strip()
