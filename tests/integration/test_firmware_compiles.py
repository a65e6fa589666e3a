"""The generated C: it compiles strictly, agrees with its models to the bit, and can fail.

Each test skips, and says so, where the compiler or the emulator it needs is not installed.
"""

import ctypes
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import fixed_model
import numpy as np
import pytest
import single_model as single_precision
from firmware_cases import CASES, codes_that_return, reference_code, strongest

from evaluation.firmware import emulator
from evaluation.firmware.size_report import flash_sizes, instructions_per_call, report
from pipeline.export import fixed_point
from pipeline.export.firmware import write_firmware
from pipeline.export.self_test import reference
from pipeline.records.fits import FirmwareCharacteristic

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-pedantic", "-Werror")
MORE = ("-Wshadow", "-Wdouble-promotion", "-Wcast-qual", "-Wmissing-prototypes", "-Wswitch-default")
ONE = fixed_point.Q16_ONE
T = TypeVar("T")
SPEED_MPS = np.arange(-250, 251) / 100.0
THRUST_N = np.arange(-1000, 1001) / 20.0

DRIVER = """
#include "rov_thruster.h"
#include <stddef.h>
#define LOOP for (size_t i = 0U; i < n; ++i)
void code_f32(size_t n, const float *t, const float *v, int16_t *out)
{ LOOP { out[i] = rov_code_from_thrust_f32(t[i], v[i]); } }
void code_q(size_t n, const int32_t *t, const int32_t *v, int16_t *out)
{ LOOP { out[i] = rov_code_from_thrust_q(t[i], v[i]); } }
void thrust_f32(size_t n, const int16_t *c, const float *v, float *out)
{ LOOP { out[i] = rov_thrust_from_code_f32(c[i], v[i]); } }
void thrust_q(size_t n, const int16_t *c, const int32_t *v, int32_t *out)
{ LOOP { out[i] = rov_thrust_from_code_q(c[i], v[i]); } }
void limits_f32(size_t n, const float *v, float *most, float *least)
{ LOOP { most[i] = rov_thrust_max_f32(v[i]); least[i] = rov_thrust_min_f32(v[i]); } }
void limits_q(size_t n, const int32_t *v, int32_t *most, int32_t *least)
{ LOOP { most[i] = rov_thrust_max_q(v[i]); least[i] = rov_thrust_min_q(v[i]); } }
"""


def need(tool: str) -> str:
    if shutil.which(tool) is None:
        pytest.skip(f"{tool} is not installed")
    return tool


def need_cross_tools() -> None:
    if missing := emulator.missing_tools():
        pytest.skip(f"{', '.join(missing)} not installed: see .ci/install_cross_tools.sh")


HOSTILE_CHECK = {"name": "reverse */", "passed": False, "text": "odd *" + " x" * 50 + " */ ??/"}


def run(*command: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False, timeout=120
    )


def build(*command: object) -> None:
    done = run(*command)
    assert done.returncode == 0, done.stderr
    assert not done.stderr


def generate(characteristic: FirmwareCharacteristic, folder: Path) -> Path:
    """Write the firmware and return the C source; its self-test lies beside it."""
    paths = write_firmware(
        "rov",
        characteristic,
        tables_digest='"hostile" */ int x; ??/',
        tool_version="0.1.0",
        folder=folder,
        tables={"quality": {"checks": [HOSTILE_CHECK]}},
    )
    return paths[1]


@pytest.fixture(scope="module", params=CASES)
def generated(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[FirmwareCharacteristic, Path]:
    characteristic = CASES[request.param]()
    return characteristic, generate(characteristic, tmp_path_factory.mktemp(request.param))


@dataclass(frozen=True)
class Library:
    """The C functions over arrays."""

    characteristic: FirmwareCharacteristic
    functions: ctypes.CDLL

    def call(self, name: str, *arguments: np.ndarray, result: type) -> np.ndarray:
        """Call one of DRIVER's functions; arguments already have the types of C."""
        arrays = [np.ascontiguousarray(a) for a in np.broadcast_arrays(*arguments)]
        out = np.empty(arrays[0].shape, result)
        pointers = [ctypes.c_void_p(a.ctypes.data) for a in (*arrays, out)]
        getattr(self.functions, name)(ctypes.c_size_t(out.size), *pointers)
        return out

    def limits(self, name: str, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        most, least = np.empty_like(speed), np.empty_like(speed)
        pointers = [ctypes.c_void_p(a.ctypes.data) for a in (speed, most, least)]
        getattr(self.functions, name)(ctypes.c_size_t(speed.size), *pointers)
        return most, least


def load(source: Path, characteristic: FirmwareCharacteristic, *flags: str) -> Library:
    need("gcc")
    driver = source.parent / "driver.c"
    driver.write_text(DRIVER)
    name = "_".join(("library", *flags)).replace("=", "-")
    target = source.parent / f"{name}.so"
    build(
        "gcc",
        *STRICT[:-1],
        "-Wno-missing-prototypes",
        "-O2",
        *flags,
        "-shared",
        "-fPIC",
        source,
        driver,
        "-o",
        target,
    )
    return Library(characteristic, ctypes.CDLL(str(target)))


@pytest.fixture(scope="module")
def library(generated: tuple[FirmwareCharacteristic, Path]) -> Library:
    characteristic, source = generated
    return load(source, characteristic, "-ffp-contract=off")


def all_codes(characteristic: FirmwareCharacteristic) -> np.ndarray:
    """Every code, or with many every so manieth, and the ends of int16 with their neighbours."""
    step = max(characteristic.code_max // 400, 1)
    codes = np.arange(-characteristic.code_max, characteristic.code_max + 1, step)
    return np.concatenate((codes, [-32768, -32767, 32767])).astype(np.int16)


def beyond(characteristic: FirmwareCharacteristic) -> np.ndarray:
    """Thrusts over the whole range of this characteristic, a little beyond T_max."""
    ratio = 1.1 * max(characteristic.positive.thrust_max_n) / THRUST_N[-1]
    return THRUST_N * ratio


def each_case_with(first: T, *others: T) -> list[tuple[str, T]]:
    """Pair every case with the first, and with the others two that share little."""
    few = ("table2", "largest_codes")
    return [(case, first) for case in CASES] + [(case, one) for one in others for case in few]


# ---- The compilers have nothing to say ----------------------------------------------------------


@pytest.mark.parametrize(
    ("generated", "compiler", "level"),
    [
        (case, *one)
        for case, one in each_case_with(("gcc", "-O2"), ("gcc", "-O0"), ("clang", "-Os"))
    ],
    indirect=["generated"],
)
def test_compiles_without_a_warning(
    generated: tuple[FirmwareCharacteristic, Path], compiler: str, level: str
) -> None:
    need(compiler)
    source = generated[1]
    self_test = source.with_name("rov_thruster_self_test.c")
    for file in (source, self_test):
        build(compiler, *STRICT, *MORE, level, "-c", file, "-o", source.with_suffix(".o"))


def test_library_needs_nothing_from_outside(generated: tuple[FirmwareCharacteristic, Path]) -> None:
    """No libm, no libc, no static data that changes."""
    need("gcc")
    target = generated[1].with_name("bare.o")
    build("gcc", *STRICT, "-O2", "-ffreestanding", "-fno-pie", "-c", generated[1], "-o", target)
    symbols = run("nm", target).stdout.splitlines()
    kinds = {line.split()[-1]: line.split()[-2] for line in symbols}
    assert not [name for name, kind in kinds.items() if kind in "UdDbBC"]
    exported = {name for name, kind in kinds.items() if kind.isupper()}
    assert all(name.startswith("rov_") for name in exported)


def test_header_serves_cpp(generated: tuple[FirmwareCharacteristic, Path]) -> None:
    compiler = need("g++")
    program = generated[1].with_name("use.cpp")
    program.write_text(
        '#include "rov_thruster.h"\n#include "rov_thruster.h"\n'
        "int main() { return rov_code_from_thrust_f32(0.0f, 0.0f); }\n"
    )
    build(compiler, "-Wall", "-Wextra", "-pedantic", "-Werror", "-c", program, "-o", "/dev/null")


def test_fast_math_is_refused(generated: tuple[FirmwareCharacteristic, Path]) -> None:
    need("gcc")
    done = run("gcc", "-std=c99", "-ffast-math", "-c", generated[1], "-o", "/dev/null")
    assert done.returncode != 0
    assert "NaN checks would be removed" in done.stderr


def test_the_linked_image_holds_the_digest_and_the_variant_in_use_alone(tmp_path: Path) -> None:
    """With the flags that header and documentation name; nothing calls the digest."""
    need("gcc")
    source = write_firmware(
        "rov",
        CASES["table2"](),
        tables_digest="0123456789abcdef",
        tool_version="0.1.0",
        folder=tmp_path,
        tables=None,
    )[1]
    header = source.with_suffix(".h").read_text()
    flags = [flag for flag in re.findall(r"-[\w,=-]+", header.split("*/")[0]) if flag[1] in "fW"]
    keep = "-Wl,--undefined=rov_thruster_tables_digest"
    assert flags[:4] == ["-ffunction-sections", "-fdata-sections", "-Wl,--gc-sections", keep]
    main = tmp_path / "main.c"
    main.write_text(
        '#include "rov_thruster.h"\n'
        "int main(int n, char **text)\n"
        "{ (void)text; return rov_code_from_thrust_f32((float)n, 0.0f); }\n"
    )
    image = tmp_path / "image"
    build("gcc", "-std=c99", "-O2", *flags[:4], source, main, "-o", image)
    assert b"0123456789abcdef" in image.read_bytes()
    assert "_code_from_thrust_q" not in run("nm", image).stdout


# ---- C against its models and the reference -----------------------------------------------------


def test_fixed_point_codes_are_the_models(library: Library) -> None:
    tables = fixed_point.fixed_tables(library.characteristic)
    thrusts = np.rint(THRUST_N * ONE).astype(np.int32)
    own = np.rint(beyond(library.characteristic) * ONE).astype(np.int32)
    ends = np.array([-(2**31), -(2**31) + 1, -1, 0, 1, 2**31 - 1], np.int32)
    thrust = np.concatenate((thrusts, own, ends))
    speeds = np.rint(SPEED_MPS * ONE).astype(np.int32)
    for speed in np.concatenate((speeds[::7], ends)):
        got = library.call("code_q", thrust, speed, result=np.int16)
        assert (got == fixed_point.code_from_thrust(tables, thrust, int(speed))).all()


def test_fixed_point_thrusts_are_the_models(library: Library) -> None:
    tables = fixed_point.fixed_tables(library.characteristic)
    codes = all_codes(library.characteristic)
    ends = np.array([-(2**31), -1, 0, 1, 2**31 - 1], np.int32)
    for speed in np.concatenate((np.rint(SPEED_MPS[::7] * ONE).astype(np.int32), ends)):
        got = library.call("thrust_q", codes, speed, result=np.int32)
        assert (got == fixed_model.thrust_from_code(tables, codes, int(speed))).all()


def test_limits_are_the_models(library: Library) -> None:
    fixed = fixed_point.fixed_tables(library.characteristic)
    single = single_precision.single_tables(library.characteristic)
    speed_q = np.append(np.rint(SPEED_MPS * ONE), [-(2**31), 2**31 - 1]).astype(np.int32)
    speed_f = np.append(SPEED_MPS, [np.inf, -np.inf, np.nan]).astype(np.float32)
    for index, sign in enumerate((1, -1)):
        q = library.limits("limits_q", speed_q)[index]
        assert (q == fixed_model.thrust_limit(fixed, speed_q, sign=sign)).all()
        f = library.limits("limits_f32", speed_f)[index]
        assert (f == single_precision.thrust_limit(single, speed_f, sign=sign)).all()


def test_single_precision_is_the_models_to_the_bit(library: Library) -> None:
    """Without fused operations; the next test lets the compiler fuse."""
    tables = single_precision.single_tables(library.characteristic)
    codes = all_codes(library.characteristic)
    ends = [np.inf, -np.inf, np.nan, 3.4e38, -3.4e38, 1e-45]
    thrust = np.concatenate((THRUST_N, beyond(library.characteristic), ends)).astype(np.float32)
    for speed in np.append(SPEED_MPS[::7], ends).astype(np.float32):
        got = library.call("code_f32", thrust, speed, result=np.int16)
        assert (got == single_precision.code_from_thrust(tables, thrust, speed)).all()
        got_n = library.call("thrust_f32", codes, speed, result=np.float32)
        wanted_n = single_precision.thrust_from_code(tables, codes, speed)
        assert (got_n == wanted_n).all()


@pytest.mark.parametrize("generated", ["table2", "largest_codes"], indirect=True)
def test_fused_operations_change_a_few_last_places(
    generated: tuple[FirmwareCharacteristic, Path],
) -> None:
    flags = Path("/proc/cpuinfo")
    if not flags.exists() or " fma " not in flags.read_text():
        pytest.skip("this processor has no fused multiply-add")
    characteristic, source = generated
    fused = load(source, characteristic, "-mfma", "-ffp-contract=fast")
    tables = single_precision.single_tables(characteristic)
    codes = all_codes(characteristic)
    largest = np.float32(max(characteristic.positive.thrust_max_n))
    for speed in SPEED_MPS[::5].astype(np.float32):
        got_n = fused.call("thrust_f32", codes, speed, result=np.float32)
        wanted_n = single_precision.thrust_from_code(tables, codes, speed)
        assert np.abs(got_n - wanted_n).max() <= 8 * np.spacing(largest)


@pytest.mark.parametrize("variant", ["f32", "q"])
def test_codes_are_at_most_one_from_the_reference(library: Library, variant: str) -> None:
    characteristic = library.characteristic
    thrust_q = np.rint(beyond(characteristic) * ONE).astype(np.int32)
    off = 0
    for speed in SPEED_MPS[::5]:
        speed_q = np.int32(round(speed * ONE))
        thrust, at = (
            (thrust_q, speed_q)
            if variant == "q"
            else ((thrust_q / ONE).astype(np.float32), np.float32(speed_q / ONE))
        )
        got = library.call(f"code_{variant}", thrust, at, result=np.int16).astype(int)
        wanted = reference_code(
            characteristic,
            thrust_q / ONE if variant == "q" else thrust.astype(float),
            float(speed_q / ONE),
        )
        rounded = np.sign(wanted) * np.floor(np.abs(wanted) + 0.5)
        assert np.abs(got - rounded).max() <= 1
        off += np.count_nonzero(got != rounded)
    # Only ties of rounding may differ, and they are rare but where a code is 30 mN wide.
    allowed = 0.1 if characteristic.code_max > 1000 else 0.002
    assert off <= allowed * len(thrust_q) * len(SPEED_MPS[::5])


@pytest.mark.parametrize("variant", ["f32", "q"])
def test_codes_come_back(library: Library, variant: str) -> None:
    """Code to thrust to code: the same code wherever the thrust is more than the dead zone's."""
    characteristic = library.characteristic
    codes = codes_that_return(characteristic, 801).astype(np.int16)
    kinds = {"f32": (np.float32, 1.0), "q": (np.int32, ONE)}
    kind, one = kinds[variant]
    for speed in (SPEED_MPS[::7] * one).astype(kind):
        thrust = library.call(f"thrust_{variant}", codes, speed, result=kind)
        back = library.call(f"code_{variant}", thrust, speed, result=np.int16)
        live = np.abs(thrust / one) > characteristic.thrust_dead_n
        assert live.any()
        assert np.abs(back.astype(int) - codes)[live].max() <= 1


# ---- The self-test ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("generated", "command"),
    each_case_with(
        ("gcc", "-O1", "-g", "-fsanitize=undefined,address", "-fno-sanitize-recover=all"),
        ("gcc", "-O3", "-ffp-contract=fast"),
        ("clang", "-O2"),
    ),
    indirect=["generated"],
)
def test_self_test_passes(
    generated: tuple[FirmwareCharacteristic, Path], command: tuple[str, ...]
) -> None:
    need(command[0])
    characteristic, source = generated
    program = source.with_name("self_test")
    self_test = source.with_name("rov_thruster_self_test.c")
    build(*command, *STRICT, source, self_test, "-o", program)
    done = run(program)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert re.fullmatch(r"\d+ passed, 0 failed\n", done.stdout)
    assert not done.stderr
    grid = reference(characteristic)
    assert int(done.stdout.split()[0]) > 4 * grid.thrust_n.size


@pytest.mark.parametrize("thrust_n", [28_500.0, 31_000.0, 32_766.0])
def test_self_test_passes_up_to_the_largest_thrust(thrust_n: float, tmp_path: Path) -> None:
    """Beyond T_max it asks for as much as the fixed-point format holds, and no more."""
    need("gcc")
    source = generate(strongest(thrust_n), tmp_path)
    program = tmp_path / "self_test"
    self_test = tmp_path / "rov_thruster_self_test.c"
    sanitizer = ("-fsanitize=undefined", "-fno-sanitize-recover=all")
    build("gcc", "-O1", *sanitizer, *STRICT, source, self_test, "-o", program)
    done = run(program)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]


def change_number(pattern: str, change: Callable[[float], str]) -> Callable[[str], str]:
    """Return a mutation that rewrites the number caught by the pattern's only group."""

    def mutate(text: str) -> str:
        match = re.search(pattern, text, flags=re.DOTALL)
        assert match is not None
        return text[: match.start(1)] + change(float(match[1])) + text[match.end(1) :]

    return mutate


MUTATIONS: dict[str, Callable[[str], str]] = {
    "a float code, by a thousandth": change_number(
        r"positive_code_f32\[.*?at 1 m/s \*/\n(?:\s*[\d.]+f,){7}\s*([\d.]+)f",
        lambda x: f"{x * 1.001}",
    ),
    "a fixed-point code, by a thousandth": change_number(
        r"negative_code_q16\[.*?at 1 m/s \*/\n(?:\s*\d+U,){7}\s*(\d+)U",
        lambda x: f"{int(x * 1.001)}",
    ),
    "a float T_max, by a ten-thousandth": change_number(
        r"negative_thrust_max_n_f32\[.*?([\d.]+)f", lambda x: f"{x * 1.0001}"
    ),
    "a fixed-point T_max, by a ten-thousandth": change_number(
        r"positive_thrust_max_q16\[.*?\{\n\s*(\d+)U", lambda x: f"{int(x * 1.0001)}"
    ),
    "a float fraction": change_number(
        r"positive_fraction_f32\[.*?0\.0f, ([\d.]+)f", lambda x: f"{x * 1.01}"
    ),
    "a fixed-point speed": change_number(
        r"positive_speed_q16\[.*?0U, (\d+)U", lambda x: f"{int(x * 1.01)}"
    ),
    "the dead zone": change_number(r"thrust_dead_q = (\d+)U", lambda x: f"{int(x) - 1}"),
    "rounding down": change_number(r"Q16_HALF \((\d+)U", lambda _: "0"),
    "no row at rest": lambda text: text.replace(
        "return against ? 0U :", "return (against && false) ? 0U :"
    ),
    "float NaN unseen": lambda text: text.replace(
        "return !(x >= 0.0f)", "return false && !(x >= 0.0f)"
    ),
    "reverse read from the wrong branch": lambda text: text.replace(
        "reverse ? &negative_q", "reverse ? &positive_q"
    ),
}


@pytest.mark.parametrize("fault", MUTATIONS)
def test_self_test_finds(fault: str, tmp_path: Path) -> None:
    need("gcc")
    source = generate(CASES["table2"](), tmp_path)
    sound = source.read_text()
    source.write_text(MUTATIONS[fault](sound))
    assert source.read_text() != sound
    program = tmp_path / "self_test"
    build("gcc", "-std=c99", source, tmp_path / "rov_thruster_self_test.c", "-o", program)
    done = run(program)
    lines = done.stdout.splitlines()
    assert done.returncode == 1
    failed = int(re.fullmatch(r"\d+ passed, (\d+) failed", lines[-1])[1])  # type: ignore[index]
    assert failed == len(lines) - 1 > 0
    assert all(line.startswith("FAIL ") for line in lines[:-1])


# ---- Cortex-M4 ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("generated", "contract"), each_case_with("fast", "off"), indirect=["generated"]
)
def test_self_test_passes_on_a_cortex_m4(
    generated: tuple[FirmwareCharacteristic, Path], contract: str
) -> None:
    need_cross_tools()
    source = generated[1]
    program = source.with_name("self_test.elf")
    self_test = source.with_name("rov_thruster_self_test.c")
    flags = (*STRICT[1:], f"-ffp-contract={contract}")
    emulator.link_program([source, self_test], program, flags=flags)
    done = run(*emulator.emulation_command(program))
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert re.fullmatch(r"\d+ passed, 0 failed\n", done.stdout)


def test_a_fault_is_found_on_a_cortex_m4(tmp_path: Path) -> None:
    need_cross_tools()
    source = generate(CASES["table2"](), tmp_path)
    source.write_text(MUTATIONS["a fixed-point T_max, by a ten-thousandth"](source.read_text()))
    program = tmp_path / "self_test.elf"
    emulator.link_program([source, tmp_path / "rov_thruster_self_test.c"], program)
    done = run(*emulator.emulation_command(program))
    assert done.returncode == 1
    assert not done.stdout.endswith(" 0 failed\n")


def test_size_and_instructions_on_a_cortex_m4(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    need_cross_tools()
    source = generate(CASES["table2"](), tmp_path)
    counts = instructions_per_call(source)
    sizes = flash_sizes(source)
    with capsys.disabled():
        print(f"\n{report(source)}")
    # The clock counts instructions, to one tick of 40.
    assert counts.pop("calibration_4000") == pytest.approx(4000, abs=40)
    assert len(counts) == 6
    assert all(0 < count < 2000 for count in counts.values())
    # Nine speeds, 33 fractions, two signs: four bytes a number, and little besides.
    numbers = 2 * 9 * 33 + 2 * 9 + 9 + 33
    for size in sizes.values():
        assert 4 * numbers <= size.tables <= 4 * numbers + 200
        assert 0 < size.code < 2500
