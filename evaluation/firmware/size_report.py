"""Code size and instructions per call of generated firmware on a Cortex-M4.

Usage: ``python -m evaluation.firmware.size_report FOLDER/<vehicle>_thruster.c``
"""

import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from evaluation.firmware import emulator
from pipeline.errors import Rig2SeaError
from pipeline.export.c_text import c_identifier

_STEM_END = "_thruster"


@dataclass(frozen=True)
class Size:
    """Bytes of flash that one variant of the library takes; it needs no RAM but the stack."""

    code: int
    tables: int


def flash_sizes(source: Path) -> dict[str, Size]:
    """Return the sizes of the ``f32`` and the ``q`` variant, each with its tables.

    Parameters
    ----------
    source : Path
        A generated ``<vehicle>_thruster.c``; its header lies beside it.
    """
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "thruster.o"
        emulator.compile_object(source, target)
        listing = emulator.run_tool([emulator.SIZE, "-A", str(target)])
    code = {"f32": 0, "q": 0}
    tables = {"f32": 0, "q": 0}
    for line in listing.splitlines():
        words = line.split()
        if not words or not words[0].startswith((".text.", ".rodata.", ".data.", ".bss.")):
            continue
        variant = "f32" if words[0].endswith("_f32") else "q"
        if words[0].endswith("_tables_digest"):
            continue
        kind = code if words[0].startswith(".text.") else tables
        kind[variant] += int(words[1])
    return {variant: Size(code[variant], tables[variant]) for variant in code}


def instructions_per_call(source: Path) -> dict[str, int]:
    """Return the mean number of instructions of each function over thrusts and speeds.

    Counted by running the library in the emulator; ``calibration_4000`` is the count of a block
    of exactly 4000 instructions, and good to one tick of 40.
    """
    return _counted([source], "count_instructions.c", source)


def allocator_instructions(source: Path) -> dict[str, int]:
    """Return mean and largest number of instructions of a call of the allocator beside `source`.

    Over demands from nothing to several times what the thrusters can and speeds either way.
    """
    allocator = source.with_name(f"{source.stem.removesuffix(_STEM_END)}_allocator.c")
    return _counted([source, allocator], "count_allocator.c", source)


def _counted(sources: Sequence[Path], program: str, source: Path) -> dict[str, int]:
    identifier = _identifier(source)
    with tempfile.TemporaryDirectory() as folder:
        image = Path(folder) / "count.elf"
        emulator.link_program(
            [*sources, emulator.SUPPORT / program],
            image,
            flags=(
                f"-I{source.parent}",
                f"-DTHRUSTER={identifier}",
                f'-DTHRUSTER_HEADER="{sources[-1].stem}.h"',
                f"-DCOUNT={identifier.upper()}_THRUSTER_COUNT",
            ),
        )
        command = emulator.emulation_command(image, count_instructions=True)
        printed = emulator.run_tool(command)
    lines = (line.rpartition(" ") for line in printed.splitlines())
    return {name: int(count) for name, _, count in lines}


def _identifier(source: Path) -> str:
    return c_identifier(source.stem.removesuffix(_STEM_END))


def report(source: Path) -> str:
    """Return the sizes and counts of one library as text."""
    compiler = emulator.run_tool([emulator.COMPILER, "--version"]).splitlines()[0]
    flags = " ".join((*emulator.TARGET_FLAGS, *emulator.CODE_FLAGS))
    lines = [f"{source.name} on a Cortex-M4", compiler, flags, "", "flash [bytes]  code  tables"]
    lines += [
        f"  {variant:<12} {size.code:5d}  {size.tables:6d}"
        for variant, size in flash_sizes(source).items()
    ]
    lines += ["", "instructions per call"]
    counts = instructions_per_call(source)
    if source.with_name(f"{source.stem.removesuffix(_STEM_END)}_allocator.c").is_file():
        counts |= allocator_instructions(source)
    lines += [f"  {name:<22} {count:7d}" for name, count in counts.items()]
    return "\n".join(lines)


def main(arguments: Sequence[str]) -> int:
    """Print the report on each file named; 0 done, 1 a tool failed, 2 wrong usage."""
    if not arguments or any(a.startswith("-") or not a.endswith(".c") for a in arguments):
        print(__doc__, file=sys.stderr)
        return 2
    for argument in arguments:
        try:
            print(report(Path(argument)))
        except Rig2SeaError as error:
            print(error, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
