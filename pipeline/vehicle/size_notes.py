"""Are masses, inertias and places of the model of one size? A slip of a unit shows by a factor."""

import math

from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.schema import Vector3, Vehicle

#: Weight and buoyancy may differ by this share of the weight, before it is mentioned.
_TRIM_SHARE = 0.3
#: Places and radii of gyration may be this many edges of a cube of water of the vehicle's mass. A
#: hull of 20 diameters has its ends at 4 from its middle and a radius of gyration of 2.3.
_EDGES = 10.0
#: The same where no mass is known. [m]
_FAR_M = 20.0


def size_notes(vehicle: Vehicle) -> tuple[str, ...]:
    """List what is so large or small that a unit may have slipped.

    Parameters
    ----------
    vehicle : Vehicle
        A checked vehicle file.

    Returns
    -------
    tuple of str
        One sentence or two for each finding; empty if all is of one size.
    """
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
