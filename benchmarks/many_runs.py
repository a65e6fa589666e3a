"""What a season of pool runs costs: python -m benchmarks.many_runs [--runs 10 100] [--write].

Flies one short run of a bundled vehicle, copies it with new starts (four runs a day), and measures
in a folder of its own, in processor seconds of all processes: all runs at first, one new run, and
nothing to do; with the peak memory of the largest process. Beyond `--most-computed` runs all but
one are laid out as finished (envelopes with true digests, nothing computed): the time of all is
then left out.
"""

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path

from matplotlib.figure import Figure
from mcap.reader import make_reader
from mcap.writer import Writer

from benchmarks import page
from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.export.mcap_log import write_run_log
from pipeline.plan import VehicleFolder
from pipeline.simulate.fly import fly
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import pack_vehicle
from pipeline.simulate.sensors import measure as measured
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.sensor_schema import Sensors

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/benchmarks_many_runs.md"
PLOT = ROOT / "docs/images/many_runs.svg"
VEHICLE = "rov8"
FIRST_NS = 1_777_000_000_000_000_000
APART_NS = 6 * 3_600_000_000_000
FLIGHT_S = 15.0


@dataclass(frozen=True)
class Cost:
    """Of one execution: processor seconds, seconds on the wall, MB of its largest process."""

    cpu_s: float
    wall_s: float
    peak_mb: float
    stages: int


@dataclass(frozen=True)
class Row:
    """The costs with so many runs in raw/; `everything` is None where nothing was computed."""

    runs: int
    everything: Cost | None
    one_new: Cost
    nothing: Cost


def main() -> None:
    """Measure and print, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--runs", type=int, nargs="*", default=[10, 100], help="None: write what --json has."
    )
    parser.add_argument("--most-computed", type=int, default=200)
    parser.add_argument("--write", action="store_true", help="Write the page and the plot.")
    parser.add_argument("--json", type=Path, help="Add the figures to those of this file.")
    asked = parser.parse_args()
    rows = _known(asked.json)
    with tempfile.TemporaryDirectory(prefix="many-runs-") as folder:
        log = Path(folder) / "one.mcap"
        _fly(log)
        for runs in asked.runs:
            place = Path(folder) / str(runs)
            rows[runs] = measure(place, log, runs, computed=runs <= asked.most_computed)
            shutil.rmtree(place)
            print(_line(rows[runs]), flush=True)
            if asked.json:
                body = [asdict(rows[key]) for key in sorted(rows)]
                asked.json.write_text(json.dumps(body, indent=1) + "\n", encoding="utf-8")
    found = [rows[key] for key in sorted(rows)]
    print(table(found))
    if asked.write:
        _write(found)


def measure(place: Path, log: Path, runs: int, *, computed: bool) -> Row:
    """Measure with so many runs, in a folder of their own."""
    folder = place / "raw" / VEHICLE
    (folder / "pool").mkdir(parents=True)
    shutil.copyfile(_vehicle_file(), folder / "vehicle.yaml")
    everything = None
    if computed:
        _copies(log, folder, 0, runs - 1)
        everything = execute(place)
    else:
        _finished(place, runs - 1)
        execute(place)  # the vehicle's own results, and the pages of what was laid out
    _copies(log, folder, runs - 1, runs)
    one_new = execute(place)
    time.sleep(0.3)  # files that are younger are read again
    execute(place)
    return Row(runs, everything, one_new, execute(place))


def execute(place: Path) -> Cost:
    """Run `rig2sea run` there, in a process that waits for all of its own.

    Raises
    ------
    RuntimeError
        When it did not end well: its times would be those of something else.
    """
    before = time.monotonic()
    code = (
        "import json, resource, subprocess, sys\n"
        "done = subprocess.run([sys.executable, '-m', 'pipeline', 'run', '--cores', '2'],"
        " stdout=sys.stderr, check=False)\n"
        "used = resource.getrusage(resource.RUSAGE_CHILDREN)\n"
        "print(json.dumps([used.ru_utime + used.ru_stime, used.ru_maxrss]))\n"
        "sys.exit(done.returncode)\n"
    )
    paths = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(  # noqa: S603 - our own program
        [sys.executable, "-c", code],
        cwd=place,
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(f"rig2sea run ended with {done.returncode}:\n{done.stderr}")
    cpu_s, peak = json.loads(done.stdout.splitlines()[-1])
    per_mb = 1e6 if sys.platform == "darwin" else 1e3
    return Cost(cpu_s, time.monotonic() - before, peak / per_mb, _stages(place))


def _stages(place: Path) -> int:
    journal = place / "processed/.rig2sea/journal.jsonl"
    if not journal.is_file():
        return 0
    lines = journal.read_text(encoding="utf-8").splitlines()
    return sum(json.loads(line)["what"] == "done" for line in lines)


def _vehicle_file() -> Path:
    return Path(bundled_vehicle(VEHICLE)) / "vehicle.yaml"


def _fly(log: Path) -> None:
    """Write one short simulated run."""
    vehicle = load_vehicle(_vehicle_file())
    packed = pack_vehicle(vehicle)
    flown = fly(packed, MANOEUVRES["heave_steps"].plan(packed, 1.0, FLIGHT_S))
    write_run_log(
        log,
        measured(flown, packed, vehicle.sensors or Sensors(), seed=1),
        vehicle_name=VEHICLE,
        density_kgpm3=vehicle.water.density_kgpm3,
        gravity_mps2=vehicle.water.gravity_mps2,
        start_time_ns=FIRST_NS,
    )


def _copies(log: Path, folder: Path, begin: int, end: int) -> None:
    """Copy the log under new names with new starts; times within it stay apart as they were."""
    for number in range(begin, end):
        later = number * APART_NS
        with log.open("rb") as source, (folder / f"pool/run-{number:04d}.mcap").open("wb") as to:
            writer = Writer(to)
            writer.start()
            schemas: dict[int, int] = {}
            channels: dict[int, int] = {}
            for schema, channel, message in make_reader(source).iter_messages():
                if channel.id not in channels:
                    if schema is not None and schema.id not in schemas:
                        schemas[schema.id] = writer.register_schema(
                            schema.name, schema.encoding, schema.data
                        )
                    channels[channel.id] = writer.register_channel(
                        channel.topic,
                        channel.message_encoding,
                        schemas[schema.id] if schema is not None else 0,
                        channel.metadata,
                    )
                writer.add_message(
                    channels[channel.id],
                    message.log_time + later,
                    message.data,
                    message.publish_time + later,
                    message.sequence,
                )
            writer.finish()  # type: ignore[no-untyped-call]


def _finished(place: Path, runs: int) -> None:
    """Lay runs out that look finished, as the tests of the plan do."""
    sys.path.insert(0, str(ROOT / "tests"))
    vehicle = VehicleFolder(VEHICLE, f"raw/{VEHICLE}")
    execute(place)  # the bench first: what the runs are compared with
    season = import_module("season_cases")
    season.make_season(place, vehicle, runs)
    season.finish(place, vehicle)


def table(rows: list[Row]) -> str:
    """Return the figures as a table."""
    head = (
        "| runs | all: CPU s | a run: CPU s | one new: CPU s | stages | nothing to do: CPU s "
        "| wall s | largest process: MB |\n|---|---|---|---|---|---|---|---|\n"
    )
    return head + "".join(_cells(row) for row in rows)


def _cells(row: Row) -> str:
    first = "- | -"
    peak = max(row.one_new.peak_mb, row.nothing.peak_mb)
    if row.everything is not None:
        first = f"{row.everything.cpu_s:.0f} | {row.everything.cpu_s / row.runs:.2f}"
        peak = max(peak, row.everything.peak_mb)
    return (
        f"| {row.runs} | {first} | {row.one_new.cpu_s:.1f} | {row.one_new.stages} | "
        f"{row.nothing.cpu_s:.2f} | {row.nothing.wall_s:.1f} | {peak:.0f} |\n"
    )


def _line(row: Row) -> str:
    return _cells(row).strip()


def _known(path: Path | None) -> dict[int, Row]:
    if path is None or not path.is_file():
        return {}
    found = {}
    for one in json.loads(path.read_text(encoding="utf-8")):
        first = one["everything"]
        found[one["runs"]] = Row(
            one["runs"],
            None if first is None else Cost(**first),
            Cost(**one["one_new"]),
            Cost(**one["nothing"]),
        )
    return found


def _write(rows: list[Row]) -> None:
    _plot(rows)
    load = ", ".join(f"{one:.1f}" for one in os.getloadavg())
    memory = resource.getpagesize() * os.sysconf("SC_PHYS_PAGES") / 1e9
    said = (
        f"Python {sys.version.split()[0]}, {os.cpu_count()} cores, {memory:.0f} GB, "
        f"load average {load}.\n\n"
    )
    page.update(PAGE, page.BEGIN, page.END, said + table(rows).rstrip("\n"))


def _plot(rows: list[Row]) -> None:
    figure = Figure(figsize=(6.4, 3.6), layout="constrained")
    axes = figure.subplots()
    counts = [row.runs for row in rows]
    whole = [(row.runs, row.everything.cpu_s) for row in rows if row.everything is not None]
    axes.plot(*zip(*whole, strict=True), "o-", label="all runs")
    axes.plot(counts, [row.one_new.cpu_s for row in rows], "s-", label="one new run")
    axes.plot(counts, [row.nothing.cpu_s for row in rows], "^-", label="nothing to do")
    axes.set(xscale="log", yscale="log", xlabel="runs in raw/", ylabel="processor time [s]")
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend()
    PLOT.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(PLOT, metadata={"Date": None})


if __name__ == "__main__":
    main()
