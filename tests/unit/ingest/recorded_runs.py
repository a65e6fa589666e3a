"""One pool run in the formats of all recorders, written small; a module of the tests, not a test.

Bags by rosbags, the telemetry log by pymavlink, data-flash and ULog byte by byte as their
specifications have them.
"""

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pool_logs import NAMES, START_NS, stamp, vector

from pipeline.types import FloatArray, IntArray

RATE_HZ = 25.0


@dataclass(frozen=True)
class Run:
    """What a vehicle did: times (k,) [ns since 1970] and readings of each quantity (k, m)."""

    time_ns: IntArray
    command_us: FloatArray
    rates_radps: FloatArray
    force_mps2: FloatArray
    euler_rad: FloatArray
    pressure_pa: FloatArray
    voltage_v: FloatArray


def run(count: int = 300) -> Run:
    """A run of some seconds in which everything moves a little."""
    t = np.arange(count) / RATE_HZ
    noise = np.random.default_rng(0).standard_normal((count, 3))
    roll, pitch, yaw = 0.05 * np.sin(t), 0.04 * np.cos(0.7 * t), 0.5 + 0.2 * np.sin(0.3 * t)
    rates = np.stack([0.05 * np.cos(t), -0.028 * np.sin(0.7 * t), 0.06 * np.cos(0.3 * t)], axis=1)
    down = np.stack(
        [-np.sin(pitch), np.sin(roll) * np.cos(pitch), np.cos(roll) * np.cos(pitch)], axis=1
    )
    codes = np.round(100.0 * np.sin(np.outer(t, [0.5, 0.6, 0.7, 0.8])))
    return Run(
        START_NS + np.round(t * 1e9).astype(np.int64),
        1500.0 + codes,
        rates + 1e-3 * noise,
        -9.81 * down + 1e-2 * noise,
        np.stack([roll, pitch, yaw], axis=1),
        101_325.0 + 9810.0 * (1.5 + 0.2 * np.sin(0.4 * t))[:, None],
        15.8 - 0.01 * t[:, None],
    )


def quaternion(euler_rad: FloatArray) -> FloatArray:
    """Quaternions w, x, y, z of roll, pitch, yaw."""
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_euler("ZYX", euler_rad[:, ::-1]).as_quat().T
    return np.stack([w, x, y, z], axis=1)


def _ros_messages(one: Run) -> dict[str, tuple[str, list[dict[str, object]]]]:
    """Topic -> type, contents; axes FRD and NED, as their frames say."""
    heads = [{"stamp": stamp(time), "frame_id": "base_frd"} for time in one.time_ns.tolist()]
    turns = quaternion(one.euler_rad)[:, [1, 2, 3, 0]]
    return {
        "/imu": (
            "sensor_msgs/msg/Imu",
            [
                {
                    "header": head,
                    "orientation": vector(turn),
                    "orientation_covariance": [0.0] * 9,
                    "angular_velocity": vector(rate),
                    "angular_velocity_covariance": [0.0] * 9,
                    "linear_acceleration": vector(force),
                    "linear_acceleration_covariance": [0.0] * 9,
                }
                for head, turn, rate, force in zip(
                    heads, turns, one.rates_radps, one.force_mps2, strict=True
                )
            ],
        ),
        "/thrusters/command": (
            "sensor_msgs/msg/JointState",
            [
                {
                    "header": head,
                    "name": list(NAMES),
                    "position": list(map(float, row)),
                    "velocity": [],
                    "effort": [],
                }
                for head, row in zip(heads, one.command_us, strict=True)
            ],
        ),
        "/water_pressure": (
            "sensor_msgs/msg/FluidPressure",
            [
                {"header": head, "fluid_pressure": float(value), "variance": 0.0}
                for head, (value,) in zip(heads, one.pressure_pa, strict=True)
            ],
        ),
    }


def write_mcap(path: Path, one: Run) -> Path:
    from pool_logs import ros_topic, write_log

    topics = [
        ros_topic(name, kind, one.time_ns.tolist(), contents)
        for name, (kind, contents) in _ros_messages(one).items()
    ]
    return write_log(path, topics)


def _as_message(store: object, kind: str, content: Mapping[str, object]) -> object:
    """Build a message of rosbags from dictionaries and lists."""
    made = {}
    for name, (node, what) in store.fielddefs[kind][1]:  # type: ignore[attr-defined]
        value = content.get(name, 0)
        if node == 2:
            made[name] = _as_message(store, what, value)  # type: ignore[arg-type]
        elif node in (3, 4) and what[0][1][0] != "string":
            made[name] = np.array(value, np.float64)
        else:
            made[name] = value
    return store.types[kind](**made)  # type: ignore[attr-defined]


def write_bag(path: Path, one: Run) -> Path:
    """A bag of ROS 1."""
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    with Writer(path) as writer:
        for name, (kind, contents) in _ros_messages(one).items():
            connection = writer.add_connection(name, kind, typestore=store)
            for time, content in zip(one.time_ns.tolist(), contents, strict=True):
                message = _as_message(store, kind, content)
                writer.write(connection, time, store.serialize_ros1(message, kind))
    return path


def write_db3(path: Path, one: Run, folder: Path) -> Path:
    """A bag of ROS 2 in SQLite, taken out of the folder that ros2 bag makes."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(folder / "bag", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        for name, (kind, contents) in _ros_messages(one).items():
            connection = writer.add_connection(name, kind, typestore=store)
            for time, content in zip(one.time_ns.tolist(), contents, strict=True):
                message = _as_message(store, kind, content)
                writer.write(connection, time, store.serialize_cdr(message, kind))
    (found,) = (folder / "bag").glob("*.db3")
    return found.rename(path)


def write_csv(path: Path, one: Run) -> Path:
    heads = ["time_ns", *(f"pwm_{name} [us]" for name in NAMES), "p [rad/s]", "q [rad/s]"]
    heads += ["r [rad/s]", "ax [m/s2]", "ay [m/s2]", "az [m/s2]", "roll [deg]", "pitch [deg]"]
    heads += ["yaw [deg]", "pressure [Pa]", "voltage [V]"]
    columns = np.concatenate(
        [
            one.command_us, one.rates_radps, one.force_mps2, np.degrees(one.euler_rad),
            one.pressure_pa, one.voltage_v,
        ],
        axis=1,
    )  # fmt: skip
    lines = [",".join(heads)]
    lines += [
        ",".join([str(time), *(f"{value:.9g}" for value in row)])
        for time, row in zip(one.time_ns.tolist(), columns, strict=True)
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


def write_parquet(path: Path, one: Run) -> Path:
    import pandas as pd

    pd.read_csv(write_csv(path.with_suffix(".tmp"), one)).to_parquet(path)
    return path


#: Of a data-flash log: type, name, format, columns.
_BIN = (
    (1, "PARM", "QNf", "TimeUS,Name,Value"),
    (2, "RCOU", "QHHHHHH", "TimeUS,C1,C2,C3,C4,C5,C6"),
    (3, "IMU", "QBffffffBB", "TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,GH,AH"),
    (4, "ATT", "Qccc", "TimeUS,Roll,Pitch,Yaw"),
    (5, "BARO", "QBffB", "TimeUS,I,Alt,Press,H"),
    (6, "BAT", "QBff", "TimeUS,Instance,Volt,Curr"),
    (7, "GPS", "QBIH", "TimeUS,Status,GMS,GWk"),
)
_CODES = {"Q": "Q", "N": "16s", "f": "f", "H": "H", "B": "B", "c": "h", "I": "I"}


def write_bin(
    path: Path,
    one: Run,
    outputs: Sequence[int] = (5, 3, 4, 2),
    ill: Sequence[int] = (),
    rewired: Sequence[int] = (),
) -> Path:
    """A data-flash log of ArduPilot; thrusters are motors 1 to 4 on these outputs.

    Sensors call themselves ill at some of the times. From the middle of the run on the motors are
    on other outputs.
    """
    packers = {
        name: struct.Struct("<" + "".join(_CODES[c] for c in form)) for _, name, form, _ in _BIN
    }
    numbers = {name: number for number, name, _, _ in _BIN}
    fmt = struct.Struct("<BB4s16s64s")
    data = bytearray()

    def add(name: str, *values: object) -> None:
        data.extend(b"\xa3\x95" + bytes([numbers[name]]) + packers[name].pack(*values))

    def define(number: int, length: int, name: str, form: str, columns: str) -> None:
        content = fmt.pack(number, length, name.encode(), form.encode(), columns.encode())
        data.extend(b"\xa3\x95\x80" + content)

    define(128, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    for number, name, form, columns in _BIN:
        define(number, 3 + packers[name].size, name, form, columns)
    boot_us = 20_000_000
    for motor, output in enumerate(outputs):
        add("PARM", boot_us, f"SERVO{output}_FUNCTION".encode(), 33.0 + motor)
    week_ns = (315_964_800 - 18) * 10**9
    since = int(one.time_ns[0]) - week_ns
    week, rest = divmod(since, 604_800 * 10**9)
    add("GPS", boot_us, 3, rest // 10**6, week)
    for k, time in enumerate(one.time_ns.tolist()):
        at = boot_us + (time - int(one.time_ns[0])) // 1000
        if rewired and 2 * k == len(one.time_ns):
            outputs = rewired
            for motor, output in enumerate(outputs):
                add("PARM", at, f"SERVO{output}_FUNCTION".encode(), 33.0 + motor)
        pulses = [1500] * 6
        for output, pulse in zip(outputs, one.command_us[k], strict=True):
            pulses[output - 1] = round(pulse)
        add("RCOU", at, *pulses)
        well = k not in ill
        add("IMU", at, 0, *one.rates_radps[k], *one.force_mps2[k], well, well)
        add("ATT", at, *(round(100.0 * angle) for angle in np.degrees(one.euler_rad[k])))
        add("BARO", at, 0, 0.1, 100_000.0 + 0.01 * k, well)
        add("BARO", at, 1, -1.0, one.pressure_pa[k, 0], well)
        add("BAT", at, 0, one.voltage_v[k, 0], 1.0 + 0.01 * k)
    path.write_bytes(bytes(data))
    return path


def write_ulg(path: Path, one: Run) -> Path:
    """A log of PX4: definitions, subscriptions, data."""
    formats = {
        "actuator_outputs": "uint64_t timestamp;float[6] output;",
        "sensor_combined": "uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;",
        "vehicle_attitude": "uint64_t timestamp;float[4] q;",
        "sensor_baro": "uint64_t timestamp;float pressure;",
        "battery_status": "uint64_t timestamp;float voltage_v;",
        "sensor_gps": "uint64_t timestamp;uint64_t time_utc_usec;",
    }
    data = bytearray(b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 5_000_000))

    def add(kind: str, content: bytes) -> None:
        data.extend(struct.pack("<HB", len(content), ord(kind)) + content)

    add("B", bytes(40))
    for name, fields in formats.items():
        add("F", f"{name}:{fields}".encode())
    for number, name in enumerate(formats):
        add("A", struct.pack("<BH", 0, number) + name.encode())
    numbers = {name: number for number, name in enumerate(formats)}

    def reading(name: str, at_us: int, *values: float, kind: str = "f") -> None:
        content = struct.pack(f"<Q{len(values)}{kind}", at_us, *values)
        add("D", struct.pack("<H", numbers[name]) + content)

    reading("sensor_gps", 5_000_000, int(one.time_ns[0]) // 1000, kind="Q")
    turns = quaternion(one.euler_rad)
    for k, time in enumerate(one.time_ns.tolist()):
        at = 5_000_000 + (time - int(one.time_ns[0])) // 1000
        reading("actuator_outputs", at, *one.command_us[k], 900.0, 900.0)
        reading("sensor_combined", at, *one.rates_radps[k], *one.force_mps2[k])
        reading("vehicle_attitude", at, *turns[k])
        reading("sensor_baro", at, one.pressure_pa[k, 0])
        reading("battery_status", at, one.voltage_v[k, 0])
    path.write_bytes(bytes(data))
    return path


def write_tlog(path: Path, one: Run) -> Path:
    """A telemetry log: a vehicle, and a ground station that talks too."""
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    vehicle = dialect.MAVLink(None, srcSystem=1, srcComponent=1)
    station = dialect.MAVLink(None, srcSystem=255, srcComponent=190)
    with path.open("wb") as file:

        def add(link: object, at_us: int, message: object) -> None:
            file.write(struct.pack(">Q", at_us) + message.pack(link))  # type: ignore[attr-defined]

        first = int(one.time_ns[0]) // 1000
        add(station, first, dialect.MAVLink_heartbeat_message(6, 8, 0, 0, 0, 3))
        add(vehicle, first, dialect.MAVLink_heartbeat_message(12, 3, 0, 0, 0, 3))
        for k, time in enumerate(one.time_ns.tolist()):
            at, boot_ms = time // 1000, (time - int(one.time_ns[0])) // 10**6
            pulses = [round(pulse) for pulse in one.command_us[k]] + [0] * 4
            add(vehicle, at, dialect.MAVLink_servo_output_raw_message(boot_ms * 1000, 0, *pulses))
            euler, rates = one.euler_rad[k], one.rates_radps[k]
            add(vehicle, at, dialect.MAVLink_attitude_message(boot_ms, *euler, *rates))
            force = [round(1000.0 * value / 9.80665) for value in one.force_mps2[k]]
            gyro = [round(1000.0 * value) for value in rates]
            imu = dialect.MAVLink_raw_imu_message(boot_ms * 1000, *force, *gyro, 0, 0, 0)
            add(vehicle, at, imu)
            pressure = one.pressure_pa[k, 0] / 100.0
            add(vehicle, at, dialect.MAVLink_scaled_pressure2_message(boot_ms, pressure, 0.0, 1200))
    return path
