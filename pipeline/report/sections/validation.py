"""The allocator flown in simulation: does the vehicle keep course, depth and speed."""

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.records.validation import AllocatorValidation, KeepingFlight
from pipeline.report import plotting
from pipeline.report.blocks import Blocks, Details, Figure, Gallery, Paragraph, Table, chapter
from pipeline.report.numbers import code, fixed, general, percent, speed
from pipeline.report.results import VehicleResults
from pipeline.report.sections.tables import explained
from pipeline.report.zoomable import Panel, Trace, zoomable_figure

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
        raise CannotComputeError(
            f"Not flown: {reason}" if results.vehicle.model is None else reason
        )
    yield Paragraph(
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
        yield Paragraph(
            f"Fixed point against floating point over {own.commands} commands of these flights: "
            f"{percent(own.differing_share)} of the codes differ, by at most "
            f"{own.largest_difference}."
        )
    yield Paragraph(validation.power_text)
    yield explained(validation.explanations)
    yield Details("What was flown", (_flown(validation),))


def _flown(validation: AllocatorValidation) -> Paragraph:
    axes = ("N on surge", "N on heave", "N m on pitch", "N m on yaw")
    pushed = [
        f"{fixed(size, 1)} {axis} every {fixed(period, 1)} s"
        for size, axis, period in zip(
            validation.disturbance, axes, validation.disturbance_period_s, strict=True
        )
        if size > 0.0
    ]
    return Paragraph(
        f"Each keeping flight lasts {validation.flight_s:g} s and starts at its speed with the "
        "thrusters where the allocator puts them for the drag there. Sines push the vehicle: "
        f"{', '.join(pushed) or 'none'}. Commands every {validation.control_period_s:g} s. "
        f"Without compensation: {validation.mooring_inverse}; with it: "
        f"{validation.compensated_inverse}."
    )


def _errors_figure(validation: AllocatorValidation) -> Figure:
    """Draw root mean square errors of speed, course and depth over the speed."""
    at = validation.settings_at_mps
    moored, compensated = (
        next(o for o in validation.keeping if o.variant == name and o.speed_mps == at)
        for name in ("mooring", "compensated")
    )
    rows: list[list[Trace]] = [[], [], []]
    for variant, name, colour, mark in _VARIANTS:
        kept, *errors = np.array(
            [
                (o.speed_mps, o.speed_error_mps, o.heading_error_deg, 100 * o.depth_error_m)
                for o in validation.keeping
                if o.variant == variant
            ]
        ).T
        for row, own in zip(rows, errors, strict=True):
            row.append(Trace(name, kept, own, colour, "both", mark=mark))
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
        [
            Panel(label, tuple(own), from_zero=True)
            for label, own in zip(_LABELS, rows, strict=True)
        ],
        x_label="speed to be kept V  [m/s]",
    )


def _traces_figure(validation: AllocatorValidation) -> Figure:
    """Draw speed, course and depth over time at one speed."""
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
        [Panel(label, tuple(own)) for label, own in zip(_LABELS, rows, strict=True)],
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
