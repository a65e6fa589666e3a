"""The firmware's calls that take the supply voltage, against real arithmetic."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import allocator_cases
import numpy as np
import pytest
from firmware_cases import table2

from pipeline.control.inverse import thrust_grid
from pipeline.export.allocator_layout import AllocatorLayout, allocator_layout
from pipeline.export.c_source import VoltageTables
from pipeline.export.firmware import write_firmware
from pipeline.export.fixed_point import Q16_ONE
from pipeline.export.grid_check import FLAG
from pipeline.physics.thrust_grid import ThrustGrid, code_from_thrust, thrust_from_code
from pipeline.records.fits import FirmwareBranch, FirmwareCharacteristic

VOLTS = (10.0, 12.5, 16.0)


def between(low: ThrustGrid, high: ThrustGrid, share: float) -> ThrustGrid:
    """Return the grid `share` of the way from one supply voltage to the next, of equal fractions.

    T_max, codes at equal fractions and drag run straight, at the speeds of both.
    """
    speed = np.union1d(low.speed_mps, high.speed_mps)
    (n0, c0), (n1, c1) = (one.at_speed(speed) for one in (low, high))
    drag = (1.0 - share) * low.drag_at(speed) + share * high.drag_at(speed)
    return ThrustGrid(
        speed_mps=speed,
        thrust_max_n=(1.0 - share) * n0 + share * n1,
        fraction=low.fraction,
        code=(1.0 - share) * c0 + share * c1,
        drag_n=drag,
    )


def at(volts: float) -> FirmwareCharacteristic:
    """Kostenko's thruster; another voltage pushes more or less, and as far as its own speed."""

    def scaled(branch: FirmwareBranch) -> FirmwareBranch:
        share = volts / 16.0
        drag = tuple((0.8 * np.array(branch.speed_mps) ** 2).tolist())
        return branch.model_copy(
            update={
                "speed_mps": tuple((np.array(branch.speed_mps) * (0.5 + 0.5 * share)).tolist()),
                "thrust_max_n": tuple((np.array(branch.thrust_max_n) * share).tolist()),
                "code": tuple(
                    tuple((127.0 - (127.0 - np.array(row)) * share**0.2).tolist())
                    for row in branch.code
                ),
                "drag_n": drag,
            }
        )

    one = table2()
    return one.model_copy(
        update={
            "positive": scaled(one.positive),
            "negative": scaled(one.negative),
            "supply_voltage_v": volts,
        }
    )


ROWS = tuple((volts, at(volts)) for volts in VOLTS)


def written(
    folder: Path,
    name: str,
    layout: AllocatorLayout | None,
    rows: VoltageTables = ROWS,
) -> None:
    """The files of a type of thruster, its tables those of 12.5 V."""
    write_firmware(
        name, at(12.5), tables_digest="x", tool_version="0", folder=folder, tables=None,
        layout=layout, voltages=rows,
    )  # fmt: skip


def compiled(folder: Path) -> ctypes.CDLL:
    """The library of all files of a folder."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    sources = sorted(one.name for one in folder.glob("*_thruster.c"))
    command = [
        *("gcc", "-std=c99", "-O2", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic"),
        *("-ffp-contract=off", "-fsanitize=undefined", "-fsanitize-undefined-trap-on-error"),
        *("-shared", "-fPIC", *sources, "rov_allocator.c", "-o", "rov.so"),
    ]
    subprocess.run(command, check=True, cwd=folder, timeout=120)
    return ctypes.CDLL(str(folder / "rov.so"))


@pytest.fixture(scope="module")
def functions(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    folder = tmp_path_factory.mktemp("firmware")
    written(folder, "rov", allocator_layout(allocator_cases.eight(), at(12.5)))
    library = compiled(folder)
    for name, number in (("f32", ctypes.c_float), ("q", ctypes.c_int32)):
        for call, result in (
            ("code_from_thrust", ctypes.c_int16),
            ("thrust_from_code", number),
            ("thruster_flags", ctypes.c_uint16),
        ):
            first = ctypes.c_int16 if call == "thrust_from_code" else number
            for kind, more in (("", []), ("_at", [number])):
                function = getattr(library, f"rov_{call}{kind}_{name}")
                function.restype, function.argtypes = result, [first, number, *more]
    return library


@pytest.mark.parametrize("variant", ["f32", "q"])
def test_between_two_voltages_the_tables_run_straight(functions: ctypes.CDLL, variant: str) -> None:
    one = 1.0 if variant == "f32" else float(Q16_ONE)

    def number(value: float) -> float:
        return value if variant == "f32" else round(value * one)

    thrust_of = getattr(functions, f"rov_thrust_from_code_at_{variant}")
    code_of = getattr(functions, f"rov_code_from_thrust_at_{variant}")
    for volts, low, high in ((8.0, 0, 0), (11.0, 0, 1), (12.5, 1, 1), (15.5, 1, 2), (18.0, 2, 2)):
        share = 0.0 if low == high else (volts - VOLTS[low]) / (VOLTS[high] - VOLTS[low])
        sides = [
            between(thrust_grid(getattr(at(VOLTS[low]), sign)),
                    thrust_grid(getattr(at(VOLTS[high]), sign)), share)
            for sign in ("positive", "negative")
        ]  # fmt: skip
        for speed in (-1.7, -0.4, 0.0, 0.9, 2.5):
            for code in range(-127, 128, 6):
                wanted = float(thrust_from_code(code, speed, positive=sides[0], negative=sides[1]))
                got = thrust_of(code, number(speed), number(volts)) / one
                assert got == pytest.approx(wanted, abs=1e-3)
                exact = float(
                    code_from_thrust(
                        wanted, speed, positive=sides[0], negative=sides[1], thrust_dead_n=0.5
                    )
                )
                back = code_of(number(wanted), number(speed), number(volts))
                assert abs(back - exact) <= 0.5 + 1e-2 or abs(wanted) < 0.501


@pytest.mark.parametrize("variant", ["f32", "q"])
def test_without_a_voltage_the_tables_are_those_that_were_chosen(
    functions: ctypes.CDLL, variant: str
) -> None:
    one = 1 if variant == "f32" else Q16_ONE
    volts = 12.5 if variant == "f32" else round(12.5 * one)
    for call in ("code_from_thrust", "thrust_from_code", "thruster_flags"):
        plain, taking = (getattr(functions, f"rov_{call}{kind}_{variant}") for kind in ("", "_at"))
        for first in range(-45, 46, 5):
            x = first if call == "thrust_from_code" else first * one
            for speed in (-2 * one, 0, one, 3 * one):
                assert plain(x, speed) == taking(x, speed, volts)


def test_a_voltage_out_of_range_is_told(functions: ctypes.CDLL) -> None:
    flags, fixed = functions.rov_thruster_flags_at_f32, functions.rov_thruster_flags_at_q
    out = FLAG["OUT_OF_TESTED_RANGE"]
    for volts, told in ((9.9, out), (10.0, 0), (16.0, 0), (16.1, out)):
        assert flags(5.0, 0.0, volts) == told
        assert fixed(5 * Q16_ONE, 0, round(volts * Q16_ONE)) == told
    assert flags(5.0, 0.0, float("nan")) == FLAG["NOT_A_NUMBER"]
    assert functions.rov_code_from_thrust_at_f32(5.0, 0.0, float("nan")) == 0


def test_the_allocator_takes_the_voltage(functions: ctypes.CDLL) -> None:
    """A lower one asks for larger codes and reaches less; its own gives the plain call's codes."""
    wrench, rest = (ctypes.c_float * 6)(20.0, 0, 0, 0, 0, 2.0), (ctypes.c_float * 3)()

    def asked(volts: float | None) -> tuple[list[int], list[float], int]:
        codes, thrust = (ctypes.c_int16 * 8)(), (ctypes.c_float * 8)()
        if volts is None:
            flags = functions.rov_allocate_thrust_f32(wrench, rest, codes, thrust)
        else:
            supply = ctypes.c_float(volts)
            flags = functions.rov_allocate_at_f32(wrench, rest, supply, codes, thrust)
        return list(codes), list(thrust), flags

    assert asked(12.5) == asked(None)
    low, high = asked(10.0), asked(16.0)
    assert np.abs(low[0]).max() > np.abs(high[0]).max()
    np.testing.assert_allclose(low[1], high[1], atol=1e-4)
    assert asked(9.0)[2] & FLAG["OUT_OF_TESTED_RANGE"]


TAKING = {"both": (ROWS, ROWS), "the others": ((), ROWS), "the first": (ROWS, ())}


@pytest.mark.parametrize("which", TAKING)
def test_each_type_of_thruster_is_asked_at_the_voltage(which: str, tmp_path: Path) -> None:
    """Bit for bit what the tables of each give of the thrust that the allocator shares out."""
    own, other = TAKING[which]
    vehicle = allocator_cases.mixed(allocator_cases.six(), "up0", "up1")
    layout = allocator_layout(vehicle, at(12.5), {"tunnel": at(12.5)}, ["tunnel"] if other else [])
    written(tmp_path, "rov", layout, own)
    written(tmp_path, "rov-tunnel", None, other)
    library = compiled(tmp_path)
    kinds = [("rov_tunnel" if kind else "rov", other if kind else own) for kind in layout.kind]
    for variant, number, one in (("f32", ctypes.c_float, 1.0), ("q", ctypes.c_int32, Q16_ONE)):
        rest = (number * 3)()
        for volts in (11.0, 12.5, 15.5):
            supply = number(volts if variant == "f32" else round(volts * one))
            for push, turn in ((20.0, 2.0), (-35.0, 5.0), (400.0, -20.0)):
                values = [push, 0.0, push / 2.0, 0.0, 0.0, turn]
                scaled = values if variant == "f32" else [round(one * x) for x in values]
                codes, thrust = (ctypes.c_int16 * 6)(), (number * 6)()
                allocate = getattr(library, f"rov_allocate_at_{variant}")
                allocate((number * 6)(*scaled), rest, supply, codes, thrust)
                assert any(codes)
                for i, (name, rows) in enumerate(kinds):
                    call = "code_from_thrust_at" if rows else "code_from_thrust"
                    code_of = getattr(library, f"{name}_{call}_{variant}")
                    code_of.restype = ctypes.c_int16
                    more = (supply,) if rows else ()
                    assert codes[i] == code_of(number(thrust[i]), number(0), *more)


def test_types_for_different_voltages_have_no_supply_in_common(tmp_path: Path) -> None:
    vehicle = allocator_cases.mixed(allocator_cases.six(), "up0")
    layout = allocator_layout(vehicle, at(12.5), {"tunnel": at(16.0)}, ["tunnel"])
    written(tmp_path, "rov", layout)
    assert "allocate_at" not in (tmp_path / "rov_allocator.h").read_text(encoding="utf-8")
