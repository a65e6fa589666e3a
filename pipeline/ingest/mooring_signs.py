"""Signs of thrust and shaft speed in a mooring table: stated, left away, or turned round."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.ingest.rows import listed
from pipeline.types import BoolArray, FloatArray

#: Below this share of the largest one a sign says nothing: noise, tare.
_SIGNIFICANT_SHARE = 0.05
#: Of the largest thrust: a larger tare is looked at twice.
_MOST_TARE = 0.2
#: Fewer rows against their code are slips of the pen.
_LEAST_OF_A_SIGN = 3


@dataclass(frozen=True)
class SignedThrust:
    """Thrust with the sign of its code; None if the table cannot be used.

    `against` are the positions that stayed against their code; `tare_signs` is -1 where the
    reading, and so its tare, was turned round.
    """

    thrust_n: FloatArray | None
    tare_signs: tuple[float, ...]
    against: frozenset[int]
    problems: tuple[Problem, ...]


def signed_thrust(
    place: Place,
    codes: FloatArray,
    thrust_n: FloatArray,
    used: BoolArray,
    rows: Sequence[int],
    *,
    tare_n: float = 0.0,
) -> SignedThrust:
    """Check that thrust goes with the code.

    Parameters
    ----------
    place : Place
        The sheet, for messages.
    codes, thrust_n : ndarray, shape (n,)
        Codes, and readings without their tare. [-], [N]
    used : ndarray of bool, shape (n,)
        Rows that count.
    rows : sequence of int, length n
        Their row numbers.
    tare_n : float
        What was read at code 0. [N]

    Returns
    -------
    SignedThrust
        Where thrust is never negative although codes are, it was written as a size and is given
        the sign of its code (warning). Where it goes against most codes, the table is left out
        (error): a sensor the other way round is the engineer's to state. Single rows are named.
    """
    same = tuple(1.0 for _ in codes)
    size = np.abs(thrust_n)
    largest = float(np.max(size[used], initial=0.0))
    counts = used & (size > _SIGNIFICANT_SHARE * largest) & (codes != 0.0)
    wrong = counts & (codes * thrust_n < 0.0)
    right = counts & ~wrong
    one_sided = not ((codes < 0.0) & used).any() or not ((codes > 0.0) & used).any()
    if not wrong.any():
        # a tare that is a good part of the thrust may be the full thrust of the other direction
        before = thrust_n[counts] + tare_n
        if one_sided and abs(tare_n) > _MOST_TARE * largest and before.min() < 0.0 < before.max():
            return SignedThrust(None, same, frozenset(), (_both_signs(place, before, codes),))
        return SignedThrust(thrust_n, same, frozenset(), ())
    number, total = int(wrong.sum()), int(counts.sum())
    if not (wrong & (codes > 0.0)).any() and not (right & (codes < 0.0)).any():
        turned = np.where(codes < 0.0, -thrust_n, thrust_n)
        problem = Problem(
            "warning",
            place,
            f"thrust is positive at all {number} negative codes: read as a size without sign, "
            "and given the sign of its code.",
            "negative thrust at negative codes.",
            "Write the minus signs if the thruster really pulled backwards.",
        )
        signs = tuple(-1.0 if code < 0.0 else 1.0 for code in codes)
        return SignedThrust(turned, signs, frozenset(), (problem,))
    if one_sided and number >= _LEAST_OF_A_SIGN and total - number >= _LEAST_OF_A_SIGN:
        problem = _both_signs(place, thrust_n[counts], codes)
        return SignedThrust(None, same, frozenset(), (problem,))
    if 2 * number > total:
        problem = Problem(
            "error",
            place,
            f"thrust has the sign opposite to its code in {number} of {total} rows; left out.",
            "positive thrust at positive codes.",
            "If the force sensor was mounted the other way round, say so in vehicle.yaml: "
            "columns: {mooring: {thrust: {header: <name of the column>, sign: -1}}}, or take that "
            "sign out if it is there.",
        )
        return SignedThrust(None, same, frozenset(), (problem,))
    against = [int(index) for index in np.flatnonzero(wrong)]
    named = [rows[index] for index in against]
    problem = Problem(
        "warning",
        Place(place.file, place.sheet, named[0]),
        f"thrust has the sign opposite to its code in {listed(named)}; left out.",
        "positive thrust at positive codes.",
        "Correct the sign or the code.",
    )
    return SignedThrust(thrust_n, same, frozenset(against), (problem,))


def _both_signs(place: Place, thrust_n: FloatArray, codes: FloatArray) -> Problem:
    against = int((thrust_n * (-1.0 if codes.min() < 0.0 else 1.0) < 0.0).sum())
    return Problem(
        "error",
        place,
        f"thrust has both signs ({against} of {thrust_n.size} rows against the code), and the "
        "codes have one: rest is not at code 0, or something else parts the rows. So the table was "
        "left out.",
        "codes with signs, 0 at rest.",
        "Write the codes with signs, or state the column of the direction in vehicle.yaml: "
        "columns: {mooring: {direction: {header: ..., reverse: [...]}}}.",
    )


def signed_shaft_speed(
    place: Place, codes: FloatArray, shaft_speed_rpm: Sequence[float | None]
) -> tuple[list[float | None], list[Problem]]:
    """Give the shaft speed the sign of its code where it was read without one.

    Parameters
    ----------
    place : Place
        The sheet, for messages.
    codes : ndarray, shape (n,)
        Codes. [-]
    shaft_speed_rpm : sequence of float or None, length n
        As read. [rpm]

    Returns
    -------
    list of float or None
        With sign. [rpm]
    list of Problem
        What was assumed.
    """
    speeds = np.array([np.nan if one is None else one for one in shaft_speed_rpm], float)
    turning = np.isfinite(speeds) & (speeds != 0.0) & (codes != 0.0)
    wrong = turning & (speeds * codes < 0.0)
    if not wrong.any():
        return list(shaft_speed_rpm), []
    number, total = int(wrong.sum()), int(turning.sum())
    if np.all(speeds[turning] > 0.0):
        what = "shaft speed is given without sign: it takes the sign of its code."
        signed = np.where(codes < 0.0, -speeds, speeds)
        notes = [Problem("note", place, what)]
    elif number == total:
        what = "shaft speed is negative at positive codes: its sign was turned round."
        signed, notes = -speeds, [Problem("note", place, what)]
    else:
        what = f"shaft speed has the sign opposite to its code in {number} of {total} rows."
        signed, notes = speeds, [Problem("warning", place, what, remedy="Check these rows.")]
    # Adding 0.0 turns -0.0 into 0.0.
    return [None if np.isnan(one) else float(one) + 0.0 for one in signed], notes
