"""PX4: parameters of the control allocation, a file that QGroundControl loads.

Motors (6DOF), body axes forward, right, down from the centre of gravity: SNAME. The allocator
divides a wrench by the pseudo-inverse of the motors' effectiveness, CT times position and axis, and
THR_MDL_FAC f makes the signal of a share of the thrust, T / CT = f u^2 + (1 - f) u (PX4 parameter
reference, Control Allocation and PWM Outputs).
"""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.export.receivers.exported import Exported, Subject, signal, thrust_exponent
from pipeline.physics.parameters import read
from pipeline.types import FloatArray

#: CA_AIRFRAME of motors in any arrangement, and the largest CA_ROTORn_CT.
_MOTORS_6DOF, _LARGEST_CT = 7, 100.0
_INTEGER, _REAL = 6, 9


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
