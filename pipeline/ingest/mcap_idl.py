"""Read message definitions in OMG IDL (``ros2idl``, ``omgidl``): structures of plain members.

Understood: modules, structures with one base, typedefs, constants, enumerations, sequences, arrays,
strings. Unions, maps, optional members, wide strings and extensible structures are refused: their
layout depends on more than the definition.
"""

import re

from pipeline.ingest.mcap_types import (
    MOST_FIELDS,
    PRIMITIVES,
    STRING,
    Definition,
    DefinitionError,
    Field,
    checked,
)

_TOKEN = re.compile(
    r"\"(?:[^\"\\]|\\.)*\"|'(?:[^'\\]|\\.)*'|::|[A-Za-z_][A-Za-z0-9_]*|[0-9][\w.+-]*|\S"
)
_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_SKIPPED_LINE = re.compile(r"^\s*(#.*|=+|IDL:.*)$", re.MULTILINE)
_WORDS = {
    ("boolean",): "bool",
    ("octet",): "octet",
    ("char",): "char",
    ("short",): "int16",
    ("long",): "int32",
    ("long", "long"): "int64",
    ("unsigned", "short"): "uint16",
    ("unsigned", "long"): "uint32",
    ("unsigned", "long", "long"): "uint64",
    ("float",): "float32",
    ("double",): "float64",
}
_REFUSED = {"union", "map", "wstring", "wchar", "bitset", "bitmask", "fixed", "any", "valuetype"}
_REFUSED_NOTES = {"optional", "mutable", "appendable"}
_MAX_TOKENS = 200_000
_LENGTH = re.compile(r"[0-9]{1,9}")
_MAX_LENGTH = 10_000_000


def parse_idl(name: str, text: str) -> Definition:
    """Parse IDL.

    Parameters
    ----------
    name : str
        ``package/msg/Name`` or ``package::msg::Name``.
    text : str
        The definitions.

    Raises
    ------
    DefinitionError
        With what cannot be understood.

    Examples
    --------
    >>> parse_idl("a/msg/B", "module a { module msg { struct B { double x[3]; }; }; };").fields
    (Field(name='x', type='float64', length=3),)
    """
    reader = _Reader(_COMMENT.sub(" ", _SKIPPED_LINE.sub("", text)))
    reader.definitions(())
    root = name.replace("/", "::")
    if root not in reader.structures:
        short = [key for key in reader.structures if key.replace("::msg::", "::") == root]
        if not short:
            raise DefinitionError(f"{name} is not defined in it")
        root = short[0]
    return checked(Definition(root, reader.structures))


class _Reader:
    def __init__(self, text: str) -> None:
        self._tokens: list[str] = _TOKEN.findall(text)
        if len(self._tokens) > _MAX_TOKENS:
            raise DefinitionError("it is too long")
        self._at = 0
        self.structures: dict[str, tuple[Field, ...]] = {}
        self._aliases: dict[str, tuple[str, int | None]] = {}
        self._constants: dict[str, int] = {}
        self._members = 0

    def definitions(self, scope: tuple[str, ...]) -> None:
        """Read to the end of the file or of a module."""
        while self._at < len(self._tokens) and self._peek() != "}":
            self._notes()
            word = self._next()
            if word == "module":
                inner = (*scope, self._next())
                if len(inner) > 20:
                    raise DefinitionError("modules are nested deeper than 20 levels")
                self._expect("{")
                self.definitions(inner)
                self._expect("}")
            elif word == "struct":
                self._structure(scope)
            elif word == "enum":
                self._enumeration(scope)
            elif word == "typedef":
                self._typedef(scope)
            elif word == "const":
                self._constant(scope)
            elif word != ";":
                raise DefinitionError(f'"{word}" is not understood')
            if self._at < len(self._tokens) and self._peek() == ";":
                self._next()

    def _typedef(self, scope: tuple[str, ...]) -> None:
        kind, length = self._type(scope)
        for alias, dimension in self._declarators(scope):
            self._aliases["::".join((*scope, alias))] = _joined(alias, kind, length, dimension)

    def _structure(self, scope: tuple[str, ...]) -> None:
        name = self._next()
        fields: list[Field] = []
        if self._peek() == ":":
            self._next()
            base, _ = self._type(scope)
            if base not in self.structures:
                raise DefinitionError(f"{base} is not defined in it")
            fields += self.structures[base]
        if self._peek() == ";":
            return  # announced only
        self._expect("{")
        while self._peek() != "}":
            self._notes()
            kind, length = self._type(scope)
            for member, dimension in self._declarators(scope):
                fields.append(Field(member, *_joined(member, kind, length, dimension)))
            self._expect(";")
        self._expect("}")
        # those of a base count in each structure that inherits them
        self._members += len(fields)
        if self._members > MOST_FIELDS:
            raise DefinitionError(f"it has more than {MOST_FIELDS} members")
        self.structures["::".join((*scope, name))] = tuple(fields)

    def _enumeration(self, scope: tuple[str, ...]) -> None:
        name = self._next()
        self._expect("{")
        self._pass_to("}")
        self._aliases["::".join((*scope, name))] = ("uint32", None)

    def _constant(self, scope: tuple[str, ...]) -> None:
        self._type(scope)
        name = self._next()
        self._expect("=")
        value = []
        while self._peek() != ";":
            value.append(self._next())
        if len(value) == 1 and _LENGTH.fullmatch(value[0]):
            self._constants["::".join((*scope, name))] = int(value[0])

    def _type(self, scope: tuple[str, ...]) -> tuple[str, int | None]:
        """Return the type and, for a sequence or an alias of an array, its length."""
        word = self._next()
        if word in _REFUSED:
            raise DefinitionError(f"{word} is not supported")
        if word == "sequence":
            return self._sequence(scope)
        if word == "string":
            if self._peek() == "<":
                self._pass_to(">")
            return STRING, None
        words = [word]
        while word in ("unsigned", "long") and self._peek() in ("long", "short", "double"):
            word = self._next()
            words.append(word)
        if tuple(words) in _WORDS:
            return _WORDS[tuple(words)], None
        if word in PRIMITIVES:
            return word, None
        name = word if word != "::" else self._next()
        while self._peek() == "::":
            self._next()
            name += "::" + self._next()
        return self._named(name, scope)

    def _sequence(self, scope: tuple[str, ...]) -> tuple[str, int]:
        self._expect("<")
        if self._peek() == "sequence":
            raise DefinitionError("a sequence of sequences is not supported")
        kind, length = self._type(scope)
        if length is not None:
            raise DefinitionError("a sequence of arrays is not supported")
        self._pass_to(">")
        return kind, -1

    def _pass_to(self, word: str) -> None:
        while self._next() != word:
            pass

    def _named(self, name: str, scope: tuple[str, ...]) -> tuple[str, int | None]:
        for depth in range(len(scope), -1, -1):
            full = "::".join((*scope[:depth], name))
            if full in self._aliases:
                return self._aliases[full]
            if full in self.structures:
                return full, None
        return name, None  # defined later, or not at all: `checked` will say

    def _declarators(self, scope: tuple[str, ...]) -> list[tuple[str, int | None]]:
        found = []
        while True:
            name, length = self._next(), None
            while self._peek() == "[":
                self._next()
                size = self._number(self._next(), scope)
                length = size if length is None else length * size
                if length > _MAX_LENGTH:
                    raise DefinitionError(f'"{name}" is too long an array')
                self._expect("]")
            found.append((name, length))
            if self._peek() != ",":
                return found
            self._next()

    def _number(self, word: str, scope: tuple[str, ...]) -> int:
        for depth in range(len(scope), -1, -1):
            full = "::".join((*scope[:depth], word))
            if full in self._constants:
                return self._constants[full]
        if not _LENGTH.fullmatch(word) or int(word) > _MAX_LENGTH:
            raise DefinitionError(f'"{word}" is not the length of an array')
        return int(word)

    def _notes(self) -> None:
        """Pass over annotations; refuse those that change the layout."""
        while self._peek() == "@":
            self._next()
            word = self._next()
            if word in _REFUSED_NOTES:
                raise DefinitionError(f"@{word} is not supported")
            while self._peek() == "::":
                self._next()
                self._next()
            if self._peek() == "(":
                depth = 0
                while True:
                    word = self._next()
                    depth += {"(": 1, ")": -1}.get(word, 0)
                    if depth == 0:
                        break

    def _peek(self) -> str:
        if self._at >= len(self._tokens):
            return ""
        return self._tokens[self._at]

    def _next(self) -> str:
        if self._at >= len(self._tokens):
            raise DefinitionError("it ends too early")
        self._at += 1
        return self._tokens[self._at - 1]

    def _expect(self, word: str) -> None:
        found = self._next()
        if found != word:
            raise DefinitionError(f'"{found}" stands where "{word}" is expected')


def _joined(
    name: str, kind: str, length: int | None, dimension: int | None
) -> tuple[str, int | None]:
    if dimension is None:
        return kind, length
    if length is not None:
        if length < 0:
            raise DefinitionError("an array of sequences is not supported")
        dimension *= length
        if dimension > _MAX_LENGTH:
            raise DefinitionError(f'"{name}" is too long an array')
    return kind, dimension
