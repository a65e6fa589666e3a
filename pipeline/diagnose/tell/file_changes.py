"""What of a verdict no key of the vehicle file can say."""

from collections.abc import Mapping, Sequence

from pipeline.effects.specification import EffectSpec
from pipeline.vehicle.frames import Change

#: Effect -> parts of the keys that say it, where they are not of its own name.
_SAID_BY = {
    "added_mass": ("added_mass",),
    "linear_damping": ("damping.linear",),
    "quadratic_damping": ("damping.quadratic",),
    "residual_buoyancy": ("displaced_volume",),
    "cg_shift": ("centre_of_mass",),
    "payload": ("rigid_body",),
    "coriolis_omitted": ("terms.coriolis",),
    "advance_speed_loss": ("thrust_falls", "wake_fraction"),
    "crossflow_coupling": ("crossflow",),
    "thruster_lag": ("lag_s",),
    "shaft_inertia": ("rotor_inertia",),
    "thrust_deduction": ("thrust_deduction", ".gain_"),
    "thruster_degraded": (".gain_", "thrust_deduction"),
    "thruster_misalignment": (".direction",),
    "reverse_thrust": ("thrust_min_n", ".gain_reverse"),
    "dead_zone": ("dead_zone_code",),
    "voltage_sag": ("model.supply",),
    "current": ("current_ned",),
    "tether": ("lumped_tether",),
    "wall_effect": ("pool.strength",),
    "lift": ("model.lift",),
    "dvl_lever_arm": ("dvl.position_m",),
    "dvl_misalignment": ("dvl.rotation_deg",),
    "dvl_delay": ("dvl.delay_s",),
    "dvl_scale": ("dvl.scale",),
}


def left_to_say(specs: Sequence[EffectSpec], changes: Mapping[str, Change]) -> tuple[str, ...]:
    """Effects that no key of the file can hold, as options of ``rig2sea simulate``."""
    return tuple(
        f"--effect {spec}"
        for spec in specs
        if not any(part in key for part in _SAID_BY.get(spec.id, ()) for key in changes)
    )
