"""Autopilots: parameters of PX4's control allocation, and of ArduSub's motors.

PX4 (a file that QGroundControl loads): Motors (6DOF), body axes forward, right, down from the
centre of gravity: SNAME. The allocator divides a wrench by the pseudo-inverse of the motors'
effectiveness, CT times position and axis, and THR_MDL_FAC f makes the signal of a share of the
thrust, T / CT = f u^2 + (1 - f) u (PX4 parameter reference, Control Allocation and PWM Outputs).

ArduSub: directions of the motors in one of its frames, thrust curve, pulse widths. A frame's motors
have fixed factors on roll, pitch, yaw, throttle (up), forward and lateral (right), whatever the
geometry (AP_Motors6DOF); a motor's output is the sum of factor times demand, and its pulse width
follows it in proportion. MOT_THST_EXPO bends that in versions that bend it for a Sub.
"""

from collections.abc import Sequence

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.export.receivers.exported import Exported, Subject, signal, thrust_exponent
from pipeline.physics.parameters import read
from pipeline.types import FloatArray

#: CA_AIRFRAME of motors in any arrangement, and the largest CA_ROTORn_CT.
_MOTORS_6DOF, _LARGEST_CT = 7, 100.0
_INTEGER, _REAL = 6, 9

_FLAT = ((0, 0, 1, 0, -1, 1), (0, 0, -1, 0, -1, -1), (0, 0, -1, 0, 1, 1), (0, 0, 1, 0, 1, -1))
#: FRAME_CONFIG -> factors of its motors on roll, pitch, yaw, throttle, forward, lateral.
FRAMES: dict[int, tuple[tuple[int, ...], ...]] = {
    1: (*_FLAT, (1, 0, 0, -1, 0, 0), (-1, 0, 0, -1, 0, 0)),
    2: (
        *_FLAT,
        *((1, -1, 0, -1, 0, 0), (-1, -1, 0, -1, 0, 0), (1, 1, 0, -1, 0, 0), (-1, 1, 0, -1, 0, 0)),
    ),
}
#: An entry of B below this share of its row's largest counts as none.
_NONE = 0.2


def px4(subject: Subject) -> Exported:
    """Return the parameters; CT is the largest thrust of each motor ahead [N], or a share of it.

    Raises
    ------
    CannotComputeError
        For a vehicle without thrusters.
    """
    packed = subject.packed
    count = len(packed.thruster_names)
    if count == 0:
        raise CannotComputeError(f"{packed.name} has no thrusters, so there is nothing for PX4.")
    full = subject.ahead[:, -1]
    unit = max(full.max() / _LARGEST_CT, 1.0)
    factor, off = thrust_exponent(subject)
    centre = read(packed.vector, "centre_of_mass")
    at = read(packed.vector, "thruster_position")[:count] - centre
    to = read(packed.vector, "thruster_direction")[:count]
    reverses = sum(1 << k for k in range(count) if packed.code_limits[k, 0] < 0.0)
    rows: list[tuple[str, float, int]] = [
        ("CA_AIRFRAME", _MOTORS_6DOF, _INTEGER),
        ("CA_ROTOR_COUNT", count, _INTEGER),
        ("CA_R_REV", reverses, _INTEGER),
    ]
    for k in range(count):
        for name, values in (("P", at[k]), ("A", to[k])):
            rows += [
                (f"CA_ROTOR{k}_{name}{axis}", float(value), _REAL)
                for axis, value in zip("XYZ", values, strict=True)
            ]
        # no torque of a propeller on the hull in the vehicle file
        rows += [
            (f"CA_ROTOR{k}_CT", float(full[k] / unit), _REAL),
            (f"CA_ROTOR{k}_KM", 0.0, _REAL),
        ]
    rows.append(("THR_MDL_FAC", factor, _REAL))
    body = "".join(
        f"1\t1\t{name}\t{value:.18f}\t{kind}\n"
        if kind == _REAL
        else f"1\t1\t{name}\t{int(value)}\t{kind}\n"
        for name, value, kind in sorted(rows)
    )
    worst = float(np.abs(1.0 - subject.astern[:, -1] / np.maximum(full, 1e-9)).max())

    def codes_for(wrench: FloatArray) -> FloatArray:
        # about the centre of gravity, as the allocator has it
        moment = wrench[3:] - np.cross(centre, wrench[:3])
        effect = np.concatenate([to.T, np.cross(at, to).T]) * full
        share = np.linalg.pinv(effect, rcond=1e-6) @ np.concatenate([wrench[:3], moment])
        return signal(share, factor) * packed.code_limits[:, 1]

    return Exported(
        file=f"{packed.name}_px4.params",
        text=lambda head: f"{head}# Vehicle-Id Component-Id Name Value Type\n{body}",
        comment=lambda line: f"# {line}".rstrip(),
        says=(
            "Motors in the order of vehicle.yaml: "
            + ", ".join(f"{k + 1} {name}" for k, name in enumerate(packed.thruster_names))
            + ".",
        ),
        lost=(
            f"each motor's own curve: that of all is off by up to {100 * off:.0f} % of its thrust",
            f"reverse thrust, which differs from that ahead by up to {100 * worst:.0f} %",
            "thrust that falls with speed, dead zones, lag, supply voltage, reaction torque",
        ),
        vector=packed.vector,
        codes_for=codes_for,
    )


def ardusub(subject: Subject) -> Exported:
    """Return the parameters of the frame whose motors push as the vehicle's do.

    Raises
    ------
    CannotComputeError
        When the thrusters are in no arrangement that a frame of ArduSub has.
    """
    packed = subject.packed
    own = _factors(subject.matrix)
    fits = [(frame, _order(own, motors)) for frame, motors in FRAMES.items()]
    frame, order = next((one for one in fits if one[1] is not None), (0, None))
    if order is None:
        raise CannotComputeError(
            f"the thrusters of {packed.name} are in no arrangement that a frame of ArduSub has "
            "(vectored with 6 or 8 thrusters), and its mixing takes no positions."
        )
    motors = FRAMES[frame]
    pulse = subject.vehicle.columns.mooring.pwm_range
    factor, off = thrust_exponent(subject)
    dead = float(np.mean(np.argmax(subject.ahead > 0.0, axis=1)) / (subject.share.size - 1))
    rows: dict[str, float] = {
        "FRAME_CONFIG": frame,
        "MOT_PWM_MIN": round(pulse.neutral_us - pulse.half_range_us),
        "MOT_PWM_MAX": round(pulse.neutral_us + pulse.half_range_us),
        "MOT_THST_EXPO": round(factor, 4),
        "MOT_SPIN_MIN": round(min(dead, 0.3), 4),
        **{f"MOT_{m + 1}_DIRECTION": sign for m, (_, sign) in enumerate(order)},
    }
    body = "".join(f"{name},{value:g}\n" for name, value in sorted(rows.items()))
    gives = np.zeros((6, len(order)))
    for m, (k, sign) in enumerate(order):
        gives[:, k] = sign * np.array(motors[m])
    matrix = subject.matrix * subject.ahead[:, -1]

    def codes_for(wrench: FloatArray) -> FloatArray:
        demand = np.zeros(6)
        for axis, (row, sign) in enumerate(((3, 1), (4, 1), (5, 1), (2, -1), (0, 1), (1, 1))):
            most = sign * float(matrix[row] @ gives[axis])
            demand[axis] = wrench[row] / most if abs(most) > 1e-9 else 0.0
            demand[axis] *= sign
        out = np.clip(demand @ gives, -1.0, 1.0)
        return np.asarray(out * packed.code_limits[:, 1])

    return Exported(
        file=f"{packed.name}_ardusub.param",
        text=lambda head: head + body,
        comment=lambda line: f"# {line}".rstrip(),
        says=(
            "Motors: "
            + ", ".join(f"{m + 1} {packed.thruster_names[k]}" for m, (k, _) in enumerate(order))
            + ".",
        ),
        lost=(
            "positions, angles and differences between thrusters: a frame's factors are fixed",
            "the thrust curve, where the version sends pulse widths in proportion",
            f"MOT_THST_EXPO is off by up to {100 * off:.0f} % of the largest thrust",
            "thrust that falls with speed, reverse unlike ahead, lag, supply voltage",
        ),
        vector=packed.vector,
        codes_for=codes_for,
    )


def _factors(matrix: FloatArray) -> FloatArray:
    """Signs (n, 6) of what each thruster does on roll, pitch, yaw, up, forward, right."""
    rows = np.stack([matrix[3], matrix[4], matrix[5], -matrix[2], matrix[0], matrix[1]])
    largest = np.maximum(np.abs(rows).max(axis=1, keepdims=True), 1e-9)
    kept = np.where(np.abs(rows) >= _NONE * largest, np.sign(rows), 0.0)
    # the couplings of a level thruster above or below the origin are none of its purpose
    level = np.abs(matrix[2]) < 0.5
    kept[0:2, level], kept[3, level] = 0.0, 0.0
    kept[2, ~level], kept[4:, ~level] = 0.0, 0.0
    return np.asarray(kept.T)


def _order(own: FloatArray, motors: Sequence[Sequence[int]]) -> tuple[tuple[int, int], ...] | None:
    """Thruster and direction of each motor; None where they do not match."""
    if len(own) != len(motors):
        return None
    found: list[tuple[int, int]] = []
    for motor in motors:
        wanted = np.array(motor, float)
        for k in range(len(own)):
            seen = np.where(wanted == 0.0, wanted, own[k])
            if k not in {one for one, _ in found} and abs(seen @ wanted) == np.abs(wanted).sum():
                found.append((k, int(np.sign(seen @ wanted))))
                break
        else:
            return None
    return tuple(found)
