# ruff: noqa: INP001, PTH123  a script, as short as it can be
"""Write a log of a pool run in JSON with the package `mcap` alone.

``python docs/examples/write_json_log.py`` writes 20 s of commands, IMU and depth of a vehicle with
the thrusters ``port`` and ``starboard`` into ``run.mcap``; it is read without any mapping.
"""

import json
import math

from mcap.writer import Writer

START_NS = 1_700_000_000_000_000_000

with open("run.mcap", "wb") as stream:
    writer = Writer(stream)
    writer.start()
    command = writer.register_channel("/thrusters/command", "json", 0)
    imu = writer.register_channel("/imu", "json", 0)
    depth = writer.register_channel("/depth", "json", 0)
    for k in range(1000):
        t = k / 50
        time_ns = START_NS + k * 20_000_000
        stamp = {"sec": time_ns // 1_000_000_000, "nanosec": time_ns % 1_000_000_000}
        code = 40.0 * math.sin(0.5 * t)
        rate = 0.2 * math.sin(0.5 * t - 0.3) + 0.001 * math.sin(500.0 * t)
        messages = {
            command: {"name": ["port", "starboard"], "position": [code, -code]},
            imu: {
                "header": {"stamp": stamp},
                "angular_velocity": {"x": 0.0, "y": 0.0, "z": rate},
                "linear_acceleration": {"x": 0.01 * rate, "y": 0.0, "z": -9.81},
            },
            depth: {"header": {"stamp": stamp}, "depth": 2.0 + 0.1 * math.sin(0.2 * t)},
        }
        for channel, message in messages.items():
            writer.add_message(channel, time_ns, json.dumps(message).encode(), time_ns)
    writer.finish()
