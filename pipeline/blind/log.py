"""Write the readings of a run as an MCAP log with standard ROS 2 messages.

The layout is that of docs/formats_log.md, written here a second time from that page: the reader of
the package meets a file that its own writer did not make.
"""

import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from pipeline.blind.truth.sensors import Log, SensorReading
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray, IntArray
from pipeline.vehicle.schema import Vehicle

SURFACE_PA = 101325.0
_LINE = "=" * 80
_HEADER = {
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
}
_VECTOR = {"geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z"}
#: Message -> its definition and those of the messages in it.
_MESSAGES = {
    "sensor_msgs/msg/JointState": (
        (
            "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
            "float64[] effort"
        ),
        _HEADER,
    ),
    "sensor_msgs/msg/Imu": (
        (
            "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
            "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
            "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
            "float64[9] linear_acceleration_covariance"
        ),
        _HEADER
        | _VECTOR
        | {"geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w"},
    ),
    "geometry_msgs/msg/TwistStamped": (
        "std_msgs/Header header\nTwist twist",
        _HEADER | _VECTOR | {"geometry_msgs/Twist": "Vector3 linear\nVector3 angular"},
    ),
    "geometry_msgs/msg/PointStamped": (
        "std_msgs/Header header\nPoint point",
        _HEADER | {"geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z"},
    ),
    "sensor_msgs/msg/FluidPressure": (
        "std_msgs/Header header\nfloat64 fluid_pressure\nfloat64 variance",
        _HEADER,
    ),
    "sensor_msgs/msg/BatteryState": (
        "std_msgs/Header header\n"
        + "\n".join(
            f"float32 {name}"
            for name in (
                "voltage",
                "temperature",
                "current",
                "charge",
                "capacity",
                "design_capacity",
                "percentage",
            )
        )
        + "\nuint8 power_supply_status\nuint8 power_supply_health\nuint8 power_supply_technology\n"
        "bool present\nfloat32[] cell_voltage\nfloat32[] cell_temperature\nstring location\n"
        "string serial_number",
        _HEADER,
    ),
}


class _Messages:
    """Messages of one topic, all of one size, put together field by field."""

    def __init__(self, stamp_ns: IntArray, frame: str) -> None:
        self.count = stamp_ns.size
        self.bytes = bytearray(b"\x00\x01\x00\x00")
        self.columns: list[tuple[int, npt.NDArray[np.uint8]]] = []
        self.numbers("<i4", stamp_ns // 1_000_000_000)
        self.numbers("<u4", stamp_ns % 1_000_000_000)
        self.text(frame)

    def numbers(self, kind: str, values: npt.NDArray[np.generic]) -> None:
        """Add a column, or several (count, m)."""
        matrix = np.ascontiguousarray(values.reshape(self.count, -1).astype(kind))
        self.align(matrix.itemsize)
        self.columns.append((len(self.bytes), matrix.view(np.uint8)))
        self.bytes += bytes(matrix.itemsize * matrix.shape[1])

    def same(self, kind: str, *values: float) -> None:
        """Add numbers that all messages share."""
        part = np.array(values, kind)
        self.align(part.itemsize)
        self.bytes += part.tobytes()

    def text(self, text: str) -> None:
        """Add a string."""
        content = text.encode() + b"\x00"
        self.same("<u4", len(content))
        self.bytes += content

    def array(self, values: FloatArray | None) -> None:
        """Add a float64[]; None is an empty one."""
        self.same("<u4", 0 if values is None else values.shape[1])
        if values is not None:
            self.numbers("<f8", values)

    def align(self, size: int) -> None:
        """Fill up to a multiple of a size, counted from after the header."""
        self.bytes += bytes(-(len(self.bytes) - 4) % size)

    def rows(self) -> list[bytes]:
        """All messages."""
        out = np.tile(np.frombuffer(bytes(self.bytes), np.uint8), (self.count, 1))
        for begin, column in self.columns:
            out[:, begin : begin + column.shape[1]] = column
        return [row.tobytes() for row in out]


def write_log(path: Path, log: Log, vehicle: Vehicle, start_time_ns: int) -> None:
    """Write the readings of one run to an MCAP; the file is there whole or not at all.

    The vehicle gives names of the thrusters, water and mount of the DVL; `start_time_ns` is time
    zero of the run since 1970 [ns].

    Raises
    ------
    CannotComputeError
        If the file cannot be written.
    """
    from mcap.writer import Writer

    topics = _topics(log, vehicle, start_time_ns)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with temporary.open("wb") as stream:
                writer = Writer(stream)
                writer.start(profile="ros2", library="")
                _write(writer, topics, log, start_time_ns)
                writer.finish()  # type: ignore[no-untyped-call]  # mcap has no annotations
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except OSError as error:
        raise CannotComputeError(
            f"{path}: the log cannot be written: {error.strerror or error}."
        ) from error


Topics = dict[str, tuple[str, str, list[bytes]]]


def _write(writer: object, topics: Topics, log: Log, start_time_ns: int) -> None:
    from mcap.writer import Writer

    if not isinstance(writer, Writer):
        raise TypeError("a writer of mcap is expected")
    schemas: dict[str, int] = {}
    queue: list[tuple[int, int, int, bytes]] = []
    for instrument, (topic, kind, rows) in topics.items():
        if kind not in schemas:
            schemas[kind] = writer.register_schema(kind, "ros2msg", _definition(kind))
        channel = writer.register_channel(topic, "cdr", schemas[kind])
        times = _nanoseconds(log[instrument].logged_s, start_time_ns)
        queue += [
            (time, channel, k, row) for k, (time, row) in enumerate(zip(times, rows, strict=True))
        ]
    for time, channel, k, row in sorted(queue, key=lambda one: one[:3]):
        writer.add_message(channel, time, row, time, k)


def _definition(kind: str) -> bytes:
    own, inner = _MESSAGES[kind]
    parts = [own, *(f"{_LINE}\nMSG: {name}\n{text}" for name, text in inner.items())]
    return "\n".join(parts).encode()


def _nanoseconds(time_s: FloatArray, start_time_ns: int) -> list[int]:
    whole = np.rint(time_s * 1e9).astype(np.int64) + start_time_ns
    return [int(value) for value in whole]


def _topics(log: Log, vehicle: Vehicle, start_time_ns: int) -> Topics:
    """Instrument -> topic, message and the bytes of its messages."""
    names = [one.name for one in vehicle.thrusters]
    out: Topics = {}
    for instrument, reading in log.items():
        stamp = np.array(_nanoseconds(reading.stamp_s, start_time_ns), np.int64)
        topic, kind, frame = _WHERE[instrument]
        body = _Messages(stamp, frame)
        if instrument in ("command", "shaft_speed"):
            body.same("<u4", len(names))
            for name in names:
                body.text(name)
            turning = reading.values * (2.0 * np.pi / 60.0)
            body.array(reading.values if instrument == "command" else None)
            body.array(turning if instrument == "shaft_speed" else None)
            body.array(None)
        else:
            _fill(instrument, body, reading, vehicle)
        out[instrument] = (topic, kind, body.rows())
    return out


_WHERE = {
    "command": ("/thrusters/command", "sensor_msgs/msg/JointState", ""),
    "shaft_speed": ("/thrusters/state", "sensor_msgs/msg/JointState", ""),
    "imu": ("/imu/data", "sensor_msgs/msg/Imu", "imu_frd"),
    "dvl": ("/dvl/velocity", "geometry_msgs/msg/TwistStamped", "dvl_frd"),
    "depth": ("/depth", "sensor_msgs/msg/FluidPressure", "depth_frd"),
    "position": ("/position", "geometry_msgs/msg/PointStamped", "ned"),
    "voltage": ("/battery", "sensor_msgs/msg/BatteryState", ""),
}


def _fill(instrument: str, body: _Messages, reading: SensorReading, vehicle: Vehicle) -> None:
    values = reading.values
    if instrument == "imu":
        body.numbers("<f8", values[:, [7, 8, 9, 6]])
        body.same("<f8", *[0.0] * 9)
        body.numbers("<f8", values[:, 0:3])
        body.same("<f8", *[0.0] * 9)
        body.numbers("<f8", values[:, 3:6])
        body.same("<f8", *[0.0] * 9)
    elif instrument == "dvl":
        from scipy.spatial.transform import Rotation

        dvl = vehicle.sensors.dvl if vehicle.sensors is not None else None
        turn = dvl.rotation_deg if dvl is not None else (0.0, 0.0, 0.0)
        mount = Rotation.from_euler("ZYX", np.radians(turn)[::-1])
        body.numbers("<f8", mount.inv().apply(values))
        body.same("<f8", 0.0, 0.0, 0.0)
    elif instrument == "depth":
        head = vehicle.water.density_kgpm3 * vehicle.water.gravity_mps2 * values
        body.numbers("<f8", SURFACE_PA + head)
        body.same("<f8", 0.0)
    elif instrument == "position":
        body.numbers("<f8", values)
    elif instrument == "voltage":
        body.numbers("<f4", values)
        body.same("<f4", *[float("nan")] * 6)
        body.same("u1", 0, 0, 0, 1)
        body.same("<u4", 0)
        body.same("<u4", 0)
        body.text("")
        body.text("")
