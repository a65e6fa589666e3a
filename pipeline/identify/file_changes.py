"""Which keys of the vehicle file an identification changes, and to what."""

from pipeline.identify.vehicle_parameters import free_parameters
from pipeline.records.identification import IdentifiedParameter, ThrustFound
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.unpack import changed_keys
from pipeline.vehicle.estimates import share_changes
from pipeline.vehicle.frames import Change, changes_as_stated
from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.schema import Vehicle

#: Has a width of its own in the file, and is written with that.
_WAKE = "wake_fraction"


def file_changes(
    vehicle: Vehicle,
    model: Model,
    packed: PackedVehicle,
    found: tuple[IdentifiedParameter, ...],
    thrust: tuple[ThrustFound, ...] = (),
) -> dict[str, Change]:
    """Say what to change in the vehicle file so that it gives the identified model.

    Written is what stands, with the values of the fit in which everything else was held at what the
    file says; the factors of the thrusters become their thrust deduction. Keys are dotted paths in
    the axes of the file.
    """
    values = {
        one.name: one.value if one.file_value is None else one.file_value
        for one in found
        if one.stands
    }
    vector = packed.vector.copy()
    for one in free_parameters(packed, model.uncertainty):
        if one.name in values and one.name != _WAKE:
            least = values[one.name] if one.lowest is None else one.lowest
            one.write(vector, max(values[one.name], least))
    changes = changed_keys(vehicle, model, packed, vector)
    return changes_as_stated(changes | _shares(vehicle, model, found, thrust), vehicle.frame)


def _shares(
    vehicle: Vehicle,
    model: Model,
    found: tuple[IdentifiedParameter, ...],
    thrust: tuple[ThrustFound, ...],
) -> dict[str, Change]:
    """Wake fraction with its standard uncertainty, and the thrust that each thruster has left."""
    names = [one.name for one in vehicle.thrusters]
    changes: dict[str, Change] = {}
    for one in found:
        if one.name == _WAKE and one.stands and one.prior_value < 1.0:
            value = one.value if one.file_value is None else one.file_value
            by = (1.0 - value) / (1.0 - one.prior_value)
            left = [by * (1.0 - model.wake_fraction.of(name)) for name in names]
            changes |= share_changes(model.wake_fraction, names, left, one.std)
    factors = {one.name: one.file_value for one in thrust if one.file_value is not None}
    own = [factors.get(f"thrust_{name}", 1.0) for name in names]
    if any(factor != 1.0 for factor in own):
        stated = [1.0 - model.thrust_deduction.of(name) for name in names]
        left = [factor * share for factor, share in zip(own, stated, strict=True)]
        changes |= share_changes(model.thrust_deduction, names, left)
    return changes
