"""A bench whose truth is known in closed form: a drive with straight characteristics.

M(n, N) = M_0 y - k (n - n_0 y), y = N / 127: torque falls along a line at every code, and the
balance at rest is the root of a quadratic.
"""

from collections.abc import Callable

import numpy as np
import pytest

from pipeline.identify.drive import fit_drive
from pipeline.identify.propeller import fit_propeller
from pipeline.identify.static import static_characteristic
from pipeline.records.base import Source
from pipeline.records.fits import DriveFit, PropellerFit, StaticCharacteristic
from pipeline.records.measurements import (
    LoadTestPoint,
    LoadTestRecord,
    MooringPoint,
    MooringRecord,
    OpenWaterPoint,
    OpenWaterRecord,
)
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Drive, Propeller, Tables, Vehicle, Water

CODES = (20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 127)
K_T = (0.139, -0.155, -0.061)
K_M = (0.0171, -0.0164, -0.0055)
DIAMETER_M = 0.14
DENSITY = 1000.62
BENCH_TORQUE_NM = 0.73
BENCH_SPEED_RPS = 28.2
BENCH_SLOPE_NMS = 0.04


def true_torque(shaft_speed_rps: FloatArray, code: FloatArray | float) -> FloatArray:
    y = np.asarray(code) / 127.0
    return BENCH_TORQUE_NM * y - BENCH_SLOPE_NMS * (shaft_speed_rps - BENCH_SPEED_RPS * y)


def true_thrust_at_rest(code: FloatArray) -> FloatArray:
    """Root of K_M0 rho D^5 n^2 + k n - (M_0 + k n_0) y = 0, then T = K_T0 rho n^2 D^4."""
    a = K_M[0] * DENSITY * DIAMETER_M**5
    c = (BENCH_TORQUE_NM + BENCH_SLOPE_NMS * BENCH_SPEED_RPS) * np.asarray(code) / 127.0
    n = (-BENCH_SLOPE_NMS + np.sqrt(BENCH_SLOPE_NMS**2 + 4 * a * c)) / (2 * a)
    return np.asarray(K_T[0] * DENSITY * n**2 * DIAMETER_M**4)


@pytest.fixture(scope="session")
def vehicle() -> Vehicle:
    return Vehicle(
        name="bench",
        title="a bench with a known answer",
        water=Water(density_kgpm3=DENSITY, gravity_mps2=9.81),
        propellers={"screw": Propeller(diameter_m=DIAMETER_M)},
        drives={"motor": Drive(code_min=-127, code_max=127)},
        tables=Tables(propeller="screw", drive="motor"),
    )


def make_load_test(noise_nm: float, seed: int, files: int = 2) -> LoadTestRecord:
    generator = np.random.default_rng(seed)
    points = []
    for file in range(files):
        scale = 1 + (file - (files - 1) / 2) * 0.006
        for code in CODES:
            centre = BENCH_SPEED_RPS * code / 127 + 2
            for branch in ("loading", "unloading"):
                shaft = np.linspace(centre - 4, centre + 4, 30)
                torque = true_torque(shaft, code) * scale + generator.normal(0, noise_nm, 30)
                points += [
                    LoadTestPoint(
                        source=Source(file=f"drive-{file}.xlsx", sheet=f"code {code}", row=row),
                        code=code,
                        shaft_speed_rpm=n * 60,
                        torque_nm=m,
                        branch=branch,
                    )
                    for row, (n, m) in enumerate(zip(shaft, torque, strict=True), start=3)
                    if n > 0.5 and m > 0
                ]
    return LoadTestRecord(points=tuple(points), sheets=(), problems=())


def make_open_water(noise: float, seed: int) -> OpenWaterRecord:
    generator = np.random.default_rng(seed)
    ratios = np.linspace(0, 0.8, 25)
    return OpenWaterRecord(
        points=tuple(
            OpenWaterPoint(
                source=Source(file="open.csv", row=row),
                advance_ratio=j,
                thrust_coefficient=np.polynomial.polynomial.polyval(j, K_T)
                + generator.normal(0, noise * K_T[0]),
                torque_coefficient=np.polynomial.polynomial.polyval(j, K_M)
                + generator.normal(0, noise * K_M[0]),
            )
            for row, j in enumerate(ratios, start=2)
        ),
        sheets=(),
        problems=(),
    )


@pytest.fixture(scope="session")
def load_test() -> LoadTestRecord:
    return make_load_test(noise_nm=0.003, seed=1)


@pytest.fixture(scope="session")
def open_water() -> OpenWaterRecord:
    return make_open_water(noise=0.004, seed=2)


@pytest.fixture(scope="session")
def propeller(open_water: OpenWaterRecord, vehicle: Vehicle) -> PropellerFit:
    return fit_propeller(open_water, vehicle)


@pytest.fixture(scope="session")
def drive(load_test: LoadTestRecord, vehicle: Vehicle) -> DriveFit:
    return fit_drive(load_test, vehicle)


@pytest.fixture(scope="session")
def static(propeller: PropellerFit, drive: DriveFit, vehicle: Vehicle) -> StaticCharacteristic:
    return static_characteristic(propeller, drive, vehicle)


@pytest.fixture(scope="session")
def mooring_from() -> Callable[[Callable[[float], float], float], MooringRecord]:
    """Make a mooring record from T(N) for both signs, with Gaussian noise."""

    def make(thrust_of: Callable[[float], float], noise_n: float) -> MooringRecord:
        generator = np.random.default_rng(5)
        points = []
        for sweep in ("up", "down"):
            for row, code in enumerate([*(-c for c in reversed(CODES)), 0, *CODES], start=2):
                clean = np.sign(code) * thrust_of(abs(code)) if code else 0.0
                points.append(
                    MooringPoint(
                        source=Source(file="mooring.csv", row=row),
                        code=code,
                        thrust_n=clean + generator.normal(0, noise_n),
                        sweep=sweep,
                    )
                )
        return MooringRecord(points=tuple(points), sheets=(), problems=())

    return make
