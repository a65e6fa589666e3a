"""Design calculations: read the file and the vehicle it names, compute, write JSON and page."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline import __version__
from pipeline.design.added_mass import (
    AddedMassInput,
    as_vehicle_section,
    part_added_mass,
    vehicle_added_mass,
)
from pipeline.design.balance_design import design_balance
from pipeline.design.balance_hull import BodyHull
from pipeline.design.balance_input import BalanceInput
from pipeline.design.balance_limits import table_limits
from pipeline.design.propeller_design import design_propeller, drive_limit, torque_curve
from pipeline.design.propeller_input import DriveOfVehicle, DrivePoint, PropellerInput
from pipeline.design.propeller_select import DriveLimit
from pipeline.design.tether_design import design_tether
from pipeline.design.tether_held import HeldVehicle
from pipeline.design.tether_input import TetherInput
from pipeline.errors import CannotComputeError
from pipeline.inputs.vehicle_place import find_vehicle, result_of
from pipeline.language import as_it_is
from pipeline.plan import UsageError
from pipeline.provenance import write_atomically
from pipeline.records.design import BalanceDesign, Design, PropellerDesign, TetherDesign
from pipeline.records.fits import DriveFit, StaticCharacteristic
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_checked, load_vehicle
from pipeline.vehicle.schema import Vehicle

if TYPE_CHECKING:
    from pipeline.simulate.pack import PackedVehicle


_AXES = "surge, sway, heave, roll, pitch, yaw"

_EXPECTED = "a YAML file with the inputs of the calculation."


@dataclass(frozen=True)
class AddedMassFound:
    """The input, the matrix about the vehicle's origin, and the section that states it."""

    given: AddedMassInput
    matrix: FloatArray
    section: str

    @property
    def text(self) -> str:
        """What is printed: each part's diagonal, then the section."""
        lines = [f"{as_it_is(self.given.title)}; kg and kg m^2 on {_AXES}:"]
        for part in self.given.parts:
            own = part_added_mass(part, self.given.density_kgpm3).diagonal()
            lines.append(f"  {part.name}: {', '.join(f'{value:.3f}' for value in own)}")
        return "\n".join(lines)

    def body(self) -> dict[str, Any]:
        """One JSON object."""
        return {
            "schema": "rig2sea/design-added-mass/1",
            "rig2sea_version": __version__,
            "name": self.given.name,
            "matrix": self.matrix.tolist(),
            "parts": {
                part.name: part_added_mass(part, self.given.density_kgpm3).tolist()
                for part in self.given.parts
            },
            "section": self.section,
        }


def design_added_mass(file: Path) -> AddedMassFound:
    """Read the parts and sum their added masses."""
    remedy = "`rig2sea design added-mass --example` prints one to start from."
    if not file.exists():
        raise UsageError(f"{file} does not exist.\n{remedy}")
    given = load_checked(
        file, AddedMassInput, expected="a YAML file with the parts of the vehicle.", remedy=remedy
    )
    matrix = vehicle_added_mass(given)
    kinds = ", ".join(f"{part.name} ({part.kind})" for part in given.parts)
    source = f"rig2sea design added-mass {file.name}: {kinds}"
    if given.source:
        source += f"; {given.source}"
    return AddedMassFound(given, matrix, as_vehicle_section(matrix, source))


def write_added_mass(found: AddedMassFound, to: Path) -> tuple[Path, Path]:
    """Write the section and the JSON file."""
    stem = to / f"{found.given.name}-added-mass"
    section, data = stem.with_suffix(".yaml"), stem.with_suffix(".json")
    write_atomically(section, found.section)
    write_atomically(data, json.dumps(found.body(), indent=1) + "\n")
    return section, data


@dataclass(frozen=True)
class DesignRequest:
    """Which calculation, from which file; vehicles are looked for under `raw` and `out`."""

    calculator: str
    file: Path
    raw: Path = Path("raw")
    out: Path = Path()


def compute_design(request: DesignRequest) -> Design:
    """Read the file, find what it names, and compute."""
    remedy = f"`rig2sea design {request.calculator} --example` prints one to start from."
    path = request.file
    if not path.exists():
        raise UsageError(f"{path} does not exist.\n{remedy}")
    if request.calculator == "balance":
        return _balance(
            load_checked(path, BalanceInput, expected=_EXPECTED, remedy=remedy), request
        )
    if request.calculator == "propeller":
        wanted = load_checked(path, PropellerInput, expected=_EXPECTED, remedy=remedy)
        return design_propeller(wanted, *_drive(wanted, request))
    one = load_checked(path, TetherInput, expected=_EXPECTED, remedy=remedy)
    return design_tether(one, _held(one, request))


def _balance(one: BalanceInput, request: DesignRequest) -> BalanceDesign:
    if one.vehicle is None:
        return design_balance(one)
    name, file = find_vehicle(one.vehicle, request.raw, request.out)
    vehicle = load_vehicle(file)
    static, _, _ = result_of(name, request.out, "static", StaticCharacteristic)
    drive = vehicle.drives[vehicle.tables.drive]
    tables = table_limits(static, drive.code_max, drive.code_min, name)
    found = design_balance(one, vehicle, tables)
    if tables is None:
        note = (
            f"{name} has no identified thrust yet, so limit: of the design file holds. "
            f"Run `rig2sea run {name}` first."
        )
        found = found.model_copy(update={"warnings": (note, *found.warnings)})
    return found


def _drive(one: PropellerInput, request: DesignRequest) -> tuple[DriveLimit, str]:
    """Return the drive of the file, or the measured one that it names."""
    drive = one.drive
    if isinstance(drive, DriveOfVehicle):
        return _measured_drive(drive, request)
    if isinstance(drive, DrivePoint):
        text = f"{drive.power_w:g} W of shaft power at {drive.shaft_speed_rpm:g} rpm"
    else:
        first, last = drive.shaft_speed_rpm[0], drive.shaft_speed_rpm[-1]
        text = f"the drive's torque between {first:g} and {last:g} rpm"
    return drive_limit(drive), text


def _measured_drive(drive: DriveOfVehicle, request: DesignRequest) -> tuple[DriveLimit, str]:
    from pipeline.physics.drive import drive_torque
    from pipeline.records.fit_values import torque_surface

    name, _ = find_vehicle(drive.vehicle, request.raw, request.out)
    fit, _, why_not = result_of(name, request.out, "drive", DriveFit)
    if fit is None:
        raise CannotComputeError(
            f"{name} has no measured mechanical characteristic: {why_not}\nRun "
            f"`rig2sea run {name}` with its load tests in raw/{name}/load_test first."
        )
    low, high = fit.code_range
    if not low <= drive.code <= high:
        raise CannotComputeError(
            f"Code {drive.code:g} of {name} was not measured: the load tests reach from code "
            f"{low:g} to {high:g}."
        )
    surface = torque_surface(fit)
    slowest = float(np.interp(drive.code, fit.band_code, fit.slowest_rps))
    fastest = float(np.interp(drive.code, fit.band_code, fit.fastest_rps))
    shaft = np.linspace(slowest, fastest, 60)
    torque = np.asarray(drive_torque(shaft, np.full(shaft.shape, drive.code), surface))
    pulling = torque > 0
    text = (
        f"the measured characteristic of {name} at code {drive.code:g}, {60 * slowest:.0f} to "
        f"{60 * fastest:.0f} rpm"
    )
    return torque_curve(shaft[pulling], torque[pulling]), text


def _held(one: TetherInput, request: DesignRequest) -> HeldVehicle | None:
    if one.held is None:
        return None
    from pipeline.inputs.simulated_vehicle import load_simulated

    found = load_simulated(one.held.vehicle, request.raw, request.out)
    return held_vehicle(
        found.vehicle,
        found.packed,
        heading_rad=float(np.radians(one.held.heading_deg)),
        attachment_m=np.array(one.held.attachment_m),
    )


def held_vehicle(
    vehicle: Vehicle,
    packed: "PackedVehicle",
    *,
    heading_rad: float = 0.0,
    attachment_m: FloatArray | None = None,
) -> HeldVehicle:
    """Put a packed vehicle and its file into what the tether calculation asks for."""
    from pipeline.simulate.context import model_of

    model = model_of(vehicle)
    _, buoyancy = BodyHull.of_model(model, vehicle.water.gravity_mps2, vehicle.water.density_kgpm3)
    return HeldVehicle(
        packed=packed,
        linear=np.array(model.damping.linear[:3]),
        quadratic=np.array(model.damping.quadratic[:3]),
        buoyancy_n=buoyancy,
        heading_rad=heading_rad,
        attachment_m=np.zeros(3) if attachment_m is None else attachment_m,
    )


def design_json(request: DesignRequest, found: Design) -> dict[str, object]:
    """Return the plain values of ``--json`` and of the file beside the page."""
    body = found.model_dump(mode="json")
    for row, printed in zip(body["printed"], found.printed, strict=True):
        row["difference"] = printed.difference
        row["within_rounding"] = printed.within_rounding
    return {
        "schema": f"rig2sea/design-{request.calculator}/1",
        "calculator": request.calculator,
        "rig2sea_version": __version__,
        **body,
    }


def write_design(request: DesignRequest, found: Design, to: Path) -> tuple[Path, Path]:
    """Write page and JSON, each whole or not at all; returns both paths."""
    from pipeline.report.design_page import design_page
    from pipeline.report.html import placed, write_page

    page = to / f"{found.name}-{request.calculator}.html"
    data = page.with_suffix(".json")
    # among the reports the page leads back to the index, which leads to it
    listed = to.resolve() == (request.out / "reports/design").resolve()
    crumbs = (("All vehicles", "../index.html"),) if listed else ()
    assets = placed(request.out / "reports/assets" if listed else to / "assets", page)
    write_page(design_page(found, crumbs, assets), page)
    write_atomically(data, json.dumps(design_json(request, found), indent=1))
    if listed:
        from pipeline.stages.index_page import write_index_again

        write_index_again(request.out)
    return page, data


def result_lines(found: Design) -> list[str]:
    """Say in a few lines what was found, for the terminal."""
    lines = [as_it_is(found.title)]
    if isinstance(found, BalanceDesign):
        lines += _balance_lines(found)
    elif isinstance(found, PropellerDesign):
        lines += _propeller_lines(found)
    else:
        lines += _tether_lines(found)
    if found.printed:
        outside = [row for row in found.printed if not row.within_rounding]
        lines.append(
            f"  printed numbers: {len(found.printed)}, beyond their rounding {len(outside)}; the "
            "page has each with its reason"
        )
    return lines


def _balance_lines(found: BalanceDesign) -> list[str]:
    state, small = found.exact, found.small_angle
    loads = ", ".join(f"{load.thruster} {load.thrust_n:.1f}" for load in state.loads)
    if small is None:
        forces = (
            f"  angle of attack {state.angle_of_attack_deg:.2f} deg, surge "
            f"{state.surge_force_n:.1f} N, vertical {state.vertical_force_n:.1f} N"
        )
    else:
        forces = (
            f"  angle of attack {state.angle_of_attack_deg:.2f} deg, surge "
            f"{state.surge_force_n:.1f} N, vertical {state.vertical_force_n:.1f} N (small angle: "
            f"{small.angle_of_attack_deg:.2f} deg, {small.surge_force_n:.1f} N, "
            f"{small.vertical_force_n:.1f} N)"
        )
    texts = [f"  {one.text}" for one in found.saturation]
    return [forces, f"  thrusters: {loads} N", *texts]


def _propeller_lines(found: PropellerDesign) -> list[str]:
    points = found.ranked if found.candidate is None else (*found.ranked, found.candidate)
    return [
        f"  {point.label}: Z {point.blades}, D {point.diameter_m:.4f} m, P/D "
        f"{point.pitch_ratio:.3f}, A_E/A_0 {point.area_ratio:.3f}, {point.shaft_speed_rpm:.0f} "
        f"rpm: {point.thrust_n:.1f} N, {point.torque_nm:.3f} N m, {point.power_w:.1f} W, "
        f"efficiency {point.efficiency:.3f}{', cavitates' if point.cavitates else ''}"
        for point in points
    ]


def _tether_lines(found: TetherDesign) -> list[str]:
    lines = []
    for variant in found.variants:
        x, y, z, whole = variant.largest_pull_n
        lines.append(
            f"  flow {variant.variant}: largest pull {x:.1f}, {y:.1f}, {z:.1f} N along X, Y, Z, "
            f"{whole:.1f} N in all"
        )
    lines += [
        f"  from {need.basis}: forces {', '.join(f'{f:.1f}' for f in need.force_n)} N, towing "
        f"{sum(need.towing_power_w):.0f} W, consumed {sum(need.consumed_power_w):.0f} W"
        for need in found.needs
    ]
    if found.held is not None:
        radii = found.held.held_radius_m
        lines.append(
            f"  {found.held.vehicle} holds {min(radii):.1f} m in the worst direction, "
            f"{max(radii):.1f} m in the best"
        )
    return lines
