"""The exported allocator: its models to the bit, its limits, and how good its division is."""

import ctypes
import os
import re
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import allocator_cases
import numpy as np
import pytest
import single_model as single_precision
from allocator_cases import CASES, Compiled, demands
from allocator_model import allocate_fixed, allocate_single
from bounded_model import bounded_thrusts
from scipy.optimize import lsq_linear

from evaluation.firmware import emulator
from evaluation.firmware.size_report import allocator_instructions
from pipeline.control.bounded_allocation import largest_demand
from pipeline.export import fixed_point
from pipeline.export.allocator_layout import allocator_layout
from pipeline.export.firmware import write_firmware
from pipeline.export.fixed_point import Q16_ONE
from pipeline.export.grid_check import FLAG

#: A lean part; RIG2SEA_ALLOCATOR_CALLS=100000 compares as many.
FEW = 1500
CALLS = int(os.environ.get("RIG2SEA_ALLOCATOR_CALLS", FEW))


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Compiled]:
    """The compiled allocator of a case, each built once."""

    @cache
    def build(case: str) -> Compiled:
        return allocator_cases.build(case, tmp_path_factory.mktemp(case), "-ffp-contract=off")

    return build


@pytest.fixture(params=CASES)
def compiled(request: pytest.FixtureRequest, library: Callable[[str], Compiled]) -> Compiled:
    return library(request.param)


def limits(one: Compiled, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Limits of each thruster in double precision, as the firmware's header promises them."""
    from pipeline.control.inverse import thrust_grid
    from pipeline.physics.thrust_grid import thrust_limits

    along = velocity @ one.layout.flow.T
    high, low = np.empty(along.shape), np.empty(along.shape)
    for place, characteristic in enumerate(one.characteristics):
        columns = np.array(one.layout.kind) == place
        high[:, columns], low[:, columns] = thrust_limits(
            along[:, columns],
            positive=thrust_grid(characteristic.positive),
            negative=thrust_grid(characteristic.negative),
            code_min=characteristic.code_min,
        )
    return low * one.layout.gain[:, 1], high * one.layout.gain[:, 0]


def same_as_models(one: Compiled, calls: int) -> None:
    """Fixed point the same integers, single precision the same bits."""
    wrench, velocity = demands(calls, seed=1)
    w, v = wrench.astype(np.float32), velocity.astype(np.float32)
    got = one.call("f32", w, v)
    wanted = allocate_single(
        one.layout, [single_precision.single_tables(c) for c in one.characteristics], w, v
    )
    for a, b in zip(got, wanted, strict=True):
        np.testing.assert_array_equal(a, b)
    q, u = (np.rint(x * Q16_ONE).astype(np.int32) for x in (wrench, velocity))
    got = one.call("q", q, u)
    fixed = allocate_fixed(
        one.layout, [fixed_point.fixed_tables(c) for c in one.characteristics], q, u
    )
    for a, b in zip(got, fixed, strict=True):
        np.testing.assert_array_equal(a, b)


def test_c_is_its_models(compiled: Compiled) -> None:
    same_as_models(compiled, CALLS)


def test_single_precision_is_double_but_for_last_places(compiled: Compiled) -> None:
    """Where no limit cuts: within a few units in the last place of the largest thrust."""
    layout = compiled.layout
    wrench, velocity = demands(FEW, seed=2)
    w, v = wrench.astype(np.float32), velocity.astype(np.float32)
    thrust, _, flags = compiled.call("f32", w, v)
    free = (flags & (FLAG["SATURATED"] | FLAG["LIMITED_BY_PORTION"])) == 0
    assert free.sum() > 50
    if layout.paper is not None:
        pytest.skip("eq. (6) is compared with the Python allocator below")
    low, high = limits(compiled, v.astype(float))
    exact, _ = bounded_thrusts(
        layout.allocation, w.astype(float), low, high, largest_n=layout.largest_n
    )
    ulp = float(np.spacing(np.float32(layout.largest_n)))
    assert np.abs(thrust - exact)[free].max() <= 8 * ulp


def test_no_thruster_is_asked_beyond_its_limit(compiled: Compiled) -> None:
    wrench, velocity = demands(FEW, seed=3)
    low, high = limits(compiled, velocity)
    slack = 1e-4 * compiled.layout.largest_n
    for variant, one in (("f32", np.float32), ("q", np.int32)):
        scale = Q16_ONE if variant == "q" else 1
        arguments = [
            (np.rint(x * scale) if scale > 1 else x).astype(one) for x in (wrench, velocity)
        ]
        thrust, codes, _ = compiled.call(variant, *arguments)
        assert (thrust / scale <= high + slack).all()
        assert (thrust / scale >= low - slack).all()
        ends = np.array([(c.code_min, c.code_max) for c in compiled.characteristics])
        ends = ends[list(compiled.layout.kind)]
        assert (codes >= ends[:, 0]).all()
        assert (codes <= ends[:, 1]).all()


def achieved(one: Compiled, thrust: np.ndarray) -> np.ndarray:
    return thrust @ one.layout.allocation.matrix.T


@pytest.mark.parametrize("case", ["eight", "six", "twelve"])
def test_demands_within_reach_are_realised_and_others_as_well_as_can_be(
    case: str, library: Callable[[str], Compiled]
) -> None:
    """Against scipy's bounded least squares, in the same weighted error."""
    one = library(case)
    generator = np.random.default_rng(4)
    velocity = np.zeros((150, 3))
    low, high = limits(one, velocity)
    numbers = one.layout.allocation
    within = achieved(one, low + (high - low) * generator.uniform(0.02, 0.98, low.shape))
    beyond = within * generator.uniform(1.0, 3.0, (150, 1))
    span = np.abs(numbers.matrix) @ high[0]
    for wrench, tolerance in ((within, 0.01), (beyond, np.inf)):
        most = largest_demand(numbers, one.layout.largest_n)
        target = np.clip(wrench, -most, most)
        best = np.array(
            [
                lsq_linear(
                    numbers.scaled, numbers.scale * t, (lo, hi), method="bvls", tol=1e-12
                ).cost
                for t, lo, hi in zip(target, low, high, strict=True)
            ]
        )
        q = np.rint(wrench * Q16_ONE).astype(np.int32)
        for thrust in (
            one.call("f32", wrench.astype(np.float32), velocity.astype(np.float32))[0],
            one.call("q", q, np.zeros((150, 3), np.int32))[0] / Q16_ONE,
        ):
            left = target * numbers.scale - thrust @ numbers.scaled.T
            error = np.linalg.norm(left, axis=-1)
            # a thousandth of the largest thrust, spread over six axes, is as good as the solver
            assert (error - np.sqrt(2 * best)).max() <= 2e-3 * one.layout.largest_n
            off = np.abs(achieved(one, thrust) - wrench)[:, span > 1e-6] / span[span > 1e-6]
            assert off.max() <= tolerance


@pytest.mark.parametrize("form", ["limit", "scaled"])
def test_eq_6_is_that_of_the_python_allocator(
    form: str, library: Callable[[str], Compiled]
) -> None:
    """The papers' geometry: thrusts as `PaperAllocator` decides, codes within one."""
    from pipeline.control.inverse import firmware_grid
    from pipeline.control.paper_allocator import PaperAllocator
    from pipeline.records.fits import InverseCharacteristic

    one = library(form)
    vehicle, characteristic = CASES[form]()
    assert vehicle.allocator is not None
    record = InverseCharacteristic(
        table3_positive=None, table3_negative=None, table4=(), firmware=characteristic,
        round_trip=(), checks=(), explanations=(),
    )  # fmt: skip
    python = PaperAllocator(
        vehicle.allocator, firmware_grid(record), one.layout.names,
        direction=one.layout.flow, corrections=one.layout.corrections,
    )  # fmt: skip
    wrench, velocity = demands(60, seed=5)
    wrench *= [1, 0, 1, 0, 1, 1]
    thrust, codes, flags = one.call("f32", wrench.astype("f4"), velocity.astype("f4"))
    cut_flags = FLAG["SATURATED"] | FLAG["LIMITED_BY_PORTION"]
    for w, v, t, c, f in zip(wrench, velocity, thrust, codes, flags, strict=True):
        wanted_codes, wanted, cut = python.decide(w, np.concatenate([v, np.zeros(3)]))
        assert np.abs(t - wanted).max() < 1e-4
        assert np.abs(c - wanted_codes).max() <= 1
        assert bool(f & cut_flags) == cut


def test_the_flags_say_what_happened(
    library: Callable[[str], Compiled],
) -> None:
    one = library("limit")

    def flags(wrench: list[float], velocity: list[float]) -> int:
        w, v = np.array([wrench], "f4"), np.array([velocity], "f4")
        q, u = (np.rint(x.astype(float) * Q16_ONE).astype("i4") for x in (w, v))
        single, fixed = one.call("f32", w, v)[2][0], one.call("q", q, u)[2][0]
        assert single == fixed
        return int(single)

    still = [0.0, 0.0, 0.0]
    assert flags([40.0, 0, 0, 0, 0, 0], still) == 0
    assert flags([200.0, 0, 0, 0, 0, 0], still) == FLAG["LIMITED_BY_PORTION"]
    assert flags([40.0, 0, -90.0, 0, 0, 0], still) & FLAG["SATURATED"]
    assert flags([1.0, 0, 0, 0, 0, 0], still) == FLAG["IN_DEAD_ZONE"]
    assert flags([40.0, 0, 0, 0, 0, 0], [2.5, 0, 0]) & FLAG["OUT_OF_TESTED_RANGE"]
    assert flags([40.0, 0, 0, 0, 0, 0], [-0.5, 0, 0]) == FLAG["AGAINST_THE_MOTION"]
    nothing = one.call("f32", np.full((1, 6), np.nan, "f4"), np.zeros((1, 3), "f4"))
    assert nothing[2][0] == FLAG["NOT_A_NUMBER"]
    assert not nothing[1].any()
    endless = one.call("f32", np.full((1, 6), np.inf, "f4"), np.zeros((1, 3), "f4"))
    assert np.isfinite(endless[0]).all()


def test_a_thruster_that_gives_less_is_asked_for_a_larger_code(
    library: Callable[[str], Compiled],
) -> None:
    """The lower stern thruster of the case gives 0.8 of the tables' and loses 7 codes."""
    one = library("limit")
    w, v = np.array([[60.0, 0, 0, 0, 0, 0]], "f4"), np.zeros((1, 3), "f4")
    thrust, codes, _ = one.call("f32", w, v)
    assert thrust[0, 0] == thrust[0, 1]
    assert codes[0, 1] > codes[0, 0] + 5
    tables = single_precision.single_tables(one.characteristics[0])
    acts = round((int(codes[0, 1]) - 7) * 127 / (127 - 7))
    given = 0.8 * single_precision.thrust_from_code(tables, acts, 0.0)
    assert given == pytest.approx(thrust[0, 1], abs=0.2)


def test_pulse_widths_go_both_ways(compiled: Compiled) -> None:
    there = compiled.functions.rov_pulse_us_from_code
    back = compiled.functions.rov_code_from_pulse_us
    there.argtypes, there.restype = [ctypes.c_int16], ctypes.c_uint16
    back.argtypes, back.restype = [ctypes.c_uint16], ctypes.c_int16
    low, high = compiled.characteristics[0].code_min, compiled.characteristics[0].code_max
    assert [there(code) for code in (low, 0, high)] == [1500 + round(400 * low / high), 1500, 1900]
    assert [back(there(code)) for code in range(low, high + 1)] == list(range(low, high + 1))
    assert (back(0), back(65535)) == (low, high)


@pytest.mark.parametrize("case", ["limit", "eight_types"])
def test_sanitizers_are_silent(case: str, tmp_path: Path) -> None:
    allocator_cases.build(case, tmp_path)
    wrench, velocity = demands(100, seed=6)
    wrench[:2], velocity[:2] = [[3e4] * 6, [-3e4] * 6], [[3e4] * 3, [-3e4] * 3]
    rows = np.hstack([wrench, velocity]).clip(-32000, 32000)
    numbers = ",\n".join("{" + ", ".join(f"{x:.6f}f" for x in row) + "}" for row in rows.tolist())
    (tmp_path / "main.c").write_text(
        '#include "rov_allocator.h"\n#include <stdio.h>\n'
        f"static const float rows[{len(rows)}][9] = {{{numbers}}};\n"
        "int main(void) { int sum = 0; int16_t c[ROV_THRUSTER_COUNT]; int32_t q[9];\n"
        f"for (int i = 0; i < {len(rows)}; ++i) {{\n"
        " for (int k = 0; k < 9; ++k) { q[k] = (int32_t)(rows[i][k] * 65536.0f); }\n"
        " sum += rov_allocate_f32(rows[i], &rows[i][6], c); sum += rov_allocate_q(q, &q[6], c); }\n"
        ' printf("%d\\n", sum); return 0; }\n'
    )
    sources = [*tmp_path.glob("rov*_thruster.c"), tmp_path / "rov_allocator.c", tmp_path / "main.c"]
    flags = ("-std=c99", "-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover=all")
    program = tmp_path / "checked"
    for command in (["gcc", *flags, *sources, "-o", program], [program]):
        done = subprocess.run(
            [str(part) for part in command],
            capture_output=True,
            text=True,
            check=False,
            timeout=120,
        )
        assert done.returncode == 0, done.stderr[-2000:]
        assert not done.stderr


def test_worst_case_instructions_are_counted_on_a_cortex_m4(
    library: Callable[[str], Compiled],
) -> None:
    if missing := emulator.missing_tools():
        pytest.skip(f"{', '.join(missing)} not installed: see .ci/install_cross_tools.sh")
    one = library("eight")
    counts = allocator_instructions(one.source)
    assert set(counts) == {
        "allocate_f32",
        "allocate_f32 at most",
        "allocate_q",
        "allocate_q at most",
    }
    assert counts["allocate_f32"] < counts["allocate_f32 at most"] < 400_000
    assert counts["allocate_q"] < counts["allocate_q at most"] < 2_000_000


def test_names_and_count_stand_in_the_header(tmp_path: Path) -> None:
    vehicle, characteristic, *_ = CASES["limit"]()
    for folder in (tmp_path, tmp_path / "again"):
        write_firmware(
            "rov", characteristic, tables_digest="0a1b", tool_version="1", folder=folder,
            tables=None, layout=allocator_layout(vehicle, characteristic),
        )  # fmt: skip
    header = (tmp_path / "rov_allocator.h").read_text()
    assert "#define ROV_THRUSTER_COUNT (5)" in header
    assert '{"upper", "lower", "left", "right", "bow"}' in header
    assert re.search(r"1  lower +at \(-0\.9, 0, 0\) m.*gain 0\.8 ahead", header)
    for file in ("rov_allocator.h", "rov_allocator.c", "rov_tables.csv", "rov_thruster.json"):
        assert (tmp_path / file).read_bytes() == (tmp_path / "again" / file).read_bytes()
