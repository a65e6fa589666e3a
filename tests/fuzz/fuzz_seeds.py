"""Valid files of every kind that is read, small, to be damaged; a module of the tests."""

import struct
import zlib
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from io import BytesIO

import numpy as np
import openpyxl
from bench_workbooks import sweep
from pool_logs import NAMES, START_NS, array_topic, imu_topic, joints_topic, json_topic, ticks

from pipeline.bundled.new_vehicle import new_vehicle_files
from pipeline.bundled.vehicles import bundled_vehicle

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, INDEX, STATISTICS, METADATA, DATA_END = (
    1, 2, 3, 4, 5, 6, 7, 0xB, 0xC, 0xF,
)  # fmt: skip
_IDL = """\
module geometry_msgs { module msg {
  struct Vector3 { double x; double y; double z; };
  typedef double Three[3];
  @verbatim(language="comment", text="a note")
  struct Depth { Vector3 at; sequence<float, 8> raw; Three spread; string<20> frame; };
}; };
"""


@dataclass(frozen=True)
class Record:
    """A record of a log; `length` is what is written for its length, None for the true one."""

    opcode: int
    content: bytes
    length: int | None = None

    def to_bytes(self) -> bytes:
        stated = len(self.content) if self.length is None else self.length
        return struct.pack("<BQ", self.opcode, stated & (2**64 - 1)) + self.content


@dataclass(frozen=True)
class Log:
    """A log as its parts: what stands before the chunk, in it, and behind it."""

    before: tuple[Record, ...]
    inside: tuple[Record, ...]
    behind: tuple[Record, ...]
    compression: str = ""
    uncompressed_size: int | None = None
    checksum: int | None = None
    packed_size: int | None = None
    index: bool = True

    def to_bytes(self) -> bytes:
        """Write the file; what is stated wrongly on purpose stays wrong, all else fits."""
        inner = b"".join(record.to_bytes() for record in self.inside)
        parts = [*self.before, Record(CHUNK, self._chunk(inner))]
        if self.index:
            parts += self._indices()
        return MAGIC + b"".join(part.to_bytes() for part in (*parts, *self.behind)) + MAGIC

    def _chunk(self, inner: bytes) -> bytes:
        packed = pack(inner, self.compression)
        size = len(inner) if self.uncompressed_size is None else self.uncompressed_size
        checksum = zlib.crc32(inner) if self.checksum is None else self.checksum
        stated = len(packed) if self.packed_size is None else self.packed_size
        head = struct.pack("<QQQI", START_NS, START_NS + 10**9, size, checksum)
        return head + text(self.compression) + struct.pack("<Q", stated) + packed

    def _indices(self) -> list[Record]:
        at = 0
        found: dict[int, list[tuple[int, int]]] = {}
        for record in self.inside:
            if record.opcode == MESSAGE and len(record.content) >= 14:
                channel, _, time = struct.unpack_from("<HIQ", record.content)
                found.setdefault(channel, []).append((time, at))
            at += 9 + len(record.content)
        return [
            Record(
                INDEX,
                struct.pack("<HI", channel, 16 * len(rows))
                + b"".join(struct.pack("<QQ", *row) for row in rows),
            )
            for channel, rows in found.items()
        ]


def text(value: str | bytes) -> bytes:
    """A text of MCAP: its length, then its bytes."""
    data = value.encode() if isinstance(value, str) else value
    return struct.pack("<I", len(data)) + data


def pack(data: bytes, compression: str) -> bytes:
    """Compress the content of a chunk."""
    if compression == "zstd":
        import zstandard

        return zstandard.ZstdCompressor().compress(data)
    if compression == "lz4":
        import lz4.frame

        return bytes(lz4.frame.compress(data))
    return data


def schema(number: int, name: str, encoding: str, definition: bytes) -> Record:
    content = struct.pack("<H", number) + text(name) + text(encoding) + text(definition)
    return Record(SCHEMA, content)


def channel(number: int, of_schema: int, topic: str, encoding: str) -> Record:
    content = struct.pack("<HH", number, of_schema) + text(topic) + text(encoding)
    return Record(CHANNEL, content + struct.pack("<I", 0))


def message(number: int, time_ns: int, data: bytes) -> Record:
    return Record(MESSAGE, struct.pack("<HIQQ", number, 0, time_ns, time_ns) + data)


def _block(field: int, content: bytes | str) -> bytes:
    data = content.encode() if isinstance(content, str) else content
    size = (
        bytes([len(data) & 0x7F | 0x80, len(data) >> 7]) if len(data) > 127 else bytes([len(data)])
    )
    return bytes([field << 3 | 2]) + size + data


def _protobuf() -> tuple[bytes, bytes]:
    """A descriptor set with one message of a double and a text, and such a message."""
    fields = [
        _block(2, _block(1, name) + bytes([3 << 3, tag, 4 << 3, 1, 5 << 3, kind]))
        for name, tag, kind in (("depth", 1, 1), ("frame", 2, 9))
    ]
    body = (
        _block(1, "d.proto") + _block(2, "rig") + _block(4, _block(1, "Depth") + b"".join(fields))
    )
    return _block(1, body), bytes([9]) + struct.pack("<d", 1.5) + _block(2, "map")


@cache
def log() -> Log:
    """Every encoding, a mapped channel of each kind of message, four thrusters, 24 readings."""
    times = ticks(24, 20.0)
    seconds = np.arange(24) / 20.0
    waves = 30.0 * np.sin(np.outer(seconds, [0.5, 0.8, 1.3, 0.3]))
    topics = [
        imu_topic(times, 0.01 * waves[:, :3]),
        joints_topic("/thrusters/command", times, [NAMES] * 24, waves),
        array_topic("/codes", times, waves.tolist()),
        json_topic("/depth", times, [{"depth": 1.0 + x, "stamp": {"sec": 1}} for x in seconds]),
    ]
    descriptor, reading = _protobuf()
    inside: list[Record] = []
    for number, topic in enumerate(topics, start=1):
        of_schema = number if topic.schema_encoding else 0
        if of_schema:
            inside.append(schema(number, topic.schema_name, topic.schema_encoding, topic.schema))
        inside.append(channel(number, of_schema, topic.name, topic.encoding))
    inside += [
        schema(8, "rig.Depth", "protobuf", descriptor),
        channel(8, 8, "/depth_pb", "protobuf"),
        schema(9, "geometry_msgs/msg/Depth", "ros2idl", _IDL.encode()),
        channel(9, 9, "/depth_idl", "cdr"),
    ]
    for k, time in enumerate(times.tolist()):
        inside += [message(i, time, one.messages[k]) for i, one in enumerate(topics, start=1)]
        inside.append(message(8, time, reading))
        values = struct.pack("<3dI2f4x3d", 0, 0, 1.5, 2, 1, 2, 0, 0, 0)
        inside.append(message(9, time, b"\0\1\0\0" + values + struct.pack("<I", 4) + b"map\0"))
    header = Record(HEADER, text("ros2") + text("fuzz"))
    pairs = text("water") + text("fresh")
    metadata = Record(METADATA, text("rig2sea") + struct.pack("<I", len(pairs)) + pairs)
    ends = (Record(DATA_END, bytes(4)), Record(FOOTER, bytes(20)))
    return Log((header, metadata), tuple(inside), ends)


@cache
def logs() -> tuple[bytes, ...]:
    """The log plain, packed in two ways, without index, and cut off."""
    one = log()
    packed = [replace(one, compression=name) for name in ("zstd", "lz4")]
    loose = replace(one, before=(*one.before, *one.inside), inside=(), index=False)
    whole = one.to_bytes()
    kinds = (*packed, replace(one, index=False), loose)
    return (whole, *(kind.to_bytes() for kind in kinds), whole[: len(whole) * 2 // 3])


def workbook(sheets: dict[str, list[list[object]]]) -> bytes:
    """A workbook as bytes."""
    book = openpyxl.Workbook()
    book.remove(book.worksheets[0])
    for name, cells in sheets.items():
        sheet = book.create_sheet(name)
        for row in cells:
            sheet.append(row)
    stream = BytesIO()
    book.save(stream)
    return stream.getvalue()


@cache
def rows() -> dict[str, dict[str, list[list[object]]]]:
    """The sheets of a valid file of each kind of bench test."""
    moored = [[code, round(0.0022 * code * abs(code), 3)] for code in range(-120, 121, 20)]
    open_water = [[x / 10, 0.139 - 0.0155 * x, 0.0171 - 0.0016 * x] for x in range(7)]
    return {
        "load_test": {
            f"Code {code}": [["Speed (rpm)", "Torque (N m)"], *map(list, sweep(code, 5))]
            for code in (30, 60, 90)
        },
        "mooring": {"Bollard": [["Code", "Thrust, N", "U, V"], *([*row, 48] for row in moored)]},
        "open_water": {"Screw": [["J", "K_T", "K_M"], *open_water]},
    }


@cache
def yaml_texts() -> dict[str, str]:
    """A valid text for every YAML file that is read."""
    folder = bundled_vehicle("rov8")
    designs = files("pipeline.bundled.design")
    return {
        "vehicle": (folder / "vehicle.yaml").read_text("utf-8"),
        "balance": designs.joinpath("mmt300_balance.yaml").read_text("utf-8"),
        "propeller": designs.joinpath("remus_propeller.yaml").read_text("utf-8"),
        "tether": designs.joinpath("mokeeva_tether.yaml").read_text("utf-8"),
        "new_vehicle": new_vehicle_files("boat")["vehicle.yaml"].decode(),
        "notes": "who: [A, B]\nbattery_v: 24.5\nballast: [{what: lead, mass_kg: 0.5, "
        "position_m: [0, 0, 1]}]\nwater: {kind: pool, temperature_c: 18}\n"
        "tether: {attached: true, paid_out_m: 12}\nchanged: trim\ntext: |\n  all well\n",
        "small": "name: boat\ntitle: a boat\nwater: {density_kgpm3: 1000.0, gravity_mps2: 9.81}\n"
        "propellers: {screw: {diameter_m: 0.14}}\ndrives: {d: {code_min: -9, code_max: 9}}\n"
        "tables: {propeller: screw, drive: d}\n"
        'columns: {load_test: {torque: {header: "M", unit: N m}}}\n',
    }


@cache
def valid_workbook(kind: str) -> bytes:
    """A valid workbook of a kind of bench test."""
    return workbook(rows()[kind])
