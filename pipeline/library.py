"""What a notebook wants of rig2sea: files and results as pandas frames, units in the column names.

Everything here is also a command of `rig2sea`; the frames hold what its files hold. The record that
a frame was made from is in ``frame.attrs["record"]``, warnings in ``frame.attrs["warnings"]``.
Errors are those of the commands: `pipeline.errors.InputError` for a file that cannot be used,
`pipeline.errors.CannotComputeError` for data that tell nothing.

    >>> import pipeline
    >>> vehicle = pipeline.load_vehicle("rov8")
    >>> len(vehicle.thrusters)
    8
"""

import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Literal

import pandas as pd

from pipeline.errors import InputError, Place
from pipeline.ingest.load_test import read_load_tests
from pipeline.ingest.mooring import read_mooring_tables
from pipeline.ingest.open_water import read_open_water
from pipeline.plan import RAW_KINDS, processed_file
from pipeline.provenance import read_tables
from pipeline.records.measurements import LoadTestRecord, MooringRecord, OpenWaterRecord
from pipeline.records.run_table import QUANTITIES, RunTable
from pipeline.stages.diagnosis import DiagnosisRequest, diagnose_to_files
from pipeline.stages.identification import IdentificationRequest
from pipeline.stages.identification import identify_runs as identified_files
from pipeline.stages.runs_to_identify import find_logs
from pipeline.stages.runs_to_identify import read_run as read_run_table
from pipeline.stages.simulated_vehicle import load_simulated
from pipeline.stages.simulation import simulate_to_file
from pipeline.stages.simulation_request import SimulationRequest
from pipeline.stages.vehicle_place import find_vehicle
from pipeline.vehicle.load import load_vehicle as read_vehicle_file
from pipeline.vehicle.schema import Vehicle

Kind = Literal["load_test", "mooring", "open_water"]
BenchRecord = LoadTestRecord | MooringRecord | OpenWaterRecord
_READERS: dict[str, Callable[[Sequence[Path], Vehicle, Path], BenchRecord]] = {
    "load_test": read_load_tests,
    "mooring": read_mooring_tables,
    "open_water": read_open_water,
}
#: Quantity -> columns of its frame; those of the commands are named after the thrusters.
_COLUMNS = {
    "angular_velocity": ("p_radps", "q_radps", "r_radps"),
    "specific_force": ("specific_force_x_mps2", "specific_force_y_mps2", "specific_force_z_mps2"),
    "attitude": ("attitude_w", "attitude_x", "attitude_y", "attitude_z"),
    "velocity": ("u_mps", "v_mps", "w_mps"),
    "depth": ("depth_m",),
    "position": ("north_m", "east_m", "down_m"),
    "voltage": ("voltage_v",),
    "current": ("current_a",),
}
_OF_THRUSTERS = {"command": "code", "shaft_speed": "rpm"}
_TABLES = ("table1", "table2", "table3", "table4")


def load_vehicle(vehicle: str | Path, raw: str | Path = "raw") -> Vehicle:
    """Read a vehicle file.

    Parameters
    ----------
    vehicle : str or Path
        A name under `raw`, a folder that holds ``vehicle.yaml``, or the name of a bundled vehicle.
    raw : str or Path
        The folder of the vehicles' raw data.

    Returns
    -------
    Vehicle
        Checked; SI units, angles as the file states them.

    Raises
    ------
    UsageError
        When there is no such vehicle.
    InputError
        When its file cannot be read.
    """
    return read_vehicle_file(find_vehicle(str(vehicle), Path(raw), Path())[1])


def read_bench(path: str | Path, vehicle: Vehicle, kind: Kind | None = None) -> pd.DataFrame:
    """Read one bench file: load test, mooring (bollard) test or open-water test.

    Parameters
    ----------
    path : str or Path
        The file.
    vehicle : Vehicle
        Whose drive, code range and ``columns:`` hold.
    kind : {"load_test", "mooring", "open_water"}, optional
        What was tested; that of the file's folder when it is not given.

    Returns
    -------
    DataFrame
        A row for each point: codes, ``thrust_n``, ``torque_nm``, ``shaft_speed_rpm`` and so on,
        ``file``, ``sheet``, ``row`` and ``marks`` (why a point takes no part in a fit).

    Raises
    ------
    InputError
        When the file gives no point at all; the text says why.
    """
    path = Path(path)
    chosen = path.absolute().parent.name if kind is None else kind
    if chosen not in _READERS:
        raise InputError.at(
            Place(str(path)),
            f'the folder "{chosen}" does not tell what was tested.',
            expected=f"a file in a folder {', '.join(RAW_KINDS)}, or kind= one of these.",
            remedy='Say which, e.g. read_bench(path, vehicle, kind="mooring").',
        )
    record = _READERS[chosen]([path], vehicle, path.absolute().parent)
    if not record.points:
        errors = [one for one in record.problems if one.severity == "error"]
        if errors:
            raise InputError(errors[0])
        raise InputError.at(
            Place(str(path)), "no point was read.", remedy="See what `rig2sea check` says of it."
        )
    rows = []
    for point in record.points:
        row = point.model_dump()
        source = row.pop("source")
        rows.append({**row, **source, "marks": ", ".join(point.marks)})
    frame = pd.DataFrame(rows).dropna(axis="columns", how="all")
    return _told(frame, record, [str(problem) for problem in record.problems])


def read_run(
    run: str | Path, vehicle: str | Path, raw: str | Path = "raw", out: str | Path = "."
) -> pd.DataFrame:
    """Read a pool run: every channel on one time base, what cannot be trusted left empty.

    Parameters
    ----------
    run : str or Path
        A name under the vehicle's ``pool/``, or a log.
    vehicle : str or Path
        As of `load_vehicle`.
    raw, out : str or Path
        The raw folder, and the folder that holds ``processed/``.

    Returns
    -------
    DataFrame
        Index ``time_s``; columns such as ``command_upper_code``, ``u_mps``, ``r_radps``,
        ``depth_m``: body axes and NED, as `docs/formats_pool.md` describes the channels.

    Raises
    ------
    UsageError
        For a vehicle or run that does not exist.
    InputError, CannotComputeError
        For a log, or a vehicle, that cannot be used.
    """
    one = load_simulated(str(vehicle), Path(raw), Path(out))
    (log,) = find_logs((str(run),), one)
    read, table = read_run_table(log, one, Path(raw))
    return _told(_frame(table), read, read.warnings)


def thruster_tables(vehicle: str, out: str | Path = ".") -> dict[str, pd.DataFrame]:
    """Return Tables 1 to 4 of a vehicle that `rig2sea run` has computed.

    Parameters
    ----------
    vehicle : str
        Its name.
    out : str or Path
        The folder that holds ``processed/``.

    Returns
    -------
    dict of str to DataFrame
        ``table1`` (K_T, K_M over powers of J), ``table2`` (thrust over code, a row for each speed),
        ``table3`` (code over thrust at rest, a column for each sign), ``table4`` (code over thrust,
        a row for each speed). A table that the bench data did not give is absent.

    Raises
    ------
    InputError
        When ``tables.json`` is absent, half-written or edited.
    """
    body = read_tables(Path(out) / processed_file(vehicle, "tables"))
    found = {}
    for name in _TABLES:
        columns = {
            key: values
            for key, values in (body.get(name) or {}).items()
            if isinstance(values, list) and values and not isinstance(values[0], list)
        }
        if columns:
            found[name] = pd.DataFrame({key: pd.Series(values) for key, values in columns.items()})
    return found


def simulate_manoeuvre(
    vehicle: str | Path,
    manoeuvre: str,
    effects: Sequence[str] = (),
    *,
    duration_s: float | None = None,
    seed: int = 0,
    to: str | Path | None = None,
    raw: str | Path = "raw",
    out: str | Path = ".",
) -> pd.DataFrame:
    """Fly a manoeuvre in simulation and return what the vehicle's sensors would show.

    Parameters
    ----------
    vehicle : str or Path
        As of `load_vehicle`.
    manoeuvre : str
        A name that ``rig2sea simulate --list`` shows.
    effects : sequence of str
        ``ID:key=value``, as of ``rig2sea simulate --effect``.
    duration_s : float, optional
        Length [s]; the manoeuvre's own when it is not given.
    seed : int
        Of the sensors' noise.
    to : str or Path, optional
        Where the log is to lie, ``*.mcap``; it is not kept when none is given.
    raw, out : str or Path
        The raw folder, and the folder that holds ``processed/``.

    Returns
    -------
    DataFrame
        As of `read_run`.

    Raises
    ------
    UsageError
        For a vehicle, manoeuvre or effect that does not exist.
    InputError, CannotComputeError
        For a vehicle that cannot be simulated.
    """
    with _folder() as folder:
        log = folder / f"{manoeuvre}.mcap" if to is None else Path(to)
        result = simulate_to_file(
            SimulationRequest(
                str(vehicle),
                log,
                manoeuvre=manoeuvre,
                effects=tuple(effects),
                duration_s=duration_s,
                seed=seed,
                raw=Path(raw),
                out=Path(out),
            )
        )
        frame = read_run(log, vehicle, raw, out)
    return _told(frame, result.summary, result.warnings)


def identify_runs(
    vehicle: str | Path,
    runs: Sequence[str | Path],
    *,
    holdout: Sequence[str | Path] = (),
    raw: str | Path = "raw",
    out: str | Path = ".",
) -> pd.DataFrame:
    """Identify added masses, damping and what else the runs can support.

    Parameters
    ----------
    vehicle : str or Path
        As of `load_vehicle`.
    runs, holdout : sequence of str or Path
        Runs to fit, and runs to judge the fit by.
    raw, out : str or Path
        The raw folder, and the folder that holds ``processed/``.

    Returns
    -------
    DataFrame
        Index ``name``; ``unit``, ``meaning``, ``value``, ``ci95_low``, ``ci95_high``, ``stands``
        and ``reason`` of each parameter. Nothing is written.

    Raises
    ------
    UsageError
        For a vehicle or run that does not exist.
    InputError, CannotComputeError
        For a log that cannot be used, or runs that tell nothing.
    """
    with _folder() as folder:
        record = identified_files(
            IdentificationRequest(
                str(vehicle), _texts(runs), _texts(holdout), to=folder, raw=Path(raw), out=Path(out)
            )
        ).record
    whole = record.whole_vehicle
    rows = [
        {
            "name": one.name,
            "unit": one.unit,
            "meaning": one.meaning,
            "value": one.value,
            "ci95_low": one.ci95[0],
            "ci95_high": one.ci95[1],
            "stands": one.stands,
            "reason": one.reason,
        }
        for one in (() if whole is None else whole.parameters)
    ]
    columns = ["name", "unit", "meaning", "value", "ci95_low", "ci95_high", "stands", "reason"]
    return _told(pd.DataFrame(rows, columns=columns).set_index("name"), record, record.warnings)


def diagnose_runs(
    vehicle: str | Path,
    runs: Sequence[str | Path],
    *,
    holdout: Sequence[str | Path] = (),
    healthy: Sequence[str | Path] = (),
    raw: str | Path = "raw",
    out: str | Path = ".",
) -> pd.DataFrame:
    """Find which unmodelled effect makes simulation and runs disagree.

    Parameters
    ----------
    vehicle : str or Path
        As of `load_vehicle`.
    runs, holdout, healthy : sequence of str or Path
        Runs that are asked of, runs that judge the answer, and runs known to be sound.
    raw, out : str or Path
        The raw folder, and the folder that holds ``processed/``.

    Returns
    -------
    DataFrame
        A row for each answer, the most probable first: ``effect``, ``thruster``, ``probability``,
        ``gap_closed`` and, where it has one parameter, ``value``, ``unit``, ``ci95_low`` and
        ``ci95_high``. The sentence is in ``attrs["sentence"]``. Nothing is written.

    Raises
    ------
    UsageError
        For a vehicle or run that does not exist.
    InputError, CannotComputeError
        For a log that cannot be used, or data from which no diagnosis can be made.
    """
    with _folder() as folder:
        record = diagnose_to_files(
            DiagnosisRequest(
                str(vehicle),
                _texts(runs),
                _texts(holdout),
                _texts(healthy),
                to=folder,
                raw=Path(raw),
                out=Path(out),
            )
        ).record
    rows = []
    for one in record.ranking:
        row: dict[str, Any] = {
            "effect": one.effect,
            "thruster": one.thruster,
            "probability": one.probability,
            "gap_closed": one.gap_closed,
        }
        if len(one.parameters) == 1:
            (only,) = one.parameters.values()
            low, high = only.ci95
            row |= {"value": only.value, "unit": only.unit, "ci95_low": low, "ci95_high": high}
        rows.append(row)
    frame = _told(pd.DataFrame(rows), record, record.notes)
    frame.attrs["sentence"] = record.verdict.sentence
    return frame


def _frame(run: RunTable) -> pd.DataFrame:
    """Put a run's channels side by side; readings that are not valid are left empty."""
    columns: dict[str, Any] = {}
    for quantity in QUANTITIES:
        if quantity not in run.valid:
            continue
        values, valid = run.values[quantity], run.valid[quantity]  # noqa: PD011 - no pandas object
        names: Sequence[str] = _COLUMNS.get(quantity, ())
        if quantity in _OF_THRUSTERS:
            names = [f"{quantity}_{one}_{_OF_THRUSTERS[quantity]}" for one in run.thrusters]
        for name, column in zip(names, values.T, strict=True):
            columns[name] = pd.Series(column).where(pd.Series(valid))
    frame = pd.DataFrame(columns)
    frame.index = pd.Index(run.time_s, name="time_s")
    return frame


def _told(frame: pd.DataFrame, record: object, warnings: Sequence[str]) -> pd.DataFrame:
    """Keep what a frame was made from, and what was said of it, beside it."""
    frame.attrs["record"] = record
    frame.attrs["warnings"] = tuple(warnings)
    return frame


def _texts(runs: Sequence[str | Path]) -> tuple[str, ...]:
    return tuple(str(run) for run in runs)


@contextmanager
def _folder() -> Iterator[Path]:
    """Give a folder for files that nobody keeps."""
    folder = Path(tempfile.mkdtemp(prefix="rig2sea-"))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
