"""What the firmware form must keep so that neither C variant can divide by zero or overflow."""

import itertools

from pipeline.errors import CannotComputeError
from pipeline.records.fits import FirmwareBranch, FirmwareCharacteristic

#: Thrust and speed are Q16.16 in an int32: [N], [m/s].
LARGEST_Q16 = 32767.0
#: Codes travel as int16.
LARGEST_CODE = 32767
#: Smallest step between codes of a row, as a share of the largest code, and between fractions:
#: some sixteen units in the last place of a 24-bit significand.
SMALLEST_STEP = 2e-6
#: Smallest step between tabulated speeds. [m/s]
SMALLEST_SPEED_STEP_MPS = 1e-3
#: Smallest T_max: fifteen bits of resolution are left to it in Q16.16. [N]
SMALLEST_THRUST_MAX_N = 1e-2
#: What a call can tell, as the bits of the C macros: name, bit, comment of the header.
FLAGS = (
    ("SATURATED", 1, "a thrust beyond the limits was asked for, or a limit cut the demand"),
    ("OUT_OF_TESTED_RANGE", 2, "speed along a thruster, or voltage, beyond what was tested"),
    ("LIMITED_BY_PORTION", 4, "a portion of eq. (6) cut a channel of the demand"),
    ("IN_DEAD_ZONE", 8, "a thrust other than zero is too small and got code 0"),
    ("AGAINST_THE_MOTION", 16, "a thruster pushes against its motion, where nothing was measured"),
    ("NOT_A_NUMBER", 32, "an argument is not a number: no code was given"),
)
FLAG = {name: bit for name, bit, _ in FLAGS}


def check_characteristic(characteristic: FirmwareCharacteristic) -> None:
    """Refuse a characteristic that the firmware could not evaluate.

    Raises
    ------
    CannotComputeError
        When shapes disagree, an axis or a row of codes does not rise, or a number is out of the
        range of the fixed-point formats.
    """
    if not 0 < characteristic.code_max <= LARGEST_CODE:
        raise _refusal(
            f"the largest code is {characteristic.code_max}", f"1 to {LARGEST_CODE} is expected"
        )
    if not -LARGEST_CODE <= characteristic.code_min <= 0:
        raise _refusal(
            f"the most negative code is {characteristic.code_min}",
            f"-{LARGEST_CODE} to 0 is expected",
        )
    if not 0.0 <= characteristic.thrust_dead_n <= LARGEST_Q16:
        raise _refusal(
            f"the dead zone is {characteristic.thrust_dead_n} N",
            f"0 to {LARGEST_Q16:.0f} N is expected",
        )
    for name, sign, branch, largest in (
        ("positive", 1, characteristic.positive, characteristic.code_max),
        ("negative", -1, characteristic.negative, largest_negative(characteristic)),
    ):
        if branch.sign != sign:
            raise _refusal(f"the {name} branch has sign {branch.sign}", f"{sign} is expected")
        _check_axes(name, branch)
        _check_codes(name, branch, largest)


def largest_negative(characteristic: FirmwareCharacteristic) -> int:
    """Magnitude up to which the tables of negative thrust may go.

    A branch that mirrors the positive one ends with it; what is beyond `code_min` is never sent.
    """
    return max(characteristic.code_max, -characteristic.code_min)


def _check_axes(name: str, branch: FirmwareBranch) -> None:
    speeds, fractions = branch.speed_mps, branch.fraction
    shape_fits = len(branch.thrust_max_n) == len(speeds) == len(branch.code) and all(
        len(row) == len(fractions) for row in branch.code
    )
    if not speeds or len(fractions) < 2 or not shape_fits:
        raise _refusal(
            f"the {name} branch has {len(speeds)} speeds, {len(branch.thrust_max_n)} largest "
            f"thrusts, {len(branch.code)} rows and {len(fractions)} fractions",
            "one largest thrust and one row a speed, one code a fraction are expected",
        )
    if speeds[0] < 0.0 or speeds[-1] > LARGEST_Q16 or _step(speeds) < SMALLEST_SPEED_STEP_MPS:
        raise _refusal(
            f"the speeds of the {name} branch are {list(speeds)} m/s",
            f"they must rise by at least {SMALLEST_SPEED_STEP_MPS} from 0 or more, "
            f"to at most {LARGEST_Q16:.0f}",
        )
    if fractions[0] != 0.0 or fractions[-1] != 1.0 or _step(fractions) < SMALLEST_STEP:
        raise _refusal(
            f"the fractions of the {name} branch are {list(fractions)}",
            f"they must rise by at least {SMALLEST_STEP} from 0 to 1",
        )
    for speed, thrust in zip(speeds, branch.thrust_max_n, strict=True):
        if not SMALLEST_THRUST_MAX_N <= thrust <= LARGEST_Q16:
            raise _refusal(
                f"the largest thrust of the {name} branch at {speed} m/s is {thrust} N",
                f"{SMALLEST_THRUST_MAX_N} to {LARGEST_Q16:.0f} N is expected; "
                "tabulate only speeds at which the thruster still pushes",
            )


def _check_codes(name: str, branch: FirmwareBranch, code_max: int) -> None:
    for speed, row in zip(branch.speed_mps, branch.code, strict=True):
        place = f"the codes of the {name} branch at {speed} m/s"
        # The tables are cut off at the ends of the range, so rounding in the fit does no harm.
        slack = SMALLEST_STEP * code_max
        if row[0] < -slack or row[-1] > code_max + slack:
            raise _refusal(
                f"{place} run from {row[0]} to {row[-1]}", f"0 to {code_max} is expected"
            )
        if _step(row) < slack:
            raise _refusal(
                f"{place} do not rise everywhere",
                f"each must exceed the one before by at least {slack:.2g}",
            )


def _step(values: tuple[float, ...]) -> float:
    """Return the smallest difference of neighbours; infinite for one value alone."""
    return min((b - a for a, b in itertools.pairwise(values)), default=float("inf"))


def _refusal(what: str, expected: str) -> CannotComputeError:
    return CannotComputeError(f"Firmware tables cannot be made: {what}; {expected}.")
