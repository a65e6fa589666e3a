"""The allocator in flight: errors over speed, what was given of what was wanted, traces, steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.records.validation import AllocatorValidation, KeepingFlight, StepFlight
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.numbers import fixed, general, percent, speed

if TYPE_CHECKING:
    import matplotlib.figure

#: Variant, label, colour, marker.
STYLES = (
    ("ideal", "ideal thrusters", plotting.SOFT, "^"),
    ("mooring", "mooring inverse", plotting.VERMILLION, "s"),
    ("compensated", "compensated", plotting.BLUE, "o"),
)


def flights_of(validation: AllocatorValidation, variant: str) -> list[KeepingFlight]:
    """Return the keeping flights of a variant, by speed."""
    return [one for one in validation.keeping if one.variant == variant]


def steps_of(validation: AllocatorValidation, variant: str, step: str) -> list[StepFlight]:
    """Return the step flights of a variant, by speed."""
    return [one for one in validation.steps if one.variant == variant and one.step == step]


def flight_errors_figure(validation: AllocatorValidation) -> Figure:
    """Root mean square errors of speed, course and depth over the speed."""
    at = validation.settings_at_mps
    moored, compensated = (
        next(one for one in flights_of(validation, name) if one.speed_mps == at)
        for name in ("mooring", "compensated")
    )
    lead = (
        f"Told to keep {speed(at)} m/s, the vehicle misses by "
        f"{general(moored.speed_error_mps, 2)} m/s (rms) with the mooring inverse and by "
        f"{general(compensated.speed_error_mps, 2)} m/s with compensation; the course by "
        f"{fixed(moored.heading_error_deg, 2)} and {fixed(compensated.heading_error_deg, 2)} deg, "
        f"the depth by {fixed(100 * moored.depth_error_m, 1)} and "
        f"{fixed(100 * compensated.depth_error_m, 1)} cm."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots(3, 1, sharex=True)
        for variant, label, colour, marker in STYLES:
            flights = flights_of(validation, variant)
            x = [one.speed_mps for one in flights]
            rows = (
                [one.speed_error_mps for one in flights],
                [one.heading_error_deg for one in flights],
                [100 * one.depth_error_m for one in flights],
            )
            for one, values in zip(axes, rows, strict=True):
                one.plot(x, values, marker=marker, color=colour, label=label)
        for one, text in zip(axes, ("speed  [m/s]", "course  [deg]", "depth  [cm]"), strict=True):
            one.set_ylabel(text)
            # only after every line: it also ends the scaling to the data
            one.set_ylim(bottom=0.0)
        axes[-1].set_xlabel("speed to be kept V  [m/s]")
        plotting.legend_above(figure, axes[0])

    alt = "Rms errors of speed, course and depth over the speed, three lines each."
    return Figure(
        "fig-flight-errors",
        lead,
        plotting.draw("fig-flight-errors", alt, paint, height_in=4.8),
        f"Root mean square over {validation.flight_s:g} s. The disturbance is the same at every "
        "speed and for everyone; ideal thrusters exert exactly the wrench that the autopilot "
        "wants, so their line is what the autopilot itself leaves.",
    )


def flight_gain_figure(validation: AllocatorValidation) -> Figure:
    """Given over wanted force and moment, by axis and speed."""
    moored = flights_of(validation, "mooring")
    surge = [one.wrench_gain[0] for one in moored]
    known = [gain for gain in surge if gain is not None]
    lead = (
        f"Under way the mooring inverse gives {percent(min(known))} to {percent(max(known))} of "
        "the surge force that is wanted."
        if known
        else "Next to no surge force was wanted."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots(3, 1, sharex=True, sharey=True)
        for variant, label, colour, marker in STYLES[1:]:
            flights = flights_of(validation, variant)
            for one, axis in zip(axes, (0, 1, 3), strict=True):
                points = [
                    (flight.speed_mps, 100 * gain)
                    for flight in flights
                    if (gain := flight.wrench_gain[axis]) is not None
                ]
                if points:
                    x, y = zip(*points, strict=True)
                    one.plot(x, y, marker=marker, color=colour, label=label)
        for one, text in zip(axes, ("surge", "heave", "yaw"), strict=True):
            one.axhline(100.0, color=plotting.SOFT, lw=0.8)
            one.set_ylabel(f"{text}  [%]")
            one.set_xlim(-0.05, validation.speed_mps[-1] * 1.05)
        axes[-1].set_xlabel("speed V  [m/s]")
        plotting.legend_above(figure, axes[0])

    alt = "Share of the wanted surge, heave and yaw that was given, over speed, two lines each."
    return Figure(
        "fig-flight-gain",
        lead,
        plotting.draw("fig-flight-gain", alt, paint, height_in=4.8),
        "Given over wanted, by least squares over the flight. It is the factor by which each "
        "regulator's gain is changed without its knowledge; 100 % changes nothing. No point "
        "where next to nothing was wanted.",
    )


def flight_traces_figure(validation: AllocatorValidation) -> Figure:
    """Speed, course and depth over time at one speed."""
    at = validation.traces_at_mps
    moored = next(one for one in validation.traces if one.variant == "mooring")
    lead = (
        f"At {speed(at)} m/s the mooring inverse lets the speed fall to "
        f"{fixed(min(moored.speed_mps), 2)} m/s before the integral of the autopilot makes up "
        "for it."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots(3, 1, sharex=True)
        for variant, label, colour, _ in STYLES:
            trace = next(one for one in validation.traces if one.variant == variant)
            depth = np.asarray(trace.depth_m)
            rows = (trace.speed_mps, trace.heading_deg, 100 * (depth - depth[0]))
            for one, values in zip(axes, rows, strict=True):
                one.plot(trace.time_s, values, color=colour, label=label, lw=1.2)
        for one, text in zip(axes, ("speed  [m/s]", "course  [deg]", "depth  [cm]"), strict=True):
            one.set_ylabel(text)
        axes[-1].set_xlabel("time  [s]")
        plotting.legend_above(figure, axes[0])

    alt = "Speed, course and depth over time with ideal thrusters and both inverses."
    return Figure(
        "fig-flight-traces",
        lead,
        plotting.draw("fig-flight-traces", alt, paint, height_in=4.8),
        f"The flights at {speed(at)} m/s. Depth downwards from the one to be kept.",
    )


def cross_talk_figure(validation: AllocatorValidation) -> Figure:
    """Largest deviations of the channels that were not stepped, by speed."""

    def largest(variant: str) -> float:
        return max(one.pitch_deg for one in steps_of(validation, variant, "depth"))

    lead = (
        f"A depth step of {fixed(validation.depth_step_m, 1)} m throws the pitch off by up to "
        f"{fixed(largest('mooring'), 2)} deg with the mooring inverse, "
        f"{fixed(largest('compensated'), 2)} deg with compensation and "
        f"{fixed(largest('ideal'), 2)} deg with ideal thrusters."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots(3, 1, sharex=True)
        for variant, label, colour, marker in STYLES:
            heading = steps_of(validation, variant, "heading")
            depth = steps_of(validation, variant, "depth")
            x = [one.speed_at_mps for one in heading]
            rows = (
                [100 * one.speed_mps for one in heading],
                [100 * one.speed_mps for one in depth],
                [one.pitch_deg for one in depth],
            )
            for one, values in zip(axes, rows, strict=True):
                one.plot(x, values, marker=marker, color=colour, label=label)
        texts = (
            "heading step:\nspeed  [cm/s]",
            "depth step:\nspeed  [cm/s]",
            "depth step:\npitch  [deg]",
        )
        for one, text in zip(axes, texts, strict=True):
            one.set_ylabel(text)
            one.set_ylim(bottom=0.0)
        axes[-1].set_xlabel("speed V  [m/s]")
        plotting.legend_above(figure, axes[0])

    alt = "Largest deviation of speed and pitch after steps of heading and depth, over speed."
    return Figure(
        "fig-cross-talk",
        lead,
        plotting.draw("fig-cross-talk", alt, paint, height_in=4.8),
        f"Steps of {fixed(validation.heading_step_deg, 0)} deg and "
        f"{fixed(validation.depth_step_m, 1)} m while the rest is kept; largest difference from "
        "the same flight without the step. What ideal thrusters show is the hull's own coupling.",
    )
