"""The bundled vehicles: are their models bodies that could swim, and as their files say?"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pydantic import BaseModel
from scipy.optimize import brentq

from evaluation.bundled import mmt300_truth as truth
from pipeline.bundled.vehicles import bundled_vehicle, bundled_vehicles
from pipeline.errors import InputError
from pipeline.physics.added_mass_shapes import ellipsoid_added_mass
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle, vehicle_notes
from pipeline.vehicle.model_schema import Crossflow, FromBollard, FromTables, Model
from pipeline.vehicle.schema import Vehicle

NAMES = ("mmt300", "rov8", "cargo_carrier")
SURGE, SWAY, HEAVE, ROLL, PITCH, YAW = range(6)


@pytest.fixture(scope="module")
def vehicles(repository: Path) -> dict[str, Vehicle]:
    folders = {"mmt300": repository / "raw" / "mmt300"}
    folders |= {name: bundled_vehicle(name) for name in bundled_vehicles()}
    return {name: load_vehicle(folder) for name, folder in folders.items()}


def model_of(vehicle: Vehicle) -> Model:
    assert vehicle.model is not None
    return vehicle.model


def bollard_of(vehicle: Vehicle, drive: str) -> FromBollard:
    characteristic = model_of(vehicle).thrusters[drive].characteristic
    assert isinstance(characteristic, FromBollard)
    return characteristic


def statics(vehicle: Vehicle, *, payloads: bool = True) -> tuple[float, FloatArray, float]:
    """Return buoyancy minus weight [N], its static moment [N m] and metacentric stiffness [N m]."""
    model, water = model_of(vehicle), vehicle.water
    body = model.rigid_body
    parts = [(body.mass_kg, body.centre_of_mass_m, body.displaced_volume_m3)]
    centres = [body.centre_of_buoyancy_m]
    if payloads:
        for one in model.payloads:
            parts.append((one.mass_kg, one.position_m, one.volume_m3))
            centres.append(one.position_m)
    g = water.gravity_mps2
    weight = [(mass * g, np.array(place)) for mass, place, _ in parts]
    lift = [
        (water.density_kgpm3 * g * volume, np.array(centre))
        for (_, _, volume), centre in zip(parts, centres, strict=True)
    ]
    moment = np.array(sum(w * r for w, r in weight)) - np.array(sum(b * r for b, r in lift))
    net = sum(b for b, _ in lift) - sum(w for w, _ in weight)
    return net, np.cross(moment, [0.0, 0.0, 1.0]), float(moment[2])


def mass_matrix(model: Model) -> FloatArray:
    """Return M_RB + M_A about the origin, without payloads (Fossen 2021, eq. 3.48)."""
    body = model.rigid_body
    xx, yy, zz, xy, xz, yz = body.inertia_kgm2
    x, y, z = body.centre_of_mass_m
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    inertia = np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]])
    dry = np.block(
        [
            [body.mass_kg * np.eye(3), -body.mass_kg * skew],
            [body.mass_kg * skew, inertia - body.mass_kg * skew @ skew],
        ]
    )
    assert model.added_mass.diagonal is not None
    return np.asarray(dry + np.diag(model.added_mass.diagonal), float)


def wrench_matrix(vehicle: Vehicle) -> FloatArray:
    """Return the wrench per newton of each thruster, shape (6, thrusters)."""
    columns = []
    for one in vehicle.thrusters:
        push = np.array(one.direction)
        columns.append(np.concatenate([push, np.cross(one.position_m, push)]))
    return np.array(columns).T


def drag_n(model: Model, speed_mps: float) -> float:
    damping = model.damping
    return damping.linear[SURGE] * speed_mps + damping.quadratic[SURGE] * speed_mps**2


def stations(crossflow: Crossflow) -> tuple[FloatArray, FloatArray]:
    """Return a fine grid along the hull from stern to bow and the breadth on it."""
    x = np.array([section.x_m for section in crossflow.sections])
    breadth = np.array([section.breadth_m for section in crossflow.sections])
    order = np.argsort(x)
    fine = np.linspace(x.min(), x.max(), 20001)
    return fine, np.interp(fine, x[order], breadth[order])


def test_the_bundled_vehicles_are_found_by_name() -> None:
    assert bundled_vehicles() == ("bluerov2", "bluerov2_heavy", "cargo_carrier", "remus100", "rov8")
    assert bundled_vehicle("bluerov2_heavy") == bundled_vehicle("rov8")
    with pytest.raises(InputError, match="no bundled vehicle has this name") as caught:
        bundled_vehicle("../rov8")
    assert "cargo_carrier, remus100, rov8" in str(caught.value)


@pytest.mark.parametrize("name", NAMES)
def test_the_file_is_valid_complete_and_without_contradictions(
    vehicles: dict[str, Vehicle], name: str
) -> None:
    vehicle = vehicles[name]
    assert vehicle.name == name
    assert vehicle.sensors is not None
    assert vehicle.model is not None
    assert vehicle_notes(vehicle) == ()
    assert vehicle.data_note


@pytest.mark.parametrize("name", NAMES)
def test_every_part_of_model_and_sensors_names_its_source(
    vehicles: dict[str, Vehicle], name: str
) -> None:
    def parts(value: object, path: str) -> Iterator[tuple[str, str]]:
        if isinstance(value, BaseModel):
            # what the file does not state has nothing to name
            if hasattr(value, "source") and value.model_fields_set:
                yield path, value.source
            for field in type(value).model_fields:
                yield from parts(getattr(value, field), f"{path}.{field}")
        elif isinstance(value, dict):
            for key, inner in value.items():
                yield from parts(inner, f"{path}.{key}")
        elif isinstance(value, tuple):
            for index, inner in enumerate(value):
                yield from parts(inner, f"{path}[{index}]")

    found = dict(parts(vehicles[name].model, "model")) | dict(
        parts(vehicles[name].sensors, "sensors")
    )
    without = {path for path, source in found.items() if not source}
    assert len(found) > 8
    assert without == set()


@pytest.mark.parametrize(
    ("name", "buoyancy_n", "released_n"),
    [("mmt300", 2.6, 2.6), ("rov8", -0.98, -0.98), ("cargo_carrier", 10.3, 118.7)],
)
def test_near_neutral_with_the_stated_residual_buoyancy(
    vehicles: dict[str, Vehicle], name: str, buoyancy_n: float, released_n: float
) -> None:
    vehicle = vehicles[name]
    net_n, _, _ = statics(vehicle)
    bare_n, _, _ = statics(vehicle, payloads=False)
    assert net_n == pytest.approx(buoyancy_n, abs=0.05)
    assert bare_n == pytest.approx(released_n, abs=0.05)
    weight_n = model_of(vehicle).rigid_body.mass_kg * vehicle.water.gravity_mps2
    assert abs(net_n) < 0.01 * weight_n


@pytest.mark.parametrize("name", NAMES)
def test_upright_and_level_at_rest(vehicles: dict[str, Vehicle], name: str) -> None:
    for payloads in (True, False):
        _, moment_nm, stiffness_nm = statics(vehicles[name], payloads=payloads)
        assert stiffness_nm > 0.0
        assert np.degrees(np.abs(moment_nm[:2]).max() / stiffness_nm) < 0.5


@pytest.mark.parametrize("name", NAMES)
def test_mass_matrix_is_symmetric_and_positive_definite(
    vehicles: dict[str, Vehicle], name: str
) -> None:
    matrix = mass_matrix(model_of(vehicles[name]))
    assert matrix == pytest.approx(matrix.T)
    assert np.linalg.eigvalsh(matrix)[0] > 0.0


@pytest.mark.parametrize("name", NAMES)
def test_damping_is_there_in_every_axis(vehicles: dict[str, Vehicle], name: str) -> None:
    damping = model_of(vehicles[name]).damping
    assert min(damping.linear) >= 0.0
    assert min(damping.quadratic) > 0.0


@pytest.mark.parametrize(
    ("name", "roll_s", "pitch_s"),
    [("mmt300", 1.20, 7.74), ("rov8", 3.69, 3.33), ("cargo_carrier", 2.2, 3.6)],
)
def test_free_roll_and_pitch_have_plausible_periods(
    vehicles: dict[str, Vehicle], name: str, roll_s: float, pitch_s: float
) -> None:
    """T = 2 pi sqrt((I + A) / stiffness), undamped and uncoupled, without payloads' inertia."""
    matrix = mass_matrix(model_of(vehicles[name]))
    _, _, stiffness_nm = statics(vehicles[name])
    periods = 2 * np.pi * np.sqrt(np.diag(matrix)[[ROLL, PITCH]] / stiffness_nm)
    assert periods == pytest.approx([roll_s, pitch_s], rel=0.03)
    assert periods.min() > 1.0
    assert periods.max() < 10.0


@pytest.mark.parametrize("name", ["rov8", "cargo_carrier"])
def test_eight_thrusters_control_all_six_degrees_of_freedom(
    vehicles: dict[str, Vehicle], name: str
) -> None:
    matrix = wrench_matrix(vehicles[name])
    assert matrix.shape == (6, 8)
    values = np.linalg.svd(matrix, compute_uv=False)
    assert np.linalg.matrix_rank(matrix) == 6
    assert values[-1] > 0.1 * values[0]


def test_mmt300_controls_surge_heave_pitch_and_yaw_and_sway_only_with_yaw(
    vehicles: dict[str, Vehicle],
) -> None:
    matrix = wrench_matrix(vehicles["mmt300"])
    assert np.linalg.matrix_rank(matrix, tol=1e-6) == 4

    def left_over(wrench: FloatArray) -> float:
        thrust, *_ = np.linalg.lstsq(matrix, wrench, rcond=None)
        return float(np.linalg.norm(matrix @ thrust - wrench))

    for axis in (SURGE, HEAVE, PITCH):
        assert left_over(np.eye(6)[axis]) < 1e-5
    # yaw comes with sway, N = -L_s Y; neither comes alone, and roll not at all
    assert left_over(np.array([0.0, 1.0, 0.0, 0.0, 0.0, -0.9])) < 1e-5
    assert left_over(np.eye(6)[YAW]) > 0.5
    assert left_over(np.eye(6)[SWAY]) > 0.5
    assert left_over(np.eye(6)[ROLL]) > 0.99


def test_mmt300_reaches_the_end_of_the_published_tables_at_full_code(
    vehicles: dict[str, Vehicle],
) -> None:
    """2.0 m/s if the inflow is the vehicle's speed (the paper), 2.06 m/s if its part along the axis

    of the thruster.
    """
    model = model_of(vehicles["mmt300"])
    speeds = sorted(truth.TABLE2)
    full = [truth.table2_thrust(127.0, speed) for speed in speeds]
    cosine = np.cos(np.radians(22.5))

    def excess_n(speed_mps: float, share: float) -> float:
        inflow = speed_mps * share
        slope = (full[-1] - full[-2]) / (speeds[-1] - speeds[-2])
        thrust = np.interp(inflow, speeds, full) + slope * max(0.0, inflow - speeds[-1])
        return float(4 * thrust * cosine - drag_n(model, speed_mps))

    assert brentq(excess_n, 0.5, 3.0, args=(1.0,)) == pytest.approx(2.0, abs=0.01)
    assert brentq(excess_n, 0.5, 3.0, args=(cosine,)) == pytest.approx(2.06, abs=0.02)
    assert isinstance(model.thrusters["at_drive"].characteristic, FromTables)


def test_rov8_reaches_the_speed_that_its_identified_drag_allows(
    vehicles: dict[str, Vehicle],
) -> None:
    model = model_of(vehicles["rov8"])
    push_n = 4 * bollard_of(vehicles["rov8"], "t200_esc").thrust_max_n * np.sqrt(0.5)
    assert brentq(lambda u: push_n - drag_n(model, u), 0.1, 3.0) == pytest.approx(0.97, abs=0.01)


def test_cargo_carrier_reaches_1_mps_and_can_hold_itself_down_without_payload(
    vehicles: dict[str, Vehicle],
) -> None:
    vehicle = vehicles["cargo_carrier"]
    motor = bollard_of(vehicle, "dc_motor")

    def excess_n(speed_mps: float) -> float:
        share = 1 - speed_mps * np.sqrt(0.5) / motor.zero_thrust_speed_mps
        thrust_n = 4 * np.sqrt(0.5) * motor.thrust_max_n * share
        return float(thrust_n - drag_n(model_of(vehicle), speed_mps))

    assert brentq(excess_n, 0.1, 3.0) == pytest.approx(0.95, abs=0.05)
    bare_n, _, _ = statics(vehicle, payloads=False)
    assert -4 * motor.thrust_min_n > 2 * bare_n


def test_mmt300_hull_estimates_follow_from_its_sections(vehicles: dict[str, Vehicle]) -> None:
    """Volume, centroid and inertia of cones between the stations; drag of the strips."""
    vehicle = vehicles["mmt300"]
    model, rho = model_of(vehicle), vehicle.water.density_kgpm3
    body, crossflow = model.rigid_body, model.crossflow
    assert crossflow is not None
    x, breadth = stations(crossflow)
    radius = breadth / 2
    area = np.pi * radius**2
    volume = np.trapezoid(area, x)
    assert body.displaced_volume_m3 == pytest.approx(volume, rel=0.002)
    assert np.trapezoid(area * x, x) / volume == pytest.approx(0.0, abs=0.001)
    solid = body.mass_kg / volume
    roll = solid * np.trapezoid(np.pi * radius**4 / 2, x)
    pitch = solid * np.trapezoid(np.pi * radius**4 / 4 + area * x**2, x)
    assert body.inertia_kgm2[:3] == pytest.approx((roll, pitch, pitch), rel=0.01)
    half = 0.5 * rho * crossflow.drag_coefficient
    across = half * np.trapezoid(breadth, x)
    turning = half * np.trapezoid(breadth * np.abs(x) ** 3, x)
    quadratic = np.array(model.damping.quadratic)
    assert quadratic[[SWAY, HEAVE, PITCH, YAW]] == pytest.approx(
        [across, across, turning, turning], rel=0.005
    )


def test_mmt300_added_mass_is_lambs_spheroid_of_its_length_and_volume(
    vehicles: dict[str, Vehicle],
) -> None:
    vehicle = vehicles["mmt300"]
    model = model_of(vehicle)
    assert model.crossflow is not None
    places = [section.x_m for section in model.crossflow.sections]
    half = (max(places) - min(places)) / 2
    radius = np.sqrt(3 * model.rigid_body.displaced_volume_m3 / (4 * np.pi * half))
    lamb = np.diag(ellipsoid_added_mass((half, radius, radius), vehicle.water.density_kgpm3))
    found = np.array(model.added_mass.diagonal)
    still = [SURGE, SWAY, HEAVE, PITCH, YAW]
    assert found[still] == pytest.approx(lamb[still], rel=0.003)


def test_mmt300_lift_is_that_of_pilgrim_scaled_by_the_arms(vehicles: dict[str, Vehicle]) -> None:
    vehicle = vehicles["mmt300"]
    lift, allocator = model_of(vehicle).lift, vehicle.allocator
    assert lift is not None
    assert allocator is not None
    scale = allocator.stern_arm_m / 2.0  # L_psi of Kostenko 2017, Table 1
    assert lift.speed_mps == 3.0
    assert lift.heave_n_per_rad == pytest.approx(1375 * scale**2, rel=0.001)
    assert lift.pitch_nm_per_rad == pytest.approx(731 * scale**3, rel=0.001)
    assert (lift.sway_n_per_rad, lift.yaw_nm_per_rad) == (
        lift.heave_n_per_rad,
        lift.pitch_nm_per_rad,
    )


@pytest.mark.parametrize("speed_mps", [0.25, 0.5, 1.0, 1.5, 2.0])
def test_mmt300_runs_straight(vehicles: dict[str, Vehicle], speed_mps: float) -> None:
    """Sway and yaw of the hull alone, linear in drift and rate, settle at every speed."""
    model = model_of(vehicles["mmt300"])
    lift = model.lift
    assert lift is not None
    matrix = mass_matrix(model)
    slope = np.array([lift.sway_n_per_rad, lift.yaw_nm_per_rad]) / lift.speed_mps**2 * speed_mps
    damping = model.damping.linear
    # the moment holds Munk's already: of the Coriolis terms -(m + A_11) u r in sway is left
    force = np.array(
        [
            [-slope[0] - damping[SWAY], -matrix[SURGE, SURGE] * speed_mps],
            [slope[1], -damping[YAW]],
        ]
    )
    system = np.linalg.solve(matrix[np.ix_([SWAY, YAW], [SWAY, YAW])], force)
    assert np.linalg.eigvals(system).real.max() < -0.05


def test_cargo_carrier_estimates_follow_from_its_box(vehicles: dict[str, Vehicle]) -> None:
    vehicle = vehicles["cargo_carrier"]
    model, rho = model_of(vehicle), vehicle.water.density_kgpm3
    sides = np.array([1.2, 0.8, 0.6])
    squares = sides**2
    body = model.rigid_body
    inertia = body.mass_kg / 12 * (squares.sum() - squares)
    assert body.inertia_kgm2[:3] == pytest.approx(inertia, rel=0.005)
    found = np.array(model.added_mass.diagonal)
    # plates of DNV-RP-H103 (2011), table A-2, thickened as in its 4.6.3.3
    assert found[:3] == pytest.approx([247.58, 405.17, 627.70], rel=0.002)
    scale = (6.0 / np.pi) ** (1 / 3)  # ellipsoid with the volume of the box
    semi = sides / 2 * scale
    lamb = np.diag(ellipsoid_added_mass((semi[0], semi[1], semi[2]), rho))
    assert found[3:] == pytest.approx(lamb[3:], rel=0.015)
    faces = 0.5 * rho * sides.prod() / sides
    assert model.damping.quadratic[:3] == pytest.approx(faces, rel=0.001)
    fourths = sides**4
    turning = rho / 64 * sides * (fourths.sum() - fourths)
    assert model.damping.quadratic[3:] == pytest.approx(turning, rel=0.005)
    for payload in model.payloads:
        radius, volume = 0.125, payload.volume_m3
        height = volume / (np.pi * radius**2)
        across = payload.mass_kg / 12 * (3 * radius**2 + height**2)
        about = payload.mass_kg * radius**2 / 2
        assert payload.inertia_kgm2 == pytest.approx((across, across, about), abs=0.006)


@pytest.mark.parametrize(("name", "drive"), [("rov8", "t200_esc"), ("cargo_carrier", "dc_motor")])
def test_zero_thrust_speed_follows_from_the_loading(
    vehicles: dict[str, Vehicle], name: str, drive: str
) -> None:
    """V_0 = J_0 / D sqrt(T / (K_T rho)) with J_0 = 0.85 and K_T = 0.44."""
    vehicle = vehicles[name]
    found = bollard_of(vehicle, drive)
    loading = found.thrust_max_n / (0.44 * vehicle.water.density_kgpm3)
    expected = 0.85 / vehicle.propeller.diameter_m * np.sqrt(loading)
    assert found.zero_thrust_speed_mps == pytest.approx(expected, rel=0.01)


def test_terms_and_surroundings_are_those_that_the_effects_need(
    vehicles: dict[str, Vehicle],
) -> None:
    assert model_of(vehicles["mmt300"]).terms.thrust_falls_with_speed
    assert not model_of(vehicles["rov8"]).terms.thrust_falls_with_speed
    rov8, cargo = model_of(vehicles["rov8"]), model_of(vehicles["cargo_carrier"])
    assert rov8.tether is not None
    assert not rov8.tether.in_nominal
    assert cargo.tether is not None
    assert cargo.tether.in_nominal
    assert len(cargo.payloads) == 2
    assert all(payload.attached for payload in cargo.payloads)


def test_the_pool_of_rov8_is_closed_and_holds_vehicle_and_tether(
    vehicles: dict[str, Vehicle],
) -> None:
    model = model_of(vehicles["rov8"])
    assert model.pool is not None
    assert model.tether is not None
    middle = np.array([0.0, 0.0, 1.5])
    for wall in model.pool.walls:
        clearance = (middle - np.array(wall.point_ned_m)) @ np.array(wall.normal_ned)
        assert clearance > 4 * model.pool.vehicle_radius_m
    corners = np.array([[5.0, y, z] for y in (-2.5, 2.5) for z in (0.0, 3.0)])
    reach = np.linalg.norm(corners - np.array(model.tether.anchor_ned_m), axis=1).max()
    assert reach < model.tether.length_m
