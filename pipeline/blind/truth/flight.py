"""Fly a craft of the truth and keep the whole motion."""

from dataclasses import dataclass

import numpy as np

from pipeline.blind.truth.craft import Craft, truth_of
from pipeline.blind.truth.kernel_flight import (
    CONTROL_S,
    SAMPLE,
    SAMPLES,
    WISHES,
    Belief,
    fly,
)
from pipeline.blind.truth.kernel_forces import CODE_MAX, MODE, SHARE, Truth
from pipeline.blind.truth.kernel_motion import Work
from pipeline.blind.truth.kernel_shafts import CODES, MOMENTA, SHAFTS, STATE
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray


@dataclass(frozen=True)
class TruthFlight:
    """The motion at 50 Hz, the commands at 10 Hz.

    `commands` (m, n); `samples` (k, 24 + 3 n) as the kernel wrote them, k = 5 m + 1.
    """

    commands: FloatArray
    samples: FloatArray

    @property
    def count(self) -> int:
        """Number of thrusters."""
        return int(self.commands.shape[1])

    @property
    def time_s(self) -> FloatArray:
        """Times of the samples from 0 (k,) [s]."""
        return np.asarray(np.arange(len(self.samples)) * (CONTROL_S / SAMPLES), np.float64)

    @property
    def place(self) -> FloatArray:
        """Place in NED (k, 3) [m]."""
        return self.samples[:, :3]

    @property
    def turn(self) -> FloatArray:
        """Rotation matrices, body to NED (k, 3, 3)."""
        return self.samples[:, 3:12].reshape(-1, 3, 3)

    @property
    def ground(self) -> FloatArray:
        """Velocity over ground, body axes (k, 6) [m/s, rad/s]."""
        return self.samples[:, 12:18]

    @property
    def rate(self) -> FloatArray:
        """Rate of `ground` (k, 6)."""
        return self.samples[:, 18:24]

    @property
    def shafts(self) -> FloatArray:
        """Shaft speeds (k, n): rev/s, or shares of the largest."""
        return self.samples[:, SAMPLE : SAMPLE + self.count]

    @property
    def thrust(self) -> FloatArray:
        """Thrusts (k, n) [N]."""
        return self.samples[:, SAMPLE + self.count : SAMPLE + 2 * self.count]


def still(place: FloatArray, heading_rad: float = 0.0) -> FloatArray:
    """Sample (24,) of a vehicle at rest, level."""
    out = np.zeros(SAMPLE)
    c, s = np.cos(heading_rad), np.sin(heading_rad)
    out[:3] = place
    out[3:12] = (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)
    return out


def fly_craft(
    craft: Craft,
    belief: Belief,
    *,
    wishes: FloatArray | None = None,
    commands: FloatArray | None = None,
    outside: FloatArray | None = None,
    gains: FloatArray | None = None,
    start: FloatArray | None = None,
    first_s: float = 0.0,
    shafts: FloatArray | None = None,
    ramped: FloatArray | None = None,
) -> TruthFlight:
    """Fly under the truth's autopilot (`wishes`), or with given codes (`commands`).

    `belief` is what the autopilot holds true, `wishes` (m, 19) are switches, values and wrench at
    each command, `commands` (m, n) codes in its place. `outside` (m + 1, 9) are forces from
    outside: NED [N], body [N], moment [N m]; `gains` (m, n) what trouble leaves of each thrust. It
    starts from the sample `start` (24,), at rest at the origin without it, with `shafts` and
    `ramped` codes (n,), at the time `first_s`, which trouble counts from [s].

    Raises `CannotComputeError` when the motion leaves the finite numbers.
    """
    n = len(craft.names)
    asked = wishes if wishes is not None else commands
    if asked is None:
        raise ValueError("fly_craft needs wishes or commands")
    count = len(asked)
    given = np.zeros((1, n)) if commands is None else np.ascontiguousarray(commands, float)
    truth = truth_of(craft)
    done, samples = np.zeros((count, n)), np.zeros((count * SAMPLES + 1, SAMPLE + 3 * n))
    fly(
        truth,
        belief,
        wishes is not None,
        np.zeros((1, WISHES)) if wishes is None else np.ascontiguousarray(wishes, float),
        given,
        np.zeros((count + 1, 9)) if outside is None else outside,
        np.ones((count, n)) if gains is None else gains,
        first_s,
        still(np.zeros(3)) if start is None else np.ascontiguousarray(start, float),
        np.zeros(n) if shafts is None else np.ascontiguousarray(shafts, float),
        np.zeros(n) if ramped is None else np.ascontiguousarray(ramped, float),
        _work(truth, n),
        np.zeros(STATE),
        done,
        samples,
    )
    if not np.isfinite(samples).all():
        raise CannotComputeError("the true vehicle left the finite numbers")
    return TruthFlight(done, samples)


def _work(truth: Truth, n: int) -> Work:
    """Make the kernel's work space; `scale` is what an error is small against."""
    inertia = truth.rigid + truth.added
    scale = np.ones(STATE)
    scale[MOMENTA:CODES] = np.diag(inertia)
    # shafts turn to and fro about kinks of their tables: what counts is their thrust
    scale[CODES : CODES + n] = 100.0 * truth.screws[:, CODE_MAX]
    scale[SHAFTS : SHAFTS + n] = np.where(truth.screws[:, MODE] == SHARE, 100.0, 1000.0)
    return Work(
        inverse=np.linalg.inv(inertia),
        turn=np.zeros((3, 3)),
        slope=np.zeros(3),
        force=np.zeros(6),
        v=np.zeros(6),
        thrust=np.zeros(n),
        working=np.zeros(n),
        push=np.zeros(9),
        slopes=np.zeros((7, STATE)),
        trial=np.zeros(STATE),
        scale=scale,
        table=np.zeros((6, 7)),
    )
