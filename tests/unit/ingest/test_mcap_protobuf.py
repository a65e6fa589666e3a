"""Protobuf put together by hand: messages and descriptors as other writers make them."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.ingest.message_definitions import BrokenMessageError, DefinitionError
from pipeline.ingest.pool_run_codec import protobuf_decoder


def varint(value: int) -> bytes:
    value &= (1 << 64) - 1
    found = b""
    while value >= 0x80:
        found += bytes([value & 0x7F | 0x80])
        value >>= 7
    return found + bytes([value])


def number(field: int, value: int) -> bytes:
    return varint(field << 3) + varint(value)


def block(field: int, content: bytes | str) -> bytes:
    data = content.encode() if isinstance(content, str) else content
    return varint(field << 3 | 2) + varint(len(data)) + data


def double(field: int, value: float) -> bytes:
    return varint(field << 3 | 1) + struct.pack("<d", value)


def field_of(  # noqa: PLR0917  the numbers of descriptor.proto in their order
    name: str, tag: int, kind: int, label: int = 1, message: str = "", extra: bytes = b""
) -> bytes:
    """A FieldDescriptorProto; types and labels are numbered as in descriptor.proto."""
    content = block(1, name) + number(3, tag) + number(4, label) + number(5, kind)
    return block(2, content + (block(6, message) if message else b"") + extra)


def descriptor_set() -> bytes:
    time = block(4, block(1, "Time") + field_of("sec", 1, 3) + field_of("nsec", 2, 5))
    inner = block(3, block(1, "Inner") + field_of("x", 1, 1))
    reading = block(
        4,
        block(1, "Reading")
        + field_of("stamp", 1, 11, message=".rig.Time")
        + field_of("depth", 2, 1)
        + field_of("temperature", 3, 2)
        + field_of("codes", 4, 17, label=3)  # sint32, packed or not
        + field_of("inner", 5, 11, label=3, message=".rig.Reading.Inner")
        + field_of("name", 6, 9)
        + field_of("on", 7, 8)
        + field_of("count", 8, 4)
        + field_of("offset", 9, 5)
        + field_of("volts", 10, 1, label=3)
        + field_of("maybe", 11, 1, extra=number(9, 0) + number(17, 1))  # optional
        + block(8, block(1, "_maybe"))
        + inner,
    )
    file = block(1, "rig.proto") + block(2, "rig") + time + reading + block(12, "proto3")
    return block(1, file)


@pytest.fixture(name="message")
def message_fixture() -> bytes:
    return (
        block(1, number(1, 5) + number(2, 7))
        + double(2, 1.25)
        + varint(3 << 3 | 5)
        + struct.pack("<f", 0.5)
        + block(4, varint(1) + varint(4))  # zigzag: -1, 2
        + number(4, 3)  # -2, unpacked
        + block(5, double(1, 3.0))
        + block(5, b"")
        + block(6, "ab")
        + number(7, 1)
        + number(8, 2**64 - 1)
        + number(9, -3)
        + block(10, struct.pack("<3d", 1.0, 2.0, 3.0))
        + number(99, 5)  # unknown
    )


def test_every_kind_of_field(message: bytes) -> None:
    decode = protobuf_decoder("rig.Reading", descriptor_set())
    assert decode(message) == {
        "stamp": {"sec": 5, "nsec": 7},
        "depth": 1.25,
        "temperature": 0.5,
        "codes": [-1, 2, -2],
        "inner": [{"x": 3.0}, {"x": 0.0}],
        "name": "ab",
        "on": 1,
        "count": 2**64 - 1,
        "offset": -3,
        "volts": [1.0, 2.0, 3.0],
    }


def test_what_was_not_sent_is_zero_or_absent() -> None:
    decode = protobuf_decoder("rig.Reading", descriptor_set())
    empty = decode(b"")
    assert empty["depth"] == 0.0
    assert empty["codes"] == []
    assert "stamp" not in empty
    assert "maybe" not in empty


def test_a_message_cut_off_anywhere_is_refused_or_shorter(message: bytes) -> None:
    decode = protobuf_decoder("rig.Reading", descriptor_set())
    # what is behind the last field that is known says nothing
    message = message[: -len(number(99, 5))]
    whole = decode(message)
    shorter = []
    for end in range(len(message)):
        try:
            shorter.append(decode(message[:end]))
        except BrokenMessageError:
            continue
    # it is read where it is cut between two of its 12 fields, and refused within any
    assert len(shorter) == 12
    assert whole not in shorter


@pytest.mark.parametrize("data", [b"\xff", b"\x0a\xff\x01", b"\x0a\x03\x22\x01\xff", b"nonsense"])
def test_what_is_no_descriptor_set_is_refused(data: bytes) -> None:
    with pytest.raises(DefinitionError):
        protobuf_decoder("rig.Reading", data)


def test_a_message_that_is_not_defined_is_named() -> None:
    with pytest.raises(DefinitionError, match=r"rig\.Other"):
        protobuf_decoder("rig.Other", descriptor_set())


@given(data=st.binary(max_size=80), at=st.integers(0, 200), change=st.integers(1, 255))
def test_whatever_the_bytes_are_there_is_a_message_or_a_reason(
    data: bytes, at: int, change: int
) -> None:
    whole = descriptor_set()
    spoiled = bytearray(whole)
    spoiled[at % len(whole)] ^= change
    for descriptor in (data, bytes(spoiled)):
        try:
            decode = protobuf_decoder("rig.Reading", descriptor)
        except DefinitionError:
            decode = protobuf_decoder("rig.Reading", whole)
        try:
            assert isinstance(decode(data), dict)
        except BrokenMessageError:
            continue


def wide(fields: int, inner: int = 0) -> bytes:
    """A descriptor set of a message that repeats one with so many numbers."""
    names = b"".join(field_of(f"f{i}", i + 1, 1) for i in range(fields))
    wide = block(4, block(1, "Wide") + names)
    more = b"".join(block(4, block(1, f"M{i}") + field_of("x", 1, 1)) for i in range(inner))
    many = block(4, block(1, "Many") + field_of("all", 1, 11, label=3, message=".rig.Wide"))
    return block(1, block(2, "rig") + wide + more + many + block(12, "proto3"))


def test_definitions_of_very_many_fields_are_refused() -> None:
    for fields, inner in ((10_001, 0), (5000, 5000)):
        with pytest.raises(DefinitionError, match="more than 10000 members"):
            protobuf_decoder("rig.Many", wide(fields, inner))


def test_fields_that_were_not_sent_do_not_multiply() -> None:
    """An element of two bytes has a thousand fields, each with its default."""
    decode = protobuf_decoder("rig.Many", wide(1000))
    element = block(1, b"")
    assert len(decode(element * 90)["all"]) == 90
    with pytest.raises(BrokenMessageError, match="more than 200000 numbers"):
        decode(element * 201)
