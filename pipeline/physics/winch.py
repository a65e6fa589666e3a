r"""The tether's winch: a drum driven by a motor, loaded by the cable.

Voitasyk 2018 states it as :math:`M_{EM} = f(u_w, \omega)`, :math:`\dot\omega = f(M_{EM}, M_L)`,
:math:`M_L = R F_1`, :math:`\dot L_T = R \omega`. Here, with :math:`\omega` positive where cable is
paid out,

.. math::

    J \dot\omega = M_s \left(u - \frac{\omega}{\omega_0}\right) - b\,\omega + R F_1
        - M_f \operatorname{sgn}\omega

M_s is the stall torque and omega_0 the no-load speed of a DC motor behind its gear, u its command
between -1 and 1, F_1 the tension at the drum, which always pulls cable out. M_f is dry friction; at
u = 0 a spring-applied brake adds to it. A drum at rest stays so while the torque is within M_f.
"""

from dataclasses import dataclass, fields

import numpy as np

from pipeline.types import FloatArray


@dataclass(frozen=True)
class Winch:
    """A drum with motor, gear and brake; torques and inertia are those at the drum.

    `drum_radius_m` R to the middle of the cable, the layers' growth is left out; `inertia_kgm2` J
    of drum, cable on it, gear and motor; at full command `stall_torque_nm` M_s at no speed and
    `no_load_radps` omega_0 at no torque; `viscous_nms` b; `dry_friction_nm` M_f; `brake_nm` that
    the brake holds at command 0, on top of the friction. At `shortest_m`, `longest_m` of paid-out
    length the drum stops hauling in, or paying out. Checked where they come in
    (`vehicle.attachment_schema`).
    """

    drum_radius_m: float
    inertia_kgm2: float
    stall_torque_nm: float
    no_load_radps: float
    viscous_nms: float = 0.0
    dry_friction_nm: float = 0.0
    brake_nm: float = 0.0
    shortest_m: float = 1.0
    longest_m: float = 1000.0

    def numbers(self) -> FloatArray:
        """Return the nine numbers in the order of the attributes, as the kernel takes them."""
        return np.array([float(getattr(self, field.name)) for field in fields(self)])


def drum_step(  # noqa: PLR0917 - the compiled kernel passes by position
    speed: float,
    command: float,
    tension: float,
    dt: float,
    radius: float,
    inertia: float,
    stall: float,
    no_load: float,
    viscous: float,
    friction: float,
    brake: float,
) -> float:
    """Advance the drum's speed [rad/s], positive pays out, by a step [s] under a tension [N].

    Friction and the motor's slope are implicit, so no step is too long for them and a drum that
    friction holds stands still exactly. Plain numbers, the last seven as in `Winch`: the compiled
    kernel takes this function too. The command u is between -1 and 1.

    Examples
    --------
    1 s from rest at full command, 1 N m on 1 kg m^2 and no slope to speak of:

    >>> round(drum_step(0.0, 1.0, 0.0, 1.0, 0.2, 1.0, 1.0, 1e9, 0.0, 0.0, 0.0), 6)
    1.0

    0.2 m x 10 N are held by 3 N m of brake:

    >>> drum_step(0.0, 0.0, 10.0, 1.0, 0.2, 1.0, 1.0, 1.0, 0.0, 0.0, 3.0)
    0.0
    """
    held = friction
    if command == 0.0:
        held += brake
    driven = inertia * speed + dt * (stall * command + radius * tension)
    loss = dt * held
    if abs(driven) <= loss:
        return 0.0
    if driven > 0.0:
        driven -= loss
    else:
        driven += loss
    return driven / (inertia + dt * (stall / no_load + viscous))
