"""Vehicles whose exported allocator is tested, and the C library over arrays."""

import ctypes
import json
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from firmware_cases import bench_only, table2

from pipeline.export.allocator_layout import AllocatorLayout, allocator_layout
from pipeline.export.firmware import write_firmware
from pipeline.records.fits import FirmwareCharacteristic
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

DRIVER = """
#include "rov_allocator.h"
#include <stddef.h>
#define N ROV_THRUSTER_COUNT
void all_f32(size_t m, const float *w, const float *v, int16_t *c, float *t, uint16_t *f)
{ for (size_t i = 0U; i < m; ++i)
  { f[i] = rov_allocate_thrust_f32(&w[6U * i], &v[3U * i], &c[N * i], &t[N * i]); } }
void all_q(size_t m, const int32_t *w, const int32_t *v, int16_t *c, int32_t *t, uint16_t *f)
{ for (size_t i = 0U; i < m; ++i)
  { f[i] = rov_allocate_thrust_q(&w[6U * i], &v[3U * i], &c[N * i], &t[N * i]); } }
"""
_ROOT = float(np.sqrt(0.5))


def vehicle(thrusters: list[dict[str, object]], **more: object) -> Vehicle:
    return Vehicle.model_validate(
        {
            "name": "rov",
            "title": "a vehicle for its allocator",
            "water": {"density_kgpm3": 1000.0, "gravity_mps2": 9.81},
            "propellers": {"screw": {"diameter_m": 0.1}},
            "drives": {"motor": {"code_min": -127, "code_max": 127}},
            "tables": {"propeller": "screw", "drive": "motor"},
            "thrusters": [{"propeller": "screw", "drive": "motor", **one} for one in thrusters],
            **more,
        }
    )


def paper(form: str, *, bow: bool = True) -> Vehicle:
    """The MMT-300's stern, inclined by 22.5 degrees, with or without a bow thruster."""
    c, s = float(np.cos(np.pi / 8)), float(np.sin(np.pi / 8))
    directions = {"upper": (c, 0, -s), "lower": (c, 0, s), "left": (c, -s, 0), "right": (c, s, 0)}
    thrusters: list[dict[str, object]] = [
        {"name": name, "position_m": (-0.9, 0, 0), "direction": d} for name, d in directions.items()
    ]
    thrusters[1] |= {"gain_ahead": 0.8, "dead_zone_code": 7.0}
    if bow:
        thrusters.append({"name": "bow", "position_m": (0.8, 0, 0), "direction": (0, 0, -1)})
    roles = {role: role for role in directions} | ({"bow": "bow", "bow_arm_m": 0.8} if bow else {})
    portions = {"surge": 0.6, "heading": 0.4, "pitch": 0.4}
    geometry = {"delta_deg": 22.5, "stern_arm_m": 0.9, "form": form, "portions": portions, **roles}
    return vehicle(thrusters, allocator=geometry)


def eight() -> Vehicle:
    """Four thrusters across the corners and four vertical ones, one of them weak."""
    thrusters = []
    for i, (x, y) in enumerate(((0.2, -0.2), (0.2, 0.2), (-0.2, -0.2), (-0.2, 0.2))):
        across = _ROOT if x * y < 0 else -_ROOT
        thrusters += [
            {"name": f"flat{i}", "position_m": (x, y, 0.02), "direction": (_ROOT, across, 0)},
            {"name": f"up{i}", "position_m": (x / 2, y, -0.03), "direction": (0, 0, -1)},
        ]
    return vehicle(
        [
            {**thrusters[0], "gain_ahead": 0.6, "gain_reverse": 0.9},
            {**thrusters[1], "dead_zone_code": 9.3},
            *thrusters[2:],
        ]
    )


def six() -> Vehicle:
    """No pitch: two vertical thrusters amidships; roll comes with sway."""
    flat = [
        {"name": f"flat{i}", "position_m": (x, y, 0.05),
         "direction": (_ROOT, _ROOT if x * y < 0 else -_ROOT, 0)}
        for i, (x, y) in enumerate(((0.15, -0.11), (0.15, 0.11), (-0.15, -0.11), (-0.15, 0.11)))
    ]  # fmt: skip
    up = [
        {"name": f"up{i}", "position_m": (0, y, 0), "direction": (0, 0, -1)}
        for i, y in enumerate((-0.11, 0.11))
    ]
    return vehicle([*flat, *up])


def twelve() -> Vehicle:
    """As many thrusters as there may be, anywhere."""
    generator = np.random.default_rng(8)
    places = generator.uniform(-1, 1, (12, 3)) * [1.0, 0.3, 0.3]
    ways = generator.normal(size=(12, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    return vehicle(
        [
            {"name": f"t{i}", "position_m": tuple(p), "direction": tuple(d)}
            for i, (p, d) in enumerate(zip(places.tolist(), ways.tolist(), strict=True))
        ]
    )


def dragging() -> FirmwareCharacteristic:
    """Kostenko's thruster with the drag of its free propeller, tested to 2 m/s."""
    rest = table2()
    drag = tuple(0.85 * v**2 for v in rest.positive.speed_mps)
    return rest.model_copy(
        update={
            side: getattr(rest, side).model_copy(update={"drag_n": drag})
            for side in ("positive", "negative")
        }
        | {"tested_mps": 2.0}
    )


def other() -> FirmwareCharacteristic:
    """Another type of thruster: a smaller one with more codes."""
    return bench_only().model_copy(update={"code_max": 400, "code_min": -400})


def mixed(one: Vehicle, *names: str) -> Vehicle:
    """The vehicle with some of its thrusters of another type."""
    kind = {"propeller": "small", "drive": "servo"}
    body = one.model_dump(mode="json", exclude_unset=True)
    body["propellers"]["small"] = {"diameter_m": 0.05}
    body["drives"]["servo"] = {"code_min": -400, "code_max": 400}
    body["tables"]["types"] = {"tunnel": {**kind}}
    for thruster in body["thrusters"]:
        thruster.update(kind if thruster["name"] in names else {})
    return Vehicle.model_validate_json(json.dumps(body))


Case = (
    tuple[Vehicle, FirmwareCharacteristic]
    | tuple[Vehicle, FirmwareCharacteristic, FirmwareCharacteristic]
)
CASES: dict[str, Callable[[], Case]] = {
    "limit": lambda: (paper("limit"), dragging()),
    "limit_types": lambda: (mixed(paper("limit"), "bow"), dragging(), other()),
    "eight_types": lambda: (mixed(eight(), "up0", "up1", "up2"), dragging(), other()),
    "scaled": lambda: (paper("scaled"), dragging()),
    "no_bow": lambda: (paper("limit", bow=False), dragging()),
    "eight": lambda: (eight(), dragging()),
    "six": lambda: (six(), other()),
    "twelve": lambda: (twelve(), dragging()),
}


@dataclass(frozen=True)
class Compiled:
    """The C library of a case."""

    layout: AllocatorLayout
    characteristics: tuple[FirmwareCharacteristic, ...]
    """Of each type of thruster."""
    source: Path
    functions: ctypes.CDLL

    def call(
        self, variant: str, wrench: np.ndarray, velocity: np.ndarray
    ) -> tuple[np.ndarray, ...]:
        """Thrusts, codes, flags of many calls."""
        kind, count = wrench.dtype, self.layout.count
        thrust, codes = np.empty((len(wrench), count), kind), np.empty((len(wrench), count), "i2")
        flags = np.empty(len(wrench), "u2")
        arrays = (
            np.ascontiguousarray(wrench),
            np.ascontiguousarray(velocity),
            codes,
            thrust,
            flags,
        )
        pointers = [ctypes.c_void_p(a.ctypes.data) for a in arrays]
        getattr(self.functions, f"all_{variant}")(ctypes.c_size_t(len(wrench)), *pointers)
        return thrust, codes, flags


def build(case: str, folder: Path, *flags: str) -> Compiled:
    one, *characteristics = CASES[case]()
    types = ("", *one.tables.types)
    by_type = dict(zip(types, characteristics, strict=True))
    others = {name: own for name, own in by_type.items() if name}
    layout = allocator_layout(one, by_type[""], others)
    paths: tuple[Path, ...] = ()
    for name, characteristic in by_type.items():
        made = write_firmware(
            f"rov-{name}" if name else "rov", characteristic, tables_digest="0a1b",
            tool_version="1", folder=folder, tables=None, layout=None if name else layout,
        )  # fmt: skip
        paths = made if name == "" else paths
    (folder / "driver.c").write_text(DRIVER)
    library = folder / "allocator.so"
    strict = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror", "-Wshadow")
    sources = [*folder.glob("rov*_thruster.c"), folder / "rov_allocator.c", folder / "driver.c"]
    command = ["gcc", *strict, "-Wno-missing-prototypes", "-O2", *flags, "-shared", "-fPIC",
               *map(str, sources), "-o", str(library)]  # fmt: skip
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    except FileNotFoundError:
        pytest.skip("gcc is not installed")
    assert not done.stderr
    assert done.returncode == 0
    return Compiled(layout, tuple(characteristics), paths[1], ctypes.CDLL(str(library)))


def demands(calls: int, seed: int) -> tuple[FloatArray, FloatArray]:
    """Wrenches up to well beyond the limits, some huge or of one axis alone, and velocities."""
    generator = np.random.default_rng(seed)
    size = np.array([150, 80, 80, 20, 60, 60.0])
    wrench = (
        generator.normal(size=(calls, 6)) * size * generator.choice([0.1, 0.4, 1.0], (calls, 1))
    )
    wrench[::7] *= generator.random((len(wrench[::7]), 6)) < 0.3
    wrench[5::101] *= 60.0
    velocity = generator.normal(size=(calls, 3)) * [1.2, 0.3, 0.3]
    return np.clip(wrench, -32000.0, 32000.0), velocity
