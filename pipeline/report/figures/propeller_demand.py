"""What the propeller asks of the shaft: torque and thrust against shaft speed (fig. 3)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pipeline.physics.torque_balance import OpenWaterPropeller
from pipeline.records.fits import Interval
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.numbers import general, speed
from pipeline.types import ArrayLike, FloatArray

if TYPE_CHECKING:
    import matplotlib.figure


@dataclass(frozen=True)
class _Curve:
    """One of the two quantities."""

    name: str
    symbol: str
    unit: str
    part: str
    value: Callable[[ArrayLike, ArrayLike], FloatArray]


def rpm_without_drive(
    model: OpenWaterPropeller, speeds: Sequence[float], covered: Interval
) -> FloatArray:
    """Shaft speeds to draw when no drive sets the scale: up to 1.5 times the middle of the test."""
    middle = max(sum(covered) / 2, 0.1)
    fastest = 1.5 * 60.0 * max(*speeds, 0.5) / (middle * model.diameter_m)
    return np.linspace(fastest / 200, fastest, 300)


def demand_figures(
    model: OpenWaterPropeller, speeds: Sequence[float], rpm: FloatArray, covered: Interval
) -> tuple[Figure, Figure]:
    """Draw torque and thrust against shaft speed, one curve for each speed of the vehicle.

    Parameters
    ----------
    model : OpenWaterPropeller
        The fitted curves.
    speeds : sequence of float
        Speeds of the vehicle. [m/s]
    rpm : ndarray
        Shaft speeds. [rpm]
    covered : (float, float)
        Advance ratios that were measured; below them the curve is dotted, above not drawn.
    """
    torque = _Curve("torque", "M", "N m", "a", model.torque_nm)
    thrust = _Curve("thrust", "T", "N", "b", model.thrust_n)
    return (
        _figure(torque, model.diameter_m, speeds, rpm, covered),
        _figure(thrust, model.diameter_m, speeds, rpm, covered),
    )


def _figure(
    curve: _Curve, diameter_m: float, speeds: Sequence[float], rpm: FloatArray, covered: Interval
) -> Figure:
    last = float(rpm[-1])
    first_value = float(curve.value(last / 60, speeds[0]))
    last_value = float(curve.value(last / 60, speeds[-1]))
    lead = (
        f"At {general(last, 4)} rpm the propeller's {curve.name} falls from "
        f"{general(first_value)} to {general(last_value)} {curve.unit} between "
        f"{speed(speeds[0])} and {speed(speeds[-1])} m/s."
    )

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        for speed_mps, colour in zip(speeds, plotting.ordered_colours(len(speeds)), strict=True):
            ratio = speed_mps / (rpm / 60.0 * diameter_m)
            values = curve.value(rpm / 60.0, speed_mps)
            measured = (ratio <= covered[1]) & (ratio >= covered[0] - 0.02)
            axes.plot(
                rpm,
                np.where(measured, values, np.nan),
                color=colour,
                label=f"{speed(speed_mps)} m/s",
            )
            beyond = ratio < covered[0] - 0.02
            axes.plot(rpm, np.where(beyond, values, np.nan), ":", color=colour, lw=1.0)
        axes.axhline(0, color=plotting.SOFT, lw=0.8)
        axes.set(
            xlabel="shaft speed n  [rpm]", ylabel=f"{curve.name} {curve.symbol}  [{curve.unit}]"
        )
        plotting.legend_above(figure, axes, columns=5)

    identity = f"fig-propeller-{curve.name}"
    alt = (
        f"The propeller's {curve.name} against shaft speed, a curve for each speed of the vehicle."
    )
    return Figure(
        identity,
        lead,
        plotting.draw(identity, alt, paint),
        f"Propeller {curve.name} (fig. 3, {curve.part} of Kostenko 2023), drawn up to the largest "
        "J of the open-water test; dotted where J is below the smallest one.",
    )
