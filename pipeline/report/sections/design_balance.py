"""Pages of the balance calculation (Kostenko 2017)."""

from collections.abc import Sequence

import numpy as np

from pipeline.records.design import BalanceDesign
from pipeline.report import plotting
from pipeline.report.bars import Bar, bars_figure
from pipeline.report.blocks import Blocks, Bullets, Figure, Gallery, Table, Text, chapter
from pipeline.report.numbers import fixed, general, speed, use_of_limit
from pipeline.report.zoomable import Panel, Trace, zoomable_figure
from pipeline.types import FloatArray

#: A use beyond this is drawn at the edge.
_MOST_USE = 2.0


@chapter("state", "Angle of attack and thruster loads")
def state_section(found: BalanceDesign) -> Blocks:
    """Show the steady state, and what each thruster carries in it."""
    yield Text(
        f"{speed(found.speed_mps)} m/s, residual buoyancy {general(found.residual_buoyancy_n)} N "
        f"upwards, stern thrusters at {general(found.angle_deg)} deg. Steady and level, eq. (1) of "
        "Kostenko 2017 is three equations for angle of attack, surge and vertical force. The "
        "moment of weight and buoyancy rights the vehicle: the paper prints it with plus in (1) "
        "and (3), with minus in (6); only the minus rights."
    )
    yield Table.of(
        "Steady state",
        [one for one in (found.exact, found.small_angle) if one is not None],
        lambda state: {
            "Form": state.method,
            "angle of attack, deg": fixed(state.angle_of_attack_deg, 2),
            "surge, N": fixed(state.surge_force_n, 1),
            "vertical, N": fixed(state.vertical_force_n, 1),
            **{f"{load.thruster}, N": fixed(load.thrust_n, 1) for load in state.loads},
        },
        note="Angle of attack nose up, vertical force upwards, in body axes.",
    )
    yield Table.of(
        "Loads of the exact form",
        found.exact.loads,
        "Thruster: {thruster} | thrust, N: {thrust_n:.1f} | inflow, m/s: {inflow_mps:.2f} | code: "
        "{code:.1f} | shaft speed, rpm: {shaft_speed_rpm:.0f} | torque, N m: {torque_nm:.3f} | "
        "power, W: {power_w:.0f} | limit, N: {limit_n:.1f} | use: {use:use}",
        note="Inflow is the speed of the water along the thruster. Code, shaft speed and torque "
        "need a vehicle with bench tables; power without them is by eq. (10).",
    )
    power, rpm = found.preliminary_power_w, found.preliminary_shaft_speed_rpm
    if power is not None:
        turns = "" if rpm is None else f" at {fixed(rpm, 0)} rpm by eq. (11), an advance ratio of 1"
        form = "exact form" if found.small_angle is None else "small-angle form"
        yield Text(
            f"Drive of the most loaded thruster in the {form}: {fixed(power, 0)} W by eq. (10)"
            f"{turns}."
        )
    loads = found.exact.loads
    most = max(loads, key=lambda load: abs(load.thrust_n))
    limits = (
        f"{use_of_limit(o.use)} of {fixed(o.limit_n, 0)} N" if o.limit_n else "" for o in loads
    )
    low, high = min(0.0, 1.2 * min(one.thrust_n for one in loads)), 1.4 * abs(most.thrust_n)
    yield bars_figure(
        "loads",
        f"The {most.thruster} thruster carries most, {fixed(most.thrust_n, 1)} N.",
        f"Exact form. Limit: {found.limit_kind}."
        if found.limit_kind
        else "Exact form; no limit is stated.",
        [Bar(o.thruster, o.thrust_n, text=own) for o, own in zip(loads, limits, strict=True)],
        x_label="thrust  [N]",
        x_range=(low, max(high, 1e-9)),
    )


@chapter("readings", "The surge force, read in several ways")
def readings_section(found: BalanceDesign) -> Blocks:
    """Show what each reading of the paper's signs gives."""
    yield Text(
        "(8) has T_y alpha with another sign than the first line of (6); both are "
        "small terms. The exact form needs no such choice and is the one that counts."
        if found.small_angle is not None
        else "The small-angle form has no state here, so (8) and (6) give no surge force."
    )
    yield Table.of(
        "Surge force and loads by each reading",
        found.readings,
        "Reading: {reading} | T_x, N: {surge_force_n:.1f} | left, N: {loads_n[0]:.1f} | "
        "right, N: {loads_n[1]:.1f} | upper, N: {loads_n[2]:.1f} | lower, N: {loads_n[3]:.1f}",
    )


@chapter("envelope", "Envelope, and which thruster saturates first")
def envelope_section(found: BalanceDesign) -> Blocks:
    """Show how loads and their limit go with speed, buoyancy and the thrusters' angle."""
    yield Text(
        f"Limit: {found.limit_kind}. One quantity is changed alone:"
        if found.saturation
        else "No limit of a thruster is stated and no vehicle with bench tables is named, so "
        "saturation cannot be judged."
    )
    yield Bullets(tuple(one.text for one in found.saturation)) if found.saturation else None
    yield Gallery((use_figure(found), _angle_figure(found)))


def _by_buoyancy(found: BalanceDesign, x: Sequence[float], rows: FloatArray) -> tuple[Trace, ...]:
    buoyancies = found.envelope.residual_buoyancy_n
    chosen = np.unique(np.linspace(0, len(buoyancies) - 1, 5).round().astype(int)).tolist()
    colours = plotting.ordered_colours(len(chosen))
    return tuple(
        Trace(f"{general(buoyancies[j])} N", np.array(x), rows[j], colour)
        for j, colour in zip(chosen, colours, strict=True)
    )


def use_figure(found: BalanceDesign) -> Figure:
    """Draw the largest use (or load) over speed, a line for each of several buoyancies."""
    envelope = found.envelope
    k = int(np.argmin(np.abs(np.array(envelope.angle_deg) - found.angle_deg)))
    judged = bool(found.limit_kind)
    load = np.array(envelope.largest_load_n)[:, :, k]
    shown = np.where(load > 0, np.array(envelope.use)[:, :, k] if judged else load, np.nan)
    drawn = np.minimum(shown, _MOST_USE) if judged else shown
    traces = _by_buoyancy(found, envelope.speed_mps, drawn.T)
    label = "use of the most\nloaded thruster  [–]" if judged else "largest load  [N]"
    panel = Panel(label, traces, height=1.9, limits=(1.0,) if judged else (), from_zero=True)
    limit = f" Dotted: the limit, {found.limit_kind}." if judged else ""
    return zoomable_figure(
        "use-map",
        _of_the_map(shown[np.isfinite(shown)], judged=judged),
        f"Thrusters at {general(envelope.angle_deg[k])} deg, the nearest of the envelope to the "
        f"design's {general(found.angle_deg)} deg; one line for each residual buoyancy.{limit}",
        (panel,),
        x_label="speed  [m/s]",
    )


def _of_the_map(use: FloatArray, *, judged: bool) -> str:
    """Say what is to be seen; the limit is passed only where the use passes 1."""
    if not use.size:
        return "Nowhere in the envelope does an angle of attack balance force and moment."
    if not judged:
        return "The load of the most loaded thruster over speed and buoyancy."
    if use.max() <= 1.0:
        return "No thruster comes to its limit anywhere in the envelope."
    if use.min() >= 1.0:
        return "The most loaded thruster is beyond its limit everywhere in the envelope."
    return "Beyond the dotted line the most loaded thruster has nothing left."


def _angle_figure(found: BalanceDesign) -> Figure:
    envelope = found.envelope
    i = int(np.argmin(np.abs(np.array(envelope.speed_mps) - found.speed_mps)))
    load = np.array(envelope.largest_load_n)[i]
    traces = _by_buoyancy(found, envelope.angle_deg, np.where(load > 0, load, np.nan))
    return zoomable_figure(
        "angle",
        "A larger angle gives more vertical force for the same thrust and costs thrust ahead.",
        f"At {general(envelope.speed_mps[i])} m/s; one line for each residual buoyancy. The "
        f"design's angle is {general(found.angle_deg)} deg.",
        (Panel("largest load  [N]", traces, height=1.9),),
        x_label="angle of the thrusters to the axis  [deg]",
    )
