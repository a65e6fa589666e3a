"""Protobuf as its own library writes it: the same numbers come out, and the same as from CDR."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from hypothesis import given
from hypothesis import strategies as st
from pool_logs import NAMES, START_NS, Topic, imu_topic, joints_topic, rov, ticks, write_log

from pipeline.ingest.pool_run import read_pool_run
from pipeline.ingest.pool_run_codec import protobuf_decoder

FIELD = descriptor_pb2.FieldDescriptorProto
#: Every type of a number -> its largest magnitude, and whether it may be negative.
INTEGERS = {
    "int64": (63, True),
    "uint64": (64, False),
    "int32": (31, True),
    "fixed64": (64, False),
    "fixed32": (32, False),
    "uint32": (32, False),
    "sfixed32": (31, True),
    "sfixed64": (63, True),
    "sint32": (31, True),
    "sint64": (63, True),
}


def file_of(syntax: str = "proto3") -> Any:  # noqa: ANN401  made by the library at run time
    """Messages rig.Vector, rig.Imu, rig.Command, rig.Numbers."""
    file = descriptor_pb2.FileDescriptorProto(name=f"{syntax}.proto", package="rig", syntax=syntax)

    def message(name: str, *fields: tuple[str, str, bool]) -> None:
        made = file.message_type.add(name=name)
        for number, (field, kind, repeated) in enumerate(fields, start=1):
            part = made.field.add(name=field, number=number)
            part.label = FIELD.LABEL_REPEATED if repeated else FIELD.LABEL_OPTIONAL
            if kind[0].isupper():
                part.type, part.type_name = FIELD.TYPE_MESSAGE, f".rig.{kind}"
            else:
                part.type = getattr(FIELD, f"TYPE_{kind.upper()}")

    message("Time", ("seconds", "int64", False), ("nanos", "int32", False))
    message("Vector", *((axis, "double", False) for axis in "xyz"))
    message(
        "Imu",
        ("timestamp", "Time", False),
        ("frame_id", "string", False),
        ("angular_velocity", "Vector", False),
        ("linear_acceleration", "Vector", False),
    )
    message(
        "Command",
        ("timestamp", "Time", False),
        ("name", "string", True),
        ("position", "double", True),
    )
    both = [(f"{kind}{'s' * many}", kind, many) for kind in INTEGERS for many in (False, True)]
    message("Numbers", *both, ("float", "float", False), ("bool", "bool", False))
    return file


def classes(syntax: str = "proto3") -> tuple[dict[str, Any], bytes]:
    """Message classes by name, and the descriptor set as a log carries it."""
    file = file_of(syntax)
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    found = {
        one.name: message_factory.GetMessageClass(pool.FindMessageTypeByName(f"rig.{one.name}"))
        for one in file.message_type
    }
    return found, descriptor_pb2.FileDescriptorSet(file=[file]).SerializeToString()


SETS = {syntax: classes(syntax) for syntax in ("proto2", "proto3")}


def integers(kind: str) -> st.SearchStrategy[int]:
    bits, signed = INTEGERS[kind]
    return st.integers(-(2**bits) if signed else 0, 2**bits - 1)


@given(
    syntax=st.sampled_from(["proto2", "proto3"]),
    one=st.fixed_dictionaries({kind: integers(kind) for kind in INTEGERS}),
    many=st.fixed_dictionaries(
        {f"{kind}s": st.lists(integers(kind), max_size=4) for kind in INTEGERS}
    ),
    real=st.floats(width=32, allow_nan=False),
    flag=st.booleans(),
)
def test_every_kind_of_number_comes_back(
    syntax: str, one: dict[str, int], many: dict[str, list[int]], real: float, flag: bool
) -> None:
    made, definition = SETS[syntax]
    message = made["Numbers"](**one, **many, float=real, bool=flag)
    found = protobuf_decoder("rig.Numbers", definition)(message.SerializeToString())
    assert found == {**one, **many, "float": real, "bool": int(flag)}


@pytest.mark.parametrize("syntax", ["proto2", "proto3"])
def test_a_log_in_protobuf_gives_the_arrays_of_the_same_log_in_cdr(
    tmp_path: Path, syntax: str
) -> None:
    made, definition = SETS[syntax]
    times = ticks(300, 50.0)
    values = np.random.default_rng(0).standard_normal((300, 3))
    values[7, 1] = 0.0  # proto3 does not send it
    codes = np.round(40.0 * np.random.default_rng(1).standard_normal((300, 4)))
    forces = values - [0.0, 0.0, 9.81]

    def stamp(time: int) -> Any:  # noqa: ANN401  as above
        return made["Time"](seconds=int(time) // 10**9, nanos=int(time) % 10**9)

    def vector(row: Any) -> Any:  # noqa: ANN401  as above
        return made["Vector"](x=row[0], y=row[1], z=row[2])

    imu = [
        made["Imu"](
            timestamp=stamp(time - 3_000_000),
            angular_velocity=vector(rate),
            linear_acceleration=vector(force),
        )
        for time, rate, force in zip(times, values, forces, strict=True)
    ]
    command = [
        made["Command"](timestamp=stamp(time), name=NAMES, position=row)
        for time, row in zip(times, codes, strict=True)
    ]

    def topic(name: str, schema: str, messages: list[Any]) -> Topic:
        data = [message.SerializeToString() for message in messages]
        return Topic(name, f"rig.{schema}", "protobuf", definition, "protobuf", times, data)

    path = write_log(
        tmp_path / "protobuf.mcap",
        [topic("/imu", "Imu", imu), topic("/thrusters/command", "Command", command)],
    )
    same = write_log(
        tmp_path / "cdr.mcap",
        [
            imu_topic(times, values, name="/imu", stamps_ns=times - 3_000_000, forces=forces),
            joints_topic("/thrusters/command", times, [NAMES] * 300, codes),
        ],
    )
    vehicle = rov()
    found, expected = (read_pool_run(one, vehicle, tmp_path) for one in (path, same))
    assert found.channels["angular_velocity"].time_ns[0] == START_NS - 3_000_000
    assert set(found.channels) == set(expected.channels)
    assert found.channels["angular_velocity"].read.encoding == "protobuf"
    for name, channel in expected.channels.items():
        np.testing.assert_array_equal(found.channels[name].values, channel.values)
        np.testing.assert_array_equal(found.channels[name].time_ns, channel.time_ns)
