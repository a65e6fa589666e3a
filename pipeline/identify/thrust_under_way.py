r"""What thrust measured in a flow corrects: the family of a sign at speed.

.. math:: T(N, V) = T_0(N + d, V) - T_{max} (d / N_{max})^2, \qquad d = d(V)

Readings under way say d at each speed, by least squares (docs/methods/inverse.md). Where nothing is
calculated T_0 is the row at rest, and d is all that the speed takes.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.identify.thrust_curve import ThrustCurve, curve_from_family
from pipeline.identify.thrust_family import Family
from pipeline.records.measurements import IN_A_FLOW, MooringPoint
from pipeline.types import ArrayLike, FloatArray

#: Speeds closer than this are one. [m/s]
_ONE_SPEED_MPS = 0.1
#: Thrust over that at rest from which on the flow cannot have gone as it is said to.
_MORE_THAN_AT_REST = 1.05
#: Share of the largest code that d is sought within, and codes to its grid.
_MOST_SHARE, _GRID = 0.6, 241


def points_under_way(points: Sequence[MooringPoint]) -> tuple[MooringPoint, ...]:
    """Return the readings in a flow that nothing else is wrong with."""
    return tuple(point for point in points if point.marks == (IN_A_FLOW,))


def with_points_under_way(
    families: tuple[Family, Family], points: Sequence[MooringPoint], notes: list[str]
) -> tuple[Family, Family]:
    """Correct both signs, ahead and in reverse, by what was measured under way.

    Readings are of the families' supply voltage. Those against the flow, or on one side of the
    codes only, leave the other sign as it is; a family of one row takes the other's. The families
    that are returned have rows at the speeds that were measured; `notes` gets what was done.
    """
    shifts = [_shifts(family, points, notes) for family in families]
    at_rest_only = all(family.speed_mps.size == 1 for family in families)
    if at_rest_only and any(shift is None for shift in shifts):
        # thrusters that are at rest on one side and under way on the other cannot be tabulated
        known = next((shift for shift in shifts if shift is not None), None)
        if known is not None and families[0].basis != "mirrored":
            notes.append("What the speed takes was measured on one side; the other takes the same.")
        shifts = [known, known]
    ahead, reverse = (
        family if shift is None else _shifted(family, *shift)
        for family, shift in zip(families, shifts, strict=True)
    )
    return ahead, reverse


def _shifts(
    family: Family, points: Sequence[MooringPoint], notes: list[str]
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Speeds (k,), codes d (k,) and scatter (k,) [N] of one sign; None where none was measured."""
    sign = family.sign
    own = sorted(
        (p for p in points if sign * p.code > 0.0 and sign * p.speed_mps > 0.0),
        key=lambda p: abs(p.speed_mps),
    )
    found, strange = [], []
    for group in _by_speed(own):
        speed = np.array([abs(p.speed_mps) for p in group])
        code = np.array([abs(p.code) for p in group])
        thrust = np.array([max(sign * p.thrust_n, 0.0) for p in group])
        rest = _thrust(family.curves[0], code)
        if thrust.sum() > _MORE_THAN_AT_REST * rest.sum():
            strange.append(float(speed.mean()))
            continue
        rows = [_row(family, float(v)) for v in speed]
        end = float(family.curves[0].code[-1])
        tried = np.linspace(-_MOST_SHARE * end, _MOST_SHARE * end, _GRID)
        at_rest = family.curves[0]
        squares = np.zeros(tried.size)
        for row, n, measured in zip(rows, code, thrust, strict=True):
            squares += np.square(_with(row, at_rest, n, tried) - measured)
        shift = _lowest(tried, squares)
        left = [float(_with(row, at_rest, n, shift)) for row, n in zip(rows, code, strict=True)]
        scatter = float(np.sqrt(np.mean(np.square(left - thrust))))
        found.append((float(speed.mean()), shift, 2.0 * scatter, code.size))
    name = "ahead" if sign > 0 else "in reverse"
    if strange:
        notes.append(
            f"Thrust {name} at {_named(strange)} m/s is more than at rest, which no flow along the "
            "thrust gives: these readings are not used. Check the sign of the speed."
        )
    if not found:
        return None
    speeds, shifts, scatters, counts = (np.array(column) for column in zip(*found, strict=True))
    notes.append(
        f"Thrust {name} was measured at {_named(speeds.tolist())} m/s ({int(counts.sum())} rows): "
        f"the family is off there by {shifts.min():+.1f} to {shifts.max():+.1f} codes, which is "
        f"taken off; readings scatter by {scatters.max():.2f} N at most (95 %)."
    )
    return speeds, shifts, scatters


def _by_speed(points: Sequence[MooringPoint]) -> list[list[MooringPoint]]:
    """Put readings of about one speed together, in the order of speed that they are in."""
    groups: list[list[MooringPoint]] = []
    for point in points:
        if groups and abs(point.speed_mps) - abs(groups[-1][0].speed_mps) < _ONE_SPEED_MPS:
            groups[-1].append(point)
        else:
            groups.append([point])
    return groups


def _lowest(x: FloatArray, y: FloatArray) -> float:
    """Place of the lowest value on an even grid, by the parabola through it and its neighbours."""
    k = int(np.clip(np.argmin(y), 1, x.size - 2))
    before, here, after = (float(y[k + j]) for j in (-1, 0, 1))
    bend = before - 2.0 * here + after
    part = 0.5 * (before - after) / bend if bend > 0.0 else 0.0
    return float(x[k] + np.clip(part, -1.0, 1.0) * (x[1] - x[0]))


def _named(speeds: Sequence[float]) -> str:
    return ", ".join(f"{speed:.3g}" for speed in speeds)


def _thrust(curve: ThrustCurve, code: FloatArray) -> FloatArray:
    """Thrust at codes, on with the last slope beyond the last of them."""
    last = curve.code[-1]
    beyond = np.maximum(code - last, 0.0) * curve.slope(last)
    return np.asarray(curve.thrust(code) + beyond)


def _with(
    curve: ThrustCurve, at_rest: ThrustCurve, code: ArrayLike, shift: ArrayLike
) -> FloatArray:
    """Thrust at codes with so many codes more; none below zero. [N]."""
    codes, shifts = np.asarray(code, float), np.asarray(shift, float)
    own = at_rest.thrust_max_n * (shifts / at_rest.code[-1]) ** 2
    return np.asarray(np.maximum(_thrust(curve, codes + shifts) - own, 0.0))


def _row(family: Family, speed_mps: float) -> ThrustCurve:
    """Return the curve at a speed: between two rows at equal code, beyond the last that one."""
    at = int(np.searchsorted(family.speed_mps, speed_mps, side="right"))
    if at == family.speed_mps.size:
        return family.curves[-1]
    low, high = family.curves[at - 1], family.curves[at]
    share = (speed_mps - family.speed_mps[at - 1]) / np.diff(family.speed_mps)[at - 1]
    codes = np.union1d(low.code, high.code)
    mixed = curve_from_family(
        codes, (1.0 - share) * _thrust(low, codes) + share * _thrust(high, codes)
    )
    return low if mixed is None else mixed


def _shifted(
    family: Family, speeds: FloatArray, shifts: FloatArray, scatters: FloatArray
) -> Family:
    """Take the codes off, at the speeds of the family and those that were measured."""
    rows = np.union1d(family.speed_mps, speeds)
    rows = rows[rows <= max(float(family.speed_mps[-1]), float(speeds[-1]))]
    curves, halves, kept = [], [], []
    for speed in rows:
        before = _row(family, float(speed))
        shift = float(np.interp(speed, np.append(0.0, speeds), np.append(0.0, shifts)))
        shift *= max(speed / speeds[-1], 1.0)
        codes = np.union1d(before.code, before.code - shift)
        codes = codes[(codes >= 0.0) & (codes <= family.curves[0].code[-1])]
        thrust = _with(before, family.curves[0], codes, shift)
        after = curve_from_family(codes, thrust) if speed else before
        if after is None:
            break
        near = int(np.argmin(np.abs(family.speed_mps - speed)))
        half = np.interp(after.code, family.curves[near].code, family.half95_n[near])
        gap = np.abs(after.thrust(after.code) - _thrust(before, after.code))
        wide = np.interp(speed, np.append(0.0, speeds), np.append(0.0, scatters))
        curves.append(after)
        halves.append(np.sqrt(half**2 + gap**2 + wide**2))
        kept.append(float(speed))
    return replace(
        family,
        basis="measured",
        speed_mps=np.array(kept),
        curves=tuple(curves),
        half95_n=tuple(halves),
        tested_mps=float(speeds[-1]),
    )
