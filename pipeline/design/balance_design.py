"""The whole balance calculation: state, readings of the paper, saturation, envelope."""

import numpy as np

from pipeline.design.balance import (
    THRUSTERS,
    Balance,
    Condition,
    Slopes,
    balanced_angle_rad,
    constant_moment_nm,
    exact_balance,
    inflows_mps,
    slopes,
    small_angle_balance,
    thruster_loads,
)
from pipeline.design.balance_envelope import envelope, saturation_points
from pipeline.design.balance_hull import BodyHull, Hull, PolarHull
from pipeline.design.balance_input import BalanceInput
from pipeline.design.balance_limits import BalanceLimits, StatedLimits, TableLimits
from pipeline.design.printed import compare
from pipeline.errors import CannotComputeError
from pipeline.records.design import (
    BalanceDesign,
    SteadyState,
    SurgeReading,
)
from pipeline.vehicle.schema import Vehicle

#: Angles of attack beyond which the linear laws of eq. (4) were not shown to hold. [deg]
LINEAR_DEG = 4.0
AS_PRINTED = "T_x and T_y as printed"


def set_up(one: BalanceInput, vehicle: Vehicle | None) -> tuple[Hull, Condition]:
    """Return hull and condition, from the file and, where it names one, the vehicle.

    Raises
    ------
    CannotComputeError
        When the vehicle has no model or no allocator and the file does not state what they hold.
    """
    hull: Hull
    buoyancy = one.residual_buoyancy_n
    if one.hull is not None and one.metacentric_nm_per_rad is not None:
        hull = PolarHull(one.hull, one.metacentric_nm_per_rad)
    else:
        if vehicle is None or vehicle.model is None:
            name = one.vehicle if vehicle is None else vehicle.name
            raise CannotComputeError(
                f"{name} has no model: section to take the hull from.\nState hull: and "
                "metacentric_nm_per_rad: in the design file."
            )
        hull, own = BodyHull.of_model(
            vehicle.model, vehicle.water.gravity_mps2, vehicle.water.density_kgpm3
        )
        buoyancy = own if buoyancy is None else buoyancy
    if buoyancy is None:
        raise CannotComputeError("State residual_buoyancy_n: in the design file.")
    if one.thrusters is not None:
        angle = one.thrusters.angle_deg
        pitch, heading = one.thrusters.pitch_arm_m, one.thrusters.heading_arm_m
    elif vehicle is not None and vehicle.allocator is not None:
        angle = vehicle.allocator.delta_deg
        pitch = heading = vehicle.allocator.stern_arm_m
    else:
        name = one.vehicle if vehicle is None else vehicle.name
        raise CannotComputeError(
            f"{name} has no allocator: section, which gives angle and arm of the four stern "
            "thrusters.\nState thrusters: in the design file; the balance is that of eq. (5), four "
            "inclined thrusters at the stern."
        )
    return hull, Condition(one.speed_mps, buoyancy, angle, pitch, heading, one.heading_moment_nm)


def steady_state(
    method: str, balance: Balance, condition: Condition, limits: BalanceLimits
) -> SteadyState:
    """Put a balance with the loads of its thrusters into a record."""
    inflows = inflows_mps(condition.speed_mps, balance.alpha_rad, condition.angle_deg)
    return SteadyState(
        method=method,
        angle_of_attack_deg=float(np.degrees(balance.alpha_rad)),
        surge_force_n=balance.surge_n,
        vertical_force_n=balance.vertical_n,
        loads=tuple(
            limits.load(name, load, inflow, condition.speed_mps)
            for name, load, inflow in zip(THRUSTERS, balance.loads_n, inflows, strict=True)
        ),
    )


def design_balance(
    one: BalanceInput, vehicle: Vehicle | None = None, tables: TableLimits | None = None
) -> BalanceDesign:
    """Compute what ``rig2sea design balance`` shows, of a file and the vehicle that it names.

    A limit that the file states goes before `tables`, the vehicle's identified thrusters.

    Raises
    ------
    CannotComputeError
        When the exact form cannot carry the buoyancy, or something that is needed is not stated.
    """
    hull, condition = set_up(one, vehicle)
    limits, judged = _limits(one, tables)
    exact = exact_balance(hull, condition)
    linear = slopes(hull, condition)
    small, apart = _small_angle(hull, linear, condition, exact)
    found = steady_state("exact", exact, condition, limits)
    approximate = None
    if small is not None:
        approximate = steady_state("small angle, eqs. (7) to (9)", small, condition, limits)
    power, shaft = _preliminary(one, exact if small is None else small)
    quantities = _quantities(approximate, found)
    if power is not None:
        quantities["power_w"] = (power, "W")
    readings = _readings(one, linear, small, exact, condition)
    for reading in readings:
        if reading.reading == AS_PRINTED:
            for thruster, load in zip(THRUSTERS, reading.loads_n, strict=True):
                quantities[f"{thruster}_n_from_printed"] = (load, "N")
            if one.limit.propeller_efficiency is not None:
                most = max(reading.loads_n) * one.speed_mps / one.limit.propeller_efficiency
                quantities["power_w_from_printed"] = (most, "W")
    printed, unknown = compare(one.published, quantities)
    return BalanceDesign(
        name=one.name,
        title=one.title,
        source=one.source,
        vehicle=one.vehicle or "",
        speed_mps=one.speed_mps,
        residual_buoyancy_n=condition.residual_buoyancy_n,
        angle_deg=condition.angle_deg,
        exact=found,
        small_angle=approximate,
        readings=readings,
        preliminary_power_w=power,
        preliminary_shaft_speed_rpm=shaft,
        limit_kind=limits.kind,
        saturation=saturation_points(one, hull, condition, limits),
        envelope=envelope(one, hull, condition, limits),
        printed=printed,
        published_source=one.published.source if one.published else "",
        warnings=(
            *judged,
            *apart,
            *_warnings(found, limits, one),
            *unknown,
        ),
    )


def _limits(one: BalanceInput, tables: TableLimits | None) -> tuple[BalanceLimits, tuple[str, ...]]:
    """Return what loads are judged by: a stated limit goes before the tables, with a warning."""
    stated = StatedLimits(one.limit)
    if tables is None:
        return stated, ()
    if not stated.kind:
        return tables, ()
    text = (
        f"limit: of the design file holds, {stated.kind}, and not {tables.kind}. Without "
        "thrust_max_n: and power_max_w: in the file the tables hold."
    )
    return stated, (text,)


def _small_angle(
    hull: Hull, linear: Slopes, condition: Condition, exact: Balance
) -> tuple[Balance | None, tuple[str, ...]]:
    """Solve the small-angle form and say where it is off, and why, or why it has no state."""
    try:
        small = small_angle_balance(linear, condition)
    except CannotComputeError as error:
        left_out = "The small-angle form is left out, the exact form holds."
        return None, (" ".join([left_out, *str(error).splitlines()]),)
    apart_rad = abs(small.alpha_rad - exact.alpha_rad)
    apart = float(np.degrees(apart_rad))
    if apart <= max(0.1 * abs(float(np.degrees(exact.alpha_rad))), 0.1):
        return small, ()
    moment = constant_moment_nm(hull, condition)
    free_rad = balanced_angle_rad(hull, condition, moment)
    free_rad = exact.alpha_rad if free_rad is None else free_rad
    # without that moment both forms come together: so it is what parts them
    if abs(small.alpha_rad - free_rad) < 0.5 * apart_rad:
        text = (
            f"The small-angle form is {apart:.1f} deg off: (7) lacks the moment of {moment:.3g} "
            "N m that acts at zero angle of attack. The exact form holds."
        )
    else:
        text = (
            f"The small-angle form is {apart:.1f} deg off: over these angles the forces on this "
            "hull are far from linear. The exact form holds."
        )
    return small, (text,)


def _preliminary(one: BalanceInput, state: Balance) -> tuple[float | None, float | None]:
    """Power (10) and shaft speed (11) of the most loaded thruster."""
    efficiency, diameter = one.limit.propeller_efficiency, one.limit.diameter_m
    most = max(abs(load) for load in state.loads_n)
    power = None if efficiency is None else most * one.speed_mps / efficiency
    return power, None if diameter is None else 60.0 * one.speed_mps / diameter


def _quantities(small: SteadyState | None, exact: SteadyState) -> dict[str, tuple[float, str]]:
    """Name what printed tables can be compared with: the small-angle form and the exact one."""
    known: dict[str, tuple[float, str]] = {}
    for suffix, state in (("", small), ("_exact", exact)):
        if state is None:
            continue
        known[f"angle_of_attack_deg{suffix}"] = (state.angle_of_attack_deg, "deg")
        known[f"surge_force_n{suffix}"] = (state.surge_force_n, "N")
        known[f"vertical_force_n{suffix}"] = (state.vertical_force_n, "N")
        for load in state.loads:
            known[f"{load.thruster}_n{suffix}"] = (load.thrust_n, "N")
    return known


def _readings(
    one: BalanceInput,
    linear: Slopes,
    small: Balance | None,
    exact: Balance,
    condition: Condition,
) -> tuple[SurgeReading, ...]:
    """Show the surge force by each formula of the paper and as printed, with its loads."""
    rows = []
    if small is not None:
        rows = [
            ("(8) as printed", small.surge_n, small.vertical_n),
            # T_x = R_0 + T_y alpha
            (
                "first line of (6)",
                linear.drag_n + small.vertical_n * small.alpha_rad,
                small.vertical_n,
            ),
        ]
    if one.published is not None:
        stated = {value.quantity: value.value for value in one.published.values}
        if "surge_force_n" in stated:
            vertical = stated.get("vertical_force_n", (small or exact).vertical_n)
            rows.append((AS_PRINTED, stated["surge_force_n"], vertical))
    rows.append(("exact form of (1)", exact.surge_n, exact.vertical_n))
    return tuple(
        SurgeReading(
            reading=text, surge_force_n=surge, loads_n=thruster_loads(surge, vertical, condition)
        )
        for text, surge, vertical in rows
    )


def _warnings(state: SteadyState, limits: BalanceLimits, one: BalanceInput) -> tuple[str, ...]:
    found = []
    if one.hull is not None and abs(state.angle_of_attack_deg) > LINEAR_DEG:
        found.append(
            f"The angle of attack is {state.angle_of_attack_deg:.1f} deg; Kostenko 2017 shows the "
            f"linear laws of eq. (4) up to {LINEAR_DEG:g} deg."
        )
    for load in state.loads:
        if load.use is not None and load.use > 1.0 and load.limit_n is not None:
            found.append(
                f"The {load.thruster} thruster is beyond its limit: {load.thrust_n:.1f} N are "
                f"needed, {load.limit_n:.1f} N is all it gives at {one.speed_mps:g} m/s."
            )
        if load.thrust_n < 0:
            found.append(
                f"The {load.thruster} thruster must push backwards: {load.thrust_n:.1f} N."
            )
    fastest = max(one.speed_mps, one.envelope.speed_mps.last)
    if isinstance(limits, TableLimits) and fastest > limits.fastest_mps:
        found.append(
            f"The identified thrust is known up to {limits.fastest_mps:g} m/s; beyond, its last "
            "values are held, which promises too much."
        )
    return tuple(found)
