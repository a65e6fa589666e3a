"""Which rows were taken in reverse: a column or headings that say so, where codes have no sign."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath

from pipeline.errors import Problem
from pipeline.ingest.bench_table import Table
from pipeline.ingest.blocks import Block
from pipeline.ingest.cells import column_letter, is_number, is_text, parse_number, shorten
from pipeline.ingest.data_files import data_of
from pipeline.ingest.rows import listed
from pipeline.ingest.vocabulary import pattern_of, plain, split_header, words_of
from pipeline.vehicle.bench_schema import Direction

_DIRECTIONS = data_of("bench_words")["directions"]
_LETTERS, _TURNS, _SIGNS, _TRUTHS = (
    _DIRECTIONS[name] for name in ("letters", "turns", "signs", "truths")
)
_MOST_TEXTS, _SIDES = 4, (1, -1)


@dataclass(frozen=True)
class RowDirections:
    """Direction of each row that has one (1 ahead, -1 reverse), its column, and what was odd."""

    signs: Mapping[int, int]
    column: int | None
    problem: Problem | None = None


def directions_of(
    block: Block, rows: Sequence[int], stated: Direction | None, kind: str
) -> RowDirections:
    """Find the direction of the rows of a table that hold readings.

    No signs where nothing tells a direction; an error where a column of that name holds two words
    that are not understood. `stated` is what vehicle.yaml says, `kind` its section.
    """
    for index, head in block.heads_not_read():
        if stated is None:
            found = _of_column(block, rows, index, head, kind)
        elif plain(head) == plain(stated.header):
            words = {plain(text) for text in stated.reverse}
            texts = block.texts_in(rows, index)
            signs = {row: -1 if plain(text) in words else 1 for row, text in texts.items()}
            found = RowDirections(signs, index)
        else:
            continue
        if found is not None:
            # a blank cell says what the one above says
            signs, last = {}, 0
            for row in rows:
                last = found.signs.get(row, last)
                signs |= {row: last} if last else {}
            return replace(found, signs=signs)
    # within a load test these words are its branches, loading and unloading
    no_words = _BRANCHES if kind == "load_test" else frozenset()
    return RowDirections(_sections(block, rows, no_words), None)


def tells_direction(head: str, texts: Iterable[str]) -> bool:
    """Tell whether a column of words is of directions, or of the course of a sweep.

    >>> tells_direction("Dir", ["F", "R"]), tells_direction("Motor", ["A7", "A8"])
    (True, False)
    """
    distinct = list(dict.fromkeys(map(_key, texts)))
    are_courses = plain(head) in _PLAIN_NAMES or _COURSES.issuperset(distinct)
    return are_courses or _meaning(distinct, is_named=True)[0] is not None


def _of_column(
    block: Block, rows: Sequence[int], index: int, head: str, kind: str
) -> RowDirections | None:
    names = {plain(head), *(plain(one.name) for one in split_header(head))}
    is_named = bool(_section_sign(head)) or not _PLAIN_NAMES.isdisjoint(names)
    first = next((one for row in rows if (one := block.sheet.cell(row, index)) is not None), None)
    is_worded = isinstance(first, str) and (is_text(first) or first.strip() in _SIGNS)
    if not is_named and not is_worded:
        return None
    texts = block.texts_in(rows, index)
    distinct = list(dict.fromkeys(map(_key, texts.values())))
    if not 1 <= len(distinct) <= _MOST_TEXTS or 2 * len(texts) < len(block.rows_of_numbers()):
        return None
    # 1 is reverse in a column that is called so, ahead in one that is called that
    of_head = -_section_sign(head)
    truths = [one for one in _TRUTHS if of_head and set(distinct) <= set(one)]
    are_signs, are_two = set(distinct) <= {*_SIGNS, "1"}, len(distinct) == len(_SIDES)
    if any(map(is_number, distinct)) and not (truths or (is_named and (are_signs or are_two))):
        return None
    meaning, by_turn = _meaning(distinct, is_named=is_named)
    if truths:
        meaning, by_turn = {text: sign * of_head for text, sign in truths[0].items()}, False
    name, place = shorten(head), block.sheet.place(block.header_row, column_letter(index))
    if meaning is None:
        shown = ", ".join(f'"{shorten(text, 20)}"' for text in distinct)
        unknown = place.error(
            f'"{name}" parts the rows into {shown}; which of them is reverse is not known. So the '
            "table was left out.",
            "negative codes, or words such as forward and reverse.",
            f"State it in vehicle.yaml:\n  columns:\n    {kind}:\n      direction: "
            f'{{header: "{name}", reverse: ["..."]}}',
        )
        return RowDirections({}, index, unknown) if is_named and len(distinct) > 1 else None
    if -1 not in meaning.values():
        return None
    problem = None
    if by_turn:
        back = next(text for text in texts.values() if meaning[_key(text)] < 0)
        problem = place.warning(
            f'"{name}": "{shorten(back)}" is taken for reverse, that is for negative codes; a '
            "left-handed screw pushes ahead with it.",
            "",
            "If it is the other way round, state it in vehicle.yaml: columns: "
            f'{{{kind}: {{direction: {{header: "{name}", reverse: [...]}}}}}}.',
        )
    return RowDirections({row: meaning[_key(text)] for row, text in texts.items()}, index, problem)


def column_that_parts(block: Block, low: Sequence[int], high: Sequence[int]) -> str:
    """Return the name of a column that is not read and says other things of low rows than of high.

    Empty where there is none.
    """
    for index, head in block.heads_not_read():
        own, other = ({*block.texts_in(rows, index).values()} for rows in (low, high))
        if own and other and own.isdisjoint(other) and len(own | other) <= 2 * _MOST_TEXTS:
            return shorten(head)
    return ""


def reverse_texts(block: Block, found: RowDirections) -> list[str]:
    """Return the texts of a column of directions that mean reverse."""
    if found.column is None:
        return []
    cells = [block.sheet.cell(row, found.column) for row, sign in found.signs.items() if sign < 0]
    return list(dict.fromkeys(str(cell).strip() for cell in cells if cell is not None))


def _meaning(distinct: Sequence[str], *, is_named: bool) -> tuple[dict[str, int] | None, bool]:
    """Return the sign of each text, None where one is not understood; whether a turn tells it."""
    texts, by_words = set(distinct), {text: _section_sign(text) for text in distinct}
    for signs, by_turn, is_told in (
        (_WORDS, False, texts <= _WORDS.keys()),
        (_TURNING, True, texts <= _TURNING.keys()),
        *((one, False, texts == set(one)) for one in _LETTERS),
        *((one, True, texts == set(one)) for one in _TURNS),
        (by_words, False, all(by_words.values()) and (is_named or len({*by_words.values()}) > 1)),
        *((one, True, is_named and texts < set(one)) for one in _TURNS),
    ):
        if is_told:
            return {text: signs[text] for text in distinct}, by_turn
    return None, False


def _sections(block: Block, rows: Sequence[int], no_words: frozenset[str]) -> dict[int, int]:
    """Return the direction that the nearest heading between the rows says."""
    signs: dict[int, int] = {}
    heads = " ".join(str(one.value) for one in block.above if one.row > block.header_row)
    sign, wanted = _section_sign(heads, no_words), set(rows)
    for row, cells in block.rows():
        if row in wanted:
            if sign:
                signs[row] = sign
            continue
        text = block.section_text(cells)
        if text is None or not is_text(text):
            continue
        sign = _section_sign(text, no_words) or sign
    return signs


def _section_sign(text: str, no_words: frozenset[str] = frozenset()) -> int:
    """Return the direction that a heading states, 0 for none or both."""
    words = set(plain(text).split()) - no_words
    ahead, back = words & _PLAIN_FORWARD, words & _PLAIN_REVERSE
    return 0 if bool(ahead) == bool(back) else (1 if ahead else -1)


def with_signed_codes(table: Table) -> Iterator[Problem]:
    """Give codes the sign of their direction, where anything tells one.

    Codes that have signs already keep them, and rows in which the two contradict are named. The
    table is left out where a column parts the rows and nobody knows how.
    """
    codes = {one.row: one.values["code"] for one in table.readings if "code" in one.values}
    if codes:
        stated = getattr(table.vehicle.columns, table.kind).direction
        found = directions_of(table.block, list(codes), stated, table.kind)
        signs, unsigned = found.signs, min(codes.values()) >= 0.0
        unknown = found.problem is not None and found.problem.severity == "error"
        if found.problem is not None and (unsigned or not unknown):
            yield found.problem
        if unsigned and not unknown:
            if told := "" if signs else _told_reverse(table):
                signs = dict.fromkeys(codes, -1)
                by_turn = table.told_apart_by - _WORDS.keys()
                say = table.place.warning if by_turn else table.place.note
                yield say(
                    f'"{shorten(told)}" says reverse and no code is negative: codes were given a '
                    "minus."
                )
            table.change(
                lambda one: (
                    one.with_values(code=codes[one.row] * signs.get(one.row, 1))
                    if one.row in codes
                    else one
                )
            )
        wrong = [row for row, code in codes.items() if code * signs.get(row, 0) < 0.0]
        if wrong and not unsigned:
            letter = None if found.column is None else column_letter(found.column)
            yield table.block.sheet.place(wrong[0], letter).warning(
                f"the direction and the sign of the code contradict in {listed(wrong)}.",
                "one direction a row.",
                "Correct the rows, or rename the column if it is no direction of thrust.",
            )
        table.must_go |= unknown and unsigned
    if table.must_go:
        table.is_left_out, table.readings = True, []


def words_apart(stem: str, others: Sequence[str]) -> frozenset[str]:
    """Return the words of a direction by which a file's name differs from that of another.

    >>> sorted(words_apart("run 2 rev", ["run 2 fwd"])), sorted(words_apart("rev 2", ["rev 3"]))
    (['rev'], [])
    """
    own, found = plain(stem).split(), set()
    for other in others:
        pairs = zip(own, plain(other).split(), strict=False)
        apart = [pair for pair in pairs if pair[0] != pair[1]]
        if len(apart) == 1 and len(own) == len(plain(other).split()):
            signs = [_IN_NAMES.get(word, 0) for word in apart[0]]
            found |= {apart[0][0]} if signs[0] * signs[1] < 0 else set()
    return frozenset(found)


def _told_reverse(table: Table) -> str:
    """Return what says that a whole table is of reverse; empty where nothing does."""
    of_names = _IN_FILE_NAMES | table.told_apart_by
    no_words = _BRANCHES if table.kind == "load_test" else frozenset()
    stem = PurePath(table.place.file).stem
    in_name = " ".join(word for word in plain(stem).split() if word in of_names)
    for shown, text in (*zip(table.texts, table.texts, strict=True), (stem, in_name)):
        sign = _section_sign(pattern_of("of_the_rig").sub(" ", plain(text)), no_words)
        if text == in_name and not sign:
            sign = sum(_IN_NAMES.get(word, 0) for word in table.told_apart_by)
        if sign:
            return shown if sign < 0 else ""
    return ""


def _key(text: str) -> str:
    if is_number(text):
        return f"{parse_number(text):g}"
    return plain(text) or text.strip()


_BRANCHES = frozenset(map(plain, ("прямой", "прямое", "обратный", "обратное", "back")))
_PLAIN_NAMES, _PLAIN_FORWARD, _PLAIN_REVERSE = (
    frozenset(map(plain, words_of("directions", name))) for name in ("names", "forward", "reverse")
)
_COURSES = frozenset(
    plain(word) for name in ("up", "down", "branches") for word in words_of("directions", name)
)
_IN_FILE_NAMES = frozenset(map(plain, words_of("directions", "in_file_names")))
_WORDS = {**dict.fromkeys(_PLAIN_FORWARD, 1), **dict.fromkeys(_PLAIN_REVERSE, -1), **_SIGNS, "1": 1}
#: What files are told apart by: a turn or a letter, too, but not "left" and "right".
_IN_NAMES = {"cw": 1, "ccw": -1, "f": 1, "r": -1, **_WORDS}
_TURNING = {
    plain(word): sign
    for name, sign in (("clockwise", 1), ("counterclockwise", -1))
    for word in words_of("directions", name)
}
