"""The directions in which a vehicle may differ from its file: one a parameter of an effect.

The stated uncertainty of the vehicle file and the effects of the library are the same directions
with different widths: a thrust that is 2 % off is ordinary, one that is 30 % off is an effect. So
there is one list, and a hypothesis says which of them may be wide.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.library import EffectSpec, apply_effects
from pipeline.errors import CannotComputeError, InputError
from pipeline.physics.parameters import read
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty

#: Size of a departure, as a share of the far end of the plausible range, that counts as 1.
_UNIT_SHARE = 0.5
#: No departure that is an effect goes further: two and a half times what is plausible.
_FARTHEST = 5.0
#: Share of the plausible range that shows whether a parameter acts.
_SMALL = 0.01
#: Steps to the last departure that leaves a vehicle.
_HALVINGS = 20
#: Departure at which that is taken which does nothing by itself.
_SLIGHTLY = 0.2


@dataclass(frozen=True)
class Coordinate:
    """One parameter of one effect at one target.

    Departures are counted in `unit_size`, half way from neutral to the far end of the plausible
    range, with the sign of the parameter. `ordinary` is the standard deviation that the vehicle
    file states for it, in the same count (0: the file says nothing of it). `beside` are the other
    parameters beside which it is taken: where a module sits says something once it has a mass.
    Beyond `valid` no vehicle is left: nothing heavier than it can be taken off. `within` is an
    effect that goes with the parameter: the direction is what a departure changes of that effect.
    """

    effect: Effect
    parameter: Parameter
    target: str | None
    unit_size: float
    ordinary: float
    beside: tuple[tuple[str, float], ...] = ()
    valid: tuple[float, float] = (-_FARTHEST, _FARTHEST)
    within: EffectSpec | None = None

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
            max((low - neutral) / self.unit_size, self.valid[0]),
            min((high - neutral) / self.unit_size, self.valid[1]),
        )

    @property
    def side(self) -> float:
        """Sign of the side on which more is plausible."""
        low, high = self.parameter.plausible
        neutral = self.parameter.neutral
        return 1.0 if abs(high - neutral) >= abs(low - neutral) else -1.0

    def value(self, departure: float) -> float:
        """Value of the parameter at a departure."""
        return self.parameter.neutral + self.unit_size * departure

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

    Those that do nothing by themselves are left out: a factor on a coefficient that the vehicle
    file has at zero, the place of a module that is not there.

    Parameters
    ----------
    packed : PackedVehicle
        The nominal vehicle.
    effects : mapping of str to Effect
        The candidates.
    uncertainty : Uncertainty
        As the vehicle file states it.
    """
    found: list[Coordinate] = []
    for effect in sorted(effects.values(), key=lambda one: one.id):
        targets: Sequence[str | None] = (
            packed.context.thruster_names if effect.scope == "thruster" else (None,)
        )
        for target in targets:
            for parameter in effect.parameters:
                unit = _UNIT_SHARE * _far(parameter)
                ordinary = _ordinary(effect.id, parameter, packed, uncertainty) / unit
                one = Coordinate(effect, parameter, target, unit, ordinary)
                if _acts(packed, one):
                    low, high = (_valid(packed, one, end) for end in one.bounds)
                    found.append(replace(one, valid=(low, high)))
    return tuple(found)


@dataclass(frozen=True)
class Added:
    """A direction that is taken at a size (in its units); `of` is its place where it is small."""

    direction: Coordinate
    size: float
    of: int | None = None


def partners(
    packed: PackedVehicle,
    one: Coordinate,
    values: Mapping[str, float],
    listed: Sequence[Coordinate],
) -> tuple[Added, ...]:
    """Return what does nothing by itself, but acts once others of its effect have values.

    Each is taken beside those that the effect lists before it, so that all of them make the whole.

    Parameters
    ----------
    packed : PackedVehicle
        The nominal vehicle.
    one : Coordinate
        A direction of the effect.
    values : mapping
        What is known of its parameters.
    listed : sequence of Coordinate
        Those that act by themselves.
    """
    have = {other.parameter.name for other in listed if other.effect.id == one.effect.id}
    beside: tuple[tuple[str, float], ...] = ()
    found = []
    for more in one.effect.parameters:
        if more.name not in have and beside:
            unit = _UNIT_SHARE * _far(more)
            own = replace(one, parameter=more, unit_size=unit, ordinary=0.0, beside=beside)
            if _acts(packed, own):
                found.append(Added(own, own.side * _SLIGHTLY))
        if more.name in values:
            beside += ((more.name, values[more.name]),)
    return tuple(found)


def scaled_by(
    one: Coordinate, values: Mapping[str, float], listed: Sequence[Coordinate], runs: int
) -> tuple[Added, ...]:
    """Return what departures that the file allows for change of an effect in proportion to them.

    An added mass that is a sixth off may be half of the moment that a difference of two makes. So
    many `runs` that are weighed together have it alike: each counts it as wider.
    """
    within = EffectSpec(one.effect.id, dict(values), one.target)
    return tuple(
        Added(
            replace(other, within=within, ordinary=runs**0.5 * other.ordinary),
            other.side * _SLIGHTLY,
        )
        for other in listed
        if other.effect.id in one.effect.scales_with and other.ordinary > 0.0
    )


def _far(parameter: Parameter) -> float:
    """Distance from neutral to the far end of the plausible range, in the parameter's unit."""
    return max(abs(limit - parameter.neutral) for limit in parameter.plausible)


def _acts(packed: PackedVehicle, one: Coordinate) -> bool:
    """Whether a small departure changes anything; what is refused counts as acting."""
    by = one.side * _SMALL * _far(one.parameter)
    moved = {**dict(one.beside), one.parameter.name: one.parameter.neutral + by}
    try:
        changed, without = (
            apply_effects(
                packed.vector, [EffectSpec(one.effect.id, values, one.target)], packed.context
            )
            for values in (moved, dict(one.beside))
        )
    except (CannotComputeError, InputError):
        return True
    return not np.array_equal(changed, without)


def _valid(packed: PackedVehicle, one: Coordinate, end: float) -> float:
    """Return the departure next to `end` that leaves a vehicle, from neutral on."""

    def leaves(departure: float) -> bool:
        values = {**dict(one.beside), one.parameter.name: one.value(departure)}
        try:
            apply_effects(
                packed.vector, [EffectSpec(one.effect.id, values, one.target)], packed.context
            )
        except (CannotComputeError, InputError):
            return False
        return True

    if leaves(end) or not leaves(0.0):
        return end
    within = 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (within + end)
        within, end = (middle, end) if leaves(middle) else (within, middle)
    return within


def _ordinary(
    effect_id: str, parameter: Parameter, packed: PackedVehicle, uncertainty: Uncertainty
) -> float:
    """Return what the vehicle file's uncertainty says of an effect's parameter, or else its own.

    Lift is a hull force as damping is, and its moments stand against the Munk moment of the added
    masses, whose uncertainty they share.
    """
    if effect_id == "lift":
        surge, sway, heave = np.diag(read(packed.vector, "added_mass"))[:3]
        both = {"pitch_slope": (heave, surge), "yaw_slope": (sway, surge)}.get(parameter.name, ())
        # what a Munk moment that the file omits would be off by goes with `coriolis_omitted`
        munk = -np.diff(both).sum() if packed.context.coriolis else 0.0
        slope = float(read(packed.vector, parameter.name.replace("_slope", "_lift_slope")))
        return float(np.hypot(uncertainty.damping * slope, uncertainty.added_mass * munk))
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
        value = one.value(float(departures[index]))
        least, most = one.parameter.possible
        value = min(max(value, least), most)
        values.setdefault((one.effect.id, one.target), {})[one.parameter.name] = value
    return tuple(EffectSpec(id_, found, target) for (id_, target), found in values.items())
