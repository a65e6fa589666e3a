"""Another simulator of another vehicle, written from docs/pool_runs.md alone.

It shares nothing with the package: Euler angles, a small fixed step, logs of JSON messages whose
times meet no row of a table, commands at 20 Hz. What a diagnosis makes of such logs is what an
outsider would see.
"""

import json
import math
from dataclasses import dataclass, field
from pathlib import Path

import numba
import numpy as np
import numpy.typing as npt
from mcap.writer import Writer

Array = npt.NDArray[np.float64]
NAMES = ("fr", "fl", "rr", "rl", "vs", "vp")
_AHEAD, _ASIDE = 0.8660254, 0.5
PLACE = np.array(
    [
        [0.22, 0.18, 0.02],
        [0.22, -0.18, 0.02],
        [-0.22, 0.18, 0.02],
        [-0.22, -0.18, 0.02],
        [0.0, 0.17, 0.0],
        [0.0, -0.17, 0.0],
    ]
)
DIRECTION = np.array(
    [
        [_AHEAD, -_ASIDE, 0.0],
        [_AHEAD, _ASIDE, 0.0],
        [_AHEAD, _ASIDE, 0.0],
        [_AHEAD, -_ASIDE, 0.0],
        [0.0, 0.0, -1.0],
        [0.0, 0.0, -1.0],
    ]
)
AHEAD_N, ASTERN_N, DEAD_CODES = 40.0, 31.0, 6.0
GRAVITY, DENSITY = 9.81, 1000.0
STEP_S, COMMAND_S = 1e-3, 0.05
START_NS = 1_760_000_000_000_000_000
IMU_PLACE, DVL_PLACE = np.array([0.05, 0.0, -0.03]), np.array([-0.1, 0.0, 0.15])


@dataclass
class Scout:
    """The vehicle of scout.yaml; change a number and it is no longer that of its file."""

    mass_kg: float = 21.0
    volume_m3: float = 0.02107
    inertia: Array = field(default_factory=lambda: np.array([0.55, 0.75, 0.95]))
    added: Array = field(default_factory=lambda: np.array([9.0, 16.0, 22.0, 0.25, 0.35, 0.3]))
    linear: Array = field(default_factory=lambda: np.array([8.0, 14.0, 20.0, 0.6, 0.9, 0.9]))
    quadratic: Array = field(default_factory=lambda: np.array([60.0, 130.0, 160.0, 1.2, 1.6, 2.0]))
    lag_s: float = 0.12
    #: Whether small codes are ignored by the controller, before the shaft lags.
    dead_zone_first: bool = False
    #: Whether a shaft starts with a jump at its dead band of 4 codes and levels off, as a motor
    #: controller's does; the file then has a formula fitted to that.
    jumps: bool = False
    #: Supply voltage over that of the bench. A controller ignores the same codes at any.
    supply: float = 1.0


def plan(kind: str, seconds: float, generator: np.random.Generator) -> Array:
    """Codes (m, 6), open loop: forces ahead, aside and down, a yaw moment, shared out."""
    time_s = COMMAND_S * np.arange(round(seconds / COMMAND_S))
    wrench = np.zeros((time_s.size, 4))
    for axis, most in enumerate((45.0, 20.0, 16.0, 3.5)):
        if kind == "steps":
            held = np.repeat(generator.uniform(-most, most, time_s.size // 80 + 1), 80)
            wrench[:, axis] = held[: time_s.size]
        else:
            for frequency in generator.uniform(0.02, 0.4, 6):
                phase = generator.uniform(0.0, 6.28)
                wrench[:, axis] += most / 2.4 * np.sin(6.28 * frequency * time_s + phase)
    moment = np.cross(PLACE, DIRECTION)
    matrix = np.concatenate([DIRECTION.T, moment[:, 2:].T])
    force = wrench @ np.linalg.pinv(matrix).T
    share = np.sqrt(np.abs(force) / np.where(force > 0.0, AHEAD_N, ASTERN_N))
    code = np.sign(force) * (DEAD_CODES + (100.0 - DEAD_CODES) * share)
    return np.round(np.clip(np.where(np.abs(force) > 0.05, code, 0.0), -100.0, 100.0))


@numba.njit  # type: ignore[untyped-decorator]  # numba has no types
def _fly(  # noqa: PLR0917 - compiled: no records
    codes: Array,
    mass: Array,
    inverse: Array,
    drag: Array,
    weight: Array,
    lag_s: float,
    dead_zone_first: bool,
    jumps: bool,
    supply: float,
    gust: Array,
    place: Array,
    direction: Array,
) -> Array:
    """North, east, down, roll, pitch, yaw, nu, specific force, angular acceleration (steps, 18)."""
    steps = len(gust)
    found = np.zeros((steps, 18))
    position, angle, nu, act = np.array([0.0, 0.0, 6.0]), np.zeros(3), np.zeros(6), np.zeros(6)
    for k in range(steps):
        (sf, st, sp), (cf, ct, cp) = np.sin(angle), np.cos(angle)
        turn = np.array(
            [
                [cp * ct, cp * st * sf - sp * cf, sp * sf + cp * st * cf],
                [sp * ct, cp * cf + sp * st * sf, sp * st * cf - cp * sf],
                [-st, ct * sf, ct * cf],
            ]
        )
        down = turn[2].copy()
        wrench = gust[k] - drag[0] * nu - drag[1] * np.abs(nu) * nu
        code = codes[int(k * STEP_S / COMMAND_S + 1e-9)]
        if dead_zone_first:
            code = np.sign(code) * np.maximum(np.abs(code) - DEAD_CODES, 0.0)
        elif jumps:
            beyond = np.maximum(np.abs(code) - 4.0, 0.0) / 96.0
            share = 0.05 + 0.95 * (1.4 * beyond - 0.4 * beyond * beyond)
            code = np.sign(code) * np.where(beyond > 0.0, share, 0.0)
        act += STEP_S / lag_s * (supply * code - act)
        for i in range(6):
            lost = 0.0 if dead_zone_first else DEAD_CODES
            share = max(abs(act[i]) - lost, 0.0) / (100.0 - DEAD_CODES)
            if jumps:
                share = abs(act[i])
            thrust = share * share * (AHEAD_N if act[i] > 0.0 else -ASTERN_N)
            wrench[:3] += thrust * direction[i]
            wrench[3:] += np.cross(place[i], thrust * direction[i])
        # weight 0.02 m below the origin, buoyancy 0.02 m above it
        wrench[:3] += (weight[0] - weight[1]) * down
        wrench[3:] += np.cross(np.array([0.0, 0.0, 0.02]), (weight[0] + weight[1]) * down)
        momentum = mass @ nu
        v, w = nu[:3].copy(), nu[3:].copy()
        wrench[:3] -= np.cross(w, momentum[:3])
        wrench[3:] -= np.cross(w, momentum[3:]) + np.cross(v, momentum[:3])
        rate = inverse @ wrench
        found[k, :3], found[k, 3:6], found[k, 6:12] = position, angle, nu
        found[k, 12:15] = rate[:3] + np.cross(w, v) - GRAVITY * down
        found[k, 15:] = rate[3:]
        nu = nu + STEP_S * rate
        position = position + STEP_S * (turn @ nu[:3])
        p, q, r = nu[3], nu[4], nu[5]
        slope = sf * q + cf * r
        angle = angle + STEP_S * np.array([p + st / ct * slope, cf * q - sf * r, slope / ct])
    return found


def fly(scout: Scout, codes: Array, generator: np.random.Generator) -> Array:
    """Fly a vehicle by its codes, pushed about by a little."""
    lever = np.array([[0.0, -0.02, 0.0], [0.02, 0.0, 0.0], [0.0, 0.0, 0.0]])
    mass = np.diag(np.concatenate([np.full(3, scout.mass_kg), scout.inertia]) + scout.added)
    mass[:3, 3:], mass[3:, :3] = -scout.mass_kg * lever, scout.mass_kg * lever
    mass[3:, 3:] += scout.mass_kg * 0.02**2 * np.diag([1.0, 1.0, 0.0])
    weight = np.array([scout.mass_kg, DENSITY * scout.volume_m3]) * GRAVITY
    steps = round(len(codes) * COMMAND_S / STEP_S)
    gust = _wander(generator, steps, np.array([0.25, 0.25, 0.25, 0.01, 0.01, 0.01]), 3.0)
    drag = np.stack([scout.linear, scout.quadratic])
    inverse = np.linalg.inv(mass)
    late = scout.lag_s, scout.dead_zone_first, scout.jumps, scout.supply
    return np.asarray(_fly(codes, mass, inverse, drag, weight, *late, gust, PLACE, DIRECTION))


def _wander(generator: np.random.Generator, steps: int, size: Array, time_s: float) -> Array:
    from scipy.signal import lfilter

    keep = math.exp(-STEP_S / time_s)
    drawn = generator.standard_normal((steps, len(size))) * size
    drawn[1:] *= math.sqrt(1.0 - keep**2)
    return np.asarray(lfilter([1.0], [1.0, -keep], drawn, axis=0))


def write_run(path: Path, scout: Scout, kind: str, seconds: float, seed: int) -> None:
    """Fly a run and write its log: IMU between the rows of 50 Hz, DVL at 6 Hz, depth at 10 Hz."""
    generator = np.random.default_rng(seed)
    codes = plan(kind, seconds, generator)
    motion = fly(scout, codes, generator)
    steps = len(motion)
    wander = _wander(generator, steps, np.full(3, 0.004), 30.0)
    rate_bias, force_bias = 5e-4 * generator.standard_normal(3), 0.02 * generator.standard_normal(3)
    depth_bias = 0.01 * generator.standard_normal()

    def noisy(value: Array, size: float) -> Array:
        return np.asarray(value + size * generator.standard_normal(value.shape))

    log: list[tuple[float, float, str, dict[str, object]]] = [
        (k * COMMAND_S, 0.0, "command", {"name": NAMES, "position": code.tolist()})
        for k, code in enumerate(codes)
    ]
    for k in range(10, steps, 20):
        w, turning = motion[k, 9:12], motion[k, 15:]
        lever = np.cross(turning, IMU_PLACE) + np.cross(w, np.cross(w, IMU_PLACE))
        force = noisy(motion[k, 12:15] + lever + force_bias, 0.01)
        imu = {
            "orientation": _quaternion(noisy(motion[k, 3:6] + wander[k], 1e-3)),
            "angular_velocity": _named(noisy(w + rate_bias, 1e-3)),
            "linear_acceleration": _named(force),
        }
        log.append((k * STEP_S, 0.0, "imu", imu))
    for time_s in np.arange(0.3, seconds - 0.01, 1.0 / 6.0):
        row = motion[round(time_s / STEP_S)]
        velocity = noisy(row[6:9] + np.cross(row[9:12], DVL_PLACE), 0.004)
        log.append((time_s, 0.08, "dvl", {"velocity": _named(velocity)}))
    for k in range(50, steps, 100):
        depth = float(motion[k, 2] + depth_bias + 0.004 * generator.standard_normal())
        log.append((k * STEP_S, 0.0, "depth", {"depth": depth}))
    _write(path, log)


def _named(vector: Array) -> dict[str, float]:
    return dict(zip("xyz", vector.tolist(), strict=True))


def _quaternion(angle: Array) -> dict[str, float]:
    """Roll, pitch, yaw as a quaternion, its members as a program that sorts them writes them."""
    (a, b, c), (x, y, z) = np.cos(0.5 * angle), np.sin(0.5 * angle)
    return {
        "w": float(a * b * c + x * y * z),
        "x": float(x * b * c - a * y * z),
        "y": float(a * y * c + x * b * z),
        "z": float(a * b * z - x * y * c),
    }


def _write(path: Path, log: list[tuple[float, float, str, dict[str, object]]]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    topics = {"command": "/thrusters/command", "imu": "/imu", "dvl": "/dvl", "depth": "/depth"}
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channels = {name: writer.register_channel(t, "json", 0) for name, t in topics.items()}
        for valid_s, later_s, name, message in sorted(log, key=lambda one: one[0] + one[1]):
            stamp, at = (START_NS + round(1e9 * t) for t in (valid_s, valid_s + later_s))
            stamped = {"sec": stamp // 10**9, "nanosec": stamp % 10**9}
            text = json.dumps({"header": {"stamp": stamped}, **message})
            writer.add_message(channels[name], at, text.encode(), at)
        writer.finish()
