"""What was measured on a drawn rig: the vehicle and its readings, before they were written."""

import math
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

Kind = Literal["mooring", "load_test", "open_water"]
DENSITY = 1000.0


@dataclass(frozen=True)
class Truth:
    """Readings in the order taken, in N, N m, rpm, V, A, m/s; `x` and `y` are what is judged."""

    kind: Kind
    vehicle: Vehicle
    columns: dict[str, FloatArray]
    x: str
    y: str
    tags: tuple[str, ...] = field(default=())


def draw_truth(rng: np.random.Generator) -> Truth:
    """Draw a rig and a test on it."""
    kind: Kind = rng.choice(
        ["mooring", "mooring", "mooring", "load_test", "load_test", "open_water"]
    )
    diameter = float(rng.choice([0.06, 0.076, 0.1, 0.14, 0.2, 0.3]))
    code_max = int(rng.choice([100, 127, 400, 1000]))
    vehicle = Vehicle.model_validate(
        {
            "name": "rig",
            "title": "a drawn rig",
            "water": {"density_kgpm3": DENSITY, "gravity_mps2": 9.81},
            "propellers": {"p": {"diameter_m": diameter}},
            "drives": {"d": {"code_min": -code_max, "code_max": code_max}},
            "tables": {"propeller": "p", "drive": "d"},
        }
    )
    make = {"mooring": _mooring, "load_test": _load_test, "open_water": _open_water}[kind]
    return make(rng, vehicle)


def _mooring(rng: np.random.Generator, vehicle: Vehicle) -> Truth:
    """Sweep up ahead and up astern, with readings of rest between, at one voltage."""
    diameter, code_max = vehicle.propeller.diameter_m, vehicle.drive.code_max
    tip_mps = rng.uniform(7.0, 14.0)
    n_max = tip_mps / (math.pi * diameter)
    k_t, astern = rng.uniform(0.2, 0.5), rng.uniform(0.6, 0.84)
    dead, power = rng.uniform(0.03, 0.08), rng.uniform(1.6, 2.0)
    steps = int(rng.integers(10, 21))
    size = np.round(np.linspace(0.0, code_max, steps + 1))
    code = np.concatenate([size, [0.0], -size[1:], [0.0]])
    share = np.clip((np.abs(code) / code_max - dead) / (1.0 - dead), 0.0, None)
    speed_rps = n_max * share ** (power / 2.0) * np.where(code < 0, math.sqrt(astern), 1.0)
    thrust = k_t * DENSITY * speed_rps**2 * diameter**4 * np.sign(code)
    noisy = thrust + rng.normal(0.0, 0.002 * np.abs(thrust).max(), thrust.size) * (share > 0)
    area = math.pi / 4.0 * diameter**2
    voltage = float(rng.choice([12.0, 16.0, 24.0, 48.0]))
    power_w = np.abs(thrust) ** 1.5 / math.sqrt(2.0 * DENSITY * area) / rng.uniform(0.25, 0.5)
    columns = {
        "code": code,
        "thrust": noisy,
        "shaft_speed": speed_rps * 60.0 * np.sign(code),
        "voltage": np.full(code.size, voltage),
        "current": power_w / voltage,
    }
    return Truth("mooring", vehicle, columns, "code", "thrust")


def _load_test(rng: np.random.Generator, vehicle: Vehicle) -> Truth:
    """Load the drive at several codes of one sign or both."""
    diameter, code_max = vehicle.propeller.diameter_m, vehicle.drive.code_max
    n_max = rng.uniform(7.0, 14.0) / (math.pi * diameter)
    torque_max = rng.uniform(0.02, 0.06) * DENSITY * n_max**2 * diameter**5
    both = rng.random() < 0.5
    sizes = np.round(np.array([0.35, 0.55, 0.8, 1.0]) * code_max)
    codes = np.concatenate([sizes, -sizes]) if both else sizes
    loads = np.linspace(0.05, 1.0, int(rng.integers(7, 13)))
    code = np.repeat(codes, loads.size)
    load = np.tile(loads, codes.size)
    share = np.abs(code) / code_max
    torque = torque_max * share * load * (1 + rng.normal(0, 0.003, code.size))
    speed = n_max * 60.0 * share * (1.0 - 0.35 * load)
    voltage = float(rng.choice([12.0, 24.0, 48.0]))
    power_w = torque * speed * 2.0 * math.pi / 60.0 / rng.uniform(0.6, 0.8)
    columns = {
        "code": code,
        "torque": torque * np.sign(code),
        "shaft_speed": speed * np.sign(code),
        "voltage": np.full(code.size, voltage),
        "current": power_w / voltage,
    }
    return Truth("load_test", vehicle, columns, "shaft_speed", "torque")


def _open_water(rng: np.random.Generator, vehicle: Vehicle) -> Truth:
    """Tow a propeller from rest to no thrust, at one shaft speed."""
    diameter = vehicle.propeller.diameter_m
    j = np.linspace(0.0, 0.8, int(rng.integers(9, 18)))
    k_t = rng.uniform(0.25, 0.45) * (1.0 - j / 0.95)
    k_q = rng.uniform(0.1, 0.14) * k_t + 0.004
    rps = rng.uniform(6.0, 10.0) / (math.pi * diameter)
    n = np.full(j.size, rps)
    columns = {
        "speed": j * n * diameter,
        "shaft_speed": n * 60.0,
        "thrust": k_t * DENSITY * n**2 * diameter**4,
        "torque": k_q * DENSITY * n**2 * diameter**5,
    }
    return Truth("open_water", vehicle, columns, "advance_ratio", "thrust_coefficient")


def judged(truth: Truth) -> tuple[FloatArray, FloatArray]:
    """Return x and y as the records have them."""
    columns = truth.columns
    if truth.kind != "open_water":
        return columns[truth.x], columns[truth.y]
    diameter = truth.vehicle.propeller.diameter_m
    n = columns["shaft_speed"] / 60.0
    return columns["speed"] / (n * diameter), columns["thrust"] / (DENSITY * n**2 * diameter**4)
