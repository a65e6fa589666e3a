"""What is done to a vehicle of the second generator, and the name that the diagnosis has for it."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from evaluation.craft import AXES, GRAVITY, Craft


@dataclass(frozen=True)
class Fault:
    """A fault of some size: the altered vehicle, and the label in the words of the library."""

    effect: str
    parameters: dict[str, float]
    craft: Craft
    thruster: str | None = None
    axes: tuple[str, ...] = ()


#: From a vehicle and a share of the largest size (0 nothing, 1 all of it) to a fault.
Maker = Callable[[Craft, float], Fault]


def _one_thruster(number: int, least: float) -> Maker:
    def make(craft: Craft, share: float) -> Fault:
        value = 1.0 - share * (1.0 - least)
        thrusters = list(craft.thrusters)
        thrusters[number] = replace(thrusters[number], gain=thrusters[number].gain * value)
        name = thrusters[number].name
        return Fault(
            "thruster_degraded",
            {"thrust_fraction": value},
            replace(craft, thrusters=tuple(thrusters)),
            name,
        )

    return make


def _every_thruster(effect: str, key: str) -> Maker:
    def make(craft: Craft, share: float) -> Fault:
        each, value = [], 0.0
        for one in craft.thrusters:
            if effect == "thrust_deduction":
                value = 0.3 * share
                each.append(replace(one, gain=one.gain * (1.0 - value)))
            elif effect == "reverse_thrust":
                value = 1.0 - 0.5 * share
                each.append(replace(one, reverse=one.reverse * value))
            else:
                value = 0.15 * share * craft.code_max
                each.append(replace(one, lost=value))
        return Fault(effect, {key: value}, replace(craft, thrusters=tuple(each)))

    return make


def _factor(effect: str, slot: str, axis: int, most: float) -> Maker:
    def make(craft: Craft, share: float) -> Fault:
        value = 1.0 + share * (most - 1.0)
        numbers = getattr(craft, slot).copy()
        numbers[axis] *= value
        return Fault(
            effect, {AXES[axis]: value}, replace(craft, **{slot: numbers}), axes=(AXES[axis],)
        )

    return make


def _buoyant(most_n: float) -> Maker:
    def make(craft: Craft, share: float) -> Fault:
        value = share * most_n
        return Fault(
            "residual_buoyancy",
            {"force_n": value},
            replace(craft, buoyancy=craft.buoyancy + value),
        )

    return make


def _shifted(axis: int, most_m: float) -> Maker:
    def make(craft: Craft, share: float) -> Fault:
        centre = list(craft.centre)
        centre[axis] += share * most_m
        moved = (centre[0], centre[1], centre[2])
        return Fault(
            "cg_shift", {("dx_m", "dy_m")[axis]: share * most_m}, replace(craft, centre=moved)
        )

    return make


def _late(most_s: float) -> Maker:
    def make(craft: Craft, share: float) -> Fault:
        value = share * most_s
        return Fault("thruster_lag", {"lag_s": value}, replace(craft, lag=craft.lag + value))

    return make


def _drifting(direction_rad: float) -> Maker:
    def make(craft: Craft, share: float) -> Fault:
        north, east = 0.25 * share * np.cos(direction_rad), 0.25 * share * np.sin(direction_rad)
        return Fault(
            "current",
            {"north_mps": float(north), "east_mps": float(east)},
            replace(craft, current=(float(north), float(east), 0.0)),
        )

    return make


def _loaded(most_kg: float) -> Maker:
    """Load a weight of steel at the origin: its water is a seventh of it."""

    def make(craft: Craft, share: float) -> Fault:
        mass = share * most_kg
        volume = mass / 7800.0
        return Fault(
            "payload",
            {"mass_kg": mass},
            replace(
                craft,
                mass=craft.mass + mass,
                buoyancy=craft.buoyancy + 1025.0 * GRAVITY * volume,
            ),
        )

    return make


def _falling(least: float) -> Maker:
    """Let the battery run down while the run lasts, and log it."""

    def make(craft: Craft, share: float) -> Fault:
        end = 1.0 - share * (1.0 - least)
        return Fault("voltage_sag", {}, replace(craft, supply=(1.0, end), voltage_logged=True))

    return make


def _read_wrong(most: float) -> Maker:
    def make(craft: Craft, share: float) -> Fault:
        value = 1.0 + share * most
        return Fault("dvl_scale", {"scale": value}, replace(craft, dvl_scale=value))

    return make


def drawn(craft: Craft, generator: np.random.Generator) -> Maker:
    """Draw a fault for a vehicle; its size is found afterwards."""
    sign = float(generator.choice([-1.0, 1.0]))
    axis = int(generator.choice([0, 1, 2, 5]))
    number = int(generator.integers(len(craft.thrusters)))
    makers: list[Maker] = [
        _one_thruster(number, 0.05),
        _one_thruster(number, 0.3),
        _every_thruster("thrust_deduction", "t"),
        _every_thruster("reverse_thrust", "fraction"),
        _every_thruster("dead_zone", "codes"),
        _factor("quadratic_damping", "quadratic", axis, 3.0),
        _factor("linear_damping", "linear", axis, 3.5),
        _factor("added_mass", "added", axis, 2.2),
        _buoyant(sign * 0.08 * craft.mass * GRAVITY),
        _shifted(int(generator.integers(2)), sign * 0.6 * craft.below),
        _late(0.6),
        _drifting(float(generator.uniform(0.0, 2.0 * np.pi))),
        _loaded(0.15 * craft.mass),
        _falling(0.8),
        _read_wrong(sign * 0.12),
    ]
    return makers[int(generator.integers(len(makers)))]
