"""Does the vehicle file agree with itself? Thrusters against the allocator, and sizes."""

import math

from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.schema import Allocator, Thruster, Vector3, Vehicle

#: Weight and buoyancy may differ by this share of the weight, before it is mentioned.
_TRIM_SHARE = 0.3
#: Places and radii of gyration may be this many edges of a cube of water of the vehicle's mass. A
#: hull of 20 diameters has its ends at 4 from its middle and a radius of gyration of 2.3.
_EDGES = 10.0
#: The same where no mass is known. [m]
_FAR_M = 20.0

#: Largest angle between a thruster and the direction that (5) gives it, before it is mentioned.
_ANGLE_DEG = 1.0
#: Largest relative difference of a lever arm, before it is mentioned.
_ARM_SHARE = 0.02


def size_notes(vehicle: Vehicle) -> tuple[str, ...]:
    """List what is so large or small that a unit may have slipped, a sentence or two for each."""
    model = vehicle.model
    places: dict[str, Vector3] = {
        f"thruster {one.name}: position_m": one.position_m for one in vehicle.thrusters
    }
    if model is None:
        return tuple(_far(places, _FAR_M))
    body = model.rigid_body
    places["model.rigid_body.centre_of_mass_m"] = body.centre_of_mass_m
    places["model.rigid_body.centre_of_buoyancy_m"] = body.centre_of_buoyancy_m
    far_m = _EDGES * (body.mass_kg / vehicle.water.density_kgpm3) ** (1.0 / 3.0)
    notes = [*_trim(model, vehicle.water.density_kgpm3), *_far(places, far_m)]
    radius_m = math.sqrt(max(body.inertia_kgm2[:3]) / body.mass_kg)
    if radius_m > far_m:
        notes.append(
            f"model.rigid_body.inertia_kgm2: the radius of gyration is {radius_m:.3g} m, for "
            f"{body.mass_kg:g} kg. Check the unit, kg m^2."
        )
    return tuple(notes)


def _trim(model: Model, density_kgpm3: float) -> list[str]:
    """Compare what the vehicle displaces with its mass, modules on board included."""
    body = model.rigid_body
    on_board = model.on_board
    mass = body.mass_kg + sum(one.mass_kg for one in on_board)
    displaced = density_kgpm3 * (body.displaced_volume_m3 + sum(one.volume_m3 for one in on_board))
    if abs(displaced - mass) <= _TRIM_SHARE * mass:
        return []
    way = "shoots up" if displaced > mass else "goes down"
    note = (
        f"model.rigid_body: {mass:.4g} kg displace {displaced:.4g} kg of water, so the vehicle "
        f"{way}. Check mass_kg and displaced_volume_m3; a litre is 0.001 m^3."
    )
    return [note]


def _far(places: dict[str, Vector3], far_m: float) -> list[str]:
    """Name the places that are far from the origin for the vehicle's size."""
    return [
        f"{what} is {math.hypot(*place):.3g} m from the origin. Check the unit, m."
        for what, place in places.items()
        if math.hypot(*place) > far_m
    ]


def vehicle_notes(vehicle: Vehicle) -> tuple[str, ...]:
    r"""List what does not fit together in a vehicle file that is otherwise valid.

    In SNAME axes (5) of the paper says of the stern group, per newton of thrust: the upper and
    the lower one push :math:`(\cos\delta, 0, \mp\sin\delta)`, the left and the right one
    :math:`(\cos\delta, \mp\sin\delta, 0)`, the bow one :math:`(0, 0, -1)`; pitch and yaw moments
    are :math:`\sin\delta\, L_s` and :math:`L_b` in size, there is no roll moment.

    References
    ----------
    Kostenko 2023, fig. 8, eq. (5); the papers' body frame is x forward, y up, z starboard.
    """
    by_name = {thruster.name: thruster for thruster in vehicle.thrusters}
    tables = " and ".join(f"{propeller} with {drive}" for drive, propeller in vehicle.kinds)
    notes = [
        f"thruster {one.name} has propeller {one.propeller} and drive {one.drive}; the tables are "
        f"computed for {tables} and do not hold for it."
        for one in vehicle.thrusters
        if vehicle.type_of(one) is None
    ]
    notes += size_notes(vehicle)
    model = vehicle.model
    if model is not None and not model.terms.thrust_falls_with_speed:
        wake = model.wake_fraction
        if wake.value != 0.0 or wake.thrusters:
            notes.append(
                "model.wake_fraction has no effect while model.terms.thrust_falls_with_speed is "
                "false: the thrust is that at rest."
            )
    allocator = vehicle.allocator
    if allocator is None:
        return tuple(notes)
    roles = {role: getattr(allocator, role) for role in ("upper", "lower", "left", "right", "bow")}
    named = [name for name in roles.values() if name is not None]
    for name in sorted({name for name in named if named.count(name) > 1}):
        held = ", ".join(role for role, one in roles.items() if one == name)
        notes.append(f"allocator: thruster {name} is named for {held}; each needs its own.")
    for role, name in roles.items():
        if name is not None:
            notes += _against_allocator(role, by_name[name], allocator)
    unused = [name for name in by_name if name not in named]
    if unused:
        notes.append(f"allocator: it does not use the thrusters {', '.join(unused)}.")
    if allocator.bow is not None and allocator.bow_arm_m is None:
        notes.append(
            f"allocator: bow thruster {allocator.bow} has no bow_arm_m; state it, or its pitch "
            "moment is left out."
        )
    return tuple(notes)


def opposed_thrusters(vehicle: Vehicle) -> tuple[str, ...]:
    """Name the thrusters that push away from where the allocator takes them to push.

    More than a right angle apart: with such a thruster every loop that is closed over it runs
    away, so the simulation refuses the vehicle.
    """
    allocator = vehicle.allocator
    if allocator is None:
        return ()
    by_name = {thruster.name: thruster for thruster in vehicle.thrusters}
    roles = {role: getattr(allocator, role) for role in ("upper", "lower", "left", "right", "bow")}
    return tuple(
        name
        for role, name in roles.items()
        if name is not None
        and sum(
            a * b for a, b in zip(by_name[name].direction, _expected(role, allocator), strict=True)
        )
        < 0.0
    )


def _expected(role: str, allocator: Allocator) -> Vector3:
    """Direction that (5) gives the thruster of a role."""
    delta = math.radians(allocator.delta_deg)
    cosine, sine = math.cos(delta), math.sin(delta)
    directions: dict[str, Vector3] = {
        "upper": (cosine, 0.0, -sine),
        "lower": (cosine, 0.0, sine),
        "left": (cosine, -sine, 0.0),
        "right": (cosine, sine, 0.0),
        "bow": (0.0, 0.0, -1.0),
    }
    return directions[role]


def _against_allocator(role: str, thruster: Thruster, allocator: Allocator) -> list[str]:
    """Compare one thruster with what the allocator assumes of its role."""
    sine = math.sin(math.radians(allocator.delta_deg))
    expected = _expected(role, allocator)
    what = f"thruster {thruster.name} ({role})"
    inner = sum(a * b for a, b in zip(thruster.direction, expected, strict=True))
    length = math.sqrt(sum(part * part for part in thruster.direction))
    angle_deg = math.degrees(math.acos(max(-1.0, min(1.0, inner / length))))
    if angle_deg > _ANGLE_DEG:
        wanted = ", ".join(f"{part:.4g}" for part in expected)
        hint = " It is opposite: check the sign." if angle_deg > 179.0 else ""
        text = (
            f"{what}: direction is {angle_deg:.1f} deg away from [{wanted}], which the allocator "
            f"assumes with delta_deg = {allocator.delta_deg:g}.{hint}"
        )
        return [text]
    roll, pitch, yaw = _moment(thruster.position_m, thruster.direction)
    # Signs of (5) in SNAME: pitch M = M_z, yaw N = -M_y.
    arm, key, stated, size = {
        "upper": (-pitch / sine, "stern_arm_m", allocator.stern_arm_m, "pitch"),
        "lower": (pitch / sine, "stern_arm_m", allocator.stern_arm_m, "pitch"),
        "left": (yaw / sine, "stern_arm_m", allocator.stern_arm_m, "yaw"),
        "right": (-yaw / sine, "stern_arm_m", allocator.stern_arm_m, "yaw"),
        "bow": (pitch, "bow_arm_m", allocator.bow_arm_m, "pitch"),
    }[role]
    notes = []
    if stated is not None and abs(arm - stated) > _ARM_SHARE * stated:
        notes.append(
            f"{what}: position and direction give a {size} arm of {arm:.3f} m, allocator."
            f"{key} is {stated:g} m. The tables use the allocator's."
        )
    if abs(roll) > _ARM_SHARE * allocator.stern_arm_m:
        notes.append(f"{what}: it makes a roll moment of {roll:.3f} N m per newton, (5) has none.")
    return notes


def _moment(position_m: Vector3, direction: Vector3) -> Vector3:
    """Return position x direction: the moment per newton of thrust. [m]."""
    (x, y, z), (a, b, c) = position_m, direction
    return (y * c - z * b, z * a - x * c, x * b - y * a)
