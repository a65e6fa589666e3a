"""How a fault is drawn: a direction among an effect's parameters, and how far along it.

`size` 1 is a large fault of the kind; the severity search scales it. Directions are drawn within
what is plausible on a real vehicle and scaled by the vehicle's own size and forces; the largest
size stays plausible, too (an added mass of two and a half times the stated one, a thruster turned
by 22 degrees), so on some vehicles and manoeuvres a fault cannot open the gap that was wanted.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from pipeline.blind.truth.craft import Craft
from pipeline.blind.truth.faults import AXES
from pipeline.blind.truth.manoeuvres import Scene

Values = dict[str, float]


@dataclass(frozen=True)
class Drawn:
    """A fault with its size open: `at(size)` gives the parameters; `most` is the largest size."""

    effect: str
    at: Callable[[float], Values]
    most: float
    thruster: str | None = None
    axes: tuple[str, ...] = ()


def draw(effect: str, craft: Craft, scene: Scene, rng: np.random.Generator) -> Drawn:
    """Draw a direction for an effect."""
    return _DRAWS[effect](effect, craft, scene, rng)


def _line(effect: str, steps: Mapping[str, float], most: float, **more: object) -> Drawn:
    """Parameters that grow from zero along a direction."""
    direction = {name: float(step) for name, step in steps.items()}

    def at(size: float) -> Values:
        return {name: size * step for name, step in direction.items()}

    return Drawn(effect, at, most, **more)  # type: ignore[arg-type]  # fields of Drawn by name


def _factor(effect: str, powers: Mapping[str, float], most: float, **more: object) -> Drawn:
    """Parameters that grow or shrink from one: e to the size."""
    rates = {name: float(power) for name, power in powers.items()}

    def at(size: float) -> Values:
        return {name: float(np.exp(size * rate)) for name, rate in rates.items()}

    return Drawn(effect, at, most, **more)  # type: ignore[arg-type]  # fields of Drawn by name


def _loss(effect: str, name: str, most: float, **more: object) -> Drawn:
    """One parameter that falls from one."""
    return Drawn(effect, lambda size: {name: 1.0 - size}, most, **more)  # type: ignore[arg-type]  # fields of Drawn by name


def _sign(rng: np.random.Generator, up: float = 0.5) -> float:
    return 1.0 if rng.random() < up else -1.0


def _axes(effect: str, craft: Craft, scene: Scene, rng: np.random.Generator) -> Drawn:
    """One axis, or two, that the vehicle moves along in earnest."""
    weights = np.array([3.0, 2.0, 2.0, 0.5, 1.0, 2.0]) * np.where(scene.axes, 1.0, 0.3)
    if effect == "linear_damping":
        weights = weights * (np.diag(craft.linear) > 0.0)
    count = 1 if rng.random() < 0.65 else 2
    count = min(count, int((weights > 0).sum()))
    chosen = rng.choice(6, size=count, replace=False, p=weights / weights.sum())
    names = tuple(AXES[k] for k in sorted(chosen))
    up = 0.75
    most = 1.25 if effect == "linear_damping" else 0.9
    return _factor(effect, {name: _sign(rng, up) for name in names}, most, axes=names)


def _cg(effect: str, craft: Craft, _scene: Scene, rng: np.random.Generator) -> Drawn:
    way = rng.standard_normal(3)
    way /= np.linalg.norm(way)
    # a shift along x or y tilts against the righting arm
    arm = max(float(craft.centre_g[2] - craft.centre_b[2]), 0.005)
    steps = dict(zip(("dx_m", "dy_m", "dz_m"), 0.5 * arm * way, strict=True))
    return _line(effect, steps, 1.2)


def _current(effect: str, _craft: Craft, scene: Scene, rng: np.random.Generator) -> Drawn:
    angle = rng.uniform(-np.pi, np.pi)
    size = 0.3 * min(scene.speed_mps, 1.0)
    down = 0.2 * rng.standard_normal() if rng.random() < 0.3 else 0.0
    steps = {"north_mps": size * np.cos(angle), "east_mps": size * np.sin(angle)}
    if down:
        steps["down_mps"] = size * down
    return _line(effect, steps, 2.0)


def _lift(effect: str, craft: Craft, scene: Scene, rng: np.random.Generator) -> Drawn:
    density, length = craft.density, (craft.mass_kg / craft.density) ** (1.0 / 3.0)
    names = ["heave_slope", "pitch_slope", "sway_slope", "yaw_slope"]
    chosen = rng.choice(4, size=1 if rng.random() < 0.6 else 2, replace=False)
    force, moment = 0.5 * density * length**2, 0.15 * density * length**3
    steps = {}
    for k in sorted(chosen):
        # a moment that upsets the hull is kept small: it would tumble
        size = force if k in (0, 2) else moment * (0.5 if scene.hovers else 1.0)
        sign = _sign(rng, 0.7) if k in (0, 2) else (-1.0 if k == 1 else 1.0)
        steps[names[k]] = sign * size
    return _line(effect, steps, 2.0)


def _payload(effect: str, craft: Craft, scene: Scene, rng: np.random.Generator) -> Drawn:
    mass = 0.08 * craft.mass_kg * _sign(rng, 0.75)
    lift = min(scene.reach[2] / craft.gravity * 0.6, abs(mass))
    # what the vertical thrusters cannot hold the module must float by itself
    wet = lift * rng.uniform(0.1, 0.8) * np.sign(mass)
    span = max(float(np.ptp(craft.place[:, 0])), 0.4)
    width = max(float(np.ptp(craft.place[:, 1])), 0.2)
    place = {
        "x_m": rng.uniform(-0.3, 0.3) * span,
        "y_m": rng.uniform(-0.2, 0.2) * width,
        "z_m": rng.uniform(0.0, 0.5) * width,
    }

    def at(size: float) -> Values:
        volume = size * (mass - wet) / craft.density
        return {"mass_kg": size * mass, "volume_m3": float(volume), **place}

    return Drawn(effect, at, 3.0)


def _buoyancy(effect: str, _craft: Craft, scene: Scene, rng: np.random.Generator) -> Drawn:
    return _line(effect, {"force_n": 0.3 * scene.reach[2] * _sign(rng)}, 1.5)


def _tether(effect: str, craft: Craft, scene: Scene, rng: np.random.Generator) -> Drawn:
    area = 0.25 * 2.0 * craft.quadratic[0] / craft.density
    pull = 0.05 * scene.reach[0]
    kind = rng.random()
    steps = {}
    if kind < 0.7:
        steps["drag_area_m2"] = area * rng.uniform(0.5, 1.5)
    if kind > 0.4:
        steps["pull_n"] = pull * rng.uniform(0.5, 1.5)
    return _line(effect, steps, 3.0)


def _thruster(craft: Craft, rng: np.random.Generator) -> str:
    return str(craft.names[int(rng.integers(len(craft.names)))])


def _degraded(effect: str, craft: Craft, _scene: Scene, rng: np.random.Generator) -> Drawn:
    return _loss(effect, "thrust_fraction", 1.0, thruster=_thruster(craft, rng))


def _misaligned(effect: str, craft: Craft, _scene: Scene, rng: np.random.Generator) -> Drawn:
    angle = rng.uniform(-np.pi, np.pi)
    if rng.random() < 0.5:
        angle = rng.choice([0.0, np.pi / 2, np.pi, -np.pi / 2])
    steps = {"azimuth_deg": 15.0 * np.cos(angle), "elevation_deg": 15.0 * np.sin(angle)}
    steps = {name: step for name, step in steps.items() if abs(step) > 1e-6}
    return _line(effect, steps, 1.5, thruster=_thruster(craft, rng))


def _sag(effect: str, _craft: Craft, _scene: Scene, rng: np.random.Generator) -> Drawn:
    kind = rng.random()
    steps = {}
    if kind < 0.75:
        steps["drop"] = 0.25
    if kind > 0.5:
        steps["load_drop"] = 0.3
    return _line(effect, steps, 1.2)


def _turned(effect: str, _craft: Craft, _scene: Scene, rng: np.random.Generator) -> Drawn:
    way = rng.standard_normal(3) * np.array([0.4, 1.0, 1.0])
    way *= 5.0 / np.linalg.norm(way)
    steps = dict(zip(("roll_deg", "pitch_deg", "yaw_deg"), way, strict=True))
    return _line(effect, steps, 2.0)


def _arm(effect: str, _craft: Craft, _scene: Scene, rng: np.random.Generator) -> Drawn:
    way = rng.standard_normal(3)
    way *= 0.4 / np.linalg.norm(way)
    return _line(effect, dict(zip(("x_m", "y_m", "z_m"), way, strict=True)), 1.5)


def _one(name: str, step: float, most: float) -> Callable[..., Drawn]:
    """Draw for an effect of one number that grows from zero."""

    def drawn(effect: str, *_: object) -> Drawn:
        return _line(effect, {name: step}, most)

    return drawn


def _scale(effect: str, _craft: Craft, _scene: Scene, rng: np.random.Generator) -> Drawn:
    return _factor(effect, {"scale": 0.1 * _sign(rng)}, 1.5)


def _reverse(effect: str, _craft: Craft, _scene: Scene, rng: np.random.Generator) -> Drawn:
    if rng.random() < 0.85:
        return _loss(effect, "fraction", 0.8)
    return Drawn(effect, lambda size: {"fraction": 1.0 + size}, 0.4)


def _dead(effect: str, craft: Craft, _scene: Scene, _rng: np.random.Generator) -> Drawn:
    return _line(effect, {"codes": 0.2 * float(craft.code_max.min())}, 1.5)


_DRAWS: Mapping[str, Callable[..., Drawn]] = {
    "added_mass": _axes,
    "linear_damping": _axes,
    "quadratic_damping": _axes,
    "advance_speed_loss": _one("inflow_fraction", 1.0, 1.3),
    "cg_shift": _cg,
    "coriolis_omitted": _one("fraction", 1.0, 1.1),
    "crossflow_coupling": _one("fraction", 1.0, 1.3),
    "current": _current,
    "dead_zone": _dead,
    "dvl_delay": _one("delay_s", 0.5, 2.0),
    "dvl_lever_arm": _arm,
    "dvl_misalignment": _turned,
    "dvl_scale": _scale,
    "lift": _lift,
    "payload": _payload,
    "residual_buoyancy": _buoyancy,
    "reverse_thrust": _reverse,
    "tether": _tether,
    "thrust_deduction": _one("t", 0.25, 1.4),
    "thruster_degraded": _degraded,
    "thruster_lag": _one("lag_s", 0.5, 2.0),
    "thruster_misalignment": _misaligned,
    "voltage_sag": _sag,
    "wall_effect": _one("strength", 1.5, 2.0),
}
