"""``python -m evaluation.messages``: bring the catalogues up to date with the program.

Every text of the program that reads like language becomes a message: string literals and f-strings
(whose values become ``{0}``, ``{1}``), the help of commands, ``_("...")`` in templates of pages,
and the lines of `MORE`. Texts with lines are taken line by line, as they are translated.
Translations that are there stay; messages that are gone go. Without an argument all catalogues are
written; with ``--check`` none, and the exit code tells whether a message lacks its translation.
"""

import ast
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pipeline
from pipeline.language.po import Entry, read_po
from pipeline.reader_language import ENGLISH, LANGUAGES

PACKAGE = Path(pipeline.__file__).resolve().parent
#: Where the catalogues are.
LANGUAGE = PACKAGE / "language"
#: Messages that stand nowhere in the program as one text.
MORE = Path(__file__).resolve().with_name("more_messages.txt")

#: Rooms and modules whose texts no person reads, or reads as part of a file for machines.
_SILENT = (
    "bundled/",
    "blind/truth/",
    "language/",
    "export/c_",
    "export/allocator_source.py",
    "export/self_test.py",
    "export/cdr.py",
    "ingest/load_test_words.py",
    "physics/parameters.py",
    "report/plotting.py",
    "campaign/blind_page.py",
    "campaign/measured_page.py",
    "campaign/measured_campaign.py",
    "campaign/page.py",
    "workflow/engine.py",
)
#: Errors for programmers: they never reach a person as they are.
_INTERNAL = {
    "AssertionError",
    "AttributeError",
    "KeyError",
    "LookupError",
    "RuntimeError",
    "TypeError",
    "ValueError",
}
#: Calls whose texts are patterns, paths or arguments of other programs.
_TECHNICAL = {"compile", "getLogger", "encode", "which", "run", "Popen", "add_filter"}
_PROSE = re.compile(
    r"[A-Za-z]{2,}[,;:.)\]]* [A-Za-z({\"'`+-]|\} [a-z]{2,}|[a-z]{2,}[ =] ?\{"
    r"|^[a-z]{3,} [0-9]|^[A-Z][a-z-]+ [\[(]"
)
#: What only a page's headings are.
_WORD = re.compile(r"^[A-Z][a-z-]{3,}$")
#: A column of a table of a page (`report.blocks.Table.of`): its heading, then what stands there.
_COLUMN = re.compile(r"(?:^| \| )([^{}|]+): [^{}|:]*\{")
_IN_TEMPLATE = re.compile(r'_\("([^"]+)"\)')
_FIELD = re.compile(r"\{(\d+)\}")
_COUNTING = {"plural", "_plural"}
_NOTE_LENGTH = 60
_HEAD = (
    "Language: {language}\\nMIME-Version: 1.0\\nContent-Type: text/plain; charset=UTF-8\\n"
    "Content-Transfer-Encoding: 8bit\\n"
)
_COUNTS = {
    "ru": "nplurals=3; plural=(n%10==1 && n%100!=11 ? 0 : n%10>=2 && n%10<=4 && "
    "(n%100<10 || n%100>=20) ? 1 : 2);"
}


@dataclass(frozen=True)
class FoundMessage(Entry):
    """A message, the modules that say it, and what its fields are, for the translator."""

    where: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def messages(package: Path = PACKAGE) -> list[FoundMessage]:
    """Return every message of the program, untranslated, in the order of the modules.

    Parameters
    ----------
    package : Path
        Folder of the package.
    """
    found: dict[str, FoundMessage] = {}
    for path in sorted([*package.rglob("*.py"), *package.rglob("*.j2")]):
        name = path.relative_to(package).as_posix()
        if not name.startswith(_SILENT):
            text = path.read_text(encoding="utf-8")
            own = _of_module(text, name) if path.suffix == ".py" else _of_template(text)
            for entry in own:
                _merge(found, entry, name)
    for line in MORE.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            one, _, many = line.partition("\t")
            _merge(found, FoundMessage(one, many), MORE.name)
    return list(found.values())


def _merge(found: dict[str, FoundMessage], entry: FoundMessage, where: str) -> None:
    known = found.get(entry.message)
    if known is None:
        found[entry.message] = FoundMessage(
            entry.message, entry.plural, entry.forms, (where,), entry.notes
        )
    elif where not in known.where:
        plural = known.plural or entry.plural
        places = (*known.where, where)
        found[entry.message] = FoundMessage(entry.message, plural, known.forms, places, known.notes)


def _of_template(text: str) -> Iterator[FoundMessage]:
    for message in _IN_TEMPLATE.findall(text):
        yield FoundMessage(message)


def _of_module(text: str, name: str) -> Iterator[FoundMessage]:
    tree = ast.parse(text)
    every = list(_in_order(tree))
    silent = _not_shown(tree, every)
    for node in every:
        if isinstance(node, ast.FunctionDef) and _is_command(node):
            for paragraph in help_paragraphs(ast.get_docstring(node, clean=True) or ""):
                yield FoundMessage(paragraph)
        if isinstance(node, ast.Call):
            yield from _counted(node)
        if node in silent or not isinstance(node, ast.Constant | ast.JoinedStr):
            continue
        whole, notes = _message(node)
        plain = node.value if isinstance(node, ast.Constant) else ""
        if name.startswith("report/") and isinstance(plain, str) and " | " in plain:
            whole = "\n".join(_COLUMN.findall(plain)) or whole
        for line in whole.split("\n"):
            message, own = _numbered(line.strip(), notes)
            heading = name.startswith("report/") and _WORD.match(message)
            if (_PROSE.search(message) and " | " not in message) or heading:
                yield FoundMessage(message, notes=own)


def help_paragraphs(text: str) -> Iterator[str]:
    r"""Yield the paragraphs of a command's help as one line each; examples are not translated.

    >>> list(help_paragraphs("Do it.\n\nFor\nall.\n\n\b\nExample:\n  rig2sea run"))
    ['Do it.', 'For all.']
    """
    for paragraph in text.split("\n\n"):
        if not paragraph.lstrip("\\").startswith(("\b", "b\n")):
            yield " ".join(paragraph.split())


def _in_order(tree: ast.AST) -> Iterator[ast.AST]:
    """Walk as a person reads."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        waiting += reversed(list(ast.iter_child_nodes(node)))


def _is_command(node: ast.FunctionDef) -> bool:
    texts = [ast.unparse(one) for one in node.decorator_list]
    return any(re.match(r"(\w+\.)?(command|group)\b", text) for text in texts)


def _counted(node: ast.Call) -> Iterator[FoundMessage]:
    """Yield the message of ``plural(count, "point")``."""
    name = node.func.id if isinstance(node.func, ast.Name) else ""
    words = [str(one.value) for one in node.args[1:] if isinstance(one, ast.Constant)]
    if name in _COUNTING and words:
        many = words[1] if len(words) > 1 else f"{words[0]}s"
        yield FoundMessage(f"{{0}} {words[0]}", f"{{0}} {many}")


def _not_shown(tree: ast.Module, every: Iterable[ast.AST]) -> set[ast.AST]:
    """Collect what is no message: docstrings, parts of f-strings, texts for programmers."""
    assigned = (one for one in tree.body if isinstance(one, ast.Assign))
    names = [one for one in assigned if ast.unparse(one.targets[0]) == "__all__"]
    silent = {node for top in every for one in _silent_in(top) for node in one}
    return silent.union(*map(ast.walk, names))


def _silent_in(node: ast.AST) -> Iterator[Iterable[ast.AST]]:
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
        yield [node.value]
    elif isinstance(node, ast.JoinedStr):
        yield [part for part in node.values if isinstance(part, ast.Constant)]
        for part in node.values:
            if isinstance(part, ast.FormattedValue) and part.format_spec is not None:
                yield ast.walk(part.format_spec)
    elif isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
        if _called(node.exc) in _INTERNAL:
            yield ast.walk(node.exc)
    elif isinstance(node, ast.Call) and _called(node) in _TECHNICAL:
        yield ast.walk(node)
    elif isinstance(node, ast.AnnAssign | ast.arg) and node.annotation is not None:
        yield ast.walk(node.annotation)
    elif isinstance(node, ast.FunctionDef) and node.returns is not None:
        yield ast.walk(node.returns)


def _called(node: ast.Call) -> str:
    return str(getattr(node.func, "attr", getattr(node.func, "id", "")))


def _message(node: ast.Constant | ast.JoinedStr) -> tuple[str, dict[int, str]]:
    """Return a text with its values as ``{0}``, and what the values are."""
    if isinstance(node, ast.Constant):
        # braces of the text itself would be taken for values
        plain = node.value if isinstance(node.value, str) else ""
        return ("" if _FIELD.search(plain) else plain), {}
    text = ""
    notes: dict[int, str] = {}
    for part in node.values:
        if isinstance(part, ast.FormattedValue):
            notes[len(notes)] = ast.unparse(part.value)
            text += f"{{{len(notes) - 1}}}"
        elif isinstance(part, ast.Constant):
            text += str(part.value)
    return text, notes


def _numbered(line: str, notes: dict[int, str]) -> tuple[str, tuple[str, ...]]:
    """Count the values of a line from 0."""
    own = [int(number) for number in _FIELD.findall(line)] if notes else []
    if not own:
        return line, ()
    first = own[0]
    text = _FIELD.sub(lambda found: f"{{{int(found[1]) - first}}}", line)
    return text, tuple(f"{{{one - first}}}: {notes[one][:_NOTE_LENGTH]}" for one in own)


def updated(language: str, found: list[FoundMessage], old: list[Entry]) -> list[FoundMessage]:
    """Return the new catalogue: the messages found, with the translations that are there."""
    known = {entry.message: entry for entry in old}
    head = _HEAD.format(language=language).replace("\\n", "\n")
    entries = [FoundMessage("", forms=(f"{head}Plural-Forms: {_COUNTS[language]}\n",))]
    for entry in found:
        before = known.get(entry.message)
        number = 3 if entry.plural else 1
        forms = (
            before.forms if before is not None and len(before.forms) == number else ("",) * number
        )
        entries.append(FoundMessage(entry.message, entry.plural, forms, entry.where, entry.notes))
    return entries


def write_po(entries: Iterable[FoundMessage]) -> str:
    """Return the text of a catalogue; the same entries give the same text."""
    return "\n".join(_block(entry) for entry in entries)


def _block(entry: FoundMessage) -> str:
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


def main(arguments: list[str]) -> int:
    """Write the catalogues, or check them; returns the exit code."""
    found = messages()
    missing = 0
    for language in LANGUAGES:
        if language == ENGLISH:
            continue
        path = LANGUAGE / f"{language}.po"
        old = read_po(path.read_text(encoding="utf-8")) if path.is_file() else []
        entries = updated(language, found, old)
        untranslated = [entry for entry in entries[1:] if not entry.translated]
        missing += len(untranslated)
        print(f"{language}: {len(entries) - 1} messages, {len(untranslated)} not translated")
        if "--check" in arguments:
            for entry in untranslated:
                print(f"  {entry.where[0]}: {entry.message}")
        else:
            path.write_text(write_po(entries), encoding="utf-8")
    return 1 if missing and "--check" in arguments else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
