"""Serialisation against bytes put together by hand."""

import struct

import numpy as np
import pytest

from pipeline.export.cdr import fields, schema_text, serialise

HEADER = b"\x00\x01\x00\x00"


def test_joint_state_by_hand() -> None:
    """Alignment counts from the end of the four-byte header; an empty sequence is only a length."""
    rows = serialise(
        "sensor_msgs/msg/JointState",
        1,
        {
            "header.stamp.sec": np.array([7]),
            "header.stamp.nanosec": np.array([8]),
            "name": ("ab", "c"),
            "velocity": np.array([[1.5, -2.0]]),
        },
    )
    body = struct.pack("<iI", 7, 8)
    body += struct.pack("<I", 1) + b"\0" + bytes(3)  # frame_id "": its zero, then padding to 4
    body += struct.pack("<I", 2)
    body += struct.pack("<I", 3) + b"ab\0" + bytes(1)
    body += struct.pack("<I", 2) + b"c\0" + bytes(2)
    body += struct.pack("<I", 0)  # position: empty, so nothing is aligned for its elements
    body += struct.pack("<I", 2)
    body += bytes(-len(body) % 8) + struct.pack("<dd", 1.5, -2.0)
    body += struct.pack("<I", 0)
    assert rows.tobytes() == HEADER + body


def test_battery_state_by_hand() -> None:
    """Single bytes in a row, then a sequence of floats and two texts."""
    rows = serialise(
        "sensor_msgs/msg/BatteryState",
        1,
        {
            "voltage": np.array([48.1]),
            "percentage": float("nan"),
            "present": 1.0,
            "cell_voltage": np.array([[3.5]]),
            "serial_number": "x",
        },
    )
    body = struct.pack("<iI", 0, 0) + struct.pack("<I", 1) + bytes(4)
    body += struct.pack("<7f", 48.1, 0, 0, 0, 0, 0, float("nan"))
    body += bytes([0, 0, 0, 1])
    body += struct.pack("<If", 1, 3.5) + struct.pack("<I", 0)
    body += struct.pack("<I", 1) + b"\0" + bytes(3)
    body += struct.pack("<I", 2) + b"x\0"
    assert rows.tobytes() == HEADER + body


def test_a_text_is_measured_in_bytes() -> None:
    rows = serialise("std_msgs/msg/Header", 1, {"frame_id": "ось"})
    assert rows.tobytes()[12:] == struct.pack("<I", 7) + "ось".encode() + b"\0"


def test_each_message_gets_its_own_row() -> None:
    turns = np.arange(6.0).reshape(2, 3)
    rows = serialise("geometry_msgs/msg/Twist", 2, {"angular": turns})
    assert rows.shape == (2, 52)
    assert struct.unpack("<6d", rows[1].tobytes()[4:]) == (0.0, 0.0, 0.0, 3.0, 4.0, 5.0)


def test_no_message_is_no_row() -> None:
    rows = serialise("geometry_msgs/msg/Vector3", 0, {"x": np.empty(0)})
    assert rows.shape == (0, 28)


@pytest.mark.parametrize(
    ("values", "error", "text"),
    [
        ({"linear.w": 1.0}, ValueError, "no field linear.w"),
        ({"linear": np.zeros((2, 4))}, ValueError, "shape"),
        ({"linear": np.zeros((3, 3))}, ValueError, "shape"),
        ({"linear.x": "fast"}, TypeError, "numbers"),
    ],
)
def test_what_does_not_fit_is_refused(values: dict, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        serialise("geometry_msgs/msg/Twist", 2, values)


@pytest.mark.parametrize(
    "values", [{"name": "ab"}, {"header.frame_id": 3.0}, {"effort": np.zeros(1)}]
)
def test_a_filling_of_the_wrong_kind_is_refused(values: dict) -> None:
    with pytest.raises(TypeError, match=r"expected|takes"):
        serialise("sensor_msgs/msg/JointState", 1, values)


def test_columns_for_a_message_of_messages_are_refused() -> None:
    with pytest.raises(ValueError, match="plain numbers"):
        serialise("geometry_msgs/msg/TwistStamped", 1, {"twist": np.zeros((1, 2))})


def test_definition_lists_each_part_once_after_the_message() -> None:
    parts = schema_text("nav_msgs/msg/Odometry").split("=" * 80 + "\n")
    names = [part.splitlines()[0] for part in parts[1:]]
    assert parts[0].startswith("std_msgs/Header header\n")
    assert names == [
        "MSG: std_msgs/Header",
        "MSG: builtin_interfaces/Time",
        "MSG: geometry_msgs/PoseWithCovariance",
        "MSG: geometry_msgs/Pose",
        "MSG: geometry_msgs/Point",
        "MSG: geometry_msgs/Quaternion",
        "MSG: geometry_msgs/TwistWithCovariance",
        "MSG: geometry_msgs/Twist",
        "MSG: geometry_msgs/Vector3",
    ]


def test_constants_are_not_fields() -> None:
    assert fields("sensor_msgs/msg/BatteryState")[0].name == "header"
