"""What the rig files of `mmt300` are made of: the printed tables of Kostenko 2023.

No rig file of the paper is public. Three things are rebuilt here, free of noise:

- the propeller, straight from Table 1;
- the drive family M(n, N), which the paper shows as a plot only (fig. 4b): Table 2 is inverted
  through Table 1 to the shaft speed and torque at which the drive must sit for every code and
  speed, and one smooth surface is laid through these working points;
- the mooring characteristic, by inverting the printed cubics N(T) of Table 3. It is *not* taken
  from Table 2: the two differ at rest, by up to 1 N at positive codes and 1.85 N at negative ones,
  and that gap is the paper's own.
"""

import numpy as np

from pipeline.physics.propeller import thrust, torque
from pipeline.types import ArrayLike, FloatArray

#: rho = 102 kg s^2/m^4 with g = 9.81 m/s^2 (below eq. 1), in SI.
GRAVITY_MPS2 = 9.81
DENSITY_KGPM3 = 102 * GRAVITY_MPS2
#: Table 1.
DIAMETER_M = 0.14
KT = (0.139, -0.155, -0.061)
KM = (0.0171, -0.0164, -0.0055)
#: Table 2: speed [m/s] -> K_F0 [N], K_F1 [N], K_F2 [N].
TABLE2 = {
    0.0: (-4.0, 0.254, 8.82e-4),
    0.5: (-5.0, 0.215, 10.2e-4),
    1.0: (-8.0, 0.211, 9.65e-4),
    1.5: (-11.0, 0.210, 9.07e-4),
    2.0: (-15.0, 0.208, 8.67e-4),
}
#: Table 3, ascending powers of the thrust in newtons; the negative row takes the signed thrust.
TABLE3_POSITIVE = (12.7, 4.336, -0.070, 7.29e-4)
TABLE3_NEGATIVE = (-12.7, 4.738, 0.089, 9.68e-4)
#: Codes of the load test (section 2 of the paper).
BENCH_CODES = (20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 127)
CODE_MAX = 127
#: The bench stops unloading here; Table 2 needs 1982 rpm at most.
SPEED_LIMIT_RPM = 2200.0

#: The drive family: M = sum_ij DRIVE[i][j] (n / 1900 rpm)^i (N / 127)^j. [N m]
#: Chosen so that the torque balance with Table 1 meets Table 2 with the smallest largest error in
#: thrust over all codes and speeds where the printed thrust exceeds 0.5 N, under the condition
#: that torque falls with speed wherever the bench goes. Table 2 itself has a step between 1.0
#: and 1.5 m/s that no smooth family follows; this one stays within 0.2 N of it at the bench
#: codes and 0.23 N between them.
DRIVE_SPEED_SCALE_RPM = 1900.0
DRIVE = (
    (-1.0329, 15.6401, 15.3860, 11.6260),
    (-3.8839, -83.1157, -30.0001, -4.6470),
    (29.3192, 121.0588, -41.5318, 12.3651),
    (-39.2228, -10.3379, 14.1789, -5.2254),
)


def table2_thrust(code: float, speed_mps: float) -> float:
    """Return the printed thrust T(N, V), eq. (4), for a positive code at a tabulated speed [N].

    Zero where the polynomial is not positive: the paper's "|N| <= K_F0" compares a code with a
    thrust.

    >>> round(table2_thrust(127, 0.0), 2), table2_thrust(14, 0.0)
    (42.48, 0.0)
    """
    constant, linear, quadratic = TABLE2[speed_mps]
    return max(0.0, constant + linear * code + quadratic * code * code)


def working_point(code: float, speed_mps: float) -> tuple[float, float]:
    """Shaft speed [rpm] and torque [N m] that Tables 1 and 2 demand of the drive together.

    Solves T = K_T(J) rho n^2 D^4, a quadratic in n, for the printed thrust and puts n into the
    torque.

    Raises
    ------
    ValueError
        Where the printed thrust is zero: any shaft speed in the dead zone would do.

    Examples
    --------
    >>> n, m = working_point(127, 0.0)
    >>> round(n), round(m, 3)
    (1692, 0.732)
    """
    thrust_n = table2_thrust(code, speed_mps)
    if thrust_n <= 0.0:
        raise ValueError(f"code {code} is in the dead zone at {speed_mps} m/s")
    inflow = speed_mps / DIAMETER_M
    linear = KT[1] * inflow
    constant = KT[2] * inflow**2 - thrust_n / (DENSITY_KGPM3 * DIAMETER_M**4)
    rps = (-linear + (linear**2 - 4 * KT[0] * constant) ** 0.5) / (2 * KT[0])
    return rps * 60.0, float(propeller_torque(rps * 60.0, speed_mps))


def propeller_thrust(shaft_speed_rpm: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
    """Thrust of Table 1's propeller, eq. (1) [N]."""
    return thrust(
        np.asarray(shaft_speed_rpm, float) / 60.0,
        speed_mps,
        coefficients=np.array(KT),
        diameter_m=DIAMETER_M,
        density_kgpm3=DENSITY_KGPM3,
    )


def propeller_torque(shaft_speed_rpm: ArrayLike, speed_mps: ArrayLike) -> FloatArray:
    """Torque of Table 1's propeller, eq. (1) [N m]."""
    return torque(
        np.asarray(shaft_speed_rpm, float) / 60.0,
        speed_mps,
        coefficients=np.array(KM),
        diameter_m=DIAMETER_M,
        density_kgpm3=DENSITY_KGPM3,
    )


def drive_torque(shaft_speed_rpm: ArrayLike, code: float) -> FloatArray:
    """Torque M(n, N) of the rebuilt drive family for a positive code [N m].

    >>> round(float(drive_torque(1692.0, 127)), 2), round(float(drive_torque(1982.0, 127)), 2)
    (0.74, 0.53)
    """
    return np.asarray(
        np.polynomial.polynomial.polyval2d(
            np.asarray(shaft_speed_rpm, float) / DRIVE_SPEED_SCALE_RPM,
            np.full_like(np.asarray(shaft_speed_rpm, float), code / CODE_MAX),
            np.array(DRIVE),
        )
    )


def drive_speed(torque_nm: float, code: float) -> float:
    """Shaft speed at which the drive gives a torque, by bisection on the bench's range [rpm].

    Raises
    ------
    ValueError
        When the drive does not give this torque between 0.8 of its speed at rest and 1.05 of
        the bench's speed limit.
    """
    at_rest_rpm, _ = working_point(code, 0.0)
    # The polynomial is a drive only on the branch next to the bollard point: walk up from there.
    rpm = np.linspace(0.8 * at_rest_rpm, 1.05 * SPEED_LIMIT_RPM, 600)
    excess = drive_torque(rpm, code) - torque_nm
    crossing = np.flatnonzero((excess[:-1] >= 0.0) & (excess[1:] < 0.0))
    if crossing.size == 0:
        raise ValueError(f"code {code} does not give {torque_nm} N m")
    low, high = float(rpm[crossing[0]]), float(rpm[crossing[0] + 1])
    for _ in range(50):
        middle = 0.5 * (low + high)
        if float(drive_torque(middle, code)) >= torque_nm:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def balanced_thrust(code: float, speed_mps: float) -> float:
    """Thrust where the rebuilt drive and the propeller agree, eq. (3); 0 in the dead zone [N].

    The check of `DRIVE`: to be compared with `table2_thrust`.
    """
    at_rest_rpm, _ = working_point(code, 0.0)
    rpm = np.linspace(0.8 * at_rest_rpm, SPEED_LIMIT_RPM, 2000)
    excess = propeller_torque(rpm, speed_mps) - drive_torque(rpm, code)
    crossing = np.flatnonzero((excess[:-1] < 0.0) & (excess[1:] >= 0.0))
    if crossing.size == 0:
        return 0.0
    low, high = float(rpm[crossing[0]]), float(rpm[crossing[0] + 1])
    for _ in range(50):
        middle = 0.5 * (low + high)
        if float(propeller_torque(middle, speed_mps) - drive_torque(middle, code)) < 0.0:
            low = middle
        else:
            high = middle
    return max(0.0, float(propeller_thrust(0.5 * (low + high), speed_mps)))


def table3_code(thrust_n: ArrayLike) -> FloatArray:
    """Code for a signed thrust at rest by the printed cubics of Table 3, eq. (7).

    >>> table3_code(np.array([-42.24, 42.71])).round(1).tolist()
    [-127.0, 127.0]
    """
    signed = np.asarray(thrust_n, float)
    polynomial = np.polynomial.polynomial.polyval
    return np.asarray(
        np.where(
            signed >= 0.0,
            polynomial(signed, np.array(TABLE3_POSITIVE)),
            polynomial(signed, np.array(TABLE3_NEGATIVE)),
        )
    )


def mooring_thrust(code: float) -> float:
    """Signed thrust at rest for a code: Table 3 inverted; 0 inside its dead zone [N].

    >>> round(mooring_thrust(60), 2), round(mooring_thrust(-60), 2), mooring_thrust(10)
    (13.4, -12.53, 0.0)
    """
    if abs(code) <= TABLE3_POSITIVE[0]:
        return 0.0
    sign = 1.0 if code > 0 else -1.0
    low, high = 0.0, 60.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if sign * float(table3_code(sign * middle)) < abs(code):
            low = middle
        else:
            high = middle
    return sign * 0.5 * (low + high)
