# ruff: noqa: INP001, ANN001, ANN201, ANN204, D101, D102, PTH123  a script, as short as it can be
"""Write a log in the layout of docs/formats_log.md with the package `mcap` alone.

``python docs/examples/write_ros2_log.py`` writes commands and depth of a run of two seconds into
``run.mcap``: messages of ROS 2 in CDR, the bytes put together here.

CDR, little endian: four bytes 00 01 00 00, offsets count from their end; fields in order; a number
begins at a multiple of its own size, the gap before it is zero. A string is its number of bytes
with the closing zero (uint32), the bytes in UTF-8, the zero. A sequence is its number of elements
(uint32), then the elements; an empty one is its number alone.
"""

import struct

from mcap.writer import Writer

START_NS = 1_700_000_000_000_000_000
LINE = "=" * 80
HEADER = f"""{LINE}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{LINE}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
"""
FLUID_PRESSURE = """std_msgs/Header header
float64 fluid_pressure
float64 variance
"""


class Message:
    def __init__(self, stamp_ns, frame_id):
        self.body = b""
        self.number("i", stamp_ns // 1_000_000_000)
        self.number("I", stamp_ns % 1_000_000_000)
        self.text(frame_id)

    def number(self, kind, value):
        size = struct.calcsize(kind)
        self.body += bytes(-len(self.body) % size) + struct.pack("<" + kind, value)

    def text(self, value):
        self.number("I", len(value.encode()) + 1)
        self.body += value.encode() + b"\0"

    def numbers(self, values):
        self.number("I", len(values))
        for value in values:
            self.number("d", value)

    def cdr(self):
        return b"\x00\x01\x00\x00" + self.body


with open("run.mcap", "wb") as file:
    writer = Writer(file)
    writer.start(profile="ros2")
    joints = writer.register_schema(
        "sensor_msgs/msg/JointState", "ros2msg", (JOINT_STATE + HEADER).encode()
    )
    pressure = writer.register_schema(
        "sensor_msgs/msg/FluidPressure", "ros2msg", (FLUID_PRESSURE + HEADER).encode()
    )
    command = writer.register_channel("/thrusters/command", "cdr", joints)
    depth = writer.register_channel("/depth", "cdr", pressure)
    for i in range(101):
        now = START_NS + i * 20_000_000
        message = Message(now, "")
        message.number("I", 2)
        message.text("port")
        message.text("starboard")
        message.numbers([0.0 if i < 50 else 60.0, 0.0])
        message.numbers([])
        message.numbers([])
        writer.add_message(command, now, message.cdr(), now, i)
        if i % 5 == 0 and i > 0:
            # ten readings a second, 20 ms late: stamped with the time that they are valid for
            message = Message(now - 20_000_000, "depth_frd")
            message.number("d", 101325.0 + 1000.0 * 9.81 * 3.0)
            message.number("d", 0.0)
            writer.add_message(depth, now, message.cdr(), now, i // 5 - 1)
    writer.finish()
