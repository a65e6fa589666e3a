"""Where the first thruster saturates, and the exact states over speed, buoyancy and angle."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from pipeline.design.balance import THRUSTERS, Balance, Condition, exact_balance, inflows_mps
from pipeline.design.balance_hull import Hull
from pipeline.design.balance_input import BalanceInput, InputSpan
from pipeline.design.balance_limits import BalanceLimits
from pipeline.errors import CannotComputeError
from pipeline.records.design import BalanceEnvelope, Saturation


def _worst(
    hull: Hull, condition: Condition, limits: BalanceLimits
) -> tuple[float, str, float, Balance]:
    """Return the largest use, its thruster, the largest load and the state; raises if none."""
    state = exact_balance(hull, condition)
    inflows = inflows_mps(condition.speed_mps, state.alpha_rad, condition.angle_deg)
    uses = [
        limits.use(load, inflow, condition.speed_mps)
        for load, inflow in zip(state.loads_n, inflows, strict=True)
    ]
    loads = [abs(load) for load in state.loads_n]
    judged = loads if uses[0] is None else [0.0 if use is None else use for use in uses]
    # of two that are equal the first: rounding must not choose
    at = next(i for i, value in enumerate(judged) if value >= max(judged) * (1 - 1e-9))
    name = THRUSTERS[at]
    if at == 0 and abs(judged[0] - judged[1]) <= 1e-9 * judged[0]:
        name = "left and right"
        if judged[2] >= judged[0] * (1 - 1e-9) and judged[3] >= judged[0] * (1 - 1e-9):
            name = "all four"
    return (0.0 if uses[0] is None else judged[at]), name, max(loads), state


def saturation_points(
    one: BalanceInput, hull: Hull, condition: Condition, limits: BalanceLimits
) -> tuple[Saturation, ...]:
    """Change speed or buoyancy alone until the first thruster has nothing left."""
    if not limits.kind:
        return ()
    spans = one.envelope

    def at_speed(x: float) -> tuple[float, str, float, Balance]:
        return _worst(hull, replace(condition, speed_mps=x), limits)

    def at_buoyancy(x: float) -> tuple[float, str, float, Balance]:
        return _worst(hull, replace(condition, residual_buoyancy_n=x), limits)

    speed, buoyancy = spans.speed_mps, spans.residual_buoyancy_n
    least, most = buoyancy.first, buoyancy.last
    vary = (
        ("speed", "m/s", speed.first, speed.last, at_speed),
        ("residual buoyancy, lighter", "N", max(least, 0.0), max(most, 0.0), at_buoyancy),
        ("residual buoyancy, heavier", "N", min(most, 0.0), min(least, 0.0), at_buoyancy),
    )
    return tuple(
        _first(name, unit, start, end, worst)
        for name, unit, start, end, worst in vary
        if start != end
    )


def _first(
    name: str,
    unit: str,
    start: float,
    end: float,
    worst: Callable[[float], tuple[float, str, float, Balance]],
) -> Saturation:
    """Find the first value between start and end at which a thruster has nothing left."""

    def none(text: str) -> Saturation:
        return Saturation(quantity=name, unit=unit, value=None, text=text)

    def balances(x: float) -> bool:
        try:
            worst(x)
        except CannotComputeError:
            return False
        return True

    def over(x: float) -> float:
        return worst(x)[0] - 1.0 if balances(x) else 1.0

    grid = np.linspace(start, end, 25)
    values = np.array([over(float(x)) for x in grid])
    # at a crawl no hull lifts: the search begins where the vehicle can hold itself at all
    held = np.flatnonzero(values <= 0)
    if not held.size:
        if any(balances(float(x)) for x in grid):
            return none(f"{name}: a thruster is beyond its limit from {start:g} to {end:g} {unit}.")
        return none(f"{name}: no angle of attack balances from {start:g} to {end:g} {unit}.")
    beyond = np.flatnonzero(values[held[0] :] > 0)
    if not beyond.size:
        return none(f"{name}: no thruster comes to its limit up to {end:g} {unit}.")
    i = int(held[0] + beyond[0])
    first, last = float(grid[i - 1]), float(grid[i])
    if not balances(last):
        last = _last_balanced(balances, first, last)
        if over(last) <= 0.0:
            return none(
                f"{name}: no thruster comes to its limit up to {last:.3g} {unit}; beyond, "
                "no angle of attack balances force and moment."
            )
    value = float(brentq(over, first, last, xtol=1e-6 * max(abs(start), abs(end))))
    thruster = worst(first + 0.999999 * (value - first))[1]
    return Saturation(
        quantity=name,
        unit=unit,
        value=value,
        thruster=thruster,
        text=f"{name}: the {thruster} thruster{_s(thruster)} first, at {value:.3g} {unit}.",
    )


def _last_balanced(balances: Callable[[float], bool], first: float, last: float) -> float:
    """Halve the way from a value that balances to one that does not; returns one that does."""
    for _ in range(40):
        middle = 0.5 * (first + last)
        first, last = (middle, last) if balances(middle) else (first, middle)
    return first


def _s(thruster: str) -> str:
    return "s saturate" if thruster in ("all four", "left and right") else " saturates"


def _values(span: InputSpan, design: float) -> list[float]:
    """Return the span's values and, where it lies within, the design's own."""
    values = {float(x) for x in np.linspace(span.first, span.last, span.points)}
    if span.first < design < span.last and min(abs(x - design) for x in values) > 1e-9:
        values.add(design)
    return sorted(values)


def envelope(
    one: BalanceInput, hull: Hull, condition: Condition, limits: BalanceLimits
) -> BalanceEnvelope:
    """Solve the exact state over speed, buoyancy and angle of the thrusters."""
    speeds = _values(one.envelope.speed_mps, condition.speed_mps)
    buoyancies = _values(one.envelope.residual_buoyancy_n, condition.residual_buoyancy_n)
    angles = _values(one.envelope.angle_deg, condition.angle_deg)
    shape = (len(speeds), len(buoyancies), len(angles))
    alpha, load, use = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    most = np.full(shape, "", dtype=object)
    for i, speed in enumerate(speeds):
        for j, buoyancy in enumerate(buoyancies):
            for k, angle in enumerate(angles):
                at = replace(
                    condition, speed_mps=speed, residual_buoyancy_n=buoyancy, angle_deg=angle
                )
                try:
                    use[i, j, k], most[i, j, k], load[i, j, k], state = _worst(hull, at, limits)
                except CannotComputeError:
                    continue
                alpha[i, j, k] = np.degrees(state.alpha_rad)
    return BalanceEnvelope(
        speed_mps=tuple(speeds),
        residual_buoyancy_n=tuple(buoyancies),
        angle_deg=tuple(angles),
        angle_of_attack_deg=tuple(tuple(tuple(row) for row in part) for part in alpha.tolist()),
        largest_load_n=tuple(tuple(tuple(row) for row in part) for part in load.tolist()),
        use=tuple(tuple(tuple(row) for row in part) for part in use.tolist()),
        most_loaded=tuple(tuple(tuple(row) for row in part) for part in most.tolist()),
    )
