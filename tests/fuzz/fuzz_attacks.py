# ruff: noqa: E501 - one case a line reads best
"""Files built to hurt a reader: small, and large once they are read; a module of the tests."""

import json
import struct
import zipfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from io import BytesIO

import fuzz_seeds as seeds
from fuzz_seeds import MESSAGE, SCHEMA, Log, Record
from pool_logs import START_NS


@dataclass(frozen=True)
class Attack:
    """A file for a target; `says` must be in the message, empty where it may be read."""

    target: str
    make: Callable[[], bytes]
    says: str = ""


def _top(line: str) -> bytes:
    return (seeds.yaml_texts()["small"] + line).encode()


def _laughs() -> bytes:
    lines = ["a0: &a0 [lol, lol, lol, lol, lol, lol, lol, lol, lol]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 10)]
    return "\n".join(lines).encode()


def _blocks_deep() -> bytes:
    return "".join(f"{' ' * i}a:\n" for i in range(300)).encode()


YAML = {
    "billion_laughs": (_laughs, "anchor or alias"),
    "merge_key": (lambda: _top("<<: {a: 1}\n"), '"<<"'),
    "flow_deep": (lambda: b"a: " + b"[" * 100_000, "nesting too deep"),
    "maps_deep": (lambda: b"a: " + b"{a: " * 10_000, "nesting too deep"),
    "blocks_deep": (_blocks_deep, "nesting too deep"),
    "dashes_deep": (lambda: b"a:\n  " + b"- " * 10_000, "nesting too deep"),
    "question_marks": (lambda: b"? " * 50_000, "as a key"),
    "many_keys": (lambda: b"".join(b"k%d: 1\n" % i for i in range(30_000)), "too many entries"),
    "many_items": (lambda: b"a: [" + b"1," * 60_000 + b"]", "too many entries"),
    "tag": (lambda: _top("model: !!python/object/apply:os.system [ls]\n"), "tag"),
    "two_documents": (lambda: _top("---\nname: x\n"), "second YAML document"),
    "digits": (lambda: _top(f"frame: {'9' * 100_000}\n"), "beyond the range"),
    "one_long_line": (lambda: b"name: " + b"x" * 900_000, "name"),
    "one_long_text": (lambda: b'name: "' + b"x\\n" * 300_000 + b'"', "name"),
    "escapes": (lambda: b'name: "' + b"\\x41" * 200_000 + b'"', "name"),
    "comments": (lambda: b"# x\n" * 200_000 + b"name: x\n", "missing"),
    "blank_lines": (lambda: b"name:" + b"\n" * 900_000 + b" x\n", "missing"),
    "too_large": (lambda: b"# x\n" * 250_001, "larger than"),
    "utf16": (lambda: "name: x\n".encode("utf-16"), "not UTF-8"),
    "zero_byte": (lambda: b"name: a\0b\n", "control character"),
    "escaped_zero": (lambda: _top('frame: "a\\0b"\n'), "frame"),
    "half_a_pair": (lambda: _top('frame: "\\ud800"\n'), "surrogate"),
    "not_finite": (lambda: _top("frame: .nan\n"), "finite"),
    "too_large_a_number": (lambda: _top("frame: 1e999\n"), "beyond the range"),
}  # fmt: skip


def _inside(*records: Record, **lies: object) -> bytes:
    """The valid log with more records in its chunk; index left out, so that they are walked."""
    one = seeds.log()
    return replace(one, inside=(*one.inside, *records), index=False, **lies).to_bytes()  # type: ignore[arg-type]


def _topic(definition: str, data: bytes, encoding: str = "cdr", language: str = "ros2msg") -> bytes:
    """The valid log with one more topic, which a message of a known type announces."""
    number = 40
    return _inside(
        seeds.schema(number, "geometry_msgs/msg/Depth", language, definition.encode()),
        seeds.channel(number, number, "/codes", encoding),
        *(seeds.message(number, START_NS + k, data) for k in range(5)),
    )


def _bomb(compression: str, megabytes: int) -> bytes:
    """A chunk of tiny records, packed to next to nothing."""
    tiny = Record(0x80, b"").to_bytes() * (megabytes * 1_000_000 // 9)
    one = seeds.log()
    return Log(
        one.before, (*one.inside, Record(0x80, tiny)), one.behind, compression, index=False
    ).to_bytes()


def _walked_bomb() -> bytes:
    """The same, with every tiny record walked."""
    body = Record(0x80, b"").to_bytes() * 27_000_000
    one = seeds.log()
    packed = seeds.pack(b"".join(r.to_bytes() for r in one.inside) + body, "zstd")
    size = sum(len(r.to_bytes()) for r in one.inside) + len(body)
    head = struct.pack("<QQQI", START_NS, START_NS, size, 0) + seeds.text("zstd")
    chunk = Record(seeds.CHUNK, head + struct.pack("<Q", len(packed)) + packed)
    return (
        seeds.MAGIC
        + b"".join(r.to_bytes() for r in (*one.before, chunk, *one.behind))
        + seeds.MAGIC
    )


def _statistics(count: int) -> bytes:
    """A summary that states a number of messages which the file cannot hold, or nearly."""
    one = seeds.log()
    head = [record for record in one.inside if record.opcode in (SCHEMA, 4)]
    pairs = struct.pack("<HQ", 2, count)
    body = struct.pack("<QHIIIIQQI", count, 6, 6, 0, 0, 1, START_NS, START_NS, len(pairs)) + pairs
    behind = (*one.behind[:-1], *head, Record(seeds.STATISTICS, body))
    start = len(replace(one, behind=one.behind[:-1]).to_bytes()) - len(seeds.MAGIC)
    footer = Record(seeds.FOOTER, struct.pack("<QQI", start, 0, 0))
    return replace(one, behind=(*behind, footer)).to_bytes()


def _many_channels() -> bytes:
    return _inside(*(seeds.channel(i % 65_536, 0, f"/t{i}", "json") for i in range(30_000)))


def _nested_types(depth: int, width: int) -> str:
    """Definitions of which each holds `width` of the next."""
    parts = [f"a/T0[{width}] x"]
    parts += [f"MSG: a/T{i}\na/T{i + 1}[{width}] x" for i in range(depth)]
    parts.append(f"MSG: a/T{depth}\nfloat64 x")
    return f"\n{'=' * 80}\n".join(parts)


def _idl(*structures: str) -> str:
    return f"module geometry_msgs {{ module msg {{ {' '.join(structures)} }}; }};"


def _heirs(count: int) -> str:
    """Structures that each have the members of all before them."""
    chain = [f"struct S{i} : S{i - 1} {{ long x{i}; }};" for i in range(1, count)]
    return _idl("struct S0 { long x0; };", *chain, "struct Depth { S0 data; };")


def _arrays_of_nothing(depth: int, nothing: str) -> str:
    """Structures that each hold a thousand of the one before; the first takes no bytes."""
    chain = [f"struct T{i} {{ T{i - 1} x[1000]; }};" for i in range(1, depth)]
    return _idl(f"struct T0 {{ {nothing} }};", *chain, f"struct Depth {{ T{depth - 1} data; }};")


def _powers(count: int) -> str:
    """Arrays of arrays by name: the length has thousands of digits."""
    chain = [f"typedef A{i - 1} A{i}[9999999];" for i in range(1, count)]
    return _idl("typedef long A0[9999999];", *chain, f"struct Depth {{ A{count - 1} data; }};")


def _codes_in_json(*messages: bytes) -> bytes:
    """The valid log with its mapped topic, channel 3, in JSON."""
    one = seeds.log()
    others = (record for record in one.inside if not record.content.startswith(b"\3\0"))
    own = (seeds.message(3, START_NS + k, data) for k, data in enumerate(messages))
    codes = seeds.channel(3, 0, "/codes", "json")
    return replace(one, inside=(*others, codes, *own), index=False).to_bytes()


def _nested_json(levels: int) -> bytes:
    return _codes_in_json(*[b'{"data": ' * levels + b"1" + b"}" * levels] * 5)


def _stamped_json(*stamps: tuple[float, float]) -> bytes:
    contents = [
        {"stamp": {"sec": sec, "nanosec": nanosec}, "data": [1.0, 2.0, 3.0, 4.0 + k]}
        for k, (sec, nanosec) in enumerate([(1_700_000_000, 0), *stamps, (1_700_000_001, 0)])
    ]
    return _codes_in_json(*(json.dumps(one).encode() for one in contents))


def _proto(field: int, content: bytes) -> bytes:
    size = len(content)
    assert size < 1 << 21
    length = bytes([size & 0x7F | 0x80, size >> 7 & 0x7F | 0x80, size >> 14])
    return bytes([field << 3 | 2]) + length + content


def _defaults(fields: int, elements: int) -> bytes:
    """A message of elements that take two bytes and have very many fields by default."""

    def part(name: str, number: int, label: int, kind: int, of: str = "") -> bytes:
        numbers = bytes([0x18, number & 0x7F | 0x80, number >> 7, 0x20, label, 0x28, kind])
        return _proto(2, _proto(1, name.encode()) + numbers + _proto(6, of.encode()))

    wide = _proto(1, b"Wide") + b"".join(part(f"f{i}", i + 1, 1, 1) for i in range(fields))
    many = _proto(1, b"Many") + part("data", 1, 3, 11, ".a.Wide")
    file = _proto(2, b"a") + _proto(4, wide) + _proto(4, many) + _proto(12, b"proto3")
    return _inside(
        seeds.schema(40, "a.Many", "protobuf", _proto(1, file)),
        seeds.channel(40, 40, "/codes", "protobuf"),
        seeds.message(40, START_NS, b"\x0a\0" * elements),
    )


def _merged(rows: int, ranges: int) -> bytes:
    """A workbook of which every cell is merged with all others, very many times."""
    merged = f'<mergeCells count="{ranges}">' + f'<mergeCell ref="A1:XFD{rows}"/>' * ranges
    target = BytesIO()
    with (
        zipfile.ZipFile(BytesIO(seeds.valid_workbook("load_test"))) as old,
        zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as new,
    ):
        for name in old.namelist():
            content = old.read(name)
            if name == "xl/worksheets/sheet1.xml":
                end = f'<row r="{rows}"><c r="CV{rows}"><v>1</v></c></row></sheetData>{merged}</mergeCells>'
                content = content.replace(b"</sheetData>", end.encode())
            new.writestr(name, content)
    return target.getvalue()


_CDR = b"\0\1\0\0"
LOGS = {
    "zstd_bomb": (lambda: _bomb("zstd", 250), "looks like a bomb"),
    "lz4_bomb": (lambda: _bomb("lz4", 120), ""),
    "tiny_records": (_walked_bomb, "looks like a bomb"),
    "chunk_states_too_much": (lambda: _inside(uncompressed_size=2**62, compression="zstd"), "no messages"),
    "packed_size_lies": (lambda: _inside(packed_size=2**63), "no messages"),
    "far_summary": (lambda: replace(seeds.log(), behind=(seeds.log().behind[0], Record(2, struct.pack("<QQI", 2**63, 2**63, 0)))).to_bytes(), ""),
    "statistics_beyond": (lambda: _statistics(2**63), ""),
    "statistics_just_possible": (lambda: _statistics(1_200_000), ""),
    "message_length_lies": (lambda: _inside(Record(MESSAGE, bytes(22), 2**63 - 1)), ""),
    "channels": (_many_channels, ""),
    "endless_sequence": (lambda: _topic("float64[] data", _CDR + struct.pack("<I", 2**32 - 1)), ""),
    "endless_text": (lambda: _topic("string data", _CDR + struct.pack("<I", 2**32 - 1)), ""),
    "sequence_of_messages": (lambda: _topic(_nested_types(2, 1).replace("[1]", "[]"), _CDR + struct.pack("<I", 2**31)), ""),
    "empty_elements": (lambda: _topic(f"a/E[] data\n{'=' * 80}\nMSG: a/E\n", _CDR + struct.pack("<I", 2**32 - 1)), ""),
    "large_array": (lambda: _topic("float64[10000000] data", _CDR), ""),
    "arrays_of_arrays": (lambda: _topic(_nested_types(10, 1000), _CDR + bytes(1000)), ""),
    "deep_types": (lambda: _topic(_nested_types(60, 1), _CDR + bytes(8)), ""),
    "type_in_itself": (lambda: _topic(f"a/T x\n{'=' * 80}\nMSG: a/T\na/T x", _CDR), ""),
    "idl_nested": (lambda: _topic("module a { " * 5000, _CDR, language="ros2idl"), ""),
    "idl_sequences": (lambda: _topic("struct Depth { " + "sequence<" * 2000 + "float" + ">" * 2000 + " x; };", _CDR, language="ros2idl"), ""),
    "idl_heirs": (lambda: _topic(_heirs(18_000), _CDR + bytes(8), language="ros2idl"), ""),
    "idl_arrays_of_nothing": (lambda: _topic(_arrays_of_nothing(20, ""), _CDR + bytes(1000), language="ros2idl"), ""),
    "idl_arrays_of_no_elements": (lambda: _topic(_arrays_of_nothing(20, "long x[0];"), _CDR + bytes(1000), language="ros2idl"), ""),
    "idl_powers": (lambda: _topic(_powers(15_000), _CDR + bytes(8), language="ros2idl"), ""),
    "arrays_of_no_elements": (lambda: _topic(_nested_types(10, 1000).replace("float64 x", "float64[0] x"), _CDR + bytes(1000)), ""),
    "json_nested": (lambda: _nested_json(900), ""),
    "json_stamps": (lambda: _stamped_json((-5, 1e30), (9_000_000_000, 9 * 10**18)), ""),
    "protobuf_defaults": (lambda: _defaults(9000, 500_000), ""),
    "json_deep": (lambda: _topic("", b"[" * 100_000, "json", ""), ""),
    "json_numbers": (lambda: _topic("", json.dumps({"data": [10**400, 1e308]}).encode() + b"1" * 9000, "json", ""), ""),
    "json_digits": (lambda: _topic("", b'{"depth": ' + b"9" * 10_000 + b"}", "json", ""), ""),
    "json_keys": (lambda: _topic("", b'{"depth": {' + b",".join(b'"k%d": {"x": 1}' % i for i in range(20_000)) + b"}}", "json", ""), ""),
    "protobuf_varint": (lambda: _topic("", b"\xff" * 10_000, "protobuf", "protobuf"), ""),
    "time_beyond": (lambda: _inside(seeds.message(2, 2**64 - 1, b"x")), ""),
}  # fmt: skip
_CSV = {
    "commas": lambda: b"," * 2_000_000,
    "quote_that_never_closes": lambda: b'n, rpm;M, N m\n1;"' + b"2\n" * 400_000,
    "lines": lambda: b"1\n" * 400_000,
    "blanks": lambda: b" " * 3_000_000 + b"1 2\n",
    "long_words": lambda: (b"a" * 100_000 + b";") * 20,
    "numbers_that_hardly_end": lambda: b"n, rpm;M, N m\n" + b"1 " * 20_000 + b"x;1\n",
    "headers": lambda: b"Code;n, rpm;M, N m\n" * 4000,
    "digits": lambda: b"Code;n, rpm;M, N m\n60;1;" + b"9" * 300_000 + b"\n",
}
ATTACKS: dict[str, Attack] = {
    **{
        f"{target} {name}": Attack(target, make, says if target == "vehicle_yaml" else "")
        for target in ("vehicle_yaml", "notes_yaml")
        for name, (make, says) in YAML.items()
    },
    **{f"pool_log {name}": Attack("pool_log", make, says) for name, (make, says) in LOGS.items()},
    "load_test_xlsx merged_ranges": Attack("load_test_xlsx", lambda: _merged(5000, 100_000)),
    **{
        f"{kind}_csv {name}": Attack(f"{kind}_csv", make)
        for kind in ("load_test", "mooring", "open_water")
        for name, make in _CSV.items()
        if kind == "load_test" or name in {"headers", "numbers_that_hardly_end"}
    },
}
