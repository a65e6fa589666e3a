"""How far off the model for thrust against the motion can be, held against measured curves.

The four-quadrant Fourier coefficients of the Wageningen B4-70 propeller (pitch ratio 1.0; van
Lammeren, van Manen and Oosterveld, The Wageningen B-screw series, SNAME Trans. 77, 1969) are here
to four decimals, taken at second hand; `test_transcription` holds them against the B-series
regression, an independent source for the first quadrant.
"""

import numpy as np
import pytest

from pipeline.physics.torque_balance import OpenWaterPropeller, free_propeller_drag
from pipeline.types import FloatArray

MMT300 = OpenWaterPropeller(
    np.array([0.139, -0.155, -0.061]), np.array([0.0171, -0.0164, -0.0055]), 0.14, 1000.62
)
# fmt: off
B4_70_THRUST = (
    [
        0.0254, 0.1782, 0.0147, 0.0281, -0.0163, -0.053, 0.0006, 0.0368, -0.0025, -0.0177,
        0.0027, 0.0214, -0.0025, 0.0012, 0.0051, 0.0078, -0.0038, 0.0035, 0.0053, 0.0022,
        -0.0028,
    ],
    [
        0.0, -0.7478, -0.0138, 0.1008, -0.0113, 0.0472, 0.0107, -0.009, -0.0078, 0.0239,
        0.0081, -0.0001, -0.0032, 0.0093, 0.0016, -0.0066, -0.0006, 0.0051, -0.0006,
        -0.0082, -0.0006,
    ],
)
B4_70_TORQUE = (
    [
        0.0025, 0.0267, 0.0016, 0.0066, -0.0022, -0.0078, 0.0002, 0.0061, -0.0016, -0.0033,
        0.0012, 0.0031, -0.0013, 0.0014, 0.0009, 0.0001, -0.0008, 0.0013, 0.0012, -0.0001,
        -0.0007,
    ],
    [
        0.0, -0.1108, 0.0002, 0.0165, -0.0021, 0.0085, 0.0009, -0.0031, -0.001, 0.0043,
        0.0012, 0.0001, -0.0008, 0.0015, 0.0002, -0.0017, 0.0005, 0.0012, -0.0005, -0.0015,
        0.0002,
    ],
)
# fmt: on


def fourier(series: tuple[list[float], list[float]], beta: FloatArray) -> FloatArray:
    k = np.arange(len(series[0]))
    angle = np.outer(np.atleast_1d(beta), k)
    return np.asarray(np.cos(angle) @ np.array(series[0]) + np.sin(angle) @ np.array(series[1]))


def measured(j: FloatArray, turning: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """K_T, K_Q at J = V/(|n| D) with the shaft turning ahead (+1) or astern (-1)."""
    beta = np.arctan2(j, 0.7 * np.pi * turning)
    factor = np.pi / 8 * (j**2 + (0.7 * np.pi) ** 2)
    return fourier(B4_70_THRUST, beta) * factor, fourier(B4_70_TORQUE, beta) * factor


def test_transcription() -> None:
    """B-series regression, B4-70, P/D 1.0: K_T(0) = 0.455, 10 K_Q(0) = 0.675, K_T(0.6) = 0.226."""
    k_t, k_q = measured(np.array([0.0, 0.6]))
    assert k_t == pytest.approx([0.4547, 0.2256], rel=0.03)
    assert 10 * k_q[0] == pytest.approx(0.6754, rel=0.03)


@pytest.mark.parametrize("turning", [1.0, -1.0])
def test_mooring_branch_is_within_fifteen_percent_up_to_j_of_a_half(turning: float) -> None:
    """At equal shaft speed. Turning ahead while moving astern (+1) and the other way round (-1)."""
    j = np.linspace(0.0, 0.5, 26)
    k_t, _ = measured(-turning * j, turning)
    ratio = k_t / k_t[0]
    assert np.abs(ratio - 1.0).max() < 0.15
    assert ratio.min() < 0.93  # it dips: the propeller works in its own recirculating wake


@pytest.mark.parametrize("turning", [1.0, -1.0])
def test_mooring_branch_is_a_lower_bound_at_equal_torque(turning: float) -> None:
    """What a torque-controlled drive keeps is torque: thrust is then 0 to 20 % above rest."""
    j = np.linspace(0.0, 1.0, 51)
    k_t, k_q = measured(-turning * j, turning)
    ratio = (k_t / k_q) / (k_t[0] / k_q[0])
    assert ratio.min() > 0.99
    assert ratio.max() < 1.21


def test_extrapolated_polynomial_errs_to_the_other_side() -> None:
    """At J = -0.5 a quadratic fitted to 0 <= J <= 0.9 promises +30 %; measured are 0 and -7 %."""
    j = np.linspace(0.0, 0.9, 19)
    quadratic = np.polynomial.polynomial.polyfit(j, measured(j)[0], 2)
    at = np.array([-0.5])
    promised = np.polynomial.polynomial.polyval(at, quadratic) / quadratic[0]
    ahead = measured(at)[0] / measured(np.zeros(1))[0]
    back = measured(-at, -1.0)[0] / measured(np.zeros(1), -1.0)[0]
    assert promised[0] == pytest.approx(1.30, abs=0.01)
    assert ahead[0] == pytest.approx(1.00, abs=0.01)
    assert back[0] == pytest.approx(0.93, abs=0.01)


def test_beyond_j_of_0_6_the_blades_brake_like_plates() -> None:
    """Turning astern at J = 1: 2.1 times the thrust of rest, at 1.8 times the torque."""
    k_t, k_q = measured(np.array([0.0, 1.0]), -1.0)
    assert k_t[1] / k_t[0] == pytest.approx(2.15, abs=0.02)
    assert k_q[1] / k_q[0] == pytest.approx(1.82, abs=0.02)


def test_reverse_thrust_at_rest_is_weaker_than_ahead() -> None:
    """The papers take the thruster as symmetric; a B-series propeller is not, by 22 %."""
    ahead, astern = (measured(np.zeros(1), turning)[0][0] for turning in (1.0, -1.0))
    assert -astern / ahead == pytest.approx(0.78, abs=0.01)


def test_drag_of_the_mmt300_propeller_at_2_mps() -> None:
    assert float(free_propeller_drag(2.0, MMT300)) == pytest.approx(3.4, abs=0.1)
    assert float(free_propeller_drag(-1.0, MMT300)) == pytest.approx(-0.85, abs=0.03)


def test_free_propeller_takes_no_torque() -> None:
    """The drag is the thrust of the shaft speed at which K_M is zero."""
    drag = float(free_propeller_drag(1.5, MMT300))
    n = np.linspace(5.0, 20.0, 15001)
    free = n[np.argmin(np.abs(MMT300.torque_nm(n, 1.5)))]
    assert -float(MMT300.thrust_n(free, 1.5)) == pytest.approx(drag, abs=0.01)


def test_free_drag_needs_a_zero_of_the_torque() -> None:
    endless = OpenWaterPropeller(np.array([0.1]), np.array([0.01]), 0.14, 1000.0)
    with pytest.raises(ValueError, match="no zero"):
        free_propeller_drag(1.0, endless)
