"""Table 1: the open-water polynomials K_T(J) and K_M(J) of a propeller."""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.polynomial import fit_polynomial
from pipeline.physics.propeller import efficiency, polynomial
from pipeline.physics.torque_balance import first_zero
from pipeline.records.fits import Check, PolynomialFit, PropellerFit
from pipeline.records.measurements import OpenWaterRecord
from pipeline.vehicle.schema import Vehicle

#: Kostenko 2023, eq. (2).
DEGREE = 2
#: A test that begins this close (share of its span) to J = 0 counts as one that measured rest,
#: where a tank stirs its own water.
REST_MARGIN = 0.1


def fit_propeller(open_water: OpenWaterRecord, vehicle: Vehicle) -> PropellerFit:
    """Fit K_T(J) and K_M(J) by quadratics and check that they are those of a propeller.

    Points with marks are not fitted; the vehicle gives the diameter.

    Raises
    ------
    CannotComputeError
        If the points do not determine both curves.

    References
    ----------
    Kostenko 2023, eq. (2), Table 1.
    """
    if not any(not point.marks for point in open_water.points):
        raise CannotComputeError(
            "no usable open-water points, so K_T(J) and K_M(J) cannot be fitted; put a file with "
            "K_T and K_M (or 10K_Q) against J into open_water/"
        )
    thrust_fit = _fit_curve(open_water, "K_T", "thrust_coefficient")
    torque_fit = _fit_curve(open_water, "K_M", "torque_coefficient")
    return PropellerFit(
        diameter_m=vehicle.propeller.diameter_m,
        thrust=thrust_fit,
        torque=torque_fit,
        checks=_physical_checks(thrust_fit, torque_fit),
    )


def _fit_curve(open_water: OpenWaterRecord, quantity: str, attribute: str) -> PolynomialFit:
    usable = [point for point in open_water.points if not point.marks]
    used = [point for point in usable if getattr(point, attribute) is not None]
    return fit_polynomial(
        np.array([point.advance_ratio for point in used], float),
        np.array([getattr(point, attribute) for point in used], float),
        degree=DEGREE,
        quantity=quantity,
        variable="J",
        unit="1",
        degree_reason="Quadratic as in Kostenko 2023, eq. (2), and as the firmware tables want it.",
        sources=[point.source for point in used],
    )


def measured_ratios(propeller: PropellerFit) -> tuple[float, float]:
    """Smallest and largest advance ratio at which both coefficients were measured."""
    return _both_measured(propeller.thrust, propeller.torque)


def _both_measured(*fits: PolynomialFit) -> tuple[float, float]:
    ranges = [fit.quality.valid_range for fit in fits]
    return max(low for low, _ in ranges), min(high for _, high in ranges)


def lowest_covered_ratio(propeller: PropellerFit) -> float:
    """Advance ratio below which the curves are continued; see `REST_MARGIN`."""
    lowest, highest = measured_ratios(propeller)
    return lowest - REST_MARGIN * (highest - lowest)


def _physical_checks(thrust_fit: PolynomialFit, torque_fit: PolynomialFit) -> tuple[Check, ...]:
    k_t, k_m = np.array(thrust_fit.coefficients), np.array(torque_fit.coefficients)
    low, high = _both_measured(thrust_fit, torque_fit)
    thrust_zero, torque_zero = first_zero(k_t), first_zero(k_m)
    j = np.linspace(low, min(high, thrust_zero), 200)
    falling = {
        name: bool(
            np.all(np.polynomial.polynomial.polyval(j, np.polynomial.polynomial.polyder(c)) < 0)
        )
        for name, c in (("K_T", k_t), ("K_M", k_m))
    }
    torque_coefficient = polynomial(j, k_m)
    if np.all(torque_coefficient > 0):
        best = float(efficiency(j, polynomial(j, k_t), torque_coefficient).max())
        efficiency_text = f"largest efficiency {best:.3f} for J up to {j[-1]:.3f}"
        efficient = best < 1.0
    else:
        efficient, efficiency_text = False, "K_M is not positive everywhere below J(K_T = 0)"
    return (
        Check(
            name="K_T crosses zero before K_M",
            passed=thrust_zero < torque_zero,
            text=f"K_T = 0 at J = {thrust_zero:.4f}, K_M = 0 at J = {torque_zero:.4f}"
            + ("" if thrust_zero <= high else f" (measured to J = {high:.3f} only)"),
        ),
        *(
            Check(
                name=f"{name} falls with J",
                passed=falls,
                text=f"slope of {name} negative for J from {j[0]:.3f} to {j[-1]:.3f}"
                if falls
                else f"{name} rises somewhere between J = {j[0]:.3f} and {j[-1]:.3f}",
            )
            for name, falls in falling.items()
        ),
        Check(name="efficiency below 1", passed=efficient, text=efficiency_text),
    )
