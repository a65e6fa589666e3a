"""Figures of the propeller calculation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pipeline.records.design import PropellerDesign
from pipeline.report import plotting
from pipeline.report.blocks import Figure
from pipeline.report.numbers import fixed

if TYPE_CHECKING:
    import matplotlib.figure


def open_water_figure(found: PropellerDesign) -> Figure:
    """Draw K_T, 10 K_Q and efficiency of the best, with its operating point."""
    best, curves = found.ranked[0], found.curves

    def paint(figure: matplotlib.figure.Figure) -> None:
        axes = figure.subplots()
        j = curves.advance_ratio
        lines = (
            ("K_T", np.array(curves.thrust_coefficient), plotting.BLUE),
            ("10 K_Q", 10 * np.array(curves.torque_coefficient), plotting.ORANGE),
            ("efficiency", np.array(curves.efficiency), plotting.GREEN),
        )
        for name, values, colour in lines:
            axes.plot(j, values, color=colour, label=name)
        axes.plot(best.advance_ratio, best.thrust_coefficient, "o", color=plotting.BLUE, ms=6)
        axes.plot(
            best.advance_ratio, 10 * best.torque_coefficient, "o", color=plotting.ORANGE, ms=6
        )
        axes.plot(best.advance_ratio, best.efficiency, "o", color=plotting.GREEN, ms=6)
        axes.axvline(best.advance_ratio, color=plotting.SOFT, lw=0.8, ls="--")
        axes.set(xlabel="advance ratio J  [–]", ylabel="coefficients  [–]")
        axes.set_ylim(bottom=0.0)
        axes.set_xlim(left=0.0)
        plotting.legend_above(figure, axes)

    return Figure(
        "open-water",
        f"The best propeller works at J = {fixed(best.advance_ratio, 2)} with an efficiency of "
        f"{fixed(best.efficiency, 3)}.",
        plotting.draw(
            "open-water", "Open-water curves of the best propeller.", paint, height_in=4.2
        ),
        f"B{best.blades}, P/D = {fixed(best.pitch_ratio, 3)}, A_E/A_0 = "
        f"{fixed(best.area_ratio, 3)}; rings: the operating point.",
    )


def drive_figure(found: PropellerDesign) -> Figure:
    """Draw the torque of the best over shaft speed, with what the drive has."""
    best, curves = found.ranked[0], found.curves

    def paint(figure: matplotlib.figure.Figure) -> None:
        torque, thrust = figure.subplots(2, 1, sharex=True)
        rpm = np.array(curves.shaft_speed_rpm)
        need = np.array(curves.propeller_torque_nm, dtype=float)
        torque.plot(rpm, need, color=plotting.BLUE, label="propeller needs")
        have = np.array(curves.drive_torque_nm, dtype=float)
        if np.isfinite(have).any():
            torque.plot(rpm, have, color=plotting.VERMILLION, label="drive has")
        else:
            torque.plot(
                best.shaft_speed_rpm,
                found.drive_torque_at_point_nm,
                "s",
                color=plotting.VERMILLION,
                label="drive's working point",
                ms=6,
            )
        torque.plot(best.shaft_speed_rpm, best.torque_nm, "o", color=plotting.BLUE, ms=6)
        pushes = np.array(curves.propeller_thrust_n, dtype=float)
        thrust.plot(rpm, pushes, color=plotting.BLUE)
        thrust.axhline(found.thrust_n, color=plotting.SOFT, lw=0.9, ls="--")
        thrust.plot(best.shaft_speed_rpm, best.thrust_n, "o", color=plotting.BLUE, ms=6)
        if best.full_power_shaft_speed_rpm is not None:
            torque.plot(
                best.full_power_shaft_speed_rpm,
                best.full_power_torque_nm,
                "D",
                color=plotting.INK,
                label="full power",
                ms=5,
            )
            thrust.plot(
                best.full_power_shaft_speed_rpm,
                best.full_power_thrust_n,
                "D",
                color=plotting.INK,
                ms=5,
            )
        torque.set(ylabel="torque  [N m]")
        thrust.set(xlabel="shaft speed  [rpm]", ylabel="thrust  [N]")
        plotting.legend_above(figure, torque)

    return Figure(
        "drive",
        f"At {fixed(best.shaft_speed_rpm, 0)} rpm the best propeller needs "
        f"{fixed(best.torque_nm, 3)} N m of the drive's "
        f"{fixed(found.drive_torque_at_point_nm, 3)} N m.",
        plotting.draw("drive", "Torque and thrust over shaft speed.", paint, height_in=4.2),
        f"At an advance speed of {fixed(found.advance_speed_mps, 2)} m/s; dashed: the required "
        f"{fixed(found.thrust_n, 1)} N. Drive: {found.drive}.",
    )
