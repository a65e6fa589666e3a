"""CDR: the general decoder against a library, the gather against the general decoder."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap_ros2._dynamic import serialize_dynamic

from pipeline.ingest.mcap_gather import Layouts, decode, layout_of
from pipeline.ingest.message_definitions import (
    BrokenMessageError,
    Definition,
    DefinitionError,
    parse_definition,
)
from pipeline.ingest.pool_run_codec import numbers_below, value_at


def parse_ros2msg(name: str, text: str) -> Definition:
    return parse_definition(name, text, "ros2msg")


def parse_idl(name: str, text: str) -> Definition:
    return parse_definition(name, text, "omgidl")


_INTEGERS = {
    "int8": (-128, 127),
    "uint8": (0, 255),
    "int16": (-(2**15), 2**15 - 1),
    "uint16": (0, 2**16 - 1),
    "int32": (-(2**31), 2**31 - 1),
    "uint32": (0, 2**32 - 1),
    "int64": (-(2**63), 2**63 - 1),
    "uint64": (0, 2**64 - 1),
}
_TEXT = st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=6)


def one_value(kind: str) -> st.SearchStrategy[object]:
    if kind in _INTEGERS:
        return st.integers(*_INTEGERS[kind])
    if kind == "string":
        return _TEXT
    if kind == "bool":
        return st.booleans()
    return st.floats(width=32 if kind == "float32" else 64, allow_nan=False)


@st.composite
def definitions(draw: st.DrawFn) -> tuple[str, list[dict[str, object]]]:
    """A definition with a message in it, and contents that fit."""

    def fields(prefix: str, *, inner: bool) -> list[tuple[str, str, str]]:
        kinds = [*_INTEGERS, "float32", "float64", "string", "bool"]
        if not inner:
            kinds.append("Inner")
        chosen = draw(st.lists(st.sampled_from(kinds), min_size=1, max_size=6))
        return [
            (kind, draw(st.sampled_from(["", "[2]", "[]", "[<=3]"])), f"{prefix}{i}")
            for i, kind in enumerate(chosen)
        ]

    outer, inner = fields("f", inner=False), fields("g", inner=True)

    def content(part: list[tuple[str, str, str]]) -> dict[str, object]:
        found: dict[str, object] = {}
        for kind, array, name in part:
            count = {"": None, "[2]": 2}.get(array, draw(st.integers(0, 3)))
            values = [
                content(inner) if kind == "Inner" else draw(one_value(kind))
                for _ in range(1 if count is None else count)
            ]
            found[name] = values[0] if count is None else values
        return found

    def text(part: list[tuple[str, str, str]]) -> str:
        return "".join(f"{kind}{array} {name}\n" for kind, array, name in part)

    definition = f"{text(outer)}{'=' * 80}\nMSG: pkg/Inner\n{text(inner)}"
    return definition, [content(outer) for _ in range(draw(st.integers(1, 5)))]


def as_plain(value: object) -> object:
    """Bytes as numbers, truths as 0 and 1, as both decoders are free to have them."""
    if isinstance(value, dict):
        return {name: as_plain(part) for name, part in value.items()}
    if isinstance(value, list | tuple | bytes):
        return [as_plain(part) for part in value]
    return int(value) if isinstance(value, bool) else value


@given(definitions())
def test_what_a_library_encodes_is_decoded(case: tuple[str, list[dict[str, object]]]) -> None:
    text, contents = case
    encode = serialize_dynamic("pkg/msg/Outer", text)["pkg/msg/Outer"]
    definition = parse_ros2msg("pkg/msg/Outer", text)
    for content in contents:
        assert decode(definition, bytes(encode(content))) == as_plain(content)


@given(definitions(), st.integers(0, 7))
def test_gathered_numbers_are_the_decoded_ones(
    case: tuple[str, list[dict[str, object]]], before: int
) -> None:
    """Whatever the lengths of strings and sequences, and wherever in the block a message lies."""
    text, contents = case
    encode = serialize_dynamic("pkg/msg/Outer", text)["pkg/msg/Outer"]
    definition = parse_ros2msg("pkg/msg/Outer", text)
    messages = [bytes(encode(content)) for content in contents] * 2
    size = np.array([len(message) for message in messages])
    start = before + np.concatenate([[0], np.cumsum(size)[:-1]])
    buffer = np.frombuffer(bytes(before) + b"".join(messages), np.uint8)
    trees = [decode(definition, message) for message in messages]
    groups, broken = Layouts(definition).groups(buffer, start, size)
    assert not broken
    assert sorted(np.concatenate([rows for rows, _ in groups]).tolist()) == list(range(len(size)))
    for rows, layout in groups:
        for row in rows.tolist():
            for path in numbers_below(trees[row], ()):
                place = layout.place(path)
                assert place is not None
                at = int(start[row]) + place.offset
                found = buffer[at : at + place.kind.itemsize].view(place.kind)[0]
                assert found == value_at(trees[row], path)


def test_a_layout_has_only_the_elements_that_are_there() -> None:
    definition = parse_ros2msg("a/B", "float64[] data")
    layout = layout_of(definition, b"\0\1\0\0" + b"\1\0\0\0" + bytes(4) + bytes(8))
    assert layout.place(("data", 0)) is not None
    assert layout.place(("data", 1)) is None
    assert layout.place(("data",)) is None


def test_big_endian_and_the_second_version() -> None:
    definition = parse_ros2msg("a/B", "uint8 x\nfloat64 y")
    number = np.array([2.5], ">f8").tobytes()
    assert decode(definition, b"\0\0\0\0" + b"\7" + bytes(7) + number) == {"x": 7, "y": 2.5}
    # XCDR version 2 aligns numbers of eight bytes to four
    second = b"\0\7\0\0" + b"\7" + bytes(3) + np.array([2.5], "<f8").tobytes()
    assert decode(definition, second) == {"x": 7, "y": 2.5}
    assert layout_of(definition, second).place(("y",)).offset == 8


@pytest.mark.parametrize(
    "message",
    [
        b"",
        b"\0\1",
        b"\0\3\0\0" + bytes(20),  # a parameter list
        b"\0\1\0\0" + b"\xff\xff\xff\x7f",  # two thousand million elements
        b"\0\1\0\0" + b"\2\0\0\0" + bytes(4) + bytes(8),  # two announced, one there
    ],
)
def test_broken_messages_are_refused_by_both_ways(message: bytes) -> None:
    definition = parse_ros2msg("a/B", "float64[] data")
    for way in (decode, layout_of):
        with pytest.raises(BrokenMessageError):
            way(definition, message)


def test_strings_that_announce_too_much_are_refused() -> None:
    definition = parse_ros2msg("a/B", "string[] name")
    message = b"\0\1\0\0" + b"\xff\xff\xff\xff" + bytes(8)
    for way in (decode, layout_of):
        with pytest.raises(BrokenMessageError, match="announced"):
            way(definition, message)


def test_definitions_with_comments_constants_defaults_and_short_names() -> None:
    text = (
        '# a comment\nuint8 LOW=1  # constant\nstring NAME = "a # b"\nHeader header\n'
        'string<=5 text "x"\nfloat32[<=4] some [1.0, 2.0]\ntime at\nInner inner\n'
        + "=" * 80
        + "\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
        + "=" * 80
        + "\nMSG: pkg/Inner\n"
    )
    definition = parse_ros2msg("pkg/msg/Outer", text)
    assert [part.name for part in definition.fields] == ["header", "text", "some", "at", "inner"]
    assert definition.fields[2].length == -1
    assert definition.messages["pkg/msg/Inner"][0].name == "structure_needs_at_least_one_member"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("Missing x", "not defined"),
        ("B x", "contains itself"),
        ("float64", "cannot be understood"),
        ("int64 a\n---\nint64 b", "service"),
        ("wstring x", "wstring"),
        ("float64[99999999] x", "too long"),
        (f"A x\n{'=' * 80}\nMSG: a/A\nfloat64[0] x", "no elements"),
    ],
)
def test_definitions_that_cannot_be_read_say_why(text: str, says: str) -> None:
    with pytest.raises(DefinitionError, match=says):
        parse_ros2msg("a/B", text)


def test_idl_gives_the_same_as_ros2msg() -> None:
    idl = """
    ================================================================================
    IDL: pkg/msg/Outer
    #include "other.idl"
    module builtin_interfaces { module msg {
      struct Time { long sec; unsigned long nanosec; };
    }; };
    // a comment
    module pkg { module msg {
      const unsigned long COUNT = 3;
      typedef double three__[3];
      enum Mode { OFF, ON };
      @verbatim (language="comment", text="a { bracket")
      struct Outer {
        builtin_interfaces::msg::Time stamp;
        three__ force;
        sequence<float, 4> some;
        float other[COUNT];
        string<8> name;
        unsigned long long count, total;
        @unit (value="m") octet raw;
        boolean on;
      };
    }; };
    """
    text = (
        "builtin_interfaces/Time stamp\nfloat64[3] force\nfloat32[] some\nfloat32[3] other\n"
        "string name\nuint64 count\nuint64 total\nuint8 raw\nbool on\n"
    )
    encode = serialize_dynamic("pkg/msg/Outer", text)["pkg/msg/Outer"]
    message = bytes(
        encode(
            {
                "stamp": {"sec": 3, "nanosec": 4},
                "force": [1.0, 2.0, 3.0],
                "some": [0.5],
                "other": [1.5, 2.5, 3.5],
                "name": "abc",
                "count": 2**60,
                "total": 1,
                "raw": 9,
                "on": True,
            }
        )
    )
    expected = decode(parse_ros2msg("pkg/msg/Outer", text), message)
    assert decode(parse_idl("pkg/msg/Outer", idl), message) == expected


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("struct B { wstring x; };", "wstring"),
        ("union B switch (long) { case 1: long x; };", "union"),
        ("struct B { @optional long x; };", "optional"),
        ("struct B { C x; };", "not defined"),
        ("struct A { long y; }; struct B : A { long x; };", "cannot be understood"),
        ("struct B { long x;", "cannot be understood"),
        ("struct B { B x; };", "contains itself"),
        ("struct A { long x; };", "not defined"),
        ("struct B { long x[y]; };", "constant 'y'"),
        ("struct B { long x[²]; };", "cannot be understood"),
        (f"struct B {{ long x[{'9' * 5000}]; }};", "cannot be understood"),
        ("struct B { long x[10000][10000]; };", "Multidimensional"),
        ("typedef long A[10000]; typedef A C[10000]; struct B { C x; };", "Multidimensional"),
        ("struct B { };", "cannot be understood"),
        ("struct E { }; struct B { E x[1000]; };", "cannot be understood"),
        ("struct E { }; struct D : E { }; struct B { D x; };", "cannot be understood"),
        ("struct E { long x[0]; }; struct B { E x[1000]; };", "no elements"),
        ("typedef long N[0]; struct E { N x; }; struct B { E x[1000]; };", "no elements"),
        ("struct B { " + "sequence<" * 5000 + "long x; };", "sequence of sequences"),
    ],
)
def test_idl_that_cannot_be_read_says_why(text: str, says: str) -> None:
    with pytest.raises(DefinitionError, match=says):
        parse_idl("B", text)


def test_definitions_that_would_take_very_long_are_refused() -> None:
    chain = "".join(f"typedef long A{i}[3];" for i in range(1001))
    with pytest.raises(DefinitionError, match="more than 1000 typedefs"):
        parse_idl("B", f"{chain} struct B {{ long x; }};")
    with pytest.raises(DefinitionError, match="at most 200000"):
        parse_ros2msg("a/B", "#" * 200_001)


@pytest.mark.parametrize("text", ["", "Header header\nfloat64 x\n"])
def test_what_files_leave_undefined_is_taken_from_the_standard(text: str) -> None:
    name = "a/msg/B" if text else "sensor_msgs/msg/FluidPressure"
    fields = [part.name for part in parse_ros2msg(name, text).fields]
    assert fields == (["header", "x"] if text else ["header", "fluid_pressure", "variance"])
    with pytest.raises(DefinitionError, match="empty: my/msg/Own"):
        parse_ros2msg("my/msg/Own", "")


def test_messages_of_ros_1_are_packed_without_gaps() -> None:
    definition = parse_definition("a/B", "Header header\nuint8 n\nfloat64 y\ntime at", "ros1msg")
    expected = {
        "header": {"seq": 7, "stamp": {"sec": 5, "nanosec": 6}, "frame_id": "imu"},
        "n": 9,
        "y": 2.5,
        "at": {"sec": 1, "nanosec": 2},
    }
    message = struct.pack("<IIII3sBdII", 7, 5, 6, 3, b"imu", 9, 2.5, 1, 2)
    assert decode(definition, message) == expected
    assert layout_of(definition, message).place(("y",)).offset == 20


def test_a_message_of_ros_without_members_is_read() -> None:
    """rosidl gives it one: its structure in C may not be empty."""
    idl = """
    module std_msgs { module msg {
      struct Empty { uint8 structure_needs_at_least_one_member; };
    }; };
    module a { module msg { struct B { std_msgs::msg::Empty none[2]; long x; }; }; };
    """
    text = f"std_msgs/Empty[2] none\nint32 x\n{'=' * 80}\nMSG: std_msgs/Empty\n"
    message = b"\0\1\0\0" + bytes(4) + b"\7\0\0\0"
    for definition in (parse_idl("a/msg/B", idl), parse_ros2msg("a/msg/B", text)):
        assert decode(definition, message)["x"] == 7
        assert layout_of(definition, message).place(("x",)).offset == 8
