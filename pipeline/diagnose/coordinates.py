"""The directions in which a vehicle may differ from its file: one a parameter of an effect.

The stated uncertainty of the vehicle file and the effects of the library are the same directions
with different widths: a thrust that is 2 % off is ordinary, one that is 30 % off is an effect. So
there is one list, and a hypothesis says which of them may be wide.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.places import far, leads, lifting
from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.library import EffectSpec, apply_effects
from pipeline.physics.parameters import read
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty

#: Size of a departure, as a share of the far end of the plausible range, that counts as 1.
_UNIT_SHARE = 0.5
#: No departure that is an effect goes further: two and a half times what is plausible.
_FARTHEST = 5.0
#: The same for the difference by which the signature is taken.
_STEP_SHARE = 0.001


@dataclass(frozen=True)
class Coordinate:
    """One parameter of one effect at one target.

    Departures are counted in `unit_size`, half way from neutral to the far end of the plausible
    range, with the sign of the parameter. `ordinary` is the standard deviation that the vehicle
    file states for it, in the same count (0: the file says nothing of it). `leads` are the indices
    of the coordinates of which one must be there for this one to have a meaning (mass or volume for
    the place of a payload), else empty; its departure is then that of the product with `lead_size`.
    `against` are those of them whose weight pulls the other way: water that is displaced.
    """

    effect: Effect
    parameter: Parameter
    target: str | None
    unit_size: float
    ordinary: float
    leads: tuple[int, ...] = ()
    against: tuple[int, ...] = ()

    @property
    def bounds(self) -> tuple[float, float]:
        """Where the departure may lie as one hypothesis of the effect, counted from neutral.

        On a side of neutral where nothing is plausible it would be another effect; far beyond what
        is plausible, damping of twenty times the stated one, it would explain a current.
        """
        low, high = self.parameter.plausible
        neutral = self.parameter.neutral
        least, most = self.parameter.possible
        low = least if low < neutral else neutral
        high = most if high > neutral else neutral
        return (
            max((low - neutral) / self.unit_size, -_FARTHEST),
            min((high - neutral) / self.unit_size, _FARTHEST),
        )

    @property
    def limits(self) -> tuple[float, float]:
        """Where the parameter has a meaning, counted from neutral."""
        low, high = self.parameter.possible
        neutral = self.parameter.neutral
        return (low - neutral) / self.unit_size, (high - neutral) / self.unit_size

    @property
    def step(self) -> float:
        """Departure by which the signature is taken, towards the plausible side."""
        low, high = self.parameter.plausible
        neutral = self.parameter.neutral
        side = 1.0 if abs(high - neutral) >= abs(low - neutral) else -1.0
        return side * _STEP_SHARE / _UNIT_SHARE

    def lead_size(self, departures: FloatArray) -> float:
        """How much there is of what leads, with the sign of what weighs more; 1 without leads."""
        if not self.leads:
            return 1.0
        own = departures[list(self.leads)]
        weighs = own * np.where(np.isin(self.leads, self.against), -1.0, 1.0)
        return float(np.copysign(np.linalg.norm(own), weighs[np.argmax(np.abs(own))]))

    @property
    def name(self) -> str:
        """For messages: effect, parameter and target."""
        return f"{self.effect.id}:{self.parameter.name}" + (
            f"@{self.target}" if self.target is not None else ""
        )


def coordinates(
    packed: PackedVehicle, effects: Mapping[str, Effect], uncertainty: Uncertainty
) -> tuple[Coordinate, ...]:
    """List the coordinates of a vehicle, effects in alphabetical order.

    Parameters
    ----------
    packed : PackedVehicle
        The nominal vehicle.
    effects : mapping of str to Effect
        The candidates.
    uncertainty : Uncertainty
        As the vehicle file states it.
    """
    context = packed.context
    found: list[Coordinate] = []
    for effect in sorted(effects.values(), key=lambda one: one.id):
        targets: Sequence[str | None] = (
            context.thruster_names if effect.scope == "thruster" else (None,)
        )
        for target in targets:
            first = len(found)
            for parameter in effect.parameters:
                unit = _UNIT_SHARE * far(parameter)
                needed = leads(packed, effect, target, parameter)
                if needed is None:
                    continue
                against = lifting(packed, effect, target, parameter, needed)
                own = range(first, len(found))
                found.append(
                    Coordinate(
                        effect,
                        parameter,
                        target,
                        unit,
                        _ordinary(effect.id, parameter, packed, uncertainty) / unit,
                        tuple(k for k in own if found[k].parameter in needed),
                        tuple(k for k in own if found[k].parameter in against),
                    )
                )
    return tuple(found)


def may_bend(all_coordinates: Sequence[Coordinate]) -> frozenset[int]:
    """Departures that may act otherwise when they are strong, as a dead zone does.

    Not those of which something is stated, which are small, nor a payload: what it does is nearly
    straight, but the secant to a strong one is that of a vehicle that has long sunk.
    """
    placed = {lead for one in all_coordinates for lead in one.leads}
    return frozenset(
        index
        for index, one in enumerate(all_coordinates)
        if one.ordinary == 0.0 and not one.leads and index not in placed
    )


def _ordinary(
    effect_id: str, parameter: Parameter, packed: PackedVehicle, uncertainty: Uncertainty
) -> float:
    """Return what the vehicle file's uncertainty says of an effect's parameter, or else its own.

    Lift is a hull force as damping is, and its moments stand against the Munk moment of the added
    masses, whose uncertainty they share.
    """
    if effect_id == "lift":
        added = np.diag(read(packed.vector, "added_mass"))
        munk = {"pitch_slope": added[2] - added[0], "yaw_slope": added[1] - added[0]}
        name = parameter.name
        slope = float(read(packed.vector, name.replace("_slope", "_lift_slope")))
        return float(
            np.hypot(uncertainty.damping * slope, uncertainty.added_mass * munk.get(name, 0.0))
        )
    return {
        "thruster_degraded": uncertainty.thrust,
        "thrust_deduction": uncertainty.thrust,
        "added_mass": uncertainty.added_mass,
        "linear_damping": uncertainty.damping,
        "quadratic_damping": uncertainty.damping,
        "residual_buoyancy": uncertainty.buoyancy_n,
        "cg_shift": uncertainty.centre_of_mass_m,
    }.get(effect_id, parameter.ordinary)


def specs_at(
    all_coordinates: Sequence[Coordinate], departures: FloatArray
) -> tuple[EffectSpec, ...]:
    """Effects with their values for departures (g,); those at neutral are left out."""
    values: dict[tuple[str, str | None], dict[str, float]] = {}
    for index in np.flatnonzero(departures).tolist():
        one = all_coordinates[index]
        value = one.parameter.neutral + one.unit_size * float(departures[index])
        least, most = one.parameter.possible
        value = min(max(value, least), most)
        values.setdefault((one.effect.id, one.target), {})[one.parameter.name] = value
    return tuple(EffectSpec(id_, found, target) for (id_, target), found in values.items())


def vector_at(
    packed: PackedVehicle, all_coordinates: Sequence[Coordinate], departures: FloatArray
) -> FloatArray:
    """Parameter vector for departures (g,).

    A departure a little beyond what an effect allows (a dead zone narrower than stated) is the
    mirror image of one inside: the vector goes on as it came.
    """
    inside = departures.copy()
    mirrored: list[tuple[int, float]] = []
    for index in np.flatnonzero(departures).tolist():
        low, high = all_coordinates[index].limits
        inside[index] = min(max(departures[index], low), high)
        if inside[index] != departures[index]:
            mirrored.append((index, float(inside[index] - departures[index])))
    context = packed.context
    vector = apply_effects(packed.vector, specs_at(all_coordinates, inside), context)
    found = vector.copy()
    for index, by in mirrored:
        other = inside.copy()
        other[index] += by
        found -= apply_effects(packed.vector, specs_at(all_coordinates, other), context) - vector
    return found
