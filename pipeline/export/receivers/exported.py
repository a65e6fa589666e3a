"""What every receiver is given of a vehicle, and what it gives back."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.physics.parameters import read
from pipeline.simulate.applied_wrench import levers, settled_thrust
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle


@dataclass(frozen=True)
class Subject:
    """A vehicle with the characteristics of its thrusters at rest.

    `code` (k,) rises from 0 to 1 as a share of the largest code; `ahead`, `astern` (n, k) [N] is
    what each thruster gives there, its own gains and dead zone included, both positive.
    """

    vehicle: Vehicle
    packed: PackedVehicle
    share: FloatArray
    ahead: FloatArray
    astern: FloatArray

    @property
    def matrix(self) -> FloatArray:
        """B (6, n): the wrench of one newton of each thruster, SNAME, about the origin."""
        return levers(self.packed)

    def code(self, thrust_n: FloatArray) -> FloatArray:
        """Codes (n,) that give thrusts (n,) at rest, held at the ends."""
        found = []
        for k, thrust in enumerate(thrust_n.tolist()):
            curve = self.ahead[k] if thrust >= 0.0 else self.astern[k]
            first = max(int(np.argmax(curve > 0.0)) - 1, 0)
            found.append(
                np.sign(thrust) * np.interp(abs(thrust), curve[first:], self.share[first:])
            )
        return np.array(found) * self.packed.code_limits[:, 1]


@dataclass(frozen=True)
class Exported:
    """A file for a receiver; `model` is what it makes of the vehicle, to be flown beside it.

    `text` has a place for the head, which `comment` makes of the lines about what is lost: as the
    receiver's own comments. `codes_for` gives the codes that the receiver sends for a wrench (6,);
    None where it takes thrusts as they are. `vector` is the parameter vector that stands for its
    published equations.
    """

    file: str
    text: Callable[[str], str]
    comment: Callable[[str], str]
    lost: tuple[str, ...]
    vector: FloatArray
    codes_for: Callable[[FloatArray], FloatArray] | None = None
    fly: Callable[[FloatArray, int, float], FloatArray] | None = None
    """Velocities (count, 6) under constant codes by equations that no vector stands for."""
    says: tuple[str, ...] = ()
    """What whoever loads the file should know."""


def subject_of(vehicle: Vehicle, packed: PackedVehicle) -> Subject:
    """Take the characteristics at rest from a packed vehicle."""
    share = np.linspace(0.0, 1.0, 129)
    largest = read(packed.vector, "code_max")[: len(packed.thruster_names)]
    curves = []
    for end, sign in zip(packed.code_limits.T[::-1], (1.0, -1.0), strict=True):
        code = sign * np.minimum(share[:, None] * largest, np.abs(end))
        thrust = sign * settled_thrust(packed, code, np.zeros(largest.size)).T
        curves.append(np.maximum.accumulate(thrust, axis=1))
    return Subject(vehicle, packed, share, *curves)


def thrust_exponent(subject: Subject) -> tuple[float, float]:
    """Share f of T = f u^2 + (1 - f) u that fits the thrust ahead best, and its largest error.

    Both of the largest thrust of each thruster, all of them together. [1]
    """
    u, full = subject.share, np.maximum(subject.ahead[:, -1:], 1e-9)
    shape = u * u - u
    share = float(np.sum((subject.ahead / full - u) * shape) / (len(full) * np.sum(shape**2)))
    share = min(max(share, 0.0), 1.0)
    return share, float(np.abs(subject.ahead / full - u - share * shape).max(initial=0.0))


def signal(share: FloatArray, factor: float) -> FloatArray:
    """Signal u of a share of the largest thrust by T = f u^2 + (1 - f) u, sign kept, held to 1."""
    size = np.abs(share)
    u = size
    if factor > 1e-6:
        u = (np.sqrt((1.0 - factor) ** 2 + 4.0 * factor * size) - (1.0 - factor)) / (2.0 * factor)
    return np.asarray(np.sign(share) * np.minimum(u, 1.0))


def numbers(values: FloatArray | list[float]) -> str:
    """Numbers between blanks, as an attribute of XML has them."""
    return " ".join(f"{value + 0.0:.9g}" for value in np.asarray(values, float).tolist())
