"""A vehicle of the truth: from the vehicle file to the numbers of the kernel, as plain data."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pipeline.blind.truth.drive_laws import DriveLaw, drive_law
from pipeline.blind.truth.kernel_forces import Truth
from pipeline.errors import CannotComputeError
from pipeline.records.fits import StaticCharacteristic
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Model, Vector6
from pipeline.vehicle.schema import Vehicle

#: Strips between the stations of a hull.
STRIPS = 60


@dataclass(frozen=True)
class DvlFault:
    """What is wrong with a DVL: scale, turn [deg], delay [s], place [m]."""

    scale: float = 1.0
    turn_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    delay_s: float = 0.0
    place_m: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Craft:
    """A vehicle and its surroundings as they are; SI, SNAME axes, origin that of the vehicle file.

    `inertia` (3, 3) is about the centre of mass; `added`, `linear` (6, 6), `quadratic` (6,);
    `gain`, `reverse`, `inflow`, `dead`, `lag_s` (n,) of the thrusters, the lag on top of the
    stated one; `azimuth`, `elevation` (n,) [rad]; `lift` (4,): heave, pitch, sway, yaw of
    forces at their places; `turning` (2,): pitch and yaw of what turns over with the course; `munk`
    (2,): what the file's slopes hold of Munk's.
    """

    names: tuple[str, ...]
    mass_kg: float
    centre_g: FloatArray
    inertia: FloatArray
    buoyancy_n: float
    centre_b: FloatArray
    density: float
    gravity: float
    added: FloatArray
    linear: FloatArray
    quadratic: FloatArray
    strips: FloatArray
    lift: FloatArray
    turning: FloatArray
    munk: FloatArray
    coriolis: float
    crossflow: float
    current: FloatArray
    walls: FloatArray
    wall_radius_m: float
    wall_strength: float
    tow: FloatArray
    tow_area_m2: float
    tow_pull_n: float
    supply_drop: float
    load_drop: float
    laws: tuple[DriveLaw, ...]
    kind: tuple[int, ...]
    place: FloatArray
    push: FloatArray
    gain: FloatArray
    reverse: FloatArray
    inflow: FloatArray
    dead: FloatArray
    lag_s: FloatArray
    azimuth: FloatArray
    elevation: FloatArray
    code_max: FloatArray
    trouble: FloatArray = field(default_factory=lambda: np.zeros(16))
    dvl: DvlFault = DvlFault()

    def changed(self, **values: Any) -> "Craft":  # noqa: ANN401 (fields of any type)
        """Return a craft with other values."""
        return replace(self, **values)


def craft_of(vehicle: Vehicle, static: StaticCharacteristic | None = None) -> Craft:
    """Build the vehicle exactly as its file states it.

    `static` is the bench's family, for thrusters of the kind ``tables``.
    """
    model = vehicle.model
    if model is None:
        raise CannotComputeError(f"{vehicle.name} has no model: section, so it cannot be flown")
    kinds: list[tuple[str, str]] = []
    for one in vehicle.thrusters:
        if (one.drive, one.propeller) not in kinds:
            kinds.append((one.drive, one.propeller))
    count = len(vehicle.thrusters)
    push = np.array([one.direction for one in vehicle.thrusters], float).reshape(-1, 3)
    place = np.array([one.position_m for one in vehicle.thrusters], float).reshape(-1, 3)
    body = _body(model, vehicle.water.density_kgpm3, vehicle.water.gravity_mps2)
    walls = model.pool.walls if model.pool is not None else ()
    tether = model.tether
    tow = (*tether.attachment_m, *tether.anchor_ned_m) if tether is not None else (0.0,) * 6
    stations = [] if model.crossflow is None else [one.x_m for one in model.crossflow.sections]
    one_end = max((abs(x) for x in (*place[:, 0], *stations)), default=0.0)
    return Craft(
        names=tuple(one.name for one in vehicle.thrusters),
        density=vehicle.water.density_kgpm3,
        gravity=vehicle.water.gravity_mps2,
        **body,
        added=added_of(model),
        linear=np.diag(model.damping.linear),
        quadratic=np.array(model.damping.quadratic),
        strips=_strips(model),
        **_lift(model, one_end),
        coriolis=1.0 if model.terms.coriolis else 0.0,
        crossflow=1.0 if model.crossflow is not None and model.crossflow.in_nominal else 0.0,
        current=np.zeros(3),
        walls=np.array([(*w.point_ned_m, *w.normal_ned) for w in walls], float).reshape(-1, 6),
        wall_radius_m=model.pool.vehicle_radius_m if model.pool is not None else 1.0,
        wall_strength=0.0,
        tow=np.array(tow, float),
        tow_area_m2=0.0,
        tow_pull_n=0.0,
        supply_drop=0.0,
        load_drop=0.0,
        laws=tuple(drive_law(vehicle, *kind, static) for kind in kinds),
        kind=tuple(kinds.index((one.drive, one.propeller)) for one in vehicle.thrusters),
        place=place,
        push=push / np.linalg.norm(push, axis=1, keepdims=True),
        gain=np.ones(count),
        reverse=np.ones(count),
        inflow=np.full(count, 1.0 if model.terms.thrust_falls_with_speed else 0.0),
        dead=np.zeros(count),
        lag_s=np.zeros(count),
        azimuth=np.zeros(count),
        elevation=np.zeros(count),
        code_max=np.array([vehicle.drives[one.drive].code_max for one in vehicle.thrusters], float),
    )


def added_of(model: Model) -> FloatArray:
    """Return the added mass of the model (6, 6)."""
    if model.added_mass.diagonal is not None:
        return np.diag(model.added_mass.diagonal)
    return np.array(model.added_mass.matrix)


def _body(model: Model, density: float, gravity: float) -> dict[str, Any]:
    """Mass, centres, inertia and buoyancy of the body with all that it carries."""
    dry = model.rigid_body
    masses = [(dry.mass_kg, np.array(dry.centre_of_mass_m), _tensor(dry.inertia_kgm2))]
    volumes = [(dry.displaced_volume_m3, np.array(dry.centre_of_buoyancy_m))]
    for carried in model.on_board:
        at = np.array(carried.position_m)
        masses.append((carried.mass_kg, at, np.diag(carried.inertia_kgm2)))
        volumes.append((carried.volume_m3, at))
    mass = sum(m for m, _, _ in masses)
    volume = sum(v for v, _ in volumes)
    centre = sum((m * at for m, at, _ in masses), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for m, at, own in masses:
        inertia += own + m * spread(at - centre)
    return {
        "mass_kg": mass,
        "centre_g": centre,
        "inertia": inertia,
        "buoyancy_n": density * gravity * volume,
        "centre_b": sum((v * at for v, at in volumes), np.zeros(3)) / volume,
    }


def spread(arm: FloatArray) -> FloatArray:
    """Inertia [m^2] of a unit mass at an arm (3, 3): Steiner's part."""
    return np.asarray(np.eye(3) * (arm @ arm) - np.outer(arm, arm))


def _tensor(entries: Vector6) -> FloatArray:
    xx, yy, zz, xy, xz, yz = entries
    return np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]])


def _lift(model: Model, end_m: float) -> dict[str, Any]:
    """Slopes over the speed squared: what a force makes at most at an end, and the rest."""
    lift = model.lift
    if lift is None:
        return {"lift": np.zeros(4), "turning": np.zeros(2), "munk": np.zeros(2)}
    square = lift.speed_mps**2
    surge, sway, heave = np.diag(added_of(model))[:3]
    munk = np.array([heave - surge, surge - sway]) * lift.includes_munk
    up, aside = lift.heave_n_per_rad / square, lift.sway_n_per_rad / square
    whole = np.array([-lift.pitch_nm_per_rad, lift.yaw_nm_per_rad]) / square
    at_place = [
        float(np.sign(m)) * min(abs(float(m)), abs(f) * end_m)
        for m, f in zip(whole - munk, (up, aside), strict=True)
    ]
    makes = munk if model.terms.coriolis else np.zeros(2)
    return {
        "lift": np.array([up, at_place[0], aside, at_place[1]]),
        "turning": whole - makes - np.array(at_place),
        "munk": munk,
    }


def _strips(model: Model) -> FloatArray:
    """Many even strips (k, 3) by the rule of the middle: station, C_d H dx, C_d B dx."""
    if model.crossflow is None:
        return np.zeros((0, 3))
    stations = sorted(model.crossflow.sections, key=lambda one: one.x_m)
    x = np.array([one.x_m for one in stations])
    edges = np.linspace(x[0], x[-1], STRIPS + 1)
    middle = 0.5 * (edges[1:] + edges[:-1])
    area = model.crossflow.drag_coefficient * (edges[1] - edges[0])
    height = np.interp(middle, x, [one.height_m for one in stations])
    breadth = np.interp(middle, x, [one.breadth_m for one in stations])
    return np.stack([middle, area * height, area * breadth], axis=1)


def rigid_of(craft: Craft) -> FloatArray:
    """Inertia of the body about the origin (6, 6)."""
    m, g = craft.mass_kg, craft.centre_g
    cross = np.array([[0.0, -g[2], g[1]], [g[2], 0.0, -g[0]], [-g[1], g[0], 0.0]])
    top = np.concatenate([m * np.eye(3), -m * cross], axis=1)
    low = np.concatenate([m * cross, craft.inertia + m * spread(g)], axis=1)
    return np.concatenate([top, low])


def pushes_of(craft: Craft) -> FloatArray:
    """Directions (n, 3) in which the thrusters push, their mounts turned."""
    turned = np.empty_like(craft.push)
    for i, ahead in enumerate(craft.push):
        level = np.array([-ahead[1], ahead[0], 0.0])
        size = float(np.linalg.norm(level))
        side = level / size if size > 1e-6 else np.array([0.0, 1.0, 0.0])
        under = np.cross(ahead, side)
        a, e = craft.azimuth[i], craft.elevation[i]
        turned[i] = np.cos(e) * (np.cos(a) * ahead + np.sin(a) * side) - np.sin(e) * under
    return turned


def truth_of(craft: Craft) -> Truth:
    """Pack a craft for the kernel."""
    laws = craft.laws
    shape = tuple(max(law.steady.shape[k] for law in laws) for k in (0, 1))
    steady = np.zeros((len(laws), *shape))
    motor = np.zeros((len(laws), shape[1]))
    for k, law in enumerate(laws):
        rows, columns = law.steady.shape
        steady[k, :rows, :columns] = law.steady
        steady[k, rows:, :columns] = law.steady[-1]
        motor[k, : law.motor.size] = law.motor[: shape[1]]
    mine = [laws[k] for k in craft.kind]
    n = len(mine)
    screws = np.stack(
        [
            np.array([law.mode for law in mine]),
            # a late thrust is a slower ramp of the controller, before the shaft
            np.array([law.code_lag_s for law in mine]) + craft.lag_s,
            np.array([law.shaft_lag_s for law in mine]),
            craft.gain,
            craft.reverse,
            craft.inflow,
            craft.dead,
            craft.code_max,
            np.array(craft.kind, float),
            np.array([law.rotor_kgm2 for law in mine]),
        ],
        axis=1,
    ).reshape(n, 10)
    scalars = np.array(
        [
            craft.mass_kg * craft.gravity,
            craft.buoyancy_n,
            craft.density,
            craft.coriolis,
            craft.crossflow,
            craft.wall_strength,
            craft.wall_radius_m,
            craft.tow_area_m2,
            craft.tow_pull_n,
            craft.supply_drop,
            craft.load_drop,
            craft.gravity,
        ]
    )
    return Truth(
        rigid_of(craft),
        craft.added,
        craft.linear,
        craft.quadratic,
        craft.strips,
        craft.lift,
        craft.turning,
        scalars,
        craft.centre_g,
        craft.centre_b,
        craft.current,
        craft.walls,
        craft.place,
        pushes_of(craft),
        screws,
        np.stack([law.law for law in laws]),
        steady,
        motor,
        craft.tow,
        craft.trouble,
    )
