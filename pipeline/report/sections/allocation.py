"""The allocator: its wrench error with and without speed compensation, and flown in simulation."""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.records.validation import AllocationMap, AllocatorValidation, KeepingFlight
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Details, Figure, Gallery, Table, Text, chapter
from pipeline.report.numbers import code, fixed, general, percent, speed
from pipeline.report.results import VehicleResults, missing_reasons
from pipeline.report.sections.tables import explained
from pipeline.report.zoomable import Panel, Trace, zoomable_figure


@chapter("allocation", "Allocator: what the vehicle gets of what it asks for")
def allocation_section(results: VehicleResults) -> Blocks:
    """Show one number for each speed and variant."""
    allocation = results.allocation
    if allocation is None:
        stated = results.missing.get("allocation", "vehicle.yaml describes no allocator.")
        raise CannotComputeError(missing_reasons(results).get("allocation") or stated)
    surge, heading, pitch = (fixed(own, 2) for own in (*allocation.portions, 0.0, 0.0, 0.0)[:3])
    inverses = (
        f" Inverse without compensation: {allocation.mooring_inverse}; "
        f"with it: {allocation.compensated_inverse}."
        if allocation.mooring_inverse and allocation.compensated_inverse
        else ""
    )
    form = (
        "a portion is only the limit of a channel, so a demand within reach is realised"
        if allocation.form == "limit"
        else "eq. (6) as printed: every demand is multiplied by its portion"
    )
    yield _map_figure(allocation)
    yield Table.of(
        "Wrench error in percent of the available range",
        zip(allocation.mooring, allocation.compensated, strict=True),
        "Speed, m/s: {0.speed_mps:speed} | Worst, mooring inverse: {0.worst:percent} | "
        "Worst, compensated: {1.worst:percent} | Rms, mooring inverse: {0.rms:percent} | "
        "Rms, compensated: {1.rms:percent} | Demands within reach: {1.reachable_share:percent} | "
        "Within reach, opposed to motion: {1.opposed_share:percent}",
        note="One-sided range: the largest surge force, pitch and yaw moment that the thrusters "
        "can make at that speed. Opposed demands need thrust against the motion and are scored "
        "apart. Both shares are of all demands. The worst demands themselves are in "
        "allocation.json.",
    )
    yield Text(
        f"Form: {form}. Portions: surge (Π_x) {surge}, heading (Π_φ) {heading}, pitch (Π_ψ) "
        f"{pitch}.{inverses}"
    )
    yield explained(allocation.explanations)


def _map_figure(allocation: AllocationMap) -> Figure:
    first, last = allocation.mooring[0], allocation.mooring[-1]
    traces = []
    for name, errors, colour, mark in (
        ("mooring inverse", allocation.mooring, plotting.VERMILLION, "s"),
        ("compensated", allocation.compensated, plotting.BLUE, "o"),
    ):
        at, worst, rms = np.array([(one.speed_mps, one.worst, one.rms) for one in errors]).T
        worst, rms = (100 * np.maximum(own, 1e-6) for own in (worst, rms))
        traces += [
            Trace(f"{name}, worst", at, worst, colour, "both", mark=mark),
            Trace(f"{name}, rms", at, rms, colour, "both", mark=mark, dash="dash", hollow=True),
        ]
    return zoomable_figure(
        "fig-error-speed",
        f"Without compensation the worst wrench error grows from {percent(first.worst)} of the "
        f"available range at {speed(first.speed_mps)} m/s to {percent(last.worst)} at "
        f"{speed(last.speed_mps)} m/s; with it, it stays at or below "
        f"{percent(max(error.worst for error in allocation.compensated))}.",
        "One number for each speed, over surge, pitch and yaw demands within reach that need no "
        "thrust against the motion.",
        (Panel("wrench error\n[% of range]", traces, height=1.9, log=True),),
        x_label="speed V  [m/s]",
    )


#: Variant, what it is called, colour, mark.
_VARIANTS: tuple[tuple[str, str, str, str], ...] = (
    ("ideal", "ideal thrusters", plotting.SOFT, "^"),
    ("mooring", "mooring inverse", plotting.VERMILLION, "s"),
    ("compensated", "compensated", plotting.BLUE, "o"),
)
_NAMES = {variant: name for variant, name, *_ in _VARIANTS}
_LABELS = ("speed  [m/s]", "course  [deg]", "depth  [cm]")


@chapter("validation", "Allocator in flight: course, depth and speed with these tables")
def validation_section(results: VehicleResults) -> Blocks:
    """Show how well the simulated vehicle keeps what it is told, and at what cost."""
    validation = results.validation
    if validation is None:
        reason = results.missing.get("validation", "the stage has not run")
        # nothing is wrong: a vehicle may be described for its tables alone
        raise CannotComputeError(reason if results.vehicle.model else f"Not flown: {reason}")
    yield Text(
        "Simulated with whole codes, lag and limits, flown by the bundled autopilot. It shows "
        "what the tables do, not how well the vehicle file's model is."
    )
    yield Gallery((_errors_figure(validation), _traces_figure(validation)))
    yield Table.of(
        "Keeping speed, course, depth and pitch: rms errors",
        validation.keeping,
        lambda one: {
            "Speed, m/s": speed(one.speed_mps),
            "Flown with": _NAMES[one.variant],
            "Reached, m/s": fixed(one.reached_mps, 2),
            "Speed error, m/s": fixed(one.speed_error_mps, 4),
            "Course error, deg": fixed(one.heading_error_deg, 2),
            "Depth error, m": fixed(one.depth_error_m, 3),
            "Pitch error, deg": fixed(one.pitch_error_deg, 2),
            "Wrench error: surge, heave, pitch, yaw": ", ".join(
                percent(share if share > 1e-5 else 0.0) for share in one.wrench_error
            )
            or "–",
        },
        note="Wrench error: what the codes give when settled less what was wanted after portions "
        "and limits, rms, in percent of the largest that the thrusters can make on that axis at "
        "that speed.",
    )
    yield _cost_table(validation)
    own = validation.fixed_point
    if own is not None:
        yield Text(
            f"Fixed point against floating point over {own.commands} commands of these flights: "
            f"{percent(own.differing_share)} of the codes differ, by at most "
            f"{own.largest_difference}."
        )
    yield Text(validation.power_text)
    yield explained(validation.explanations)
    axes = ("N on surge", "N on heave", "N m on pitch", "N m on yaw")
    pushes = zip(validation.disturbance, axes, validation.disturbance_period_s, strict=True)
    pushed = [
        f"{fixed(n, 1)} {of} every {fixed(period, 1)} s" for n, of, period in pushes if n > 0.0
    ]
    text = (
        f"Each keeping flight lasts {validation.flight_s:g} s and starts at its speed with the "
        "thrusters where the allocator puts them for the drag there. Sines push the vehicle: "
        f"{', '.join(pushed) or 'none'}. Commands every {validation.control_period_s:g} s. Without "
        f"compensation: {validation.mooring_inverse}; with it: {validation.compensated_inverse}."
    )
    yield Details("What was flown", (Text(text),))


def _errors_figure(validation: AllocatorValidation) -> Figure:
    at = validation.settings_at_mps
    moored, compensated = (
        next(o for o in validation.keeping if o.variant == name and o.speed_mps == at)
        for name in ("mooring", "compensated")
    )
    rows: list[list[Trace]] = [[], [], []]
    for variant, name, colour, mark in _VARIANTS:
        own = [one for one in validation.keeping if one.variant == variant]
        kept, *errors = np.array(
            [
                (o.speed_mps, o.speed_error_mps, o.heading_error_deg, 100 * o.depth_error_m)
                for o in own
            ]
        ).T
        for row, error in zip(rows, errors, strict=True):
            row.append(Trace(name, kept, error, colour, "both", mark=mark))
    return zoomable_figure(
        "fig-flight-errors",
        f"Told to keep {speed(at)} m/s, the vehicle misses by "
        f"{general(moored.speed_error_mps, 2)} m/s (rms) with the mooring inverse and by "
        f"{general(compensated.speed_error_mps, 2)} m/s with compensation; the course by "
        f"{fixed(moored.heading_error_deg, 2)} and {fixed(compensated.heading_error_deg, 2)} deg, "
        f"the depth by {fixed(100 * moored.depth_error_m, 1)} and "
        f"{fixed(100 * compensated.depth_error_m, 1)} cm.",
        f"Root mean square over {validation.flight_s:g} s. The disturbance is the same at every "
        "speed and for everyone; ideal thrusters exert exactly the wrench that the autopilot "
        "wants, so their line is what the autopilot itself leaves.",
        [Panel(label, own, from_zero=True) for label, own in zip(_LABELS, rows, strict=True)],
        x_label="speed to be kept V  [m/s]",
    )


def _traces_figure(validation: AllocatorValidation) -> Figure:
    at = validation.traces_at_mps
    rows: list[list[Trace]] = [[], [], []]
    lowest = 0.0
    for variant, name, colour, _ in _VARIANTS:
        trace = next(one for one in validation.traces if one.variant == variant)
        depth = np.asarray(trace.depth_m)
        if variant == "mooring":
            lowest = min(trace.speed_mps)
        values = (np.asarray(trace.speed_mps), np.asarray(trace.heading_deg))
        for row, own in zip(rows, (*values, 100 * (depth - depth[0])), strict=True):
            row.append(Trace(name, np.asarray(trace.time_s), own, colour))
    return zoomable_figure(
        "fig-flight-traces",
        f"At {speed(at)} m/s the mooring inverse lets the speed fall to {fixed(lowest, 2)} m/s "
        "before the integral of the autopilot makes up for it.",
        f"The flights at {speed(at)} m/s. Depth downwards from the one to be kept.",
        [Panel(label, own) for label, own in zip(_LABELS, rows, strict=True)],
        x_label="time  [s]",
    )


def _cost_table(validation: AllocatorValidation) -> Table:
    def watts(value: float | None) -> str:
        return "not known" if value is None else fixed(value, 1)

    def per_metre(one: KeepingFlight) -> str:
        power = one.shaft_power_w if one.electrical_power_w is None else one.electrical_power_w
        return "–" if power is None or one.reached_mps < 0.05 else fixed(power / one.reached_mps, 0)

    return Table.of(
        "Limits and power of the same flights",
        [one for one in validation.keeping if one.variant != "ideal"],
        lambda one: {
            "Speed, m/s": speed(one.speed_mps),
            "Flown with": _NAMES[one.variant],
            "Demands cut": percent(one.cut_share),
            "of surge": percent(one.cut_surge_share),
            "Code at its end": percent(one.code_end_share),
            "Largest code": code(one.largest_code),
            "Against the flow": percent(one.opposed_share),
            "Thrust x inflow, W": fixed(one.thrust_power_w, 1),
            "At the shafts, W": watts(one.shaft_power_w),
            "At the supply, W": watts(one.electrical_power_w),
            "J per metre": per_metre(one),
        },
        note="Against the flow: share of the time with a thruster that pushes against more than "
        "0.1 m/s, where the row at rest is a model. "
        "Compare power only where both reach the same speed: the slower one needs less. J "
        "per metre: supply, or shafts where the supply is not known, over the speed reached.",
    )
