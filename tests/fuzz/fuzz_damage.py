# ruff: noqa: E501 - one case a line reads best
"""Damage valid files: anywhere, or where their structure hurts most; a module of the tests.

Every function takes the source of chance and returns the bytes of a file.
"""

import io
import re
import struct
import zipfile
from collections.abc import Callable
from dataclasses import replace
from random import Random

import fuzz_seeds as seeds
from fuzz_seeds import CHUNK, MESSAGE, SCHEMA, Log, Record

Damage = Callable[[Random], bytes]
_NUMBERS = (0, 1, 2, 7, 8, 255, 256, 65_535, 2**31 - 1, 2**31, 2**32 - 1, 2**63 - 1, 2**63, 2**64 - 1)  # fmt: skip
_DIALECT = {
    "xml": ('r="XFD1048576"', 't="s"', 't="e"', 't="b"', 't="d"', "<v>1e999</v>", "<v>99999999</v>",
            "<f>", "</c>", "<row>", "<!DOCTYPE a>", "&amp;", "&x;", "<![CDATA[", "]]>", 'r="A0"',
            "<mergeCell ref='A1:XFD1048576'/>", 'count="4294967295"', "nan", "\x00", "<is><t>"),
    "yaml": ("&a [*a]", "*a", "!!python/object:os.system", "[" * 40, "{" * 40, "- " * 40, "? ", "|",
             ">-", "---", "...", "%YAML 9.9", "'", '"', "\\U00110000", "\t", ".inf", ".nan", "1e999",
             "<<: *a", "0x" + "f" * 30, "9" * 400, "{}", "[]", "~", "true", "-0", "1e-320", "1,5",
             "../../etc/passwd", "\u202e", "\ud7ff", "\ufeff", "- [" * 30, "a: {" * 30, "-1", "0", "1e9"),
    "csv": (";", ",", "\t", '"', '""', "\r", "\n", "\r\n", "1e999", "nan", "-inf", "1,5", "1.5.2",
            "=1+1", "\u0000", "\ufeff", "\u2028", "\u0661", "²", "rpm", "N m", "%", "|", "9" * 400,
            "#", "1 000", "−5", "1e-999", "#DIV/0!", "x" * 5000, "code", "T, N", "об/мин"),
    "ros2msg": ("float64[99999999] x", "float64[] x", "string[<=3] s", "A/B c", "Imu me", "=" * 80,
                "MSG: std_msgs/Header", "uint8[10000000] x", "Header header", "---", "float64 x=1",
                "wstring w", "std_msgs/Header[1000] h", "geometry_msgs/Vector3[] v"),
}  # fmt: skip
_CELLS: tuple[object, ...] = (
    None, True, 0, -1, 1e308, -1e308, 1e-320, 2**53, "", " ", "nan", "inf", "1,5", "1.5.2", "=1/0",
    "=A1", "x" * 3000, "\u202eabc", "²", "1e999", "Code", "rpm", "N", "N m", "V", "#DIV/0!", "5 N",
    "Speed (rpm)", "Torque (N m)", "K_T", "form of rig2sea new", "code 5", "{{7*7}}", "<b>", "%n",
)  # fmt: skip


def anywhere(data: bytes, chance: Random) -> bytes:
    """Flip bits, cut, repeat, overwrite, or set a number: what a bad disk or copy does, or worse."""
    found = bytearray(data)
    for _ in range(chance.choice((1, 1, 2, 4, 8))):
        if not found:
            return bytes(found)
        at = chance.randrange(len(found))
        kind = chance.randrange(7)
        if kind == 0:
            found[at] ^= 1 << chance.randrange(8)
        elif kind == 1:
            del found[at:]
        elif kind == 2:
            del found[at : at + chance.randrange(1, 64)]
        elif kind == 3:
            found[at:at] = found[at : at + chance.randrange(1, 200)] * chance.choice((1, 2, 50))
        elif kind == 4:
            found[at : at + 16] = chance.randbytes(chance.randrange(1, 16))
        else:
            size, code = chance.choice(((1, "B"), (2, "H"), (4, "I"), (8, "Q")))
            number = chance.choice(_NUMBERS) & (256**size - 1)
            found[at : at + size] = struct.pack(f"<{code}", number)
    return bytes(found)


def in_text(text: str, dialect: str, chance: Random) -> str:
    """Put words that mean something between, or in place of, the words of a text."""
    words = re.split(r"(\s+|(?<=[<>:,;={}\[\]\"])|(?=[<>:,;={}\[\]\"]))", text)
    for _ in range(chance.choice((1, 1, 2, 3, 6))):
        at = chance.randrange(len(words))
        kind = chance.randrange(6)
        odd = chance.choice(_DIALECT[dialect])
        if kind <= 1:
            words[at] = odd
        elif kind == 2:
            words[at:at] = [odd]
        elif kind == 3:
            end = at + chance.randrange(1, 30)
            words[at:at] = words[at:end] * chance.choice((1, 3, 40))
        elif kind == 4:
            other = chance.randrange(len(words))
            words[at], words[other] = words[other], words[at]
        else:
            del words[at : at + chance.randrange(1, 12)]
        words = words or [""]
    return "".join(words)


# --- tables --------------------------------------------------------------------------------------


def _cells(kind: str, chance: Random) -> dict[str, list[list[object]]]:
    """The rows of a valid file with odd cells, rows and columns lost, doubled or exchanged."""
    sheets = {name: [list(row) for row in rows] for name, rows in seeds.rows()[kind].items()}
    for _ in range(chance.choice((1, 2, 4, 10))):
        name = chance.choice(list(sheets))
        rows = sheets[name]
        if not rows:
            continue
        at = chance.randrange(len(rows))
        action = chance.randrange(8)
        if action <= 3 and rows[at]:
            rows[at][chance.randrange(len(rows[at]))] = chance.choice(_CELLS)
        elif action == 4:
            rows.insert(at, [chance.choice(_CELLS) for _ in range(chance.randrange(5))])
        elif action == 5:
            del rows[at]
        elif action == 6:
            odd = chance.choice(_CELLS)
            for row in rows:
                row.insert(0, odd)
        else:
            rows[at] = rows[at] * chance.choice((0, 2, 30))
    if chance.random() < 0.2:
        sheets = {
            chance.choice(("", "Code", "N m", "Code -5", "99999", "a" * 31)) or "s": rows
            for rows in sheets.values()
        }
    return sheets


def table_text(kind: str, chance: Random) -> bytes:
    """A text table: odd cells in any delimiter and encoding, then perhaps odd words or bytes."""
    if chance.random() < 0.6:
        rows = next(iter(_cells(kind, chance).values()))
    else:
        rows = next(iter(seeds.rows()[kind].values()))
        if kind == "load_test":
            rows = [["Code", *rows[0]], *([60, *row] for row in rows[1:])]
    delimiter = chance.choice((",", ";", "\t", "|", "  "))
    comma = chance.random() < 0.2

    def cell(value: object) -> str:
        shown = "" if value is None else str(value)
        return shown.replace(".", ",") if comma and isinstance(value, float) else shown

    text = "\n".join(delimiter.join(map(cell, row)) for row in rows) + "\n"
    if chance.random() < 0.5:
        text = in_text(text, "csv", chance)
    encoding = chance.choice(("utf-8", "utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1251"))
    data = text.encode(encoding, errors="replace")
    return anywhere(data, chance) if chance.random() < 0.2 else data


def workbook(kind: str, chance: Random) -> bytes:
    """A workbook: odd cells, odd XML in a part, or damage to the zip file itself."""
    way = chance.randrange(4)
    if way == 0:
        try:
            return seeds.workbook(_cells(kind, chance))
        except ValueError:  # what the writer itself refuses
            way = 1
    data = seeds.valid_workbook(kind)
    if way == 1:
        return anywhere(data, chance)
    return _repacked(data, chance)


def _repacked(data: bytes, chance: Random) -> bytes:
    """Change a part, then pack it so that sizes and checksums agree."""
    target = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(data)) as old,
        zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new,
    ):
        names = old.namelist()
        sheets = [name for name in names if "sheet" in name or "workbook" in name]
        hit = chance.choice(sheets if chance.random() < 0.8 else names)
        for name in names:
            content = old.read(name)
            if name == hit:
                if chance.random() < 0.3:
                    content = anywhere(content, chance)
                else:
                    text = content.decode("utf-8", errors="replace")
                    content = in_text(text, "xml", chance).encode("utf-8", errors="replace")
            new.writestr(name, content)
        if chance.random() < 0.1:
            new.writestr(chance.choice(("xl/worksheets/sheet9.xml", "../../x", "/etc/x")), b"<a/>")
    return target.getvalue()


# --- YAML ----------------------------------------------------------------------------------------


def yaml(name: str, chance: Random) -> bytes:
    """A YAML file: odd words for values and between them, sometimes odd bytes."""
    text = seeds.yaml_texts()[name]
    if chance.random() < 0.6:
        text = _odd_value(text, chance)
    if chance.random() < 0.6:
        text = in_text(text, "yaml", chance)
    data = text.encode("utf-8", errors="surrogatepass")
    return anywhere(data, chance) if chance.random() < 0.15 else data


def _odd_value(text: str, chance: Random) -> str:
    """Replace a number or a word behind a key, so that the file stays YAML."""
    values = list(re.finditer(r"(?<=[:,\[] )[^\s,:{}\[\]#]+", text))
    if not values:
        return text
    for one in sorted(
        chance.sample(values, min(len(values), chance.choice((1, 1, 2)))), key=lambda m: -m.start()
    ):
        odd = chance.choice(("0", "-1", "1e300", "1e-300", "-1e9", "1e-5", "~", "[]", "{}", "true",
                             "'x'", "[0, 0, 0]", "9007199254740993", "-0.0", "a", "[1e200, 1, 1]"))  # fmt: skip
        text = text[: one.start()] + odd + text[one.end() :]
    return text


# --- logs ----------------------------------------------------------------------------------------


def log(chance: Random) -> bytes:
    """A log: damage anywhere, to its records, its sizes, a definition, or a message."""
    way = chance.randrange(6)
    if way == 0:
        return anywhere(chance.choice(seeds.logs()), chance)
    one = seeds.log()
    for _ in range(chance.choice((1, 1, 2, 3))):
        one = chance.choice((_records, _sizes, _content, _content, _definition))(one, chance)
    return one.to_bytes()


def _sizes(one: Log, chance: Random) -> Log:
    """Lie about sizes, offsets and checksums."""
    number = chance.choice(_NUMBERS)
    way = chance.randrange(6)
    if way == 0:
        return replace(one, uncompressed_size=number)
    if way == 1:
        return replace(one, packed_size=number)
    if way == 2:
        return replace(one, compression=chance.choice(("zstd", "lz4", "zst\u0000", "x" * 300)))
    if way == 3:
        return replace(one, index=False, checksum=0)
    if way == 4:
        footer = struct.pack("<QQI", number, chance.choice(_NUMBERS), 0)
        return replace(one, behind=(*one.behind[:-1], Record(seeds.FOOTER, footer)))
    at = chance.randrange(len(one.inside))
    hit = replace(one.inside[at], length=number)
    return replace(one, inside=(*one.inside[:at], hit, *one.inside[at + 1 :]))


def _records(one: Log, chance: Random) -> Log:
    """Lose, double, exchange or invent records; add lying ones behind the chunk."""
    inside = list(one.inside)
    for _ in range(chance.choice((1, 2, 10))):
        at, other = chance.randrange(len(inside)), chance.randrange(len(inside))
        way = chance.randrange(4)
        if way == 0 and len(inside) > 5:
            del inside[at]
        elif way == 1:
            inside[at:at] = [inside[other]] * chance.choice((1, 100))
        elif way == 2:
            inside[at], inside[other] = inside[other], inside[at]
        else:
            inside.insert(at, Record(chance.randrange(256), chance.randbytes(chance.randrange(60))))
    behind = list(one.behind)
    if chance.random() < 0.4:
        opcode = chance.choice((SCHEMA, CHUNK, 6, 7, 8, 9, 0xA, 0xB, 0xC, 0xD, 0xE))
        content = b"".join(
            struct.pack("<Q", chance.choice(_NUMBERS)) for _ in range(chance.randrange(9))
        )
        behind.insert(0, Record(opcode, content))
    return replace(one, inside=tuple(inside), behind=tuple(behind))


def _content(one: Log, chance: Random) -> Log:
    """Damage the bytes of some records; all around them fits."""
    inside = list(one.inside)
    for _ in range(chance.choice((1, 3, 30))):
        at = chance.randrange(len(inside))
        record = inside[at]
        keep = 22 if record.opcode == MESSAGE and chance.random() < 0.7 else 0
        inside[at] = Record(
            record.opcode, record.content[:keep] + anywhere(record.content[keep:], chance)
        )
    return replace(one, inside=tuple(inside))


def _text_of(schema: bytes) -> int | None:
    """Place of a definition's text; None where an earlier damage has its sizes lead beyond it."""
    place = 2
    for _name_then_encoding in range(2):
        if place + 4 > len(schema):
            return None
        place += 4 + int(struct.unpack_from("<I", schema, place)[0])
    return place if place + 4 <= len(schema) else None


def _definition(one: Log, chance: Random) -> Log:
    """Change the text of a definition, or what a definition or a topic says it is."""
    inside = list(one.inside)
    at = chance.choice([i for i, record in enumerate(inside) if record.opcode in (SCHEMA, 4)])
    record = inside[at]
    content = record.content
    if chance.random() < 0.3:
        words = (b"ros2msg", b"ros2idl", b"protobuf", b"jsonschema", b"cdr", b"json")
        content = content.replace(chance.choice(words), chance.choice(words))
    elif record.opcode == SCHEMA and (at_text := _text_of(content)) is not None:
        definition = content[at_text + 4 :]
        if b"protobuf" in content:
            definition = anywhere(definition, chance)
        else:
            text = definition.decode("utf-8", errors="replace")
            changed = in_text(text, "ros2msg", chance)
            if chance.random() < 0.5:
                lines = text.splitlines()
                lines.insert(chance.randrange(len(lines) + 1), chance.choice(_DIALECT["ros2msg"]))
                changed = "\n".join(lines)
            definition = changed.encode("utf-8", errors="replace")
        content = content[:at_text] + seeds.text(definition)
    else:
        content = anywhere(content, chance)
    inside[at] = Record(record.opcode, content)
    return replace(one, inside=tuple(inside))
