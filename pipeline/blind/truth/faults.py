"""The effects of the library once more, written for the truth: id and parameters to a craft.

Parameter names and units are those that ``rig2sea effects`` lists; nothing else is shared.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from pipeline.blind.truth.craft import Craft, DvlFault, spread
from pipeline.types import FloatArray

AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
Values = Mapping[str, float]
Change = Callable[[Craft, Values, int], Craft]


def with_fault(
    craft: Craft, effect: str, values: Mapping[str, float], thruster: str | None = None
) -> Craft:
    """Return the craft with an effect of the library at work.

    `values` are in the units of the library; those that are not named are neutral. `thruster` is
    which one, for effects of one thruster.
    """
    return FAULTS[effect](craft, values, craft.names.index(thruster) if thruster else -1)


def _adding(**fields: str | tuple[str, ...]) -> Change:
    """Add to fields of a craft the values of parameters; several make the entries of an array."""

    def change(craft: Craft, values: Values, _one: int) -> Craft:
        more = {
            field: values.get(names, 0.0)
            if isinstance(names, str)
            else np.array([values.get(one, 0.0) for one in names])
            for field, names in fields.items()
        }
        return craft.changed(**{field: getattr(craft, field) + by for field, by in more.items()})

    return change


def _factors(values: Values) -> FloatArray:
    return np.array([values.get(axis, 1.0) for axis in AXES])


def _added_mass(craft: Craft, values: Values, _one: int) -> Craft:
    root = np.diag(np.sqrt(_factors(values)))
    return craft.changed(added=root @ craft.added @ root)


def _linear(craft: Craft, values: Values, _one: int) -> Craft:
    root = np.diag(np.sqrt(_factors(values)))
    return craft.changed(linear=root @ craft.linear @ root)


def _quadratic(craft: Craft, values: Values, _one: int) -> Craft:
    return craft.changed(quadratic=craft.quadratic * _factors(values))


def _coriolis(craft: Craft, values: Values, _one: int) -> Craft:
    share = values["fraction"]
    # what the momenta make now is no part of the measured slopes any more
    return craft.changed(
        coriolis=craft.coriolis + share, turning=craft.turning - share * craft.munk
    )


def _lift(craft: Craft, values: Values, _one: int) -> Craft:
    heave, pitch, sway, yaw = (
        values.get(f"{name}_slope", 0.0) for name in ("heave", "pitch", "sway", "yaw")
    )
    # the moments are of the lee end, which changes sides with the course
    return craft.changed(
        lift=craft.lift + np.array([heave, 0.0, sway, 0.0]),
        turning=craft.turning + np.array([pitch, yaw]),
    )


def _payload(craft: Craft, values: Values, _one: int) -> Craft:
    at = np.array([values.get(name, 0.0) for name in ("x_m", "y_m", "z_m")])
    extra, floats = values.get("mass_kg", 0.0), values.get("volume_m3", 0.0)
    mass = craft.mass_kg + extra
    centre = (craft.mass_kg * craft.centre_g + extra * at) / mass
    inertia = craft.inertia + craft.mass_kg * spread(craft.centre_g - centre)
    inertia = inertia + extra * spread(at - centre)
    lift = floats * craft.density * craft.gravity
    buoyancy = craft.buoyancy_n + lift
    return craft.changed(
        mass_kg=mass,
        centre_g=centre,
        inertia=inertia,
        buoyancy_n=buoyancy,
        centre_b=(craft.buoyancy_n * craft.centre_b + lift * at) / buoyancy,
    )


def _reverse(craft: Craft, values: Values, _one: int) -> Craft:
    return craft.changed(reverse=craft.reverse * values["fraction"])


def _deduction(craft: Craft, values: Values, _one: int) -> Craft:
    return craft.changed(gain=craft.gain * (1.0 - values["t"]))


def _degraded(craft: Craft, values: Values, one: int) -> Craft:
    gain = craft.gain.copy()
    gain[one] *= values["thrust_fraction"]
    return craft.changed(gain=gain)


def _misaligned(craft: Craft, values: Values, one: int) -> Craft:
    azimuth, elevation = craft.azimuth.copy(), craft.elevation.copy()
    azimuth[one] += np.radians(values.get("azimuth_deg", 0.0))
    elevation[one] += np.radians(values.get("elevation_deg", 0.0))
    return craft.changed(azimuth=azimuth, elevation=elevation)


def _dvl_scale(craft: Craft, values: Values, _one: int) -> Craft:
    return craft.changed(dvl=replace(craft.dvl, scale=craft.dvl.scale * values["scale"]))


def _dvl_delay(craft: Craft, values: Values, _one: int) -> Craft:
    return craft.changed(dvl=replace(craft.dvl, delay_s=craft.dvl.delay_s + values["delay_s"]))


def _dvl_turn(craft: Craft, values: Values, _one: int) -> Craft:
    turn = tuple(values.get(name, 0.0) for name in ("roll_deg", "pitch_deg", "yaw_deg"))
    return craft.changed(dvl=replace(craft.dvl, turn_deg=_three(craft.dvl.turn_deg, turn)))


def _dvl_place(craft: Craft, values: Values, _one: int) -> Craft:
    shift = tuple(values.get(name, 0.0) for name in ("x_m", "y_m", "z_m"))
    return craft.changed(dvl=replace(craft.dvl, place_m=_three(craft.dvl.place_m, shift)))


def _three(a: tuple[float, ...], b: tuple[float, ...]) -> tuple[float, float, float]:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


#: Effect -> what it changes.
FAULTS: Mapping[str, Change] = {
    "added_mass": _added_mass,
    "advance_speed_loss": _adding(inflow="inflow_fraction"),
    "cg_shift": _adding(centre_g=("dx_m", "dy_m", "dz_m")),
    "coriolis_omitted": _coriolis,
    "crossflow_coupling": _adding(crossflow="fraction"),
    "current": _adding(current=("north_mps", "east_mps", "down_mps")),
    "dead_zone": _adding(dead="codes"),
    "dvl_delay": _dvl_delay,
    "dvl_lever_arm": _dvl_place,
    "dvl_misalignment": _dvl_turn,
    "dvl_scale": _dvl_scale,
    "lift": _lift,
    "linear_damping": _linear,
    "payload": _payload,
    "quadratic_damping": _quadratic,
    "residual_buoyancy": _adding(buoyancy_n="force_n"),
    "reverse_thrust": _reverse,
    "tether": _adding(tow_area_m2="drag_area_m2", tow_pull_n="pull_n"),
    "thrust_deduction": _deduction,
    "thruster_degraded": _degraded,
    "thruster_lag": _adding(lag_s="lag_s"),
    "thruster_misalignment": _misaligned,
    "voltage_sag": _adding(supply_drop="drop", load_drop="load_drop"),
    "wall_effect": _adding(wall_strength="strength"),
}
#: Effects that make readings wrong and leave the motion alone.
OF_MEASUREMENT = frozenset({"dvl_scale", "dvl_delay", "dvl_misalignment", "dvl_lever_arm"})

__all__ = ["AXES", "FAULTS", "OF_MEASUREMENT", "DvlFault", "with_fault"]
