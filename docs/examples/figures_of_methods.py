# ruff: noqa: INP001  a script, not a package
"""Print figures of docs/methods that no page of the report has.

``python docs/examples/figures_of_methods.py`` in a folder where ``rig2sea run mmt300`` was run.
"""

import json
from pathlib import Path

import numpy as np
from scipy.stats import f

from pipeline.identify.static import thruster_model
from pipeline.identify.working_grid import thrust_jacobian
from pipeline.provenance import read_envelope
from pipeline.records.fits import DriveFit, PropellerFit
from pipeline.vehicle.load import load_vehicle

FOLDER = Path("processed/mmt300")


def propeller() -> None:
    """Print the probability of coefficients further off than the printed ones (propeller.md)."""
    record = json.loads((FOLDER / "propeller.json").read_text("utf-8"))["record"]
    printed = json.loads((FOLDER / "tables.json").read_text("utf-8"))["published"]["table1"]
    for name, key in (("KT", "thrust"), ("KM", "torque")):
        fit = record[key]
        off = np.subtract(printed[name], fit["coefficients"])
        square = off @ np.linalg.solve(fit["covariance"], off) / 3
        print(f"{name}: probability {f.sf(square, 3, fit['quality']['points'] - 3):.2f}")


def variance_of_thrust() -> None:
    """Print where the variance of thrust at code 127 and rest comes from (uncertainty.md)."""
    propeller_fit = read_envelope(FOLDER / "propeller.json", "propeller", PropellerFit).record
    drive = read_envelope(FOLDER / "drive.json", "drive", DriveFit).record
    if propeller_fit is None or drive is None:
        return
    model = thruster_model(propeller_fit, drive, load_vehicle(Path("raw/mmt300")))
    code, speed = np.array([127.0]), np.array([0.0])
    point = model.solve(code, speed)
    slope, covariance = thrust_jacobian(model, point, code)[0], model.covariance()
    total = slope @ covariance @ slope
    for name, part in (("K_T", slice(0, 3)), ("K_Q", slice(3, 6)), ("drive", slice(6, None))):
        print(f"{name}: {slope[part] @ covariance[part, part] @ slope[part] / total:.2f}")
    by_torque = slope[6:] @ np.array(drive.coefficients)
    spread = by_torque**2 * drive.torque_scale_std**2 / len(drive.torque_scale_by_file)
    print(f"between drives: {spread / total:.2f}")
    print(f"% thrust per % torque: {by_torque / point.thrust_n[0]:.2f}")
    print(f"half-width: {model.interval_factor() * total**0.5:.2f} N")


def inverse_of_table_2() -> None:
    """Fit a cubic to the inverse of the printed Table 2 at rest; round trips (inverse.md)."""
    codes = np.linspace(16.7, 127, 2000)
    thrust = -4.0 + 0.254 * codes + 8.82e-4 * codes**2
    at = np.linspace(0.5, 42.48, 200)
    cubic = np.polynomial.Polynomial.fit(at, np.interp(at, thrust, codes), 3).convert()
    back = np.interp(cubic(at), codes, thrust)
    print(f"coefficients {cubic.coef.round(5)}, back within {np.abs(back - at).max():.3f} N")
    tables = json.loads((FOLDER / "tables.json").read_text("utf-8"))
    trips = tables["quality"]["round_trip"]
    for key in ("firmware_n", "firmware_rounded_codes", "cubic_n", "published_n"):
        print(f"largest {key}: {max(one[key] or 0.0 for one in trips):.3f}")


if __name__ == "__main__":
    propeller()
    variance_of_thrust()
    inverse_of_table_2()
