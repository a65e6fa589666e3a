"""All pairs of supply voltages of a measured thruster: modelled at one, diagnosed at another.

    python -m benchmarks.bench_diagnosis_t200 WORKBOOK.xlsx [--shown]

Prints a row for each pair; with --shown the speed, current and voltage columns are used as well.
"""

import sys
from pathlib import Path

from pipeline.diagnose.bench.engine import diagnose_bench
from pipeline.diagnose.bench.model import bench_model
from pipeline.diagnose.bench.table import bench_table
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.vehicle.load import load_vehicle

VEHICLE = Path(__file__).resolve().parents[1] / "tests" / "acceptance" / "t200"
HIDDEN = ("shaft_speed", "current", "voltage")


def main(arguments: list[str]) -> None:
    """Diagnose every pair and print the verdicts."""
    workbook = Path(arguments[0])
    without = () if "--shown" in arguments else HIDDEN
    vehicle = load_vehicle(VEHICLE)
    record = read_mooring_tables([workbook], vehicle, workbook.parent)
    volts = sorted({p.voltage_v for p in record.points if p.voltage_v is not None})
    for modelled in volts:
        tables = vehicle.tables.model_copy(update={"supply_voltage_v": modelled})
        model = bench_model(vehicle.model_copy(update={"tables": tables}), None, record)
        for measured in volts:
            points = [p for p in record.points if p.voltage_v == measured]
            table = bench_table(points, model, name=f"{measured:g} V", without=without)
            found = diagnose_bench(model, table)
            also = ", ".join(found.verdict.ambiguous_with)
            closed = found.shrink.gap_closed
            sys.stdout.write(
                f"| {modelled:g} | {measured:g} | {'+'.join(found.verdict.effects)} | {also} | "
                f"{found.gap.channels['thrust'].ratio:.1f} | "
                f"{'' if closed is None else f'{100 * closed:.0f} %'} |\n"
            )
            sys.stdout.flush()


if __name__ == "__main__":
    main(sys.argv[1:])
