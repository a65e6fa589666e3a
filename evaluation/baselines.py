"""``python -m evaluation.baselines DIR``: two plain methods beside a campaign of `rig2sea blind`.

The cases of the campaign are made again; the answers lie beside its own in ``baselines.jsonl``,
from where `evaluation.write_campaign` takes them.

*Least squares and BIC*: every other ten seconds of the runs are simulated from the measured state;
each effect is fitted to the raw differences by one Gauss-Newton step, and the Bayesian information
criterion n log(RSS / n) + k log n ranks them, every sample counted as independent.

*Sparse regression*: the differences of measured and modelled acceleration are regressed on what
each effect would add to it; effects are picked greedily (orthogonal matching pursuit) and the first
one is the answer, if the criterion allows it at all.

Neither knows of noise that has a colour, of errors of the stated parameters, of healthy runs or of
`unknown`.
"""

import argparse
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from pipeline.blind.cases import case_of
from pipeline.blind.generate import generate
from pipeline.campaign.blind_case import packed_of, subjects_of
from pipeline.campaign.campaign import CASES_FILE, HEADER_FILE, appending, read_lines
from pipeline.effects.effect import Effect
from pipeline.effects.library import apply_effects, candidates
from pipeline.effects.specification import EffectSpec
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.records.run_table import RunTable
from pipeline.simulate.applied_wrench import actuator_states
from pipeline.simulate.kernel import BODY, STATE
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import run
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

ANSWERS_FILE = "baselines.jsonl"
WINDOW_S = 10.0
#: Share of the plausible range by which a parameter is moved for its slope.
_MOVED = 0.1
#: Seconds between samples of the regression, and over which its accelerations are averaged.
_SAMPLE_S, _SMOOTH_S = 1.0, 0.3
_SLOWEST = 1e-12


@dataclass(frozen=True)
class _Measured:
    """A run as the baselines take it, at one period: states of the body origin.

    `state` (m, 13): place, quaternion, velocity and rates; `velocity` (m, 3) of the DVL's place;
    `known` (m,) where all of it was measured.
    """

    period_s: float
    state: FloatArray
    velocity: FloatArray
    force: FloatArray
    command: FloatArray
    known: FloatArray


def bic_baseline(vehicle: Vehicle, packed: PackedVehicle, runs: Sequence[RunTable]) -> str:
    """Name the effect that least squares and BIC put first, or ``none``.

    ``refused`` where the runs have no attitude, rates and velocity.
    """
    measured = [one for one in (_measured(vehicle, table) for table in runs) if one is not None]
    if not measured:
        return "refused"

    def differences(vector: FloatArray) -> FloatArray:
        return np.concatenate(
            [_window_differences(vehicle, packed, one, vector) for one in measured]
        )

    return _first(packed, differences, differences(packed.vector), 1.0)


def sparse_baseline(vehicle: Vehicle, packed: PackedVehicle, runs: Sequence[RunTable]) -> str:
    """Name the effect that a sparse regression of accelerations picks first, or ``none``.

    Parameters and answers as `bic_baseline`.
    """
    measured = [one for one in (_measured(vehicle, table) for table in runs) if one is not None]
    if not measured:
        return "refused"
    seen = np.concatenate([_measured_accelerations(vehicle, one) for one in measured])

    def differences(vector: FloatArray) -> FloatArray:
        modelled = [_modelled_accelerations(packed, one, vector) for one in measured]
        return (seen - np.concatenate(modelled)).ravel()

    plain = differences(packed.vector)
    scale = np.maximum(np.std(plain.reshape(-1, 6), axis=0), _SLOWEST) if plain.size else np.ones(6)
    return _first(packed, differences, plain, np.tile(1.0 / scale, len(plain) // 6))


def _first(
    packed: PackedVehicle,
    differences: Callable[[FloatArray], FloatArray],
    plain: FloatArray,
    weight: FloatArray | float,
) -> str:
    """Name the effect that takes most off the weighted differences, by the criterion."""
    if not plain.size:  # no window is as long as it takes
        return "refused"
    best, least = "none", _bic(plain * weight, 0)
    for name, target, effect in _all_targets(packed):
        columns = (_columns(packed, effect, target, differences, plain).T * weight).T
        if columns.shape[1] == 0:
            continue
        left = plain * weight - columns @ np.linalg.lstsq(columns, plain * weight, rcond=1e-9)[0]
        value = _bic(left, columns.shape[1])
        if value < least:
            best, least = name, value
    return best


def _bic(left: FloatArray, parameters: int) -> float:
    count = left.size
    return float(
        count * np.log(max(float(left @ left), _SLOWEST) / count) + parameters * np.log(count)
    )


def _all_targets(packed: PackedVehicle) -> list[tuple[str, str | None, Effect]]:
    """Every effect that the vehicle can have, with every thruster where it is of one."""
    out: list[tuple[str, str | None, Effect]] = []
    for name, effect in candidates(packed.context).items():
        if effect.scope == "thruster":
            out += [(name, thruster, effect) for thruster in packed.thruster_names]
        else:
            out.append((name, None, effect))
    return out


def _columns(
    packed: PackedVehicle,
    effect: Effect,
    target: str | None,
    differences: Callable[[FloatArray], FloatArray],
    plain: FloatArray,
) -> FloatArray:
    """Return what a step of each parameter takes off the differences (samples, parameters)."""
    columns = []
    neutral = effect.neutral_values()
    for parameter in effect.parameters:
        step = _MOVED * (parameter.plausible[1] - parameter.plausible[0])
        if parameter.neutral + step > parameter.possible[1]:
            step = -step
        values = dict(neutral)
        if effect.id == "payload" and parameter.name in ("x_m", "y_m", "z_m"):
            # without mass a place has no meaning
            values["mass_kg"] = _MOVED * 20.0
        values[parameter.name] = parameter.neutral + step
        try:
            vector = apply_effects(
                packed.vector, [EffectSpec(effect.id, values, target)], packed.context
            )
            column = (plain - differences(vector)) / step
        except CannotComputeError:
            continue
        if np.isfinite(column).all() and column.any():
            columns.append(column / np.linalg.norm(column))
    return np.stack(columns, axis=1) if columns else np.zeros((plain.size, 0))


def _measured(vehicle: Vehicle, table: RunTable) -> _Measured | None:
    """Bring a run's channels to states of the body origin; None where one is missing."""
    sensors = vehicle.sensors
    wanted = ("attitude", "angular_velocity", "specific_force", "velocity")
    if sensors is None or sensors.dvl is None or any(name not in table.values for name in wanted):
        return None
    count = len(table.time_s)
    known = np.ones(count, np.bool_)
    for name in wanted:
        known &= table.valid[name]
    state = np.zeros((count, 13))
    state[:, 3:7] = table.values["attitude"]
    rate, velocity = table.values["angular_velocity"], table.values["velocity"]
    state[:, 10:13] = rate
    state[:, 7:10] = velocity - np.cross(rate, np.array(sensors.dvl.position_m))
    if "depth" in table.values:
        known &= table.valid["depth"]
        state[:, 2] = table.values["depth"][:, 0]
    if "position" in table.values:
        good = table.valid["position"]
        if good.any():
            for k in range(2):
                column = table.values["position"][good, k]
                state[:, k] = np.interp(table.time_s, table.time_s[good], column)
    command = np.where(table.valid["command"][:, None], table.values["command"], 0.0)
    return _Measured(
        float(table.time_s[1] - table.time_s[0]),
        state,
        velocity,
        table.values["specific_force"],
        command,
        known.astype(float),
    )


def _kernel_states(
    packed: PackedVehicle, one: _Measured, vector: FloatArray, rows: FloatArray
) -> FloatArray:
    """Kernel states of chosen samples (k, STATE), drives as the commands so far have left them."""
    drives = actuator_states(packed, one.command, one.period_s, vector=vector)
    out = np.zeros((len(rows), STATE))
    index = rows.astype(int)
    out[:, :BODY] = one.state[index]
    out[:, BODY : BODY + drives.shape[1]] = drives[index]
    return out


def _window_differences(
    vehicle: Vehicle, packed: PackedVehicle, one: _Measured, vector: FloatArray
) -> FloatArray:
    """Measured less simulated readings in windows, over the noise of each, as one vector."""
    sensors = vehicle.sensors
    if sensors is None or sensors.dvl is None or sensors.imu is None:
        return np.zeros(0)
    length = round(WINDOW_S / one.period_s)
    begins = np.array(
        [
            first
            for first in range(0, len(one.state) - length, 2 * length)
            if one.known[first : first + length + 1].all()
        ],
        float,
    )
    starts = _kernel_states(packed, one, vector, begins)
    depth_noise = sensors.depth.noise_m if sensors.depth is not None else 1.0
    noise = np.array(
        [sensors.dvl.noise_mps] * 3
        + [max(sensors.imu.rate_noise_radps, 1e-5)] * 3
        + [np.hypot(sensors.imu.attitude_noise_rad, sensors.imu.attitude_wander_rad) + 1e-5] * 3
        + [depth_noise]
    )
    place = np.array(sensors.dvl.position_m) + read(vector, "dvl_lever_arm")
    wrong = Rotation.from_euler("ZYX", read(vector, "dvl_rotation")[::-1])
    late = float(read(vector, "dvl_delay")) / one.period_s
    rows = np.arange(0, length, 10)
    parts = []
    for first, start in zip(begins.astype(int), starts, strict=True):
        flown = run(
            packed,
            one.command[first : first + length],
            dt_s=one.period_s,
            vector=vector,
            start=start,
        )
        moved = flown.nu[:, :3] + np.cross(flown.nu[:, 3:], place)
        moved = float(read(vector, "dvl_scale")) * wrong.inv().apply(moved)
        if late:
            shown = np.clip(np.arange(len(moved)) - late, 0, len(moved) - 1)
            grid = np.arange(len(moved))
            moved = np.stack([np.interp(shown, grid, column) for column in moved.T], axis=1)
        seen = one.state[first : first + length]
        turn = Rotation.from_quat(seen[rows][:, [4, 5, 6, 3]]).inv() * Rotation.from_quat(
            flown.quaternion[rows][:, [1, 2, 3, 0]]
        )
        parts.append(
            np.concatenate(
                [
                    one.velocity[first : first + length][rows] - moved[rows],
                    seen[rows, 10:13] - flown.nu[rows, 3:],
                    -turn.as_rotvec(),
                    (seen[rows, 2] - flown.position_ned_m[rows, 2])[:, None],
                ],
                axis=1,
            )
            / noise
        )
    return np.concatenate(parts).ravel() if parts else np.zeros(0)


def _rows(one: _Measured) -> FloatArray:
    """Choose the samples of the regression, away from the ends and from gaps."""
    step, edge = round(_SAMPLE_S / one.period_s), round(2 * _SMOOTH_S / one.period_s)
    rows = np.arange(edge, len(one.state) - edge, step)
    return np.asarray([row for row in rows if one.known[row - edge : row + edge + 1].all()], float)


def _measured_accelerations(vehicle: Vehicle, one: _Measured) -> FloatArray:
    """Rates of the velocity of the body origin (k, 6) from specific force and gyro, averaged."""
    imu = vehicle.sensors.imu if vehicle.sensors is not None else None
    if imu is None:
        return np.zeros((0, 6))
    place = np.array(imu.position_m)
    width = max(round(_SMOOTH_S / one.period_s), 1)
    kernel = np.ones(width) / width
    rate = np.nan_to_num(one.state[:, 10:13])
    smooth = np.stack([np.convolve(column, kernel, "same") for column in rate.T], axis=1)
    spin = np.gradient(smooth, one.period_s, axis=0)
    turn = one.state[:, 3:7].copy()
    turn[~np.isfinite(turn).all(axis=1)] = (1.0, 0.0, 0.0, 0.0)
    down = Rotation.from_quat(turn[:, [1, 2, 3, 0]]).inv().apply([0.0, 0.0, 1.0])
    moved = np.nan_to_num(one.force) + vehicle.water.gravity_mps2 * down
    moved = np.stack([np.convolve(column, kernel, "same") for column in moved.T], axis=1)
    moved -= np.cross(smooth, np.nan_to_num(one.state[:, 7:10]))
    moved -= np.cross(spin, place) + np.cross(smooth, np.cross(smooth, place))
    index = _rows(one).astype(int)
    return np.concatenate([moved[index], spin[index]], axis=1)


def _modelled_accelerations(
    packed: PackedVehicle, one: _Measured, vector: FloatArray
) -> FloatArray:
    """Accelerations that the model has at the measured states (k, 6)."""
    rows = _rows(one)
    states = _kernel_states(packed, one, vector, rows)
    commands = one.command[rows.astype(int)]
    out = np.zeros((len(rows), 6))
    for k, (state, command) in enumerate(zip(states, commands, strict=True)):
        out[k] = run(
            packed, command[None, :], dt_s=one.period_s, vector=vector, start=state
        ).nu_dot[0]
    return out


def answer_campaign(folder: Path, raw: Path, out: Path) -> None:
    """Let both methods answer the cases of a campaign of which nothing was left out."""
    header = json.loads((folder / HEADER_FILE).read_text(encoding="utf-8"))
    subjects = subjects_of(tuple(header["vehicles"]), raw, out)
    answered = {line["number"] for line in read_lines(folder / ANSWERS_FILE)}
    with appending(folder / ANSWERS_FILE) as append:
        for line in read_lines(folder / CASES_FILE):
            number = line["number"]
            spec = case_of(number, subjects, header["seed"], run_s=header["run_s"])
            if "score" not in line or number in answered or spec.spec.kind == "leave_one_out":
                continue
            case = generate(subjects[spec.vehicle], spec.spec)
            asked = case.subject.vehicle, packed_of(case.subject), case.runs
            answers = {
                "BIC on raw residuals": bic_baseline(*asked),
                "sparse regression": sparse_baseline(*asked),
            }
            append({"number": number, "answers": answers})


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path, help="folder of the campaign")
    parser.add_argument("--raw", type=Path, default=Path("raw"))
    parser.add_argument("--out", type=Path, default=Path())
    asked = parser.parse_args()
    answer_campaign(asked.folder, asked.raw, asked.out)


if __name__ == "__main__":
    main()
