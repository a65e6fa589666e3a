"""What was learned of each departure, in the units of whoever reads it."""

from collections.abc import Iterator

import numpy as np

from pipeline.diagnose.asking.run_marginals import of_curves, of_rest
from pipeline.diagnose.linear.characteristic import curve_names
from pipeline.diagnose.linear.linear_model import Setting
from pipeline.diagnose.linear.rest import RestTerm
from pipeline.diagnose.reference.learn import Learned
from pipeline.records.diagnosis import VELOCITIES
from pipeline.records.reference import Departure
from pipeline.types import FloatArray

#: Axes in the order of SNAME.
AXES = tuple(VELOCITIES)
_EARTH = ("north", "east")
#: Standard deviations to either side of which 95 % lie.
_WIDE = 1.96


def departures_of(learned: Learned) -> tuple[Departure, ...]:
    """List what was learned; departures of which nothing may be believed are left out."""
    setting, prior = learned.model.setting, learned.beliefs.prior
    std = np.sqrt(np.maximum(np.diag(prior.covariance), 0.0))
    each = np.column_stack([prior.mean, std, learned.beliefs.scatter])
    first = len(setting.coordinates)
    found = [*_effects(setting, each[:first])]
    found += _rest(setting, each[of_rest(setting)])
    found += _curves(setting, each[of_curves(setting)])
    return tuple(found)


def force_unit_of(axis: int) -> str:
    """Return the unit of a force along an axis."""
    return "N" if axis < 3 else "N m"


def _effects(setting: Setting, each: FloatArray) -> Iterator[Departure]:
    for one, (mean, std, scatter) in zip(setting.coordinates, each, strict=True):
        if one.leads or std == 0.0:
            # the place of what is not on board has no value
            continue
        size, neutral = one.unit_size, one.parameter.neutral
        yield Departure(
            name=one.name,
            kind="effect",
            thruster=one.target,
            unit=one.parameter.unit,
            value=neutral + size * mean,
            ci95=_interval(neutral + size * mean, size * std),
            neutral=neutral,
            scatter=abs(size) * scatter,
        )


def _rest(setting: Setting, each: FloatArray) -> Iterator[Departure]:
    thrusters = setting.bench.stack.packed.thruster_names
    for term, (mean, std, scatter) in zip(setting.rest.terms, each, strict=True):
        with_thruster = term.kind == "thrust"
        axis = AXES[term.axis] if term.axis >= 0 else _EARTH[term.column]
        goes_with = ""
        if with_thruster:
            goes_with = f"@{thrusters[term.column]}"
        elif term.kind == "damping":
            goes_with = f"/{AXES[term.column]}"
        yield Departure.model_validate(
            {
                "name": f"{term.kind}:{axis}{goes_with}",
                "kind": term.kind,
                "axis": axis,
                "thruster": thrusters[term.column] if with_thruster else None,
                "unit": _unit(term),
                "value": term.unit * mean,
                "ci95": _interval(term.unit * mean, term.unit * std),
                "neutral": 0.0,
                "scatter": term.unit * scatter,
            }
        )


def _curves(setting: Setting, each: FloatArray) -> Iterator[Departure]:
    packed = setting.bench.stack.packed
    names = curve_names(packed, setting.curves)
    for (name, unit, size), (mean, std, scatter) in zip(names, each, strict=True):
        yield Departure(
            name=name,
            kind="curve",
            thruster=name.partition("@")[2] or None,
            unit=unit,
            value=size * mean,
            ci95=_interval(size * mean, size * std),
            neutral=0.0,
            scatter=size * scatter,
        )


def _interval(value: float, std: float) -> tuple[float, float]:
    return value - _WIDE * abs(std), value + _WIDE * abs(std)


def _unit(term: RestTerm) -> str:
    """Return the SI unit of a coefficient of the rest."""
    if term.kind == "late":
        return "s"
    if term.kind == "thrust":
        return "1" if term.axis < 3 else "m"
    if term.kind == "damping":
        speed = "s/m" if term.column < 3 else "s/rad"
        return f"{force_unit_of(term.axis)} {speed}"
    return "N" if term.kind == "earth" else force_unit_of(term.axis)
