"""A reference as it is written: what the sound runs show, and how well it predicts."""

from dataclasses import dataclass

from pipeline.diagnose.case import Case
from pipeline.diagnose.regression.directions import directions_of, stated_widths
from pipeline.diagnose.regression.grid import grid_period, on_grid
from pipeline.diagnose.regression.held_out import FileModel, Method, best_of, decides
from pipeline.diagnose.regression.ordinary import ordinary_of
from pipeline.diagnose.regression.response import Response
from pipeline.effects.effect import AXES
from pipeline.errors import CannotComputeError
from pipeline.records.reference import Prediction, Width


@dataclass(frozen=True)
class Made:
    """A reference and how good it is; as of `ReferenceRecord`."""

    used: bool
    why: str
    period_s: float
    noise_trusted: float
    force: dict[str, dict[str, float]]
    widths: tuple[Width, ...]
    predictions: tuple[Prediction, ...]


def made(case: Case, identified: FileModel | None = None) -> Made:
    """Learn from the healthy runs of a case and predict each by the others.

    Parameters
    ----------
    case : Case
        The vehicle and its healthy runs.
    identified : FileModel, optional
        The vehicle as it was identified.

    Raises
    ------
    CannotComputeError
        For runs without rates of turn or attitude, or of different channels.
    """
    sensors, directions = (
        case.vehicle.sensors,
        directions_of(case.vehicle, case.packed, case.candidates),
    )
    period = grid_period(case.healthy)
    runs = [on_grid(case.packed, run, sensors, directions, period) for run in case.healthy]
    if len({run.channels for run in runs}) > 1:
        raise CannotComputeError(
            "the sound runs have not the same channels: "
            + "; ".join(f"{run.name} {', '.join(run.channels)}" for run in runs)
            + ". Name runs that measured the same velocities and rates."
        )
    files: dict[Method, FileModel] = {"vehicle file": FileModel(case.packed)}
    if identified is not None:
        files["identified file"] = identified
    bent, table = best_of(runs, files)
    used, why = decides(table)
    response = Response(runs, bent)
    stated = stated_widths(case.vehicle, directions)
    ordinary = ordinary_of(response.told_of_sound(), directions, stated)
    force = response.force.reshape(-1, 6, len(response.channels)).sum(axis=0) / period
    return Made(
        used=used,
        why=why,
        period_s=period,
        noise_trusted=ordinary.share,
        force={
            name: {axis: float(force[a, c]) for a, axis in enumerate(AXES)}
            for c, name in enumerate(response.channels)
        },
        widths=tuple(
            Width(
                name=one.name,
                unit=one.parameter.unit,
                stated=float(stated[k] * one.unit_size),
                learned=float(ordinary.width[k] * one.unit_size),
            )
            for k, one in enumerate(directions)
        ),
        predictions=table,
    )
