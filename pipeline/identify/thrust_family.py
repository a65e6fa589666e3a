r"""The thrust T(N, V) of each sign from all that was measured.

The torque balance gives a calculated family, the same for both signs. Where the mooring test has a
sign, what it measured holds at rest, and the calculation says only what the speed takes away: with
N' the code that is calculated to give at rest what N was measured to give,

.. math:: T(N, V) = T_c(N', V), \qquad T_c(N', 0) = T_m(N)

so that thrusters alike at rest are alike under way. Beyond the calculated thrust of the largest
code the rest is in proportion. Between this and other ways to carry the correction along (the same
share, the same newtons) lie at most as many newtons as the gap at rest, which the interval holds.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.cubic_inverse import mooring_curve
from pipeline.identify.thrust_curve import ThrustCurve, curve_from_family
from pipeline.records.fit_values import static_factor
from pipeline.records.fits import Basis, SignedFamily, StaticCharacteristic, ThrustFamily, Vector
from pipeline.records.measurements import MooringPoint
from pipeline.types import BoolArray, FloatArray

#: Codes of a family that no static one gives the codes to.
MOORED_CODES = 129


@dataclass(frozen=True)
class Family:
    """Curves T(N) of one sign by speed; speeds without thrust are left out.

    `half95_n` are half-widths of the 95 % interval at the codes of each curve's own knots.
    """

    sign: Literal[1, -1]
    basis: Basis
    speed_mps: FloatArray
    curves: tuple[ThrustCurve, ...]
    half95_n: tuple[FloatArray, ...]
    tested_mps: float = 0.0
    """Speed up to which thrust itself was measured."""

    def at(self, speed_mps: float) -> ThrustCurve:
        """Return the curve of the nearest speed."""
        return self.curves[int(np.argmin(np.abs(self.speed_mps - speed_mps)))]

    def mirrored(self) -> "Family":
        """Return the same for the other sign."""
        sign: Literal[1, -1] = -1 if self.sign > 0 else 1
        return replace(self, sign=sign, basis="mirrored")

    def record(self, code: FloatArray) -> SignedFamily:
        """Tabulate at codes."""
        curves = list(zip(self.curves, self.half95_n, strict=True))
        return SignedFamily(
            sign=self.sign,
            basis=self.basis,
            speed_mps=self.speed_mps.tolist(),
            code=code.tolist(),
            thrust_n=[c.thrust(code).tolist() for c, _ in curves],
            half95_n=[np.interp(code, c.code, half).tolist() for c, half in curves],
        )


def family_curves(static: StaticCharacteristic, thrust_dead_n: float) -> Family | None:
    """Curves of every speed of the calculated family up to the first without thrust.

    Thrust up to `thrust_dead_n` counts as none.
    """
    code, factor = np.array(static.code), static_factor(static)
    rows: list[tuple[float, Vector, Vector, BoolArray]] = [
        (v, row, std, np.array([s != "no_working_point" for s in status]))
        for v, row, std, status in zip(
            static.speed_mps, static.thrust_n, static.thrust_std_n, static.status, strict=True
        )
    ]
    if static.faster is not None:
        more = zip(
            static.faster.speed_mps, static.faster.thrust_n, static.faster.thrust_std_n, strict=True
        )
        rows += [(v, row, std, np.ones(code.size, bool)) for v, row, std in more]
    speeds, curves, halves = [], [], []
    for speed, row, std, met in rows:
        curve = curve_from_family(code[met], np.array(row)[met]) if met[-1] else None
        if curve is None or curve.thrust_max_n <= thrust_dead_n:
            break
        speeds.append(speed)
        curves.append(curve)
        halves.append(factor * np.interp(curve.code, code[met], np.array(std)[met]))
    if not speeds:
        return None
    return Family(1, "calculated", np.array(speeds), tuple(curves), tuple(halves))


def measured_family(
    calculated: Family | None, points: tuple[MooringPoint, ...], sign: Literal[1, -1]
) -> Family:
    """Return the family of one sign that was moored, from readings of one supply voltage.

    Without a calculated one it has the row at rest alone.

    Raises
    ------
    CannotComputeError
        With too few codes of this sign, which the message names.
    """
    curve = mooring_curve(points, sign)
    noise = _scatter(curve, points, sign)
    if calculated is None:
        return Family(sign, "measured", np.zeros(1), (curve,), (np.full(curve.code.size, noise),))
    at_rest = calculated.curves[0]
    code = curve.code
    end = at_rest.code[-1]
    if code[-1] < end:  # not moored to the end: on in proportion to the calculation
        more = at_rest.code[at_rest.code > code[-1] + 1e-6]
        share = curve.thrust_max_n / float(at_rest.thrust(code[-1]))
        thrust = np.concatenate([curve.thrust_n, share * at_rest.thrust(more)])
        code = np.concatenate([code, more])
        curve = ThrustCurve(code, np.maximum.accumulate(thrust + 1e-9 * np.arange(code.size)))
    codes = np.unique(np.concatenate([curve.code, at_rest.code[at_rest.code > curve.code[0]]]))
    measured = curve.thrust(codes)
    equal = at_rest.code_at(measured)
    beyond = np.maximum(measured / at_rest.thrust_max_n, 1.0)
    gap = np.abs(np.where(codes <= end, at_rest.thrust(codes), 0.0) - measured)
    gap = np.where(codes <= end, gap, gap[codes <= end][-1])
    # where the two happen to cross they are no better known than elsewhere
    gap = np.maximum(gap, np.minimum(np.sqrt(np.mean(gap**2)), measured))
    speeds, curves, halves = [], [], []
    for speed, row, half in zip(
        calculated.speed_mps, calculated.curves, calculated.half95_n, strict=True
    ):
        thrust = measured if speed == 0.0 else beyond * row.thrust(equal)
        one = curve_from_family(codes[1:], thrust[1:])
        if one is None:
            break
        wide = np.hypot(np.interp(equal, row.code, half) if speed else noise, gap)
        speeds.append(speed)
        curves.append(curve if speed == 0.0 else one)
        halves.append(np.interp(curves[-1].code, codes, wide))
    return Family(sign, "measured", np.array(speeds), tuple(curves), tuple(halves))


def _scatter(curve: ThrustCurve, points: tuple[MooringPoint, ...], sign: int) -> float:
    """Half-width of the 95 % interval of the readings about the curve. [N]."""
    used = [p for p in points if sign * p.code > curve.code[0]]
    off = curve.thrust([abs(p.code) for p in used]) - [sign * p.thrust_n for p in used]
    return 2.0 * float(np.sqrt(np.mean(off**2))) if used else 0.0


def both_signs(
    calculated: Family | None, points: tuple[MooringPoint, ...], *, reverses: bool, notes: list[str]
) -> tuple[Family, Family]:
    """Return the families ahead and in reverse.

    A sign without a usable mooring test is that of the calculation. A drive that takes no negative
    code has none to measure: its reverse mirrors its forward branch and is never asked for. Where
    nothing is calculated, each sign that the drive takes needs readings of its own.

    Raises
    ------
    CannotComputeError
        If nothing is calculated and a sign has too few codes.
    """
    found: dict[int, Family] = {}
    signs: tuple[Literal[1, -1], ...] = (1, -1) if reverses else (1,)
    faults = []
    for sign in signs:
        try:
            found[sign] = measured_family(calculated, points, sign)
        except CannotComputeError as error:
            faults.append(str(error))
    if calculated is None:
        if faults:
            raise CannotComputeError("; ".join(faults))
        return found[1], found.get(-1, found[1].mirrored())
    if points:
        notes.extend(f"Not corrected by the mooring test: {fault}." for fault in faults)
    ahead = found.get(1, calculated)
    if reverses and -1 not in found:
        notes.append(
            "Negative codes mirror positive ones (Kostenko 2023, eq. 8): no thrust in reverse was "
            "measured."
        )
    return ahead, found.get(-1, ahead.mirrored())


def family_record(
    families: tuple[Family, Family],
    static: StaticCharacteristic | None,
    code: FloatArray | None = None,
) -> ThrustFamily:
    """Tabulate both signs at codes: of the static family, or evenly up to the last moored."""
    if code is None:
        last = max(float(one.curves[0].code[-1]) for one in families)
        code = np.linspace(0.0, last, MOORED_CODES)
        if static is not None:
            code = np.concatenate([[0.0], np.array(static.code)])
    return ThrustFamily(
        positive=families[0].record(code),
        negative=families[1].record(code),
        free_drag_ns2pm2=0.0 if static is None else static.free_drag_ns2pm2,
    )
