"""What an effect is: a few parameters that move entries of the parameter vector off neutral."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import EllipsisType
from typing import Literal

import numpy as np

from pipeline.physics.parameters import read
from pipeline.types import FloatArray

Where = slice | EllipsisType

#: Mass of the vehicle that plausible ranges are stated for.
_OF_MASS_KG = 100.0
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


def add(vector: FloatArray, name: str, departure: float | FloatArray, where: Where = ...) -> None:
    """Add a departure to a slot, or to some of its entries, in place.

    Every bit stays at the neutral value: adding 0.0 would turn a -0.0 into 0.0, so an entry whose
    departure is zero is not touched.

    Parameters
    ----------
    vector : ndarray
        The parameter vector; changed.
    name : str
        The slot.
    departure : float or ndarray
        In the slot's unit; broadcast to its shape.
    where : slice, optional
        Entries along the first axis of the slot; all without it.
    """
    target = read(vector, name)[where]
    departure = np.asarray(departure, dtype=np.float64)
    np.add(target, departure, out=target, where=departure != 0.0)


def scale(vector: FloatArray, name: str, factor: float | FloatArray, where: Where = ...) -> None:
    """Multiply a slot, or some of its entries, in place; parameters as `add`, factor [1]."""
    target = read(vector, name)[where]
    np.multiply(target, factor, out=target)


@dataclass(frozen=True)
class Parameter:
    """One number of an effect; at `neutral` it changes nothing.

    `plausible` is where the number lies when the effect is at work on a real vehicle, so it need
    not hold the neutral value. Outside `possible` the number has no meaning and is refused.
    `ordinary` is the standard deviation on healthy vehicles of what no vehicle file states.
    `plausible` is stated for a vehicle of 100 kg and `grows` with its length to this power.
    Where it is known `together_with` another parameter, neither is without the other.
    """

    name: str
    unit: str
    neutral: float
    plausible: tuple[float, float]
    meaning: str
    possible: tuple[float, float] = (-math.inf, math.inf)
    ordinary: float = 0.0
    grows: int = 0
    together_with: str = ""

    def on(self, context: "EffectContext") -> "Parameter":
        """Return the parameter with what is plausible on a vehicle of this size."""
        if not self.grows:
            return self
        by = (context.mass_kg / _OF_MASS_KG) ** (self.grows / 3.0)
        low, high = (self.neutral + by * (end - self.neutral) for end in self.plausible)
        return replace(self, plausible=(float(f"{low:.2g}"), float(f"{high:.2g}")))


@dataclass(frozen=True)
class EffectContext:
    """What an effect needs to know of the vehicle beside its parameter vector.

    `strips` tells whether the hull's sections are known (cross-flow), `walls` whether walls or a
    bottom are, `measured` names the quantities that are measured ("dvl", "depth" ...).
    `crossflow_in_nominal` tells whether the nominal model computes the cross-flow of the strips,
    `munk_held` are the Munk moments of pitch and yaw [kg] that the file's lift slopes hold.
    `lagged` tells whether a lag acts on every thruster: not where the torque balance of the shaft
    is solved in time. `inflow_shares` and `thrust_shares` are stated of each thruster: the share
    1 - w of the inflow that reaches its blades, and 1 - t of its thrust that drives the hull
    (empty: all of it); `wake_std` and `deduction_std` are their standard uncertainties (None: not
    stated).
    """

    thruster_names: tuple[str, ...]
    thrust_falls_with_speed: bool
    coriolis: bool
    strips: bool
    walls: bool
    gravity_mps2: float
    measured: frozenset[str] = frozenset()
    crossflow_in_nominal: bool = False
    lagged: bool = True
    mass_kg: float = _OF_MASS_KG
    munk_held: tuple[float, float] = (0.0, 0.0)
    inflow_shares: tuple[float, ...] = ()
    thrust_shares: tuple[float, ...] = ()
    wake_std: float | None = None
    deduction_std: float | None = None

    @property
    def inflow_share(self) -> float:
        """Stated share of the inflow that reaches the blades, mean over the thrusters."""
        return _mean(self.inflow_shares)

    @property
    def thrust_share(self) -> float:
        """Stated share of the thrust that drives the hull, mean over the thrusters."""
        return _mean(self.thrust_shares)


def _mean(shares: tuple[float, ...]) -> float:
    return math.fsum(shares) / len(shares) if shares else 1.0


#: Parameters of an effect on a vehicle, from those that any vehicle has.
Stated = Callable[[tuple[Parameter, ...], EffectContext], tuple[Parameter, ...]]

#: Changes a parameter vector in place: (vector, parameter values, target, context).
#: The target is a thruster's index for effects of one thruster, else None.
Apply = Callable[[FloatArray, Mapping[str, float], int | None, EffectContext], None]


def always(_context: EffectContext) -> str | None:
    """Accept every vehicle."""
    return None


def alike(parameters: tuple[Parameter, ...], _context: EffectContext) -> tuple[Parameter, ...]:
    """Leave the parameters as they are: the same on every vehicle."""
    return parameters


@dataclass(frozen=True)
class Effect:
    """A departure of the vehicle from what its file states, constant over a run.

    `scope` "vehicle" has no target, "thruster" names one thruster. `missing` says why the effect
    is no candidate for a vehicle (None when it is one), e.g. because the nominal model contains
    the term already. `channels` are those it can touch: u v w p q r phi theta psi z x y.
    `vector_slots` lists the slots that `apply` writes. What is `unstated` is no fault: vehicle
    files say nothing of it, so that it may differ on any vehicle, and it is never an answer. An
    effect `of_thrusters` acts on all of them, and is no candidate for a vehicle that has none.
    `stated` turns the parameters into those of a vehicle whose file states a value: its neutral is
    that value, and the width that the file states is ordinary. `scales_with` names effects whose
    parameters its force is in proportion to: what the file is off by in these it is off by, too.
    """

    id: str
    title: str
    source: str
    parameters: tuple[Parameter, ...]
    channels: tuple[str, ...]
    vector_slots: tuple[str, ...]
    apply: Apply
    scope: Literal["vehicle", "thruster"] = "vehicle"
    missing: Callable[[EffectContext], str | None] = field(default=always)
    unstated: bool = False
    of_thrusters: bool = False
    stated: Stated = field(default=alike)
    scales_with: tuple[str, ...] = ()

    def on(self, context: EffectContext) -> "Effect":
        """Return the effect with the neutral values and widths that hold for a vehicle."""
        own = tuple(one.on(context) for one in self.parameters)
        return replace(self, parameters=self.stated(own, context))

    def neutral_values(self) -> dict[str, float]:
        """Values at which the effect vanishes."""
        return {parameter.name: parameter.neutral for parameter in self.parameters}
