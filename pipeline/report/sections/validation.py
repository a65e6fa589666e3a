"""The allocator flown in simulation: does the vehicle keep course, depth and speed."""

from pipeline.records.validation import AllocatorValidation, KeepingFlight, StepFlight
from pipeline.report.blocks import (
    Block,
    Details,
    Gallery,
    Paragraph,
    Section,
    Table,
    not_computed,
)
from pipeline.report.figures.validation import (
    cross_talk_figure,
    flight_errors_figure,
    flight_gain_figure,
    flight_traces_figure,
)
from pipeline.report.numbers import code, fixed, general, percent, speed
from pipeline.report.results import VehicleResults
from pipeline.report.sections.tables import explained

ANCHOR, TITLE = "validation", "Allocator in flight: course, depth and speed with these tables"

_NAMES = {"ideal": "ideal thrusters", "mooring": "mooring inverse", "compensated": "compensated"}


def validation_section(results: VehicleResults) -> Section:
    """Show how well the simulated vehicle keeps what it is told, and at what cost."""
    validation = results.validation
    if validation is None:
        reason = results.missing.get("validation", "the stage has not run")
        if results.vehicle.model is None:
            # nothing is wrong: a vehicle may be described for its tables alone
            return Section(ANCHOR, TITLE, (Paragraph(f"Not flown: {reason}"),), available=False)
        return not_computed(ANCHOR, TITLE, reason)
    blocks: list[Block] = [
        Paragraph(
            "The vehicle of the model section, simulated with whole codes, lag and limits, flown "
            "by the bundled autopilot. Everything here holds for that model: it shows what the "
            "tables do, not how well the model is."
        ),
        Gallery((flight_errors_figure(validation), flight_gain_figure(validation))),
        Gallery((flight_traces_figure(validation), cross_talk_figure(validation))),
        _keeping_table(validation),
        _cost_table(validation),
        Details("Every step at every speed", (_steps_table(validation),)),
    ]
    if validation.settings:
        blocks.append(_settings_table(validation))
    if validation.portions_flown:
        blocks.append(_portions_table(validation))
    if validation.fixed_point is not None:
        fixed_point = validation.fixed_point
        blocks.append(
            Paragraph(
                f"Fixed point against floating point over {fixed_point.commands} commands of "
                f"these flights: {percent(fixed_point.differing_share)} of the codes differ, by "
                f"at most {fixed_point.largest_difference}."
            )
        )
    blocks.append(Paragraph(validation.power_text))
    if validation.explanations:
        blocks += explained(validation.explanations)
    blocks.append(Details("What was flown", (_flown(validation),)))
    return Section(ANCHOR, TITLE, tuple(blocks))


def _shares(values: tuple[float, ...]) -> str:
    """Write shares of the ranges; what is not a thousandth of a percent is none."""
    return ", ".join(percent(share if share > 1e-5 else 0.0) for share in values) or "–"


def _flown(validation: AllocatorValidation) -> Paragraph:
    surge, heave, pitch, yaw = validation.disturbance
    periods = validation.disturbance_period_s
    pushed = [
        f"{fixed(size, 1)} {unit} on {name} every {fixed(period, 1)} s"
        for size, unit, name, period in (
            (surge, "N", "surge", periods[0]),
            (heave, "N", "heave", periods[1]),
            (pitch, "N m", "pitch", periods[2]),
            (yaw, "N m", "yaw", periods[3]),
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


def _keeping_table(validation: AllocatorValidation) -> Table:
    return Table(
        "Keeping speed, course, depth and pitch: rms errors",
        (
            "Speed, m/s",
            "Flown with",
            "Reached, m/s",
            "Speed error, m/s",
            "Course error, deg",
            "Depth error, m",
            "Pitch error, deg",
            "Wrench error: surge, heave, pitch, yaw",
        ),
        tuple(
            (
                speed(one.speed_mps),
                _NAMES[one.variant],
                fixed(one.reached_mps, 2),
                fixed(one.speed_error_mps, 4),
                fixed(one.heading_error_deg, 2),
                fixed(one.depth_error_m, 3),
                fixed(one.pitch_error_deg, 2),
                _shares(one.wrench_error),
            )
            for one in validation.keeping
        ),
        text_columns=frozenset({1}),
        note="Wrench error: what the codes give when settled less what was wanted after portions "
        "and limits, rms, in percent of the largest that the thrusters can make on that axis at "
        "that speed.",
    )


def _cost_table(validation: AllocatorValidation) -> Table:
    def watts(value: float | None) -> str:
        return "not known" if value is None else fixed(value, 1)

    def per_metre(one: KeepingFlight) -> str:
        power = one.shaft_power_w if one.electrical_power_w is None else one.electrical_power_w
        return "–" if power is None or one.reached_mps < 0.05 else fixed(power / one.reached_mps, 0)

    return Table(
        "Limits and power of the same flights",
        (
            "Speed, m/s",
            "Flown with",
            "Demands cut",
            "of surge",
            "Code at its end",
            "Largest code",
            "Against the flow",
            "Thrust x inflow, W",
            "At the shafts, W",
            "At the supply, W",
            "J per metre",
        ),
        tuple(
            (
                speed(one.speed_mps),
                _NAMES[one.variant],
                percent(one.cut_share),
                percent(one.cut_surge_share),
                percent(one.code_end_share),
                code(one.largest_code),
                percent(one.opposed_share),
                fixed(one.thrust_power_w, 1),
                watts(one.shaft_power_w),
                watts(one.electrical_power_w),
                per_metre(one),
            )
            for one in validation.keeping
            if one.variant != "ideal"
        ),
        text_columns=frozenset({1}),
        note="Against the flow: share of the time with a thruster that pushes against more than "
        "0.1 m/s, where the row at rest is a model. "
        "Compare power only where both reach the same speed: the slower one needs less. J "
        "per metre: supply, or shafts where the supply is not known, over the speed reached.",
    )


def _steps_table(validation: AllocatorValidation) -> Table:
    def row(one: StepFlight) -> tuple[str, ...]:
        def shown(own: bool, text: str) -> str:
            return f"({text})" if own else text

        return (
            speed(one.speed_at_mps),
            one.step,
            _NAMES[one.variant],
            fixed(one.speed_mps, 4),
            shown(one.step == "depth", fixed(one.depth_m, 4)),
            shown(one.step == "heading", fixed(one.heading_deg, 2)),
            fixed(one.pitch_deg, 2),
            _shares(one.wrench),
        )

    return Table(
        "What a step in one channel does to the others: largest deviation",
        (
            "Speed, m/s",
            "Step",
            "Flown with",
            "Speed changes by, m/s",
            "Depth changes by, m",
            "Course changes by, deg",
            "Pitch changes by, deg",
            "Wrench error: surge, heave, pitch, yaw",
        ),
        tuple(row(one) for one in validation.steps),
        text_columns=frozenset({1, 2}),
        note="Difference from the same flight without the step. In brackets the stepped channel: "
        "its largest distance from the same step with ideal thrusters.",
    )


def _settings_table(validation: AllocatorValidation) -> Table:
    own = next(
        one
        for one in validation.keeping
        if one.variant == "compensated" and one.speed_mps == validation.settings_at_mps
    )
    rows = [("as above", own), *((one.setting, one.flight) for one in validation.settings)]
    return Table(
        f"Compensated, one thing changed, at {speed(validation.settings_at_mps)} m/s: rms errors",
        (
            "Changed",
            "Speed error, m/s",
            "Course error, deg",
            "Depth error, m",
            "Surge force error",
            "Yaw error",
        ),
        tuple(
            (
                text,
                fixed(one.speed_error_mps, 4),
                fixed(one.heading_error_deg, 2),
                fixed(one.depth_error_m, 3),
                percent(one.wrench_error[0]),
                percent(one.wrench_error[3]),
            )
            for text, one in rows
        ),
    )


def _portions_table(validation: AllocatorValidation) -> Table:
    return Table(
        f"Portions varied, compensated, at {speed(validation.settings_at_mps)} m/s",
        (
            "Π_x surge",
            "Π_φ, Π_ψ heading, pitch",
            "Reached, m/s",
            "Speed error, m/s",
            "Course error, deg",
            "Demands cut",
            "Cut in a large turn",
            "Turned, deg",
        ),
        tuple(
            (
                fixed(one.surge, 2),
                fixed(one.heading, 2),
                fixed(one.flight.reached_mps, 2),
                fixed(one.flight.speed_error_mps, 4),
                fixed(one.flight.heading_error_deg, 2),
                percent(one.flight.cut_share),
                percent(one.heading_step_cut_share),
                general(one.heading_step_reached_deg, 3),
            )
            for one in validation.portions_flown
        ),
        note=f"The turn is a step of {fixed(validation.large_step_deg, 0)} deg; turned: largest "
        "heading within that flight.",
    )
