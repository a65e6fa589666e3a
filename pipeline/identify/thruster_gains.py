"""Gains of thrusters from runs: rows for each run, pooled, against a reference, and what they show.

`gains_of` is the one call: tables of runs and a packed vehicle in, a record out. How a run is
regressed is in `thruster_regression`, how gains follow in `gain_estimates`, the tests in
`gain_findings`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pipeline.effects.effect import AXES
from pipeline.errors import CannotComputeError
from pipeline.identify.gain_estimates import (
    WIDEST,
    Doubt,
    Estimates,
    Pooled,
    axis_gains,
    joint_gains,
    moving,
    pool,
    typical,
)
from pipeline.identify.gain_tests import FALSE_ALARMS
from pipeline.identify.heading_check import HeadingCheck, heading_check
from pipeline.identify.thruster_regression import RunLikelihood, run_likelihood
from pipeline.records.gains import GainReference, GainRun, PooledGain, ThrusterGain, ThrusterGains
from pipeline.records.run_table import RunTable
from pipeline.simulate.applied_wrench import levers
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import BoolArray, FloatArray
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.sensor_schema import Sensors

#: Axis of a gain that all axes tell together.
ALL = "all"
_LEAST_DOUBT = 0.02
#: Fewer sound runs do not tell what runs differ by: at least so much is taken.
_MANY, _FEW_BETWEEN = 4, 0.1


@dataclass(frozen=True)
class RunGains:
    """Everything of one run: likelihood, gains by axis (axis -> (n,)), and on all axes."""

    likelihood: RunLikelihood
    by_axis: Mapping[str, Estimates]
    joint: Estimates
    heading: HeadingCheck | None


@dataclass(frozen=True)
class GainSet:
    """Runs of a vehicle that were regressed, and what is needed to compare them."""

    names: tuple[str, ...]
    levers: FloatArray
    doubt: Doubt
    runs: tuple[RunGains, ...]
    why_not: dict[str, str] = field(default_factory=dict)

    @property
    def moves(self) -> BoolArray:
        """Which thrusters move which axes (6, n)."""
        return moving(self.levers)


def regress_runs(
    packed: PackedVehicle,
    sensors: Sensors,
    runs: Sequence[RunTable],
    uncertainty: Uncertainty | None = None,
) -> GainSet:
    """Regress runs one by one; one that cannot be is left out with the reason.

    Parameters
    ----------
    packed : PackedVehicle
        The nominal model.
    sensors : Sensors
        Places of the sensors.
    runs : sequence of RunTable
        The runs.
    uncertainty : Uncertainty, optional
        Of the vehicle file: how far a sound thruster and an axis may be from it.
    """
    doubts = uncertainty or Uncertainty()
    thruster = max(doubts.thrust, _LEAST_DOUBT)
    doubt = Doubt(float(np.hypot(thruster, doubts.added_mass)), thruster)
    arms = levers(packed)
    found, why_not = [], {}
    for run in runs:
        try:
            told = run_likelihood(packed, sensors, run)
        except CannotComputeError as error:
            why_not[run.name] = str(error)
            continue
        size = typical(arms)
        by_axis = {one.name: axis_gains(one, arms) for one in told.axes if size[one.axis] > 0.0}
        joint = joint_gains(told, arms, doubt)
        heading = heading_check(packed, run, told.delay_s)
        found.append(RunGains(told, by_axis, joint, heading))
    return GainSet(packed.thruster_names, arms, doubt, tuple(found), why_not)


def gains_of(
    packed: PackedVehicle,
    sensors: Sensors,
    runs: Sequence[RunTable],
    *,
    uncertainty: Uncertainty | None = None,
    reference: Sequence[RunTable] = (),
    reference_name: str = "",
    vehicle_file_sha256: str = "",
) -> ThrusterGains:
    """Tell what each thruster gives on each axis in each run, against the file and a reference.

    Parameters
    ----------
    packed : PackedVehicle
        The nominal model: masses, damping, restoring and thrust curves of the vehicle file.
    sensors : Sensors
        Places of the sensors.
    runs : sequence of RunTable
        The runs that are asked.
    uncertainty : Uncertainty, optional
        Of the vehicle file.
    reference : sequence of RunTable
        Runs that are known to be sound; one of `runs` is judged by the others.
    reference_name : str
        How to call them ("24 May"); their names if empty.
    vehicle_file_sha256 : str
        To be kept in the record.

    Returns
    -------
    ThrusterGains
    """
    asked = regress_runs(packed, sensors, runs, uncertainty)
    done = {run.likelihood.run: run for run in asked.runs}
    more = [run for run in reference if run.name not in {one.name for one in runs}]
    other = regress_runs(packed, sensors, more, uncertainty)
    both = tuple(done[run.name] for run in reference if run.name in done)
    known = replace(other, runs=(*both, *other.runs))
    return gains_record(packed.name, asked, known, reference_name, vehicle_file_sha256)


def gains_record(
    vehicle: str,
    asked: GainSet,
    known: GainSet,
    reference_name: str = "",
    vehicle_file_sha256: str = "",
) -> ThrusterGains:
    """Make the record of runs that were regressed, and of sound ones (none: no reference)."""
    from pipeline.identify.gain_findings import findings_of

    sound = Sound(known, reference_name)
    rows = tuple(
        row for run in asked.runs for row in _rows(asked, run, sound.apart_from(run.likelihood.run))
    )
    told = {row.thruster for row in rows if row.judged and row.moves}
    return ThrusterGains(
        vehicle=vehicle,
        vehicle_file_sha256=vehicle_file_sha256,
        false_alarms=FALSE_ALARMS,
        reference=sound.called if known.runs else None,
        runs=tuple(_run_row(asked, run) for run in asked.runs),
        gains=rows,
        pooled=tuple(_pooled(asked, sound.apart_from(*(r.likelihood.run for r in asked.runs)))),
        findings=tuple(findings_of(asked, sound)),
        not_judged={name: _why(rows, name) for name in asked.names if name not in told},
        why_no_run={**asked.why_not, **known.why_not},
    )


References = Mapping[tuple[str, str], GainReference]


@dataclass(frozen=True)
class Sound:
    """Runs that are known to be sound, and what they gave."""

    known: GainSet
    name: str = ""

    @property
    def called(self) -> str:
        """How they are called: their names, where nobody gave them one."""
        return self.name or ", ".join(run.likelihood.run for run in self.known.runs)

    def apart_from(self, *runs: str) -> References:
        """Pool the gains of all but some runs: (thruster, axis) -> what they gave."""
        kept = tuple(run for run in self.known.runs if run.likelihood.run not in runs)
        rest = Sound(replace(self.known, runs=kept), self.name)
        return references(rest.known, rest.called) if kept else {}


def references(known: GainSet, name: str) -> dict[tuple[str, str], GainReference]:
    """Pool the gains of sound runs: (thruster, axis) -> what they gave."""
    least = max(known.doubt.thruster, 0.0 if len(known.runs) >= _MANY else _FEW_BETWEEN)
    return {
        key: GainReference(
            name=name,
            runs=runs,
            mean=found.mean,
            ci95=(found.mean - found.half_width, found.mean + found.half_width),
            between_runs=found.between,
        )
        for key, (found, runs) in pooled_gains(known, least).items()
    }


def pooled_gains(
    asked: GainSet, least_between: float = 0.0
) -> dict[tuple[str, str], tuple[Pooled, tuple[str, ...]]]:
    """Pool each gain over the runs that tell it: (thruster, axis) -> mean and the runs' names."""
    told: dict[tuple[str, str], list[tuple[float, float, str]]] = {}
    for run in asked.runs:
        for axis, estimates in {**run.by_axis, ALL: run.joint}.items():
            judged = _judged(run, estimates)
            for i in np.flatnonzero(judged):
                told.setdefault((asked.names[i], axis), []).append(
                    (float(estimates.value[i]), float(estimates.std[i]), run.likelihood.run)
                )
    return {
        key: (
            pool([v for v, _, _ in rows], [s for _, s, _ in rows], least_between),
            tuple(run for _, _, run in rows),
        )
        for key, rows in told.items()
    }


def _judged(run: RunGains, estimates: Estimates) -> BoolArray:
    return run.likelihood.excited & (estimates.half_width() < WIDEST)


def _rows(asked: GainSet, run: RunGains, sound: References) -> list[ThrusterGain]:
    found = []
    for axis, estimates in {ALL: run.joint, **run.by_axis}.items():
        judged, half = _judged(run, estimates), estimates.half_width()
        for i, name in enumerate(asked.names):
            moves = axis == ALL or bool(asked.moves[AXES.index(axis), i])
            value, width = float(estimates.value[i]), float(half[i])
            excited = bool(run.likelihood.excited[i])
            why = "" if judged[i] else "commanded together with others, or too little"
            found.append(
                ThrusterGain(
                    run=run.likelihood.run,
                    thruster=name,
                    axis=axis,
                    moves=moves,
                    value=value if excited else None,
                    ci95=(value - width, value + width) if excited else None,
                    judged=bool(judged[i]),
                    why_not=why if excited else "not commanded",
                    reference=against(
                        sound.get((name, axis)), value, float(estimates.std[i]), width
                    )
                    if judged[i] and moves
                    else None,
                )
            )
    return found


def against(
    sound: GainReference | None, value: float, std: float, half_width: float
) -> GainReference | None:
    """Compare a gain with its reference: the ratio, and the interval of it for a single run."""
    if sound is None:
        return None
    low, high = sound.ci95
    # Fieller would leave it open; where the reference itself may be nothing there is no ratio
    if low * high <= 0.0:
        return sound
    factor = half_width / std if std > 0.0 else 2.0
    own = (high - low) / 2.0 / factor
    ratio = value / sound.mean
    spread = (std**2 + ratio**2 * (own**2 + sound.between_runs**2)) ** 0.5 / abs(sound.mean)
    return sound.model_copy(
        update={"ratio": ratio, "ratio_ci95": (ratio - factor * spread, ratio + factor * spread)}
    )


def _pooled(asked: GainSet, sound: References) -> list[PooledGain]:
    found = []
    for (name, axis), (one, runs) in sorted(pooled_gains(asked).items()):
        moves = axis == ALL or bool(asked.moves[AXES.index(axis), asked.names.index(name)])
        found.append(
            PooledGain(
                thruster=name,
                axis=axis,
                moves=moves,
                value=one.mean,
                ci95=(one.mean - one.half_width, one.mean + one.half_width),
                between_runs=one.between,
                runs=runs,
                reference=against(sound.get((name, axis)), one.mean, one.std, one.half_width)
                if moves
                else None,
            )
        )
    return found


def against_day(
    pooled: Sequence[PooledGain], sound: Sequence[PooledGain], name: str
) -> tuple[PooledGain, ...]:
    """Compare pooled gains with those of sound runs of another day.

    Parameters
    ----------
    pooled, sound : sequence of PooledGain
        Of the day that is asked, and of the other.
    name : str
        What the other day is called.
    """
    known = {
        (one.thruster, one.axis): GainReference(
            name=name,
            runs=one.runs,
            mean=one.value,
            ci95=one.ci95,
            between_runs=one.between_runs,
        )
        for one in sound
    }
    found = []
    for one in pooled:
        half = (one.ci95[1] - one.ci95[0]) / 2.0
        mine = against(known.get((one.thruster, one.axis)), one.value, half / 2.0, half)
        found.append(one.model_copy(update={"reference": mine if one.moves else None}))
    return tuple(found)


def _run_row(asked: GainSet, run: RunGains) -> GainRun:
    told = run.likelihood
    return GainRun(
        run=told.run,
        delay_s=told.delay_s,
        thrust_std_n=dict(zip(asked.names, told.thrust_std.tolist(), strict=True)),
        why_not_axes=told.why_not,
        heading_correlation=None if run.heading is None else run.heading.correlation,
    )


def _why(rows: Sequence[ThrusterGain], name: str) -> str:
    own = [row for row in rows if row.thruster == name]
    if not own:
        return "no run could be taken"
    if all(row.value is None for row in own):
        return "not commanded in any of these runs"
    return "never commanded apart from others, or too little, in these runs"
