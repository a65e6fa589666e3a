"""Messages with their translations, and how a text that was made from one is found again.

A text is looked for as a whole, then as a template with values (which are translated in turn),
then in parts: a list of known items, sentences, a place before a colon. What is not found stays
English; its numbers are written as the reader expects them all the same.
"""

import re
from collections.abc import Callable, Iterator
from gettext import c2py

from pipeline.language import phrases
from pipeline.language.numerals import UNITS, has_words, in_russian, is_measured
from pipeline.language.phrases import BRACKETED, SEMICOLON
from pipeline.language.po import Entry
from pipeline.language.template import Template, as_begun, fill, turned, variants
from pipeline.reader_language import MARKED

#: A line beyond this is no message of ours.
_LONGEST = 4000
_DEEPEST = 6
_MOST_ITEMS = 16
#: A template of so many is no chance match: it goes before everything else.
_MANY_LETTERS = 20
#: One of so many is none even where a value of it holds the end of a sentence ("vehicle.yaml. ").
_VERY_MANY_LETTERS = 40
_MOST_REMEMBERED = 50_000
#: So many pieces of a line are looked for: a hostile text costs no more than a long one.
_MOST_PIECES = 400
_SENTENCES = re.compile(
    r"(?<=[.!?]) (?=[A-Z\"\d])(?<!\bfig\. )(?<!\bfigs\. )(?<!\beq\. )(?<!\beqs\. )"
)
#: A value that stays as it is: of an option, of a key, between quotation marks.
_TYPED = re.compile(r"(?:=|--[\w-]+ |[\"'`])\{(\d+)\}")
_FIELD = re.compile(r"\{(\d+)\}")
#: A value between quotation marks: it has none itself.
_QUOTED = re.compile(r"\"\{(\d+)\}\"")
#: Words of the engineer's files.
_CITED = re.compile(r'"[^"]*"')
_EDGE = re.compile(r"^(\s*(?:(?:[-•*>]|\d+\.) )?)(.*?)(\s*)$", re.DOTALL)
#: A line to be put into vehicle.yaml: its key is no word.
_OF_A_FILE = re.compile(r" {2,}[a-z][a-z0-9_]*: \{")
_PAIR = re.compile(r"\([^()]*\)")
_COUNT = re.compile(r"\d+")
_JOINTS = ("; ", ", ", ". ")
#: Units that are names as well: of a column, a code, an axis.
_AMBIGUOUS = frozenset({"N", "A", "V", "W", "code", "codes"})


class Catalogue:
    """Messages with their translations, arranged for finding.

    The first entry is the head, which says how the language counts.
    """

    def __init__(self, entries: list[Entry]) -> None:
        rule = re.search(r"plural=([^;\n]+)", entries[0].forms[0] if entries else "")
        self._form_of = c2py(rule[1] if rule else "n != 1")
        self._plain: dict[str, Entry] = {}
        self._by_word: dict[str, list[tuple[Template, Entry]]] = {}
        self._anywhere: list[tuple[str, Template, Entry]] = []
        self._remembered: dict[tuple[str, bool], str | None] = {}
        self._patience = _MOST_PIECES
        for entry in entries[1:]:
            if entry.translated:
                for message in filter(None, (entry.message, entry.plural)):
                    self._add(message, entry)
                if entry.message[:2] in _JOINTS and entry.forms[0][:2] in _JOINTS:
                    # "; a healthy vehicle leaves 3 N" is also an item of a list by itself
                    plain = Entry(entry.message[2:], forms=(entry.forms[0][2:],))
                    self._add(plain.message, plain)
        for found in self._by_word.values():
            found.sort(key=lambda one: -one[0].letters)
        self._anywhere.sort(key=lambda one: -one[1].letters)

    def _add(self, message: str, entry: Entry) -> None:
        template = Template.of(message)
        if not template.order:
            self._plain[message] = entry
        elif template.first_word:
            self._by_word.setdefault(template.first_word, []).append((template, entry))
        else:
            self._anywhere.append((max(template.literals, key=len), template, entry))

    def say(self, text: str) -> str:
        """Translate a text of any number of lines, as much of it as is in the catalogue."""
        if "\n" in text:
            return "\n".join(self.say(line) for line in text.split("\n"))
        found = _EDGE.match(text)
        if found is None or not found[2] or _OF_A_FILE.match(text):
            return text
        if len(self._remembered) > _MOST_REMEMBERED:
            self._remembered.clear()
        self._patience = _MOST_PIECES
        return f"{found[1]}{self._line(found[2], 0)}{found[3]}"

    def _line(self, text: str, depth: int) -> str:
        if len(text) > _LONGEST or depth > _DEEPEST:
            return in_russian(text)
        known = self._known(text, depth)
        return known if known is not None else in_russian(self._in_parts(text, depth + 1))

    def _known(self, text: str, depth: int, *, sure: bool = False) -> str | None:
        """Translate a text that is in the catalogue, numbers need not be; None for any other.

        `sure`: not even a value of it may be unknown, unless it is a name without blanks.
        """
        simple = self._simple(text)
        if simple is not None or depth > _DEEPEST:
            return simple
        key = (text, sure)
        if key not in self._remembered:
            self._patience -= 1
            found = self._composed(text, depth, sure=sure) if self._patience > 0 else None
            # near the bottom the search is cut short: further up it may succeed
            if found is None and (depth > _DEEPEST // 2 or self._patience <= 0):
                return None
            self._remembered[key] = found
        return self._remembered[key]

    def _simple(self, text: str) -> str | None:
        """Translate a text that stands in the catalogue as it is, a name, a unit or a number."""
        if MARKED.fullmatch(text) or _CITED.fullmatch(text):
            return text
        if not has_words(text):
            entry = self._plain.get(text)
            return entry.forms[0] if entry is not None else in_russian(text)
        for variant, ending in variants(text):
            entry = self._plain.get(variant)
            if entry is not None:
                return in_russian(as_begun(text, entry.message, entry.forms[0])) + ending
        if is_measured(text):
            return in_russian(text)
        for variant in (f"{text}.", f"{turned(text)}."):
            entry = self._plain.get(variant)
            if entry is not None:
                said = in_russian(entry.forms[0].removesuffix("."))
                return as_begun(text, entry.message, said)
        return UNITS.get(text) if text not in _AMBIGUOUS else None

    def _composed(self, text: str, depth: int, *, sure: bool) -> str | None:
        """Translate a text that is put together: a label, a count, a list, a template."""

        def known(part: str) -> str | None:
            return self._known(part, depth + 1, sure=True)

        ways: tuple[Callable[[], str | None], ...] = (
            lambda: phrases.with_remark(text, known),
            # before any template: "error: rov8" is no value of "{0} has no allocator: section"
            lambda: self._announced(text, depth, sure=sure),
            lambda: self._fitting(text, depth, sure=sure, least=_MANY_LETTERS),
            lambda: self._fitting(text, depth, sure=sure, sentences=True, least=_VERY_MANY_LETTERS),
            # an item does not reach over the end of a sentence
            lambda: None if _SENTENCES.search(text) else phrases.items(text, known),
            lambda: phrases.named_numbers(text, known),
            lambda: self._fitting(text, depth, sure=sure),
            lambda: phrases.counted(text, known),
            lambda: self._sentences(text, depth, sure=sure),
            lambda: None if sure else self._fitting(text, depth, sentences=True),
        )
        return next((said for way in ways if (said := way()) is not None), None)

    def _fitting(
        self,
        text: str,
        depth: int,
        *,
        sure: bool = False,
        sentences: bool = False,
        least: int = 0,
    ) -> str | None:
        """Translate by the template that fits best; a value may hold whole `sentences` or not.

        `least`: letters that a template must have.
        """
        for variant, ending in ((text, ""), (text[:-1], ".")):
            if ending and not text.endswith("."):
                break
            for template, entry in self._candidates(variant):
                values = template.match(variant)
                if values is None or _is_moved(entry, values):
                    continue
                # a message that has a joint of lists itself is not to be taken apart at it
                if template.letters < least and "; " not in template.between:
                    continue
                if not sentences and any(_is_torn(one) for one in values.values()):
                    continue
                if sentences and any(max(template.literals, key=len) in v for v in values.values()):
                    # from one sentence of a kind to the next of the same kind
                    continue
                if any('"' in values[int(number)] for number in _QUOTED.findall(entry.message)):
                    # from one quoted name to the next: a match by chance
                    continue
                said = self._filled(template, entry, values, depth, sure=sure)
                if said is not None:
                    return as_begun(variant, entry.message, said) + ending
        return None

    def _announced(self, text: str, depth: int, *, sure: bool) -> str | None:
        """Translate ``error: ``, ``Expected `` and the like before what is known as a whole."""
        for sign in (": ", " ") if text[:1].isupper() else (": ",):
            before, found, after = text.partition(sign)
            begin = f"{before}{found}" if found else ""
            for template, entry in self._by_word.get(begin.split(" ", 1)[0].lower(), ()):
                if template.literals[1:] == ("",) and template.match(begin) == {0: ""}:
                    # of what a word introduces nothing may be unknown: it may be another sentence
                    said = self._known(after, depth + 1, sure=sure or sign == " ")
                    if said is not None:
                        return as_begun(text, entry.message, fill(entry.forms[0], {0: said}))
        return None

    def _candidates(self, text: str) -> Iterator[tuple[Template, Entry]]:
        yield from self._by_word.get(text.split(" ", 1)[0].lower(), ())
        before, colon, after = text.partition(": ")
        # a name with what is said of it: the name is no part of a message
        of_a_name = bool(colon) and " " not in before and has_words(after)
        for piece, template, entry in self._anywhere:
            if piece in text and not (of_a_name and ":" not in template.between):
                yield template, entry

    def _filled(
        self, template: Template, entry: Entry, values: dict[int, str], depth: int, *, sure: bool
    ) -> str | None:
        """Put the translated values into the translation; None when the match was by chance."""
        form = entry.forms[0]
        if entry.plural:
            if not _COUNT.fullmatch(values[0]):
                return None
            form = entry.forms[min(self._form_of(int(values[0])), len(entry.forms) - 1)]
        typed = {int(number) for number in _TYPED.findall(form)}
        said: dict[int, str] = {}
        for number, value in values.items():
            core = value.strip()
            if not core or number in typed:
                said[number] = value
                continue
            known = self._known(core, depth + 1, sure=sure)
            if known is None:
                if (sure or template.is_weak) and " " in core:
                    return None
                known = self._line(core, depth + 1)
            said[number] = value.replace(core, known, 1)
        return in_russian(fill(form, said))

    def _sentences(self, text: str, depth: int, *, sure: bool) -> str | None:
        """Translate sentences that are all known, some of them together."""
        parts = _SENTENCES.split(text)
        if not 1 < len(parts) <= _MOST_ITEMS:
            return None
        for count in range(len(parts) - 1, 0, -1):
            first = self._known(" ".join(parts[:count]), depth + 1, sure=sure)
            if first is not None:
                last = self._known(" ".join(parts[count:]), depth + 1, sure=sure)
                return None if last is None else f"{first} {last}"
        return None

    def _in_parts(self, text: str, depth: int) -> str:
        """Translate what of a text can be."""
        boundary = _SENTENCES.search(text)
        end = boundary.start() if boundary is not None else len(text)
        at = text.find(": ", 0, end)
        while at >= 0:
            said = self._known(text[at + 2 :], depth)
            if said is not None:
                return f"{self._place(text[:at], depth)}: {said}"
            at = text.find(": ", at + 2, end)
        for signs, joint in ((_SENTENCES, " "), (SEMICOLON, "; ")):
            parts = [part for part in signs.split(text) if part != joint]
            if len(parts) > 1:
                return joint.join(self._line(part, depth) for part in parts)
        before, colon, after = text.partition(": ")
        if colon:
            return f"{self._place(before, depth)}: {self._line(after, depth)}"
        return self._with_brackets(text, depth) or self._listed(text, depth)

    def _listed(self, text: str, depth: int) -> str:
        """Translate the items of a list, of which some are names."""
        parts = text.split(", ")
        if not 1 < len(parts) <= _MOST_ITEMS:
            return text
        known = [self._known(part, depth) for part in parts]
        # many unknown ones are a sentence that is not in the catalogue
        if sum(item is None for item in known) > len(known) // 2:
            return text
        return ", ".join(
            self._line(part, depth) if item is None else item
            for part, item in zip(parts, known, strict=True)
        )

    def _place(self, text: str, depth: int) -> str:
        known = self._known(text, depth)
        if known is not None:
            return known
        return ", ".join(self._line(part, depth) for part in text.split(", "))

    def _with_brackets(self, text: str, depth: int) -> str:
        """Translate ``name (value)``, where a part of it is known; empty for any other text."""
        found = BRACKETED.fullmatch(text)
        if found is None:
            return ""
        before, gap, inside, stop = found.groups()
        whole = self._known(f"({inside})", depth)
        if whole is None:
            whole = f"({self._line(inside, depth)})"
        return f"{self._line(before, depth)}{gap}{whole}{stop}"


def _is_moved(entry: Entry, values: dict[int, str]) -> bool:
    """Whether what was said before a message would come to stand inside its translation."""
    first = _FIELD.match(entry.message)
    if first is None or entry.forms[0].startswith(first[0]):
        return False
    before = values[int(first[1])]
    return ": " in before or _SENTENCES.search(before) is not None


def _is_torn(value: str) -> bool:
    """Whether a value reaches over the end of a sentence or out of brackets: a match by chance."""
    left = _PAIR.sub("", _PAIR.sub("", value))
    return "(" in left or ")" in left or _SENTENCES.search(value) is not None
