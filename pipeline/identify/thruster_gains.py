"""Gains of thrusters from runs: rows for each run, pooled, against a reference, and what they show.

`gains_of` is the one call: tables of runs and a packed vehicle in, a record out. How a run is
regressed is in `thruster_regression`, how gains follow and are pooled in `gain_estimates`, the
tests in `gain_findings`.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.identify.gain_estimates import (
    Doubt,
    GainSet,
    References,
    RunGains,
)
from pipeline.identify.gain_findings import findings_of
from pipeline.identify.gain_tests import FALSE_ALARMS
from pipeline.identify.heading_check import heading_check
from pipeline.identify.thruster_regression import run_likelihood
from pipeline.records.gains import GainReference, GainRun, PooledGain, ThrusterGain, ThrusterGains
from pipeline.records.run_table import RunTable
from pipeline.simulate.applied_wrench import levers
from pipeline.simulate.pack import PackedVehicle
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.sensor_schema import Sensors

_LEAST_DOUBT = 0.02


def _regressed(
    packed: PackedVehicle, sensors: Sensors, runs: Sequence[RunTable], doubts: Uncertainty
) -> GainSet:
    """Regress runs one by one; one that cannot be is left out with the reason."""
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
        heading = heading_check(packed, run, told.delay_s)
        found.append(RunGains.of(told, packed.thruster_names, arms, doubt, heading))
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

    `packed` is the nominal model: masses, damping, restoring and thrust curves of the vehicle file,
    which states their `uncertainty`. Runs of the `reference` are known to be sound, one of `runs`
    is judged by the others; `reference_name` is how to call them ("24 May"), by their names if
    empty. `vehicle_file_sha256` is kept in the record.
    """
    doubts = uncertainty or Uncertainty()
    asked = _regressed(packed, sensors, runs, doubts)
    done = {run.name: run for run in asked.runs}
    more = [run for run in reference if run.name not in {one.name for one in runs}]
    other = _regressed(packed, sensors, more, doubts)
    both = tuple(done[run.name] for run in reference if run.name in done)
    known = replace(other, runs=(*both, *other.runs), called=reference_name)
    rows = tuple(row for run in asked.runs for row in _rows(asked, run, known.apart_from(run.name)))
    told = {row.thruster for row in rows if row.judged and row.moves}
    return ThrusterGains(
        vehicle=packed.name,
        vehicle_file_sha256=vehicle_file_sha256,
        false_alarms=FALSE_ALARMS,
        reference=(reference_name or ", ".join(run.name for run in known.runs))
        if known.runs
        else None,
        runs=tuple(
            GainRun(
                run=run.name,
                delay_s=run.likelihood.delay_s,
                thrust_std_n=dict(
                    zip(asked.names, run.likelihood.thrust_std.tolist(), strict=True)
                ),
                why_not_axes=run.likelihood.why_not,
                heading_correlation=None if run.heading is None else run.heading.correlation,
            )
            for run in asked.runs
        ),
        gains=rows,
        pooled=tuple(_pooled(asked, known.apart_from(*done))),
        findings=tuple(findings_of(asked, known)),
        not_judged={name: _why(rows, name) for name in asked.names if name not in told},
        why_no_run={**asked.why_not, **known.why_not},
    )


def _rows(asked: GainSet, run: RunGains, sound: References) -> list[ThrusterGain]:
    excited = dict(zip(asked.names, run.likelihood.excited.tolist(), strict=True))
    found = []
    for (name, axis), own in run.gains.items():
        moves, judged = asked.moves(name, axis), (name, axis) in run.told
        why = "" if judged else "commanded together with others, or too little"
        known = sound.get((name, axis)) if judged and moves else None
        found.append(
            ThrusterGain(
                run=run.name,
                thruster=name,
                axis=axis,
                moves=moves,
                value=own.mean if excited[name] else None,
                ci95=own.ci95 if excited[name] else None,
                judged=judged,
                why_not=why if excited[name] else "not commanded",
                reference=against(known, own.mean, own.std, own.half_width),
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
    for (name, axis), one in sorted(asked.pooled().items(), key=lambda item: item[0]):
        moves = asked.moves(name, axis)
        known = sound.get((name, axis)) if moves else None
        found.append(
            PooledGain(
                thruster=name,
                axis=axis,
                moves=moves,
                value=one.mean,
                ci95=one.ci95,
                between_runs=one.between,
                runs=one.runs,
                reference=against(known, one.mean, one.std, one.half_width),
            )
        )
    return found


def against_day(
    pooled: Sequence[PooledGain], sound: Sequence[PooledGain], name: str
) -> tuple[PooledGain, ...]:
    """Compare pooled gains with those of `sound` runs of another day, called `name`."""
    there = {(one.thruster, one.axis): one for one in sound}
    found = []
    for one in pooled:
        half, mine = (one.ci95[1] - one.ci95[0]) / 2.0, None
        other = there.get((one.thruster, one.axis)) if one.moves else None
        if other is not None:
            runs, mean, ci95 = other.runs, other.value, other.ci95
            between = other.between_runs
            mine = GainReference(name=name, runs=runs, mean=mean, ci95=ci95, between_runs=between)
        reference = against(mine, one.value, half / 2.0, half)
        found.append(one.model_copy(update={"reference": reference}))
    return tuple(found)


def _why(rows: Sequence[ThrusterGain], name: str) -> str:
    own = [row for row in rows if row.thruster == name]
    if not own:
        return "no run could be taken"
    if all(row.value is None for row in own):
        return "not commanded in any of these runs"
    return "never commanded apart from others, or too little, in these runs"
