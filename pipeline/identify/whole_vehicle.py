"""The whole-vehicle fit: added mass, damping, buoyancy and righting moment from runs.

Windowed output error on the compiled kernel: `vehicle_fit` fits, `parameter_intervals` says how
well each parameter is known, `window_prediction` judges the fit, `identifiability` says what to fly
next.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipeline.identify.channel_noise import QUANTITIES, ChannelNoise
from pipeline.identify.corrected_file import (
    NOT_CORRECTED,
    as_filed,
    channels_worse,
    steps_of_file,
    worse_than_before,
)
from pipeline.identify.identifiability import best_manoeuvres, cannot_identify
from pipeline.identify.output_error import FitSolution
from pipeline.identify.standing import deduction_found, thrust_found
from pipeline.identify.vehicle_fit import VehicleFit, chained_windows, fit_for_file, fit_vehicle
from pipeline.identify.window_prediction import fit_black_box, prediction_quality
from pipeline.identify.windows import SMALLEST_SHARE, cut, readings_of
from pipeline.physics.parameters import read
from pipeline.records.identification import (
    ChannelNoiseFound,
    ChannelQuality,
    ThrustFound,
    VehicleIdentification,
)
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty
from pipeline.vehicle.sensor_schema import Sensors

#: Residuals beyond so many times the stated noise are more than a sensor that was misjudged.
MODEL_ERROR = 2.0
#: A thrust further from the stated one than this many of its stated widths is to be looked at.
FAR_OFF = 3.0


def identify_vehicle(
    packed: PackedVehicle,
    sensors: Sensors,
    runs: Sequence[RunTable],
    *,
    uncertainty: Uncertainty | None = None,
    only: Sequence[str] | None = None,
    holdout: Sequence[RunTable] = (),
    window_s: float | None = None,
    suggest: bool = True,
    threads: int = 2,
    most_steps: int | None = None,
    correct: bool = True,
) -> VehicleIdentification:
    """Identify a vehicle's model from runs; channels that are missing are done without.

    `packed` and `sensors` are as the vehicle file states them: nominal model, centre of the priors,
    noise. Its `uncertainty` widens the priors and says how far the thrust is trusted. `only` names
    the parameters to free. `holdout` runs judge the fit; without them every sixth window of `runs`
    is kept for that. Windows are `window_s` long [s]; 8 s, or 20 s without velocity and position.
    `suggest` computes which manoeuvre would identify what these runs do not, `correct` what a
    corrected vehicle file is to have. The fit ends where it stands after `most_steps` Gauss-Newton
    steps in all, of `threads` simulations at a time.

    Raises
    ------
    CannotComputeError
        If there is nothing to identify from, or the model cannot be simulated over the windows.
    """
    doubts = Uncertainty() if uncertainty is None else uncertainty
    fit = fit_vehicle(
        packed,
        sensors,
        runs,
        uncertainty=doubts,
        only=only,
        hold_out=not holdout,
        window_s=window_s,
        threads=threads,
        most_steps=most_steps,
    )
    solution = fit.solution
    windows, judged_by = list(fit.held_out), runs
    offsets: FloatArray | None = solution.problem.shared.offsets(solution.point.shared)
    if holdout:
        judged_by, offsets = _with_channels_of(fit, holdout), None
        windows = cut(packed, judged_by, fit.channels, fit.window_s)
        windows = chained_windows(solution.packed, solution.vector, windows)
    found = fit.found
    thrust = thrust_found(solution.problem.thrust, solution.point.steps, fit.posterior, fit.halves)
    code_max = np.abs(packed.code_limits).max(axis=1)
    black_box = fit_black_box(runs, solution.problem.stack.windows, code_max)

    def judged(corrected: FloatArray | None) -> tuple[ChannelQuality, ...]:
        models = {
            "identified": (solution.packed, solution.vector),
            "vehicle_file": (packed, packed.vector),
        }
        if corrected is not None:
            models["corrected_file"] = (packed, solution.problem.vector(corrected))
        return prediction_quality(
            models, windows, judged_by, fit.channels, black_box, offsets=offsets, threads=threads
        )

    filed = steps_of_file(solution, found, thrust) if correct else None
    quality = judged(filed)
    why_no_file = worse_than_before(quality) if correct else NOT_CORRECTED
    if correct and quality and why_no_file:
        # without the curves of the thrust what was found does not belong together
        filed = fit_for_file(fit).point.steps
        quality = judged(filed)
        why_no_file = worse_than_before(quality)
    found, thrust = as_filed(solution.problem, filed, found, thrust)
    gains = best_manoeuvres(packed, sensors, solution, found, threads) if suggest else None
    return VehicleIdentification(
        vehicle=packed.name,
        runs=tuple(run.name for run in runs),
        holdout=tuple(run.name for run in holdout),
        windows=len(solution.problem.stack.windows),
        holdout_windows=len(windows),
        window_s=fit.window_s,
        readings=int(solution.residual.size),
        iterations=fit.steps,
        converged=fit.settled,
        thrust_uncertainty=doubts.thrust,
        parameters=found,
        thrust=thrust,
        thrust_deduction=deduction_found(packed, solution, fit.posterior),
        why_no_file=why_no_file,
        cannot_identify=cannot_identify(found, gains),
        next_manoeuvres=gains or (),
        noise=_noise_found(solution),
        quality=quality,
        notes=(
            *_notes(packed, runs, fit),
            *_thrust_notes(packed, thrust),
            *(() if why_no_file else channels_worse(quality)),
        ),
    )


def _with_channels_of(fit: VehicleFit, runs: Sequence[RunTable]) -> list[RunTable]:
    """Leave out of the runs what the fit had no channel for: it knows no sensor for that."""
    unknown = set(QUANTITIES) - {channel.quantity for channel in fit.channels}
    return [
        replace(run, values={name: v for name, v in run.values.items() if name not in unknown})
        for run in runs
    ]


def _noise_found(solution: FitSolution) -> tuple[ChannelNoiseFound, ...]:
    stack = solution.problem.stack
    return tuple(
        ChannelNoiseFound(
            channel=rows.channel.quantity,
            unit=rows.channel.unit,
            stated_noise=rows.channel.white,
            scale=stack.scale.get(rows.channel.quantity, 1.0),
            residual_over_noise=float(
                np.sqrt(np.mean(solution.residual[stack.owner == number] ** 2))
            ),
        )
        for number, rows in enumerate(stack.rows)
    )


def _notes(packed: PackedVehicle, runs: Sequence[RunTable], fit: VehicleFit) -> tuple[str, ...]:
    notes = [
        (
            "Thrust is as uncertain as the vehicle file states: a factor for each thruster and the "
            "shape of the curves are fitted beside the parameters and integrated out of their "
            "intervals. A corrected vehicle file has the factors, and the curves as they were."
        ),
        (
            "Added mass and dry mass act as one sum: the dry mass of the vehicle file is taken as "
            f"exact ({float(read(packed.vector, 'mass')):g} kg)."
        ),
    ]
    measured = {c.quantity for c in fit.channels}
    if "velocity" not in measured and "position" not in measured:
        notes.append(
            "No velocity and no position was measured: speed shows only in acceleration, attitude "
            "and depth, and each window begins at the speed that the model had at its end before."
        )
    used = {rows.channel.quantity for rows in fit.solution.problem.stack.rows}
    unused = [
        f"{one.quantity} ({_rate_hz(runs, one):.2g} Hz in these runs, {one.rate_hz:g} Hz expected)"
        for one in fit.channels
        if one.quantity not in used
    ]
    if unused:
        notes.append(
            f"Measured, but not used: {', '.join(unused)}. A window goes without a channel that "
            f"has less than {100 * SMALLEST_SHARE:.0f} % of the readings that its rate promises: "
            "state the sensor's true rate_hz under sensors: in vehicle.yaml, or see on the page of "
            "the run when the sensor lost them."
        )
    assumed = [c.quantity for c in fit.channels if not c.stated]
    if assumed:
        notes.append(
            "The vehicle file states no noise for " + ", ".join(assumed) + ": taken from the "
            "residuals."
        )
    poor = [
        rows.channel.quantity
        for rows in fit.solution.problem.stack.rows
        if fit.solution.problem.stack.scale.get(rows.channel.quantity, 1.0) > MODEL_ERROR
    ]
    if poor:
        notes.append(
            f"Residuals of {', '.join(poor)} are more than {MODEL_ERROR:g} times the stated noise: "
            "the model lacks something (or the sensor is worse than stated). The intervals hold "
            "for a model that is right; diagnose the runs before using these values."
        )
    if fit.out_of_steps:
        notes.append(
            f"The fit was stopped after {fit.steps} steps, before it had settled. Take other runs, "
            "or let it go on as long as it needs with `rig2sea identify`."
        )
    if not fit.settled:
        notes.append("The fit did not settle: do not use these values.")
    short = [run.name for run in runs if run.time_s.size and run.time_s[-1] < fit.window_s]
    if short:
        notes.append(f"Shorter than one window and used in part: {', '.join(short)}.")
    return tuple(notes)


def _rate_hz(runs: Sequence[RunTable], channel: ChannelNoise) -> float:
    """Count the readings a second of the runs that have a channel at all."""
    own = [run for run in runs if channel.quantity in run.values]
    count = sum(readings_of(run, channel.quantity, np.inf).size for run in own)
    return count / max(sum(float(run.time_s[-1] - run.time_s[0]) for run in own), 1e-9)


def _thrust_notes(packed: PackedVehicle, thrust: Sequence[ThrustFound]) -> tuple[str, ...]:
    """Name the thrusters, and the curves, whose thrust is far from what the file states."""
    notes = [
        (
            f"{one.name.removeprefix('thrust_')} gives {one.value:.2f} ({one.ci95[0]:.2f} to "
            f"{one.ci95[1]:.2f}) of the stated thrust, {one.widths:.1f} times its stated "
            "uncertainty off. Look at that thruster, its propeller and its commands; if it is as "
            "it should be, its thrust in the vehicle file is not."
        )
        for one in thrust
        if one.unit == "1" and one.widths > FAR_OFF
    ]
    curves = [one for one in thrust if one.unit == "N" and one.widths > FAR_OFF]
    if curves:
        worst = max(curves, key=lambda one: one.widths)
        notes.append(
            f"The curve of thrust against command is of another shape than stated: {worst.name} is "
            f"off by {worst.value:+.3g} N, {worst.widths:.1f} times what the stated uncertainty of "
            "the thrust allows. Give the characteristic in vehicle.yaml another exponent or dead "
            "zone, or a bollard-pull test of its own, and identify again."
        )
    if len(notes) > 1 and len(notes) >= len(packed.thruster_names):
        notes.append(
            "All thrusters are off: the supply, a gain between pilot and thrusters, or the "
            "characteristic of the drive is not what the file states."
        )
    return tuple(notes)
