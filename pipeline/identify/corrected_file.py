"""What goes into a corrected vehicle file, as which keys, and whether it predicts well enough."""

from collections.abc import Sequence

import numpy as np

from pipeline.identify.output_error import FitSolution
from pipeline.identify.vehicle_parameters import free_parameters, values_from_steps
from pipeline.identify.window_derivatives import FitProblem
from pipeline.records.identification import ChannelQuality, IdentifiedParameter, ThrustFound
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.unpack import changed_keys
from pipeline.types import FloatArray
from pipeline.vehicle.estimates import share_changes
from pipeline.vehicle.frames import Change, changes_as_stated
from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.schema import Vehicle

#: Why there is none where none was asked for.
NOT_CORRECTED = "no corrected file was fitted"
#: What a vehicle file is for first: where one of these was measured, the others are only told.
FIRST = ("velocity", "angular_velocity")
#: Beyond this share more error on windows that took no part a channel is predicted worse.
WORSE = 0.05


def steps_of_file(
    solution: FitSolution, found: Sequence[IdentifiedParameter], thrust: Sequence[ThrustFound]
) -> FloatArray:
    """Unknowns (p + q,) of a file that has what stands and the factors of the thrusters, as found.

    What does not stand is as the file before has it, and so are the curves of the thrust.
    """
    parameters = solution.problem.parameters
    own = [
        (one.value - parameter.nominal) / parameter.prior_std if one.stands else 0.0
        for parameter, one in zip(parameters, found, strict=True)
    ]
    factors = [(one.value - 1.0) / one.prior_std if one.unit == "1" else 0.0 for one in thrust]
    return np.array([*own, *factors])


def as_filed(
    problem: FitProblem,
    steps: FloatArray | None,
    found: Sequence[IdentifiedParameter],
    thrust: Sequence[ThrustFound],
) -> tuple[tuple[IdentifiedParameter, ...], tuple[ThrustFound, ...]]:
    """Add to parameters and thrust the values that the corrected vehicle file has."""
    if steps is None:
        return tuple(found), tuple(thrust)
    values = values_from_steps(problem.parameters, steps[: len(found)]).tolist()
    moved = (problem.thrust.scales * steps[len(found) :]).tolist()
    return (
        tuple(
            one.model_copy(update={"file_value": value})
            for one, value in zip(found, values, strict=True)
        ),
        tuple(
            one.model_copy(update={"file_value": by + (1.0 if one.unit == "1" else 0.0)})
            for one, by in zip(thrust, moved, strict=True)
        ),
    )


def worse_than_before(quality: Sequence[ChannelQuality]) -> str:
    """Say why a corrected file is not to be used; empty where it predicts no worse than before.

    Errors on windows that took no part, of velocity and angular velocity where they were measured:
    none may be larger by more than `WORSE`, nor all together (mean of the logarithms of the
    ratios). Nor may all channels together be predicted worse.
    """
    if not quality:
        return (
            "no window was left to judge it by; give longer runs, or a run that is kept out of the "
            "fit (--holdout RUN)"
        )
    first = [one for one in quality if one.channel in FIRST] or list(quality)
    for one in first:
        if one.rmse_corrected_file is None:
            return f"with it the prediction of {one.channel} runs away"
        if one.rmse_vehicle_file is not None and _ratio(one) > 1.0 + WORSE:
            return _told(one)
    for part in (first, quality):
        if np.mean([np.log(_ratio(one)) for one in part]) > 0.0:
            return _told(max(part, key=_ratio))
    return ""


def channels_worse(quality: Sequence[ChannelQuality]) -> tuple[str, ...]:
    """Name the channels that a file which is good enough predicts worse than the one before."""
    worse = [one.channel for one in quality if _ratio(one) > 1.0 + WORSE]
    if not worse:
        return ()
    return (
        (
            f"The corrected vehicle file predicts {', '.join(worse)} worse than the file before, "
            "and the rest better."
        ),
    )


def _ratio(one: ChannelQuality) -> float:
    """Error of the corrected file over that of the one before, the sensor's noise in both."""
    after, before = one.rmse_corrected_file, one.rmse_vehicle_file
    if before is None:
        # whatever does not run away is better
        return 1.0
    if after is None:
        return 10.0
    return float(np.hypot(after, one.sensor_noise) / np.hypot(before, one.sensor_noise))


def _told(one: ChannelQuality) -> str:
    return (
        f"it predicts {one.channel} worse than the file before on data not used for the fit: "
        f"{one.rmse_corrected_file or 0.0:.3g} against {one.rmse_vehicle_file or 0.0:.3g} "
        f"{one.unit} (rms) over {one.horizon_s:.0f} s"
    )


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
