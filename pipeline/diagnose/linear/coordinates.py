"""The directions in which a vehicle may differ from its file: one a parameter of an effect.

The stated uncertainty of the vehicle file and the effects of the library are the same directions
with different widths: a thrust that is 2 % off is ordinary, one that is 30 % off is an effect. So
there is one list, and a hypothesis says which of them may be wide.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.diagnose.linear.places import far, leads, pulls
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
#: Share of what there is that counts beside its weight in water. Of what counts whole a hundredth
#: (in units of half the plausible range) is too small to tell where it sits.
_AFLOAT, _LEAST_LEAD = 0.1, 0.01


@dataclass(frozen=True)
class Coordinate:
    """One parameter of one effect at one target.

    Departures are counted in `unit_size`, half way from neutral to the far end of the plausible
    range, with the sign of the parameter. `ordinary` is the standard deviation that the vehicle
    file states for it, in the same count (0: the file says nothing of it). `leads` are the indices
    of the coordinates of which one must be there for this one to have a meaning (mass or volume for
    the place of a payload), else empty; its departure is then that of the product with `lead_size`.
    `pulls` is how hard a unit of each of them pulls there: displaced water against the mass;
    `afloat` is the share of what there is that counts beside what weighs in water.
    """

    effect: Effect
    parameter: Parameter
    target: str | None
    unit_size: float
    ordinary: float
    leads: tuple[int, ...] = ()
    pulls: tuple[float, ...] = ()
    afloat: float = _AFLOAT

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
        """How much there is of what leads, with the sign of what weighs more; 1 without leads.

        The trim tells what weighs in water times its place to a per cent, when mass and volume by
        themselves, felt as inertia, are known to a fifth. Counted by its weight in water what the
        trim shows is one straight departure whatever the mass; counted by the mass it bends, and
        its estimate stays where it was begun. What neither sinks nor floats has a place, too: a
        share of its size counts beside.
        """
        if not self.leads:
            return 1.0
        own = departures[list(self.leads)]
        weighs = own * np.array(self.pulls)
        size = np.sqrt(own @ self._lead_form @ own)
        return float(np.copysign(size, weighs[np.argmax(np.abs(weighs))]))

    @property
    def _lead_form(self) -> FloatArray:
        """Form (k, k) whose value at what leads is the square of `lead_size`."""
        pulls = np.array(self.pulls)
        share = self.afloat**2
        return (1.0 - share) * np.outer(pulls, pulls) + share * np.diag(pulls**2)

    @property
    def least_lead(self) -> float:
        """Size of a lead below which it is too small to tell where it sits."""
        return _LEAST_LEAD * self.afloat

    def lead_slope(self, departures: FloatArray) -> FloatArray:
        """Differentiate `lead_size` by what leads (k,); zero where there is none."""
        own, size = departures[list(self.leads)], self.lead_size(departures)
        return np.asarray(self._lead_form @ own / size if size else np.zeros(own.size))

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
                own = range(first, len(found))
                found.append(
                    Coordinate(
                        effect,
                        parameter,
                        target,
                        unit,
                        _ordinary(effect.id, parameter, packed, uncertainty) / unit,
                        tuple(k for k in own if found[k].parameter in needed),
                        pulls(packed, effect, target, parameter, needed) if needed else (),
                    )
                )
    return tuple(found)


def counted_by_size(all_coordinates: Sequence[Coordinate]) -> tuple[Coordinate, ...]:
    """Count places by all that there is: on a long way it may sink at first and float at last."""
    return tuple(
        replace(one, afloat=1.0, pulls=tuple(float(np.sign(pull)) for pull in one.pulls))
        for one in all_coordinates
    )


def recounted(
    before: Sequence[Coordinate], after: Sequence[Coordinate], departures: FloatArray
) -> FloatArray:
    """Count departures (g,) in other coordinates: places by another size of what leads them."""
    found = departures.copy()
    for index, (one, other) in enumerate(zip(before, after, strict=True)):
        if one.leads:
            found[index] *= other.lead_size(departures) / (one.lead_size(departures) or 1.0)
    return found


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
    if effect_id == "thrust_deduction" and packed.context.deduction_std is not None:
        return parameter.ordinary
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
