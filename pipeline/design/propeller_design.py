"""The whole propeller calculation: ranked propellers, the candidate, curves, printed numbers."""

import numpy as np
from scipy.interpolate import PchipInterpolator

from pipeline.design.printed import compare
from pipeline.design.propeller_cavitation import burrill, keller_area_ratio
from pipeline.design.propeller_input import DriveCurve, DrivePoint, PropellerInput
from pipeline.design.propeller_select import (
    DriveLimit,
    Screw,
    Task,
    full_power,
    least_power,
    most_thrust,
    screw,
    shaft_speed_for_thrust,
)
from pipeline.design.propeller_series import (
    SERIES_REYNOLDS,
    TESTED_AREA_RATIOS,
    Geometry,
    no_thrust_from,
    reynolds,
    thrust_coefficient,
    torque_coefficient,
)
from pipeline.errors import CannotComputeError
from pipeline.physics.propeller import efficiency
from pipeline.records.design import PropellerCurves, PropellerDesign, PropellerPoint
from pipeline.types import FloatArray


def drive_limit(drive: DrivePoint | DriveCurve) -> DriveLimit:
    """Turn what the file states of the drive into a limit of the torque."""
    if isinstance(drive, DrivePoint):
        shaft = drive.shaft_speed_rpm / 60.0
        torque = drive.power_w / (2.0 * np.pi * shaft)
        return DriveLimit(lambda n: np.full(np.shape(n), torque), shaft, shaft)
    return torque_curve(np.array(drive.shaft_speed_rpm) / 60.0, np.array(drive.torque_nm))


def torque_curve(shaft_speed_rps: FloatArray, torque_nm: FloatArray) -> DriveLimit:
    """Limit of a tabulated characteristic, monotone between its points (PCHIP)."""
    curve = PchipInterpolator(shaft_speed_rps, torque_nm)
    return DriveLimit(
        lambda n: np.maximum(np.asarray(curve(n), float), 1e-9),
        float(shaft_speed_rps[0]),
        float(shaft_speed_rps[-1]),
    )


def propeller_point(task: Task, found: Screw, label: str) -> PropellerPoint:
    """Describe a propeller at its operating point, with cavitation and what to beware of."""
    one, water, advance_mps = found.geometry, task.asked.water, task.advance_speed_mps
    thrust, shaft_rps = float(found.thrust_n), found.shaft_speed_rps
    least = float(keller_area_ratio(max(thrust, 0.0), one, water, task.asked.keller_margin))
    loading, limit = burrill(thrust, advance_mps, shaft_rps, one, water)
    full = full_power(task, one)
    cavitates = least > float(one.area_ratio) + 1e-6 or float(loading) > float(limit) * (1 + 1e-6)
    return PropellerPoint(
        label=label,
        blades=one.blades,
        diameter_m=float(one.diameter_m),
        pitch_ratio=float(one.pitch_ratio),
        area_ratio=float(one.area_ratio),
        shaft_speed_rpm=60.0 * float(found.shaft_speed_rps),
        advance_ratio=float(found.advance_ratio),
        thrust_coefficient=float(found.thrust_coefficient),
        torque_coefficient=float(found.torque_coefficient),
        thrust_n=thrust,
        torque_nm=float(found.torque_nm),
        power_w=float(found.power_w),
        efficiency=float(
            efficiency(found.advance_ratio, found.thrust_coefficient, found.torque_coefficient)
        ),
        reynolds=float(reynolds(advance_mps, shaft_rps, one, water.kinematic_viscosity_m2ps)),
        keller_area_ratio=least,
        burrill_loading=float(loading),
        burrill_limit=float(limit),
        cavitates=cavitates,
        full_power_shaft_speed_rpm=None if full is None else 60.0 * float(full.shaft_speed_rps),
        full_power_thrust_n=None if full is None else float(full.thrust_n),
        full_power_torque_nm=None if full is None else float(full.torque_nm),
        notes=_notes(task, found, label),
    )


def _notes(task: Task, found: Screw, label: str) -> tuple[str, ...]:
    one = found.geometry
    area, (low, high) = float(one.area_ratio), TESTED_AREA_RATIOS[one.blades]
    notes = []
    if area < low - 1e-6 or area > high + 1e-6:
        where = f"{low:.2f} to {high:.2f}" if low < high else f"{low:.2f} alone"
        notes.append(
            f"{label}: A_E/A_0 = {area:.3g} lies outside what was tested with {one.blades} blades "
            f"({where}); the polynomials reach from 0.30 to 1.05, and here they extrapolate."
        )
    for name, value, bounds in (
        ("diameter", float(one.diameter_m), task.asked.bounds.diameter_m),
        ("pitch ratio", float(one.pitch_ratio), task.asked.bounds.pitch_ratio),
    ):
        if bounds[0] < bounds[1] and min(abs(value - b) for b in bounds) < 1e-5 * bounds[1]:
            notes.append(f"{label}: the {name} lies at its bound, {value:.4g}.")
    shaft, drive = float(found.shaft_speed_rps), task.drive
    if not drive.point and min(shaft - drive.slowest_rps, drive.fastest_rps - shaft) < 1e-4 * shaft:
        notes.append(
            f"{label}: the shaft speed lies at the end of what is known of the drive, "
            f"{60 * shaft:.0f} rpm."
        )
    return tuple(notes)


def design_propeller(one: PropellerInput, drive: DriveLimit, drive_text: str) -> PropellerDesign:
    """Compute what ``rig2sea design propeller`` shows, on a drive that `drive_text` names.

    Raises
    ------
    CannotComputeError
        When no propeller of the series gives the thrust; the text has the most that one gives.
    """
    task = Task(one, drive)
    found = [(z, best) for z in one.bounds.blades if (best := least_power(task, z)) is not None]
    candidate = None if one.candidate is None else _candidate(one, task)
    if not found:
        raise CannotComputeError(_impossible(one, task, drive_text))
    found.sort(key=lambda pair: float(pair[1].power_w))
    ranked = tuple(propeller_point(task, best, f"B{z}") for z, best in found)
    known = _quantities(candidate if candidate is not None else ranked[0])
    printed, unknown = compare(one.published, known)
    shown = found[0][1].geometry
    return PropellerDesign(
        name=one.name,
        title=one.title,
        source=one.source,
        thrust_n=one.required.thrust_n,
        advance_speed_mps=task.advance_speed_mps,
        density_kgpm3=one.water.density_kgpm3,
        drive=drive_text,
        drive_torque_at_point_nm=float(drive.torque_nm(found[0][1].shaft_speed_rps)),
        ranked=ranked,
        candidate=candidate,
        curves=propeller_curves(task, shown),
        printed=printed,
        published_source=one.published.source if one.published else "",
        warnings=(*_warnings(one, ranked, candidate, [z for z, _ in found]), *unknown),
    )


def _candidate(one: PropellerInput, task: Task) -> PropellerPoint:
    stated = one.candidate
    assert stated is not None  # noqa: S101 - the caller asked
    shape = Geometry(stated.blades, stated.diameter_m, stated.pitch_ratio, stated.area_ratio)
    if stated.shaft_speed_rpm is not None:
        shaft: float | None = stated.shaft_speed_rpm / 60.0
    else:
        shaft = shaft_speed_for_thrust(task, shape)
    if shaft is None:
        raise CannotComputeError(
            f"candidate {stated.label}: within the drive's shaft speeds it never gives the "
            f"required {task.thrust_n:g} N.\nState shaft_speed_rpm: for it, or leave it out."
        )
    found = screw(task, shape, shaft)
    last = no_thrust_from(shape)
    if last is not None and float(found.advance_ratio) >= last:
        raise CannotComputeError(
            f"candidate {stated.label}: at {60.0 * shaft:.0f} rpm its advance ratio is "
            f"{float(found.advance_ratio):.3g}; from {last:.3g} on it gives no thrust, and the "
            "series says nothing.\nState a higher shaft_speed_rpm: for it, or leave it out."
        )
    return propeller_point(task, found, stated.label)


def _quantities(point: PropellerPoint) -> dict[str, tuple[float, str]]:
    shape = Geometry(point.blades, point.diameter_m, point.pitch_ratio, point.area_ratio)
    return {
        "thrust_n": (point.thrust_n, "N"),
        "shaft_speed_rpm": (point.shaft_speed_rpm, "rpm"),
        "power_w": (point.power_w, "W"),
        "torque_nm": (point.torque_nm, "N m"),
        "efficiency": (point.efficiency, "-"),
        "advance_ratio": (point.advance_ratio, "-"),
        "thrust_coefficient": (point.thrust_coefficient, "-"),
        "torque_coefficient": (point.torque_coefficient, "-"),
        "bollard_thrust_coefficient": (float(thrust_coefficient(0.0, shape)), "-"),
        "bollard_torque_coefficient": (float(torque_coefficient(0.0, shape)), "-"),
        "diameter_m": (point.diameter_m, "m"),
        "pitch_ratio": (point.pitch_ratio, "-"),
        "area_ratio": (point.area_ratio, "-"),
    }


def _impossible(one: PropellerInput, task: Task, drive_text: str) -> str:
    """Say how much thrust the series gives within the bounds and the drive."""
    most = most_thrust(task, one.bounds.blades)
    asked = (
        f"No propeller of the series gives {task.thrust_n:g} N at an advance speed of "
        f"{task.advance_speed_mps:.3g} m/s within the bounds, with {drive_text}"
        + (" and without cavitation" if one.enforce_cavitation else "")
        + "."
    )
    if most is None:
        return (
            f"{asked}\nWhatever the thrust, none there keeps to the drive's torque, free of "
            "cavitation and short of windmilling: widen the bounds, or change the drive."
        )
    if float(most.thrust_n) <= 0.0:
        return asked + "\nNone gives any thrust there: allow a larger pitch ratio or shaft speed."
    shape = most.geometry
    return (
        f"{asked}\nThe most is {float(most.thrust_n):.4g} N, with {shape.blades} blades, "
        f"D = {float(shape.diameter_m):.3g} m, P/D = {float(shape.pitch_ratio):.3g}, A_E/A_0 = "
        f"{float(shape.area_ratio):.3g} at {60 * float(most.shaft_speed_rps):.0f} rpm and "
        f"{float(most.power_w):.4g} W. Ask for less thrust, or allow a larger propeller or drive."
    )


def _warnings(
    one: PropellerInput,
    ranked: tuple[PropellerPoint, ...],
    candidate: PropellerPoint | None,
    found: list[int],
) -> tuple[str, ...]:
    points = ranked if candidate is None else (candidate, *ranked)
    warnings = [note for point in points for note in point.notes if "outside" in note]
    missing = [str(z) for z in one.bounds.blades if z not in found]
    if missing:
        warnings.append(
            f"With {', '.join(missing)} blades nothing within the bounds gives "
            f"{one.required.thrust_n:g} N on this drive."
        )
    if candidate is not None and candidate.cavitates:
        warnings.append(f"{candidate.label} cavitates by Keller's or Burrill's criterion.")
    slow = min(point.reynolds for point in points)
    if slow < SERIES_REYNOLDS:
        warnings.append(
            f"The Reynolds number is {slow:.2g}, the series holds at 2e6: small propellers lose "
            "some efficiency that is not counted here. The published correction starts at 2e6"
            + (" and changes nothing." if one.reynolds_correction else ".")
        )
    return tuple(warnings)


def propeller_curves(task: Task, shape: Geometry) -> PropellerCurves:
    """Return open-water curves, and thrust and torque beside the drive."""
    j = np.linspace(0.0, 1.6, 81)
    k_t, k_q = thrust_coefficient(j, shape), torque_coefficient(j, shape)
    end = int(np.argmax(k_t <= 0)) if (k_t <= 0).any() else len(j)
    j, k_t, k_q = j[:end], k_t[:end], k_q[:end]
    slow, fast = task.drive.slowest_rps, task.drive.fastest_rps
    shaft = (
        np.linspace(0.6 * slow, 1.15 * fast, 60)
        if task.drive.point
        else np.linspace(slow, fast, 60)
    )
    at = screw(task, shape, shaft)
    real = (at.thrust_coefficient > 0) & (at.torque_coefficient > 0)
    drive = np.asarray(task.drive.torque_nm(shaft))
    stated: tuple[float | None, ...] = (
        (None,) * len(shaft) if task.drive.point else tuple(float(m) for m in drive)
    )
    return PropellerCurves(
        advance_ratio=tuple(j.tolist()),
        thrust_coefficient=tuple(k_t.tolist()),
        torque_coefficient=tuple(k_q.tolist()),
        efficiency=tuple(np.asarray(efficiency(j, k_t, k_q)).tolist()),
        shaft_speed_rpm=tuple((60 * shaft).tolist()),
        drive_torque_nm=stated,
        propeller_torque_nm=_shown(at.torque_nm, real),
        propeller_thrust_n=_shown(at.thrust_n, real),
    )


def _shown(values: FloatArray, real: "np.typing.NDArray[np.bool_]") -> tuple[float | None, ...]:
    return tuple(float(v) if ok else None for v, ok in zip(values, real, strict=True))
