"""``python -m tests.fuzz --minutes 10``: damage files of every kind until a reader gives in."""

import sys
import time
from pathlib import Path

import click

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent), str(HERE.parent / "unit" / "ingest")]

from fuzz_campaign import keep, search  # noqa: E402 - the folders above are needed for it
from fuzz_targets import TARGETS  # noqa: E402


@click.command()
@click.option("--minutes", default=10.0, show_default=True, help="For all readers together.")
@click.option("--seed", type=int, default=None, help="Start of the chance; else by the clock.")
@click.option("--only", multiple=True, type=click.Choice(sorted(TARGETS)), help="These readers.")
def main(minutes: float, seed: int | None, only: tuple[str, ...]) -> None:
    """Search for files that a reader cannot stand; keep what is found in tests/fuzz/corpus."""
    names = only or tuple(TARGETS)
    start = int(time.time()) if seed is None else seed
    print(f"seed {start}, {60 * minutes / len(names):.0f} s a reader")
    found = 0
    for name in names:
        tally = search(name, 60 * minutes / len(names), start)
        print(
            f"{name}: {tally.tried} files, {tally.lines} lines of the readers reached, "
            f"{tally.kept} files kept for damage, {len(tally.findings)} faults",
            flush=True,
        )
        for finding in tally.findings:
            found += 1
            path = keep(finding)
            size = len(finding.data)
            print(f"  {finding.what}\n    {finding.where}\n    {path or f'not kept, {size} bytes'}")
    sys.exit(1 if found else 0)


main()
