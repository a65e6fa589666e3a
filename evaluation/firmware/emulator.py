"""Build C programs for a Cortex-M4 and run them in QEMU (machine mps2-an386)."""

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from pipeline.errors import CannotComputeError

COMPILER = "arm-none-eabi-gcc"
SIZE = "arm-none-eabi-size"
EMULATOR = "qemu-system-arm"
#: Start-up code, memory map and the counting program.
SUPPORT = Path(__file__).parent / "cortex_m4"

TARGET_FLAGS = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
CODE_FLAGS = ("-std=c99", "-O2", "-ffunction-sections", "-fdata-sections")
_LINK_FLAGS = ("-T", str(SUPPORT / "mps2_an386.ld"), "--specs=rdimon.specs", "-Wl,--gc-sections")
_TIMEOUT_S = 120


def missing_tools() -> tuple[str, ...]:
    """Return which of the compiler, its size tool and the emulator are not installed."""
    return tuple(tool for tool in (COMPILER, SIZE, EMULATOR) if shutil.which(tool) is None)


def run_tool(command: Sequence[str]) -> str:
    """Run a tool and return what it printed.

    Raises
    ------
    CannotComputeError
        When the tool is not installed or fails; the text holds what it said.
    """
    if shutil.which(command[0]) is None:
        raise CannotComputeError(
            f"{command[0]} is not installed. On Debian and Ubuntu, .ci/install_cross_tools.sh "
            "installs what cross-compiling and emulating need."
        )
    done = subprocess.run(  # noqa: S603  a list of arguments, no shell
        command, capture_output=True, text=True, check=False, timeout=_TIMEOUT_S
    )
    if done.returncode != 0:
        raise CannotComputeError(f"{' '.join(command)}\n{done.stdout}{done.stderr}".rstrip())
    return done.stdout


def compile_object(source: Path, target: Path, *, flags: Sequence[str] = ()) -> None:
    """Compile one C file for the Cortex-M4."""
    run_tool([COMPILER, *TARGET_FLAGS, *CODE_FLAGS, *flags, "-c", str(source), "-o", str(target)])


def link_program(sources: Sequence[Path], target: Path, *, flags: Sequence[str] = ()) -> None:
    """Compile C files and link them with start-up code and C library to a program."""
    files = [str(source) for source in (*sources, SUPPORT / "startup.c")]
    run_tool(
        [COMPILER, *TARGET_FLAGS, *CODE_FLAGS, *flags, *files, *_LINK_FLAGS, "-o", str(target)]
    )


def emulation_command(program: Path, *, count_instructions: bool = False) -> list[str]:
    """Return the command that runs a program; it ends with the program's exit status.

    With `count_instructions` one nanosecond of the emulated clock passes for each instruction.
    """
    clock = ["-icount", "shift=0"] if count_instructions else []
    return [
        *(EMULATOR, "-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none"),
        *(*clock, "-semihosting-config", "enable=on,target=native"),
        *("-kernel", str(program)),
    ]
