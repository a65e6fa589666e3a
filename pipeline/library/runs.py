"""Pool runs: read, simulated, identified and diagnosed, as frames."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.actions.diagnosis import DiagnosisRequest, diagnose_to_files
from pipeline.actions.identification import IdentificationRequest
from pipeline.actions.identification import identify_runs as identified_files
from pipeline.actions.simulation import simulate_to_file
from pipeline.actions.simulation_request import SimulationRequest
from pipeline.inputs.runs_to_identify import find_logs
from pipeline.inputs.runs_to_identify import read_run as read_run_table
from pipeline.inputs.simulated_vehicle import load_simulated
from pipeline.library.bench import frame_of, told
from pipeline.plan import UsageError


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
        ``depth_m``: body axes and NED, as `docs/pool_runs.md` describes the channels.

    Raises
    ------
    UsageError
        For a vehicle or run that does not exist.
    InputError, CannotComputeError
        For a log, or a vehicle, that cannot be used.
    """
    one = load_simulated(_name(vehicle), Path(raw), Path(out))
    (log,) = find_logs((str(run),), one)
    read, table = read_run_table(log, one, Path(raw))
    return told(frame_of(table), read, read.warnings)


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
    with tempfile.TemporaryDirectory(prefix="rig2sea-", ignore_cleanup_errors=True) as folder:
        log = Path(folder) / f"{manoeuvre}.mcap" if to is None else Path(to)
        result = simulate_to_file(
            SimulationRequest(
                _name(vehicle),
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
    return told(frame, result.summary, result.warnings)


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
    vehicle, raw, out : str or Path
        As of `read_run`.
    runs, holdout : sequence of str or Path
        Runs to fit, and runs to judge the fit by.

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
    with tempfile.TemporaryDirectory(prefix="rig2sea-", ignore_cleanup_errors=True) as folder:
        record = identified_files(
            IdentificationRequest(
                _name(vehicle),
                _texts(runs),
                _texts(holdout),
                to=Path(folder),
                raw=Path(raw),
                out=Path(out),
            )
        ).record
    whole = record.whole_vehicle
    rows = [
        (one.name, one.unit, one.meaning, one.value, *one.ci95, one.stands, one.reason)
        for one in (() if whole is None else whole.parameters)
    ]
    columns = ["name", "unit", "meaning", "value", "ci95_low", "ci95_high", "stands", "reason"]
    return told(pd.DataFrame(rows, columns=columns).set_index("name"), record, record.warnings)


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
    vehicle, raw, out : str or Path
        As of `read_run`.
    runs, holdout, healthy : sequence of str or Path
        Runs that are asked of, runs that judge the answer, and runs known to be sound.

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
    with tempfile.TemporaryDirectory(prefix="rig2sea-", ignore_cleanup_errors=True) as folder:
        record = diagnose_to_files(
            DiagnosisRequest(
                _name(vehicle),
                _texts(runs),
                _texts(holdout),
                _texts(healthy),
                to=Path(folder),
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
    frame = told(pd.DataFrame(rows), record, record.notes)
    frame.attrs["sentence"] = record.verdict.sentence
    return frame


def _texts(runs: Sequence[str | Path]) -> tuple[str, ...]:
    return tuple(str(run) for run in runs)


def _name(vehicle: object) -> str:
    if not isinstance(vehicle, str | Path):
        raise UsageError(
            "a vehicle is given by its name or folder here, as what was computed of it lies there: "
            'for example read_run(log, "rov8").'
        )
    return str(vehicle)
