"""The second generator's motion: classical Runge-Kutta of one state vector, by shafts that turn.

State: position NED, quaternion body to NED, velocities in body axes, shaft speeds over full speed.
Momenta are taken with the whole mass matrix; moments are about the origin of the body.
"""

import math

import numba
import numpy as np
from scipy.signal import lfilter

from evaluation.craft import GRAVITY, Array, Craft

STEP_S, COMMAND_S = 0.02, 0.1


@numba.njit(cache=True)
def _slope(  # noqa: PLR0915, PLR0917 - compiled: no records
    x: Array,
    share: Array,
    mass: Array,
    inverse: Array,
    drag: Array,
    rest: Array,
    shafts: Array,
    push: Array,
    torque_held: bool,
    rate: Array,
    work: Array,
) -> None:
    """Fill the rate of change of the state; `share` is what each drive holds, of its full code.

    `rest` is weight, buoyancy, centre of mass, height of the buoyancy, current; a row of `shafts`
    is a thruster: its numbers, place and direction. `work` (4, 6) is room to work in.
    """
    nr, wrench, moved = work[0], work[1], work[2]
    w, i, j, k = x[3], x[4], x[5], x[6]
    t00, t01, t02 = 1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j)
    t10, t11, t12 = 2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i)
    t20, t21, t22 = 2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j)
    f0 = t00 * rest[6] + t10 * rest[7] + t20 * rest[8]
    f1 = t01 * rest[6] + t11 * rest[7] + t21 * rest[8]
    f2 = t02 * rest[6] + t12 * rest[7] + t22 * rest[8]
    nr[0], nr[1], nr[2] = x[7] - f0, x[8] - f1, x[9] - f2
    p, q, r = x[10], x[11], x[12]
    nr[3], nr[4], nr[5] = p, q, r
    for a in range(6):
        wrench[a] = push[a] - (drag[0, a] + drag[1, a] * abs(nr[a])) * nr[a]
    for t in range(share.size):
        n = x[13 + t]
        ahead_n, astern_n, free, lag, gain, reverse, px, py, pz, dx, dy, dz = shafts[t]
        along = (
            dx * (nr[0] + q * pz - r * py)
            + dy * (nr[1] + r * px - p * pz)
            + dz * (nr[2] + p * py - q * px)
        )
        most = ahead_n if n > 0.0 else astern_n * reverse
        force = gain * most * (n * abs(n) - abs(n) * along / free)
        wrench[0] += force * dx
        wrench[1] += force * dy
        wrench[2] += force * dz
        wrench[3] += force * (py * dz - pz * dy)
        wrench[4] += force * (pz * dx - px * dz)
        wrench[5] += force * (px * dy - py * dx)
        if torque_held:
            # torque of the drive less that of the water
            rate[13 + t] = (share[t] - n * abs(n)) / lag
        else:
            rate[13 + t] = (math.copysign(math.sqrt(abs(share[t])), share[t]) - n) / lag
    weight, lift = rest[0], rest[1]
    wrench[0] += (weight - lift) * t20
    wrench[1] += (weight - lift) * t21
    wrench[2] += (weight - lift) * t22
    gx, gy, gz = weight * rest[2], weight * rest[3], weight * rest[4] - lift * rest[5]
    wrench[3] += gy * t22 - gz * t21
    wrench[4] += gz * t20 - gx * t22
    wrench[5] += gx * t21 - gy * t20
    for a in range(6):
        moved[a] = 0.0
        for b in range(6):
            moved[a] += mass[a, b] * nr[b]
    wrench[0] -= q * moved[2] - r * moved[1]
    wrench[1] -= r * moved[0] - p * moved[2]
    wrench[2] -= p * moved[1] - q * moved[0]
    wrench[3] -= q * moved[5] - r * moved[4] + nr[1] * moved[2] - nr[2] * moved[1]
    wrench[4] -= r * moved[3] - p * moved[5] + nr[2] * moved[0] - nr[0] * moved[2]
    wrench[5] -= p * moved[4] - q * moved[3] + nr[0] * moved[1] - nr[1] * moved[0]
    for a in range(6):
        rate[7 + a] = 0.0
        for b in range(6):
            rate[7 + a] += inverse[a, b] * wrench[b]
    rate[7] -= q * f2 - r * f1
    rate[8] -= r * f0 - p * f2
    rate[9] -= p * f1 - q * f0
    rate[0] = t00 * x[7] + t01 * x[8] + t02 * x[9]
    rate[1] = t10 * x[7] + t11 * x[8] + t12 * x[9]
    rate[2] = t20 * x[7] + t21 * x[8] + t22 * x[9]
    rate[3] = -0.5 * (i * p + j * q + k * r)
    rate[4] = 0.5 * (w * p + j * r - k * q)
    rate[5] = 0.5 * (w * q + k * p - i * r)
    rate[6] = 0.5 * (w * r + i * q - j * p)


@numba.njit(cache=True)
def _march(  # noqa: PLR0917 - compiled: no records
    start: Array,
    shares: Array,
    every: int,
    mass: Array,
    inverse: Array,
    drag: Array,
    rest: Array,
    shafts: Array,
    pushes: Array,
    torque_held: bool,
    step: float,
) -> Array:
    """States (steps + 1, ...), then the accelerations in six further columns."""
    steps, size = pushes.shape[0], start.size
    out, work = np.zeros((steps + 1, size + 6)), np.zeros((4, 6))
    x, at, slopes = start.copy(), start.copy(), np.zeros((4, size))
    ahead = (0.0, 0.5, 0.5, 1.0)
    for s in range(steps + 1):
        share = shares[min(s // every, shares.shape[0] - 1)]
        push = pushes[min(s, steps - 1)]
        for stage in range(4):
            for c in range(size):
                at[c] = x[c]
                if stage > 0:
                    at[c] += ahead[stage] * step * slopes[stage - 1, c]
            _slope(
                at, share, mass, inverse, drag, rest, shafts, push, torque_held, slopes[stage], work
            )
        for c in range(size):
            out[s, c] = x[c]
        for c in range(6):
            out[s, size + c] = slopes[0, 7 + c]
        for c in range(size):
            x[c] += (
                step / 6.0 * (slopes[0, c] + 2.0 * slopes[1, c] + 2.0 * slopes[2, c] + slopes[3, c])
            )
        length = math.sqrt(x[3] ** 2 + x[4] ** 2 + x[5] ** 2 + x[6] ** 2)
        for c in range(3, 7):
            x[c] /= length
    return out


def march(  # noqa: PLR0917 - a flight, and where it begins
    craft: Craft,
    codes: Array,
    pushes: Array,
    start: Array | None = None,
    first_s: float = 0.0,
    whole_s: float = 60.0,
) -> Array:
    """Fly codes (m, n) of 10 Hz under pushes (steps, 6) of a craft.

    Returns
    -------
    ndarray, shape (steps + 1, 13 + n + 6)
        States, and accelerations of the velocities.
    """
    count = len(craft.thrusters)
    centre = np.array(craft.centre) + np.array([0.0, 0.0, craft.below])
    cross = np.array(
        [[0, -centre[2], centre[1]], [centre[2], 0, -centre[0]], [-centre[1], centre[0], 0]]
    )
    mass = np.zeros((6, 6))
    mass[:3, :3] = craft.mass * np.eye(3)
    mass[:3, 3:], mass[3:, :3] = -craft.mass * cross, craft.mass * cross
    mass[3:, 3:] = np.diag(craft.inertia) - craft.mass * cross @ cross
    mass += np.diag(craft.added)
    rest = np.array(
        [craft.mass * GRAVITY, craft.buoyancy, *centre, -craft.below, *craft.current], float
    )
    shafts = np.array(
        [
            [
                *(craft.ahead_n, craft.astern_n, craft.free_speed, craft.lag),
                *(one.gain, one.reverse),
                *one.place,
                *(np.array(one.direction) / np.linalg.norm(one.direction)),
            ]
            for one in craft.thrusters
        ]
    )
    time_s = first_s + STEP_S * round(COMMAND_S / STEP_S) * np.arange(len(codes))
    low, high = craft.supply
    supply = low + (high - low) * np.minimum(time_s / whole_s, 1.0)
    lost = np.array([one.lost for one in craft.thrusters])
    beyond = np.maximum(np.abs(codes) - lost, 0.0) / (craft.code_max - lost)
    linear = np.sign(codes) * beyond * supply[:, None]
    # a held speed goes with the code, a held torque too; the first is squared in the thrust
    shares = linear if craft.torque_held else np.sign(linear) * linear**2
    if start is None:
        start = np.zeros(13 + count)
        start[2], start[3] = 12.0, 1.0
    return np.asarray(
        _march(
            np.ascontiguousarray(start),
            np.ascontiguousarray(shares),
            round(COMMAND_S / STEP_S),
            mass,
            np.asarray(np.linalg.inv(mass), float),
            np.stack([craft.linear, craft.quadratic]),
            rest,
            shafts,
            np.ascontiguousarray(pushes),
            craft.torque_held,
            STEP_S,
        )
    )


def coloured(generator: np.random.Generator, steps: int, size: Array, time_s: float) -> Array:
    """Noise of a first-order process (steps, k) with standard deviations `size`."""
    keep = math.exp(-STEP_S / time_s)
    drawn = generator.standard_normal((steps, len(size))) * size
    drawn[1:] *= math.sqrt(1.0 - keep**2)
    return np.asarray(lfilter([1.0], [1.0, -keep], drawn, axis=0))
