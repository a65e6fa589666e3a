"""What the slowest tables cost that are known: python -m benchmarks.slowest_tables.

Files of nothing but column names, narrow and wide: every row is looked at as the head of a table.
Prints processor seconds over size; both grow alike, so the limit of size bounds the time.
"""

import tempfile
import time
from pathlib import Path

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.ingest.load_test import read_load_tests
from pipeline.vehicle.load import load_vehicle

_NAMES = ("Code", "n, rpm", "M, N m")
#: Columns, rows.
_SHAPES = ((3, 25_000), (3, 50_000), (3, 100_000), (300, 500), (300, 1000))


def seconds(columns: int, rows: int) -> tuple[float, float]:
    """Return the size of such a file [MB] and the processor seconds of reading it."""
    vehicle = load_vehicle(bundled_vehicle("rov8"))
    with tempfile.TemporaryDirectory() as folder:
        raw = Path(folder) / "raw"
        file = raw / "rov8/load_test/names.csv"
        file.parent.mkdir(parents=True)
        file.write_text((";".join(_NAMES * (columns // 3)) + "\n") * rows, encoding="utf-8")
        before = time.process_time()
        read_load_tests([file], vehicle, raw)
        return file.stat().st_size / 1e6, time.process_time() - before


def main() -> None:
    """Measure and print."""
    print("columns   rows    MB     s   s/MB")
    for columns, rows in _SHAPES:
        size_mb, cpu_s = seconds(columns, rows)
        print(f"{columns:7d} {rows:6d} {size_mb:5.2f} {cpu_s:5.1f} {cpu_s / size_mb:6.1f}")


if __name__ == "__main__":
    main()
