"""Troubles that no effect of the library stands for: what a diagnosis should call unknown.

Waves, a line that snags, water that comes in, propellers that draw air, a thruster that drops out,
a weight that is lost in mid-run. Each has a size, which the severity search scales, and its times.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from pipeline.blind.truth.craft import Craft
from pipeline.blind.truth.kernel_flight import CONTROL_S
from pipeline.blind.truth.kernel_forces import (
    FLOOD_FROM,
    FLOOD_MOST,
    FLOOD_RATE,
    FLOOD_X,
    FLOOD_Y,
    FLOOD_Z,
    SNAG_FROM,
    SNAG_SLACK,
    SNAG_STIFF,
    SNAG_TO,
    SNAG_X,
    SNAG_Y,
    SNAG_Z,
    VENT_ABOVE,
    VENT_DEPTH,
    VENT_LEFT,
)
from pipeline.blind.truth.manoeuvres import Scene
from pipeline.types import FloatArray

#: What is done to one run: the craft, forces on top (m + 1, 9), gains (m, n).
Hit = tuple[Craft, FloatArray | None, FloatArray | None]


@dataclass(frozen=True)
class Trouble:
    """A trouble with its size open.

    `hit(craft, size, run, count)` does it to run number `run` of `count` commands; `times_s` says
    when it is there, by run; `overlaps` names library effects that are as good an answer when the
    time course is told.
    """

    name: str
    hit: Callable[[Craft, float, int, int], Hit]
    most: float
    times_s: Mapping[int, tuple[tuple[float, float], ...]] = field(default_factory=dict)
    overlaps: tuple[str, ...] = ()
    thruster: str | None = None


def draw_trouble(
    name: str, craft: Craft, scene: Scene, durations_s: tuple[float, ...], rng: np.random.Generator
) -> Trouble:
    """Draw a trouble for a case whose runs last so long."""
    return _DRAWS[name](craft, scene, durations_s, rng)


def _waves(
    _craft: Craft, scene: Scene, durations_s: tuple[float, ...], rng: np.random.Generator
) -> Trouble:
    """Swell from one side: five sines of its spectrum, heave a quarter behind."""
    angle, peak_hz = rng.uniform(-np.pi, np.pi), rng.uniform(0.12, 0.35)
    tones = peak_hz * rng.uniform(0.8, 1.25, 5)
    phases = rng.uniform(0, 2 * np.pi, (len(durations_s), 5))
    force = 0.15 * min(scene.reach[0], scene.reach[2])

    def hit(craft: Craft, size: float, run: int, count: int) -> Hit:
        time_s = np.arange(count + 1)[:, None] * CONTROL_S
        turns = 2 * np.pi * tones * time_s + phases[run]
        level = size * force / np.sqrt(5.0) * np.sin(turns).sum(axis=1)
        heave = size * force / np.sqrt(5.0) * np.cos(turns).sum(axis=1)
        out = np.zeros((count + 1, 9))
        out[:, 0], out[:, 1], out[:, 2] = np.cos(angle) * level, np.sin(angle) * level, heave
        return craft, out, None

    times = {k: ((0.0, d),) for k, d in enumerate(durations_s)}
    return Trouble("waves", hit, 3.0, times)


def _snag(
    _craft: Craft, scene: Scene, durations_s: tuple[float, ...], rng: np.random.Generator
) -> Trouble:
    """Catch a line in mid-run: a spring towards a place near the start, beyond a slack length."""
    times = {}
    for k, d in enumerate(durations_s):
        begin = rng.uniform(0.25, 0.6) * d
        times[k] = ((begin, min(begin + rng.uniform(0.2, 0.4) * d, d)),)
    anchor = np.array([rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), scene.depth_m + 1.5])
    slack = 1.8 if scene.pool else 4.0
    stiff = 0.12 * scene.reach[0]

    def hit(craft: Craft, size: float, run: int, _count: int) -> Hit:
        trouble = craft.trouble.copy()
        trouble[SNAG_FROM], trouble[SNAG_TO] = times[run][0]
        trouble[[SNAG_X, SNAG_Y, SNAG_Z]] = anchor
        trouble[SNAG_SLACK], trouble[SNAG_STIFF] = slack, size * stiff
        return craft.changed(trouble=trouble), None, None

    return Trouble("line_snag", hit, 4.0, times, ("tether",))


def _flooding(
    craft: Craft, scene: Scene, durations_s: tuple[float, ...], rng: np.random.Generator
) -> Trouble:
    """Water comes into a housing, at a steady rate from some time on, in every run anew."""
    times = {k: ((rng.uniform(0.1, 0.5) * d, d),) for k, d in enumerate(durations_s)}
    span = max(float(np.ptp(craft.place[:, 0])), 0.4)
    place = np.array([rng.uniform(-0.35, 0.35) * span, 0.0, 0.02])
    most = 0.5 * scene.reach[2] / craft.gravity

    def hit(craft: Craft, size: float, run: int, _count: int) -> Hit:
        trouble = craft.trouble.copy()
        begin, end = times[run][0]
        trouble[FLOOD_FROM] = begin
        trouble[FLOOD_MOST] = size * most
        trouble[FLOOD_RATE] = size * most / max(end - begin, 1.0)
        trouble[[FLOOD_X, FLOOD_Y, FLOOD_Z]] = place
        return craft.changed(trouble=trouble), None, None

    return Trouble("slow_flooding", hit, 1.6, times, ("residual_buoyancy", "payload"))


def _ventilation(
    _craft: Craft, scene: Scene, durations_s: tuple[float, ...], rng: np.random.Generator
) -> Trouble:
    """Propellers that work hard draw air when the vehicle is high in the water."""
    above = rng.uniform(0.3, 0.45)
    depth = scene.depth_m + rng.uniform(-0.1, 0.3)

    def hit(craft: Craft, size: float, _run: int, _count: int) -> Hit:
        trouble = craft.trouble.copy()
        trouble[VENT_ABOVE], trouble[VENT_DEPTH] = above, depth
        trouble[VENT_LEFT] = max(1.0 - size, 0.0)
        return craft.changed(trouble=trouble), None, None

    times = {k: ((0.0, d),) for k, d in enumerate(durations_s)}
    return Trouble("ventilation", hit, 1.0, times)


def _intermittent(
    craft: Craft, _scene: Scene, durations_s: tuple[float, ...], rng: np.random.Generator
) -> Trouble:
    """One thruster drops out from time to time."""
    one = int(rng.integers(len(craft.names)))
    times: dict[int, tuple[tuple[float, float], ...]] = {}
    for k, d in enumerate(durations_s):
        spans, now = [], rng.uniform(5.0, 30.0)
        while now < d:
            end = min(now + rng.uniform(6.0, 20.0), d)
            spans.append((float(now), float(end)))
            now = end + rng.uniform(10.0, 40.0)
        times[k] = tuple(spans)

    def hit(craft: Craft, size: float, run: int, count: int) -> Hit:
        gains = np.ones((count, len(craft.names)))
        time_s = np.arange(count) * CONTROL_S
        for begin, end in times[run]:
            gains[(time_s >= begin) & (time_s < end), one] = max(1.0 - size, 0.0)
        return craft, None, gains

    overlaps = ("thruster_degraded",)
    return Trouble("intermittent_thruster", hit, 1.0, times, overlaps, craft.names[one])


def _lost_weight(
    _craft: Craft, scene: Scene, durations_s: tuple[float, ...], rng: np.random.Generator
) -> Trouble:
    """Ballast falls off in mid-run: a force that was not there before."""
    times = {k: ((rng.uniform(0.3, 0.7) * d, d),) for k, d in enumerate(durations_s)}
    force = 0.3 * scene.reach[2]

    def hit(craft: Craft, size: float, run: int, count: int) -> Hit:
        out = np.zeros((count + 1, 9))
        out[np.arange(count + 1) * CONTROL_S >= times[run][0][0], 2] = -size * force
        return craft, out, None

    return Trouble("lost_ballast", hit, 1.5, times, ("residual_buoyancy", "payload"))


_DRAWS = {
    "waves": _waves,
    "line_snag": _snag,
    "slow_flooding": _flooding,
    "ventilation": _ventilation,
    "intermittent_thruster": _intermittent,
    "lost_ballast": _lost_weight,
}
#: Names of the troubles outside the library.
TROUBLES = tuple(_DRAWS)
