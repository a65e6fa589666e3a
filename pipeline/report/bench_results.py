"""What is told first of a vehicle, and what the bench gave of it in one line and one picture."""

from __future__ import annotations

import numpy as np

from pipeline.control.inverse import thrust_grid
from pipeline.language import as_it_is
from pipeline.physics.thrust_grid import thrust_from_code
from pipeline.records.base import LIGHTS, Advice, Glance, Light
from pipeline.records.fits import FirmwareCharacteristic, InverseCharacteristic
from pipeline.records.measurements import MooringRecord
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.numbers import code, fixed, plural
from pipeline.report.results import (
    VehicleResults,
    all_checks,
    all_problems,
    mooring_points_of_tables,
)
from pipeline.report.zoomable import Panel, Trace, zoomable_figure
from pipeline.types import FloatArray

_CODES = 401
_ADVICE = 3


def vehicle_glance(results: VehicleResults) -> Glance:
    """Say first what is to be said of a vehicle: of its last trial day, and of its bench data."""
    name = results.vehicle.name
    bench = bench_line(results.vehicle.title, results.inverse, results.mooring)
    errors, warnings = (
        [one for one in all_problems(results) if one.severity == wanted]
        for wanted in ("error", "warning")
    )
    failed = [check for _, check in all_checks(results) if not check.passed]
    day = next((one for one in reversed(results.trials) if one.glance is not None), None)
    own = None if day is None else day.glance
    doubts: list[Advice] = []
    parts: list[str] = []
    if own is not None and day is not None:
        parts.append(f"{day.name}: {own.matter}")
    elif bench:
        parts.append(f"{bench}.")
    if errors:
        said = plural(len(errors), "file part") if len(errors) > 1 else str(errors[0].place)
        doubts.append(Advice(text=f"Not read: {said}.", command=f"rig2sea check {name}"))
        parts.append(f"{plural(len(errors), 'error')} in the raw files.")
    if len(names := list(dict.fromkeys(check.name for check in failed))) > 1:
        text = f"See {len(names)} checks that failed: {', '.join(names)}."
        doubts.append(Advice(text=text))
    else:
        doubts += [Advice(text=f"See a check that failed: {one}.") for one in names]
    if warnings:
        more = f" ({len(warnings) - 1} more)" if len(warnings) > 1 else ""
        told = f"See a warning{more}: {warnings[0].place}: {warnings[0].what}"
        doubts.append(Advice(text=told, command=f"rig2sea check {name}"))
    doubted = not parts or ((failed or warnings) and own is None)
    lights: list[Light] = ["red" if errors else "amber" if doubted else "green"]
    lights += [own.light] if own is not None else []
    begun = any((results.load_test, results.mooring, results.open_water))
    nothing = "no tables yet" if begun else "nothing was measured yet"
    if not parts:
        told = "What was measured gives no tables yet." if begun else "Nothing was measured yet."
        parts.append(told)
        # the reason of the whole ends with that of the tables
        made, mark = results.inverse, "No firmware tables: "
        why = [results.missing.get("inverse", "")] if made is None else made.explanations
        lacking = next((one.rpartition(mark)[2] for one in why if made is None or mark in one), "")
        doubts += [Advice(text=f"Measure what is lacking: {lacking}")] if begun and lacking else []
    first = own.do if own is not None and own.light != "green" else ()
    short = own.short if own is not None else bench or nothing
    return Glance(
        light=min(lights, key=LIGHTS.index),
        matter=" ".join(parts),
        short=f"{day.name}: {short}" if day is not None else short,
        do=(*first, *doubts)[:_ADVICE],
        fly_next="" if own is None else own.fly_next,
        last_advice="" if own is None else own.last_advice,
    )


def bench_line(
    title: str, inverse: InverseCharacteristic | None, mooring: MooringRecord | None = None
) -> str:
    """Say largest thrusts, dead zone and residual; nothing where there are no tables."""
    if inverse is None or inverse.firmware is None:
        return ""
    made = inverse.firmware
    ahead, astern = made.positive, made.negative
    volts = made.supply_voltage_v
    name = as_it_is(title)
    where = f"{name} at {volts:g} V" if volts is not None else name
    # a drive that does not reverse has a mirrored branch that it never enters
    largest = fixed(ahead.thrust_max_n[0], 1)
    largest += f" / {fixed(-astern.thrust_max_n[0], 1)}" if made.code_min < 0 else ""
    parts = [f"{largest} N at rest", f"dead zone to code {code(round(ahead.code[0][0]))}"]
    own = [p for p in mooring.points if not p.marks and p.code] if mooring is not None else []
    if own:
        codes, thrust = _curve(made)
        left = [p.thrust_n - float(np.interp(p.code, codes, thrust)) for p in own]
        rms = float(np.sqrt(np.mean(np.square(left))))
        parts.append(f"residual {fixed(rms, 2)} N rms")
    return f"{where}: {', '.join(parts)}"


def thrust_figure(results: VehicleResults) -> Figure | None:
    """Draw thrust at rest against code with the measured points; None without tables."""
    inverse = results.inverse
    if inverse is None or inverse.firmware is None:
        return None
    codes, thrust = _curve(inverse.firmware)
    traces = [Trace("tables", codes, thrust, plotting.BLUE, width=1.6)]
    points = sorted(mooring_points_of_tables(results), key=lambda point: point.code)
    if points:
        x, y = (np.array([getattr(p, name) for p in points]) for name in ("code", "thrust_n"))
        traces.append(Trace("measured", x, y, plotting.INK, "points"))
    moving = inverse.firmware.positive.speed_mps[1:]
    if moving:
        fastest = moving[-1]
        x, y = _curve(inverse.firmware, fastest)
        traces.append(Trace(f"at {fastest:g} m/s", x, y, plotting.ORANGE))
    return zoomable_figure(
        "fig-thrust",
        f"{bench_line(results.vehicle.title, inverse, results.mooring)}.",
        "Line: the firmware's tables; points: the mooring test. Thrust astern is negative.",
        (Panel("thrust  [N]", traces, height=1.3),),
        x_label="control code  [–]",
    )


def _curve(made: FirmwareCharacteristic, speed_mps: float = 0.0) -> tuple[FloatArray, FloatArray]:
    codes = np.linspace(made.code_min, made.code_max, _CODES)
    sides = {"positive": thrust_grid(made.positive), "negative": thrust_grid(made.negative)}
    return codes, thrust_from_code(codes, speed_mps, **sides)
