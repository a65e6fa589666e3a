"""Sections of the balance calculation (Kostenko 2017)."""

from pipeline.records.design import BalanceDesign, SteadyState
from pipeline.report.blocks import Block, Bullets, Gallery, Paragraph, Section, Table
from pipeline.report.figures.design_balance import angle_figure, loads_figure, use_figure
from pipeline.report.numbers import fixed, general, speed, use_of_limit


def balance_sections(found: BalanceDesign) -> tuple[Section, ...]:
    """Return everything but the printed numbers."""
    return (_state(found), _readings(found), _envelope(found))


def _state(found: BalanceDesign) -> Section:
    rows = [
        (
            state.method,
            fixed(state.angle_of_attack_deg, 2),
            fixed(state.surge_force_n, 1),
            fixed(state.vertical_force_n, 1),
            *(fixed(load.thrust_n, 1) for load in state.loads),
        )
        for state in (found.exact, found.small_angle)
        if state is not None
    ]
    blocks: list[Block] = [
        Paragraph(
            f"{speed(found.speed_mps)} m/s, residual buoyancy "
            f"{general(found.residual_buoyancy_n)} N upwards, stern thrusters at "
            f"{general(found.angle_deg)} deg. Steady and level, eq. (1) of Kostenko 2017 is three "
            "equations for angle of attack, surge and vertical force. The moment of weight and "
            "buoyancy rights the vehicle: the paper prints it with plus in (1) and (3), with minus "
            "in (6); only the minus rights."
        ),
        Table(
            "Steady state",
            (
                "Form",
                "angle of attack, deg",
                "surge, N",
                "vertical, N",
                *(f"{load.thruster}, N" for load in found.exact.loads),
            ),
            tuple(rows),
            note="Angle of attack nose up, vertical force upwards, in body axes.",
        ),
        _loads(found.exact),
    ]
    if found.preliminary_power_w is not None:
        shaft = (
            ""
            if found.preliminary_shaft_speed_rpm is None
            else f" at {fixed(found.preliminary_shaft_speed_rpm, 0)} rpm by eq. (11), an advance "
            "ratio of 1"
        )
        power = fixed(found.preliminary_power_w, 0)
        blocks.append(
            Paragraph(
                "Drive of the most loaded thruster in the exact form: "
                f"{power} W by eq. (10){shaft}."
                if found.small_angle is None
                else "Drive of the most loaded thruster in the small-angle form: "
                f"{power} W by eq. (10){shaft}."
            )
        )
    blocks.append(Gallery((loads_figure(found),)))
    return Section("state", "Angle of attack and thruster loads", tuple(blocks))


def _loads(state: SteadyState) -> Table:
    def text(value: float | None, decimals: int) -> str:
        return "–" if value is None else fixed(value, decimals)

    return Table(
        "Loads of the exact form",
        (
            "Thruster",
            "thrust, N",
            "inflow, m/s",
            "code",
            "shaft speed, rpm",
            "torque, N m",
            "power, W",
            "limit, N",
            "use",
        ),
        tuple(
            (
                load.thruster,
                fixed(load.thrust_n, 1),
                fixed(load.inflow_mps, 2),
                text(load.code, 1),
                text(load.shaft_speed_rpm, 0),
                text(load.torque_nm, 3),
                text(load.power_w, 0),
                text(load.limit_n, 1),
                use_of_limit(load.use),
            )
            for load in state.loads
        ),
        note="Inflow is the speed of the water along the thruster. Code, shaft speed and torque "
        "need a vehicle with bench tables; power without them is by eq. (10).",
    )


def _readings(found: BalanceDesign) -> Section:
    return Section(
        "readings",
        "The surge force, read in several ways",
        (
            Paragraph(
                "(8) has T_y alpha with another sign than the first line of (6); both are "
                "small terms. The exact form needs no such choice and is the one that counts."
                if found.small_angle is not None
                else "The small-angle form has no state here, so (8) and (6) give no surge force."
            ),
            Table(
                "Surge force and loads by each reading",
                ("Reading", "T_x, N", "left, N", "right, N", "upper, N", "lower, N"),
                tuple(
                    (
                        row.reading,
                        fixed(row.surge_force_n, 1),
                        *(fixed(load, 1) for load in row.loads_n),
                    )
                    for row in found.readings
                ),
            ),
        ),
    )


def _envelope(found: BalanceDesign) -> Section:
    blocks: list[Block] = []
    if found.saturation:
        blocks.append(Paragraph(f"Limit: {found.limit_kind}. One quantity is changed alone:"))
        blocks.append(Bullets(tuple(one.text for one in found.saturation)))
    else:
        blocks.append(
            Paragraph(
                "No limit of a thruster is stated and no vehicle with bench tables is named, so "
                "saturation cannot be told."
            )
        )
    blocks.append(Gallery((use_figure(found), angle_figure(found))))
    return Section("envelope", "Envelope, and which thruster saturates first", tuple(blocks))
