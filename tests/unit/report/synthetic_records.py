"""Records of a whole vehicle built from the printed tables.

The report is tested against these: what it says can be checked by hand from Tables 1-4. Only the
drive's surface is fitted, by the pipeline itself.
"""

from __future__ import annotations

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.identify.drive import fit_drive
from pipeline.physics.torque_balance import OpenWaterPropeller
from pipeline.records.base import Source
from pipeline.records.fits import (
    Check,
    FirmwareBranch,
    FirmwareCharacteristic,
    FitQuality,
    InverseCharacteristic,
    OrderScore,
    Outlier,
    PolynomialFit,
    PropellerFit,
    ResidualPoint,
    RoundTrip,
    SpeedInverse,
    StaticCharacteristic,
    StaticRow,
)
from pipeline.records.measurements import (
    ColumnRead,
    LoadTestPoint,
    LoadTestRecord,
    MooringPoint,
    MooringRecord,
    OpenWaterPoint,
    OpenWaterRecord,
    SheetRead,
)
from pipeline.records.validation import AllocationMap, SpeedError
from pipeline.report.results import VehicleResults
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

K_T, K_M = (0.139, -0.155, -0.061), (0.0171, -0.0164, -0.0055)
SPEEDS = (0.0, 0.5, 1.0, 1.5, 2.0)
KF0 = (-4.0, -5.0, -8.0, -11.0, -15.0)
KF1 = (0.254, 0.215, 0.211, 0.210, 0.208)
KF2 = (8.82e-4, 10.2e-4, 9.65e-4, 9.07e-4, 8.67e-4)
TABLE3 = ((12.7, 4.336, -0.070, 7.29e-4), (-12.7, 4.738, 0.089, 9.68e-4))
T_MAX = (42.0, 38.5, 34.5, 29.9, 24.8)
KN = (
    (11.7, 20.6, 30.8, 43.2, 60.0),
    (4.32, 4.04, 3.97, 3.95, 3.17),
    (-0.073, -0.062, -0.063, -0.074, -0.031),
    (8.51e-4, 7.43e-4, 8.33e-4, 12.1e-4, 5.00e-4),
)
#: Shaft speed [rpm] and torque [N m] at which Tables 1 and 2 put the drive, by code.
DRIVE = {
    127: ((1692, 0.732), (1746, 0.684), (1805, 0.628), (1892, 0.583), (1982, 0.527)),
    80: ((1217, 0.378), (1258, 0.335), (1312, 0.287), (1403, 0.248), (1495, 0.197)),
    40: ((714, 0.130), (742, 0.098), (760, 0.053)),
}
CODES = (20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 127)
HOSTILE = '<script>alert("1")</script>'


def vehicle() -> Vehicle:
    """The vehicle of the paper with its published tables."""
    stern = {"propeller": "screw", "drive": "motor"}
    forward, side = 0.92388, 0.38268
    return Vehicle.model_validate(
        {
            "name": "synthetic",
            "title": "Synthetic vehicle of the tests",
            "data_note": "These data are rebuilt from printed tables, they were not measured.",
            "water": {"density_kgpm3": 1000.62, "gravity_mps2": 9.81},
            "propellers": {"screw": {"diameter_m": 0.14, "pitch_ratio": 0.6, "blades": 3}},
            "drives": {"motor": {"code_min": -127, "code_max": 127}},
            "thrusters": [
                {"name": "up", "position_m": (-1.0, 0, -0.2), "direction": (forward, 0, side)}
                | stern,
                {"name": "down", "position_m": (-1.0, 0, 0.2), "direction": (forward, 0, -side)}
                | stern,
                {"name": "left", "position_m": (-1.0, -0.2, 0), "direction": (forward, side, 0)}
                | stern,
                {"name": "right", "position_m": (-1.0, 0.2, 0), "direction": (forward, -side, 0)}
                | stern,
            ],
            "allocator": {
                "delta_deg": 22.5,
                "stern_arm_m": 1.0,
                "upper": "up",
                "lower": "down",
                "left": "left",
                "right": "right",
                "portions": {"surge": 0.6, "heading": 0.4, "pitch": 0.4},
            },
            "tables": {"propeller": "screw", "drive": "motor"},
            "published": {
                "source": "Kostenko 2023",
                "table1": {"KT": K_T, "KM": K_M},
                "table2": {"speed_mps": SPEEDS, "KF0": KF0, "KF1": KF1, "KF2": KF2},
                "table3": {"positive": TABLE3[0], "negative": TABLE3[1]},
                "table4": {
                    "speed_mps": SPEEDS,
                    "T_max_n": T_MAX,
                    **{f"KN{index}": row for index, row in enumerate(KN)},
                },
            },
        }
    )


def full_results() -> VehicleResults:
    """Results with every stage present and one problem of each severity."""
    record = load_test()
    propeller = propeller_fit()
    static = static_family(propeller)
    return VehicleResults(
        vehicle=vehicle(),
        notes=("The positions of the thrusters are taken as given.",),
        load_test=record,
        mooring=mooring(),
        open_water=open_water(),
        propeller=propeller,
        drive=fit_drive(record, vehicle()),
        static=static,
        inverse=inverse(static),
        allocation=allocation(),
        missing={},
        provenance={"raw/synthetic/load_test/drive-01.xlsx": "sha256 0123", "rig2sea": "0.1.0"},
        firmware_files=("../processed/synthetic/firmware/synthetic_thruster.c",),
    )


def quality(unit: str, valid: tuple[float, float], points: int, std: float) -> FitQuality:
    """A plausible quality with three candidate orders."""
    orders = tuple(
        OrderScore(
            order=name,
            parameters=index + 2,
            aicc=-100.0 - 10.0 * (index == 1) - index,
            leave_one_out_rmse=std * (1.3 - 0.2 * (index == 1)),
            chosen=index == 1,
        )
        for index, name in enumerate(("linear", "quadratic", "cubic"))
    )
    return FitQuality(
        points=points,
        r_squared=0.9991,
        residual_std=std,
        unit=unit,
        valid_range=valid,
        orders=orders,
        order_reason="Quadratic as in Kostenko 2023, eq. (2), and as the firmware tables want it.",
    )


def polynomial_fit(  # noqa: PLR0917 - a fixture
    quantity: str,
    variable: str,
    coefficients: tuple[float, ...],
    x: FloatArray,
    noise: float,
    unit: str,
    outlier: Outlier | None = None,
) -> PolynomialFit:
    """A polynomial with the covariance that least squares gives for points at x."""
    design = np.vander(x, len(coefficients), increasing=True)
    covariance = noise**2 * np.linalg.inv(design.T @ design)
    half = 1.96 * np.sqrt(np.diag(covariance))
    fitted = design @ np.asarray(coefficients)
    wiggle = noise * np.sin(7.0 * np.arange(len(x)))
    name = quality(unit, (float(x.min()), float(x.max())), len(x), noise)
    if outlier is not None:
        name = name.model_copy(update={"outliers": (outlier,)})
    return PolynomialFit(
        quantity=quantity,
        variable=variable,
        coefficients=coefficients,
        covariance=tuple(tuple(row) for row in covariance.tolist()),
        ci95=tuple((c - h, c + h) for c, h in zip(coefficients, half.tolist(), strict=True)),
        quality=name,
        points=tuple(
            ResidualPoint(x=a, measured=b + e, fitted=b)
            for a, b, e in zip(x.tolist(), fitted.tolist(), wiggle.tolist(), strict=True)
        ),
    )


def open_water() -> OpenWaterRecord:
    """Forty points on the printed curves."""
    j = np.linspace(0.0, 0.7, 40)
    k_t, k_m = np.polyval(K_T[::-1], j), np.polyval(K_M[::-1], j)
    file = "synthetic/open_water/curves.csv"
    return OpenWaterRecord(
        points=tuple(
            OpenWaterPoint(
                source=Source(file=file, row=index + 2),
                advance_ratio=float(j[index]),
                thrust_coefficient=float(k_t[index] + 0.0008 * np.sin(7 * index)),
                torque_coefficient=float(k_m[index] + 0.0001 * np.sin(9 * index)),
            )
            for index in range(len(j))
        ),
        sheets=(
            SheetRead(
                file=file,
                sheet=None,
                rows=41,
                columns=(
                    ColumnRead(
                        quantity="advance ratio",
                        header="J",
                        column="A",
                        unit="1",
                        unit_from="assumed",
                    ),
                ),
                summary="40 points, J 0 to 0.7",
            ),
        ),
        problems=(),
    )


def propeller_fit() -> PropellerFit:
    """Table 1 with a slightly larger K_T0 than printed: 0.1391."""
    j = np.linspace(0.0, 0.7, 40)
    outlier = Outlier(
        source=Source(file="synthetic/open_water/curves.csv", row=17),
        label="J = 0.27",
        residual=0.011,
        robust_sigmas=9.4,
    )
    return PropellerFit(
        diameter_m=0.14,
        thrust=polynomial_fit("K_T", "J", (0.1391, *K_T[1:]), j, 0.0008, "1", outlier),
        torque=polynomial_fit("K_M", "J", K_M, j, 0.0001, "1"),
        checks=(
            Check(name="efficiency below 1", passed=True, text="largest efficiency 0.61"),
            Check(name="K_T falls with J", passed=True, text="slope negative"),
        ),
    )


def drive_torque(shaft_speed_rpm: FloatArray, code: FloatArray) -> FloatArray:
    """Torque on the straight lines that Tables 1 and 2 imply, between codes by parabolas. [N m]"""
    codes = np.array(list(DRIVE), float)
    speed, torque, slope = (
        np.polyval(np.polyfit(codes, values, 2), code)
        for values in (
            [pairs[0][0] for pairs in DRIVE.values()],
            [pairs[0][1] for pairs in DRIVE.values()],
            [(p[-1][1] - p[0][1]) / (p[-1][0] - p[0][0]) for p in DRIVE.values()],
        )
    )
    return np.asarray(torque + slope * (shaft_speed_rpm - speed))


def working_speed(code: FloatArray, speed_mps: FloatArray, screw: OpenWaterPropeller) -> FloatArray:
    """Shaft speed at which the propeller needs the drive's torque, by bisection. [rev/s]"""
    low, high = np.full(code.shape, 1e-3), np.full(code.shape, 60.0)
    for _ in range(60):
        middle = (low + high) / 2
        above = screw.torque_nm(middle, speed_mps) > drive_torque(60 * middle, code)
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return low


def _speeds_of(code: int) -> FloatArray:
    middle = np.polyval(np.polyfit(list(DRIVE), [p[0][0] for p in DRIVE.values()], 2), code)
    return np.linspace(0.95 * middle, 1.0 * middle + 2.0 * code, 28)


def load_test() -> LoadTestRecord:
    """Both branches at twelve codes, warm-up rows, and problems with a hostile sheet name."""
    points, sheets = [], []
    file = "synthetic/load_test/drive-01.xlsx"
    for code in CODES:
        rpm = _speeds_of(code)
        torque = drive_torque(rpm, np.full(rpm.shape, float(code)))
        sheet = f"Код {code}"
        for index, (n, m) in enumerate(zip(rpm.tolist(), torque.tolist(), strict=True)):
            for step, branch in enumerate(("loading", "unloading")):
                noise = 0.003 * np.sin(11.0 * index + code + step) + 0.0015 * (1 - 2 * step)
                points.append(
                    LoadTestPoint(
                        source=Source(file=file, sheet=sheet, row=5 + index + 40 * step),
                        code=float(code),
                        shaft_speed_rpm=n,
                        torque_nm=max(m + noise, 0.001),
                        branch=branch,
                        marks=("warm-up",) if index < 2 and step == 0 else (),
                    )
                )
        sheets.append(
            SheetRead(
                file=file,
                sheet=sheet,
                rows=56,
                columns=(
                    ColumnRead(
                        quantity="shaft speed",
                        header="Обороты, об/мин",
                        column="B",
                        unit="rpm",
                        unit_from="header",
                    ),
                    ColumnRead(
                        quantity="torque",
                        header="Момент",
                        column="C",
                        unit="kg cm",
                        unit_from="unit row",
                    ),
                ),
                summary=f"code {code} (sheet name), 56 points",
            )
        )
    problems = (
        Problem("note", Place(file), "warm-up rows were found by their drift"),
        Problem(
            "warning",
            Place(file, HOSTILE, 14, "C"),
            f'torque "{HOSTILE}" is not a number.',
            "a decimal number in kg cm",
            "Fix the cell.",
        ),
        Problem("error", Place("synthetic/load_test/broken.xlsx"), "is truncated", "a workbook"),
        *(
            Problem("warning", Place(file, f"Код {code}", 9), "voltage sags below 20 V")
            for code in CODES[:7]
        ),
    )
    return LoadTestRecord(points=tuple(points), sheets=tuple(sheets), problems=problems)


def static_family(propeller: PropellerFit) -> StaticCharacteristic:
    """Working points of propeller and drive lines, and Table 2 as printed less 0.1 N in K_F0."""
    speed = np.round(np.arange(0.0, 2.001, 0.1), 9)
    code = np.arange(1.0, 128.0)
    speeds, codes = np.meshgrid(speed, code, indexing="ij")
    screw = OpenWaterPropeller(
        np.asarray(propeller.thrust.coefficients),
        np.asarray(propeller.torque.coefficients),
        0.14,
        1000.62,
    )
    shaft = working_speed(codes, speeds, screw)
    thrust = screw.thrust_n(shaft, speeds)
    found = thrust > 0
    status = np.where(found, np.where(codes < CODES[0], "extrapolated", "live"), "dead")
    status = status.astype(object)
    status[-1, 0] = "no_working_point"
    thrust, shaft = np.where(found, thrust, 0.0), np.where(found, shaft, 0.0)
    std = np.where(found, 0.05 + 0.002 * thrust, 0.0)

    def grid(values: FloatArray) -> tuple[tuple[float, ...], ...]:
        return tuple(tuple(row) for row in values.tolist())

    rows = []
    for index, v in enumerate(SPEEDS):
        row = int(np.flatnonzero(np.isclose(speed, v))[0])
        top = float(thrust[row, -1])
        rows.append(
            StaticRow(
                speed_mps=v,
                fit=polynomial_fit(
                    "T", "N", (KF0[index] - 0.1, KF1[index], KF2[index]), code[19:], 0.05, "N"
                ),
                dead_zone_code=15.3 + 5 * index,
                thrust_max_n=top,
                thrust_max_ci95=(top - 0.2, top + 0.2),
                mode_code=(20.0, 127.0),
                thrust_modes_n=((0.05, 0.1),),
            )
        )
    return StaticCharacteristic(
        speed_mps=tuple(speed.tolist()),
        code=tuple(code.tolist()),
        thrust_n=grid(thrust),
        thrust_std_n=grid(std),
        shaft_speed_rpm=grid(60 * shaft),
        torque_nm=grid(np.where(found, screw.torque_nm(np.maximum(shaft, 1.0), speeds), 0.0)),
        advance_ratio=grid(np.where(found, speeds / (0.14 * np.maximum(shaft, 1.0)), 0.0)),
        status=tuple(tuple(row) for row in status.tolist()),
        table2=tuple(rows),
        checks=(Check(name="thrust falls with speed", passed=False, text="1 of 2540 steps rise"),),
        explanations=("Codes below 20 were not on the bench.",),
    )


def mooring() -> MooringRecord:
    """Both sweeps of both signs on the printed Table 3."""
    points = []
    file = "synthetic/mooring/tank.csv"
    for side, sign in ((TABLE3[0], 1), (TABLE3[1], -1)):
        thrust = sign * np.linspace(0.5, 43.0, 4000)
        curve = sign * np.polyval(side[::-1], thrust)
        for index, code in enumerate(CODES):
            at = float(np.interp(code, curve, np.abs(thrust)))
            for sweep, offset in (("up", -0.1), ("down", 0.1)):
                points.append(
                    MooringPoint(
                        source=Source(file=file, row=3 + index),
                        code=float(sign * code),
                        thrust_n=sign * (at + offset),
                        tare_n=0.2,
                        voltage_v=24.0,
                        sweep=sweep,
                    )
                )
    sheet = SheetRead(
        file=file,
        sheet=None,
        rows=48,
        columns=(
            ColumnRead(
                quantity="thrust", header="Упор", column="B", unit="kgf", unit_from="mapping"
            ),
        ),
        summary="48 points, both signs",
    )
    return MooringRecord(
        points=tuple(points), sheets=(sheet,), problems=(), hysteresis_n=0.2, tare_drift_n=0.13
    )


def inverse(static: StaticCharacteristic) -> InverseCharacteristic:
    """Table 3 as printed with K_N00 0.4 higher; Table 4 refitted to the family."""
    positive = polynomial_fit(
        "N", "T", (13.1, *TABLE3[0][1:]), np.linspace(1.5, 42.5, 24), 0.3, "codes"
    )
    negative = polynomial_fit("N", "T", TABLE3[1], np.linspace(-42.0, -1.4, 24), 0.3, "codes")
    rows, tops, codes = [], [], []
    fraction = np.linspace(0.0, 1.0, 41)
    grid = np.asarray(static.code)
    for v in SPEEDS:
        index = int(np.flatnonzero(np.isclose(static.speed_mps, v))[0])
        thrust = np.asarray(static.thrust_n[index])
        live = thrust > 0
        coefficients = np.polynomial.polynomial.polyfit(
            thrust[live & (thrust > 0.5)], grid[live & (thrust > 0.5)], 3
        )
        top = float(thrust[-1])
        rows.append(
            SpeedInverse(
                speed_mps=v,
                thrust_max_n=top,
                coefficients=tuple(coefficients.tolist()),
                ci95=tuple((c - 0.02 * abs(c), c + 0.02 * abs(c)) for c in coefficients.tolist()),
            )
        )
        tops.append(top)
        edge = float(grid[live][0]) - 0.5
        codes.append(
            tuple(
                np.interp(
                    fraction * top, np.r_[0.0, thrust[live]], np.r_[edge, grid[live]]
                ).tolist()
            )
        )
    branches = [
        FirmwareBranch(
            sign=sign,
            speed_mps=SPEEDS,
            thrust_max_n=tuple(tops),
            fraction=tuple(fraction.tolist()),
            code=tuple(codes),
            against_motion="the row at rest holds.",
        )
        for sign in (1, -1)
    ]
    return InverseCharacteristic(
        table3_positive=positive,
        table3_negative=negative,
        table4=tuple(rows),
        firmware=FirmwareCharacteristic(
            thrust_dead_n=0.5, code_max=127, positive=branches[0], negative=branches[1]
        ),
        round_trip=tuple(
            RoundTrip(
                speed_mps=v,
                cubic_n=0.2 if v in SPEEDS else None,
                firmware_n=0.02 + 0.01 * v,
                firmware_rounded_codes=0.5,
                published_n={0.0: 0.72, 0.5: 0.72, 1.0: 0.76, 1.5: 0.62, 2.0: 0.68}.get(v),
            )
            for v in np.round(np.arange(0.0, 2.01, 0.1), 9).tolist()
        ),
        checks=(),
        explanations=("Table 4 is fitted over 0.5 N to T_max.",),
    )


def allocation() -> AllocationMap:
    """Errors that grow with speed without compensation."""
    speed = np.round(np.arange(0.0, 2.01, 0.25), 9)

    def errors(worst: float) -> tuple[SpeedError, ...]:
        return tuple(
            SpeedError(
                speed_mps=v,
                worst=0.004 + worst * v,
                rms=0.002 + 0.4 * worst * v,
                worst_demand=(60.0, 0.0, 5.0),
                reachable_share=0.6 - 0.1 * v,
                opposed_share=0.2,
            )
            for v in speed.tolist()
        )

    return AllocationMap(
        form="limit",
        portions=(0.6, 0.4, 0.4),
        mooring=errors(0.2),
        compensated=errors(0.004),
        speed_mps=tuple(speed.tolist()),
        explanations=("Demands against the motion use the row at rest.",),
        mooring_inverse="Table 3",
        compensated_inverse="firmware form",
    )
