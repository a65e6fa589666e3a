"""Runs of the second generator: what is commanded, what is measured, and the log of it."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from mcap.writer import Writer

from evaluation.craft import (
    DEPTH_BIAS,
    FORCE_BIAS,
    GRAVITY,
    NOISE,
    NOMINAL_V,
    RATE_BIAS,
    WANDER_RAD,
    WANDER_S,
    Array,
    Craft,
)
from evaluation.flight import COMMAND_S, STEP_S, coloured, march

START_NS = 1_790_000_000_000_000_000
#: Disturbances of a healthy vehicle: forces [N] and moments [N m] over thrust and lever.
PUSH_SHARE, PUSH_S = 0.004, 4.0
TOPICS = {
    "command": "/thrusters/command",
    "imu": "/imu",
    "dvl": "/dvl",
    "depth": "/depth",
    "volt": "/battery",
}


def codes_for(craft: Craft, kind: str, seconds: float, generator: np.random.Generator) -> Array:
    """Codes (m, n) at 10 Hz, open loop: a tenth of the thrust, a third of it in short bursts.

    ``straight`` uses the first thruster, or the first two that push ahead, alone.
    """
    rows = round(seconds / COMMAND_S)
    time_s = COMMAND_S * np.arange(rows)
    count = len(craft.thrusters)
    thrust = np.zeros((rows, count))
    ahead = [t for t, one in enumerate(craft.thrusters) if one.direction[0] > 0.5]
    most = 0.1 * min(craft.ahead_n, craft.astern_n)
    if kind == "straight":
        level = np.repeat(generator.uniform(0.4, 1.0, rows // 120 + 1), 120)[:rows]
        thrust[:, ahead] = most * level[:, None]
    elif kind == "steps":
        for t in range(count):
            hold = int(generator.integers(25, 70))
            levels = generator.choice([-1.0, -0.5, 0.0, 0.5, 1.0], rows // hold + 1)
            thrust[:, t] = most * np.repeat(levels, hold)[:rows]
    else:
        for t in range(count):
            for _ in range(4):
                frequency, phase = generator.uniform(0.02, 0.35), generator.uniform(0.0, 6.28)
                thrust[:, t] += most / 2.0 * np.sin(6.28 * frequency * time_s + phase)
        burst = generator.random(rows // 40 + 1) < 0.15
        thrust *= np.where(np.repeat(burst, 40)[:rows], 3.0, 1.0)[:, None]
    limit = np.where(thrust > 0.0, craft.ahead_n, craft.astern_n)
    share = np.minimum(np.abs(thrust) / limit, 1.0)
    code = share if craft.torque_held else np.sqrt(share)
    return np.asarray(np.round(np.sign(thrust) * code * craft.code_max))


def pushes_for(craft: Craft, seconds: float, generator: np.random.Generator) -> Array:
    """Small forces and moments (steps, 6) that any healthy vehicle feels."""
    lever = 0.3 * np.sqrt(craft.inertia / craft.mass) + 0.05
    size = PUSH_SHARE * craft.ahead_n * np.concatenate([np.ones(3), lever])
    return coloured(generator, round(seconds / STEP_S), size, PUSH_S)


def snag(seconds: float, generator: np.random.Generator, size_n: float) -> Array:
    """Let a line catch and let go (steps, 6): nothing of the library pulls like that."""
    steps = round(seconds / STEP_S)
    out = np.zeros((steps, 6))
    way = generator.standard_normal(3)
    way *= size_n / np.linalg.norm(way)
    for _ in range(3):
        begin = int(generator.integers(steps // 6, 5 * steps // 6))
        end = min(begin + int(generator.integers(steps // 15, steps // 6)), steps)
        out[begin:end, :3] += way * generator.choice([-1.0, 1.0])
    return out


def fly(craft: Craft, codes: Array, pushes: Array) -> Array:
    """Fly a whole run from rest."""
    return march(craft, codes, pushes, whole_s=len(codes) * COMMAND_S)


def write_log(
    path: Path, craft: Craft, codes: Array, flown: Array, generator: np.random.Generator
) -> None:
    """Write what the sensors read: IMU at 50 Hz, its errors wander, DVL at 5 Hz, depth at 8 Hz."""
    steps = len(flown)
    seconds = (steps - 1) * STEP_S
    wander = coloured(generator, steps, np.full(3, WANDER_RAD), WANDER_S)
    slow = coloured(generator, steps, np.full(6, 1.0), 0.05)
    rate_bias = RATE_BIAS * generator.standard_normal(3)
    force_bias = FORCE_BIAS * generator.standard_normal(3)
    depth_bias = DEPTH_BIAS * float(generator.standard_normal())
    lines: list[tuple[float, float, str, dict[str, object]]] = [
        (k * COMMAND_S, 0.0, "command", {"name": list(craft.names()), "position": code.tolist()})
        for k, code in enumerate(codes)
    ]
    for k in range(steps):
        row = flown[k]
        turn = _matrix(row[3:7])
        omega = row[10:13]
        force = row[-6:-3] + np.cross(omega, row[7:10]) - GRAVITY * turn[2]
        tilt = wander[k] + NOISE["attitude"] * generator.standard_normal(3)
        lines.append(
            (
                k * STEP_S,
                0.0,
                "imu",
                {
                    "orientation": _tilted(row[3:7], tilt),
                    "angular_velocity": _named(omega + rate_bias + NOISE["rate"] * slow[k, :3]),
                    "linear_acceleration": _named(
                        force + force_bias + NOISE["force"] * slow[k, 3:]
                    ),
                },
            )
        )
    for at in np.arange(0.13, seconds - 0.1, 0.2):
        row = flown[round(at / STEP_S)]
        seen = row[7:10] + np.cross(row[10:13], np.array(craft.dvl_place))
        noisy = craft.dvl_scale * seen + NOISE["dvl"] * generator.standard_normal(3)
        lines.append((float(at), 0.05, "dvl", {"velocity": _named(noisy)}))
    for at in np.arange(0.02, seconds, 0.125):
        depth = flown[round(at / STEP_S), 2] + depth_bias
        value = float(depth + NOISE["depth"] * generator.standard_normal())
        lines.append((float(at), 0.0, "depth", {"depth": value}))
    if craft.voltage_logged:
        low, high = craft.supply
        for at in np.arange(0.05, seconds, 0.5):
            volt = NOMINAL_V * (low + (high - low) * at / seconds)
            value = float(volt + NOISE["volt"] * generator.standard_normal())
            lines.append((float(at), 0.0, "volt", {"voltage": value}))
    _write(path, lines)


def _matrix(quaternion: Array) -> Array:
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _tilted(quaternion: Array, tilt: Array) -> dict[str, float]:
    """Turn an attitude by a small rotation in body axes."""
    w, x, y, z = quaternion
    a, b, c = 0.5 * tilt
    turned = np.array(
        [
            w - x * a - y * b - z * c,
            x + w * a + y * c - z * b,
            y + w * b + z * a - x * c,
            z + w * c + x * b - y * a,
        ]
    )
    turned /= np.linalg.norm(turned)
    return dict(zip("wxyz", turned.tolist(), strict=True))


def _named(vector: Array) -> dict[str, float]:
    return dict(zip("xyz", vector.tolist(), strict=True))


def _write(path: Path, lines: Sequence[tuple[float, float, str, dict[str, object]]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    names = sorted({name for _, _, name, _ in lines})
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channels = {name: writer.register_channel(TOPICS[name], "json", 0) for name in names}
        for valid_s, later_s, name, message in sorted(lines, key=lambda one: one[0] + one[1]):
            stamp, at = (START_NS + round(1e9 * t) for t in (valid_s, valid_s + later_s))
            head = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}}
            text = json.dumps({"header": head, **message})
            writer.add_message(channels[name], at, text.encode(), at)
        writer.finish()  # type: ignore[no-untyped-call]
