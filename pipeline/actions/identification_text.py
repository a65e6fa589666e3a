"""What `rig2sea identify` prints: values with intervals, what is missing, how well it predicts."""

from collections.abc import Sequence

from pipeline.records.gains import ThrusterGain, ThrusterGains
from pipeline.records.identification import (
    ChannelQuality,
    Identification,
    StraightLineIdentification,
    VehicleIdentification,
)

_ALL = "all"


def gains_text(gains: ThrusterGains) -> list[str]:
    """Return a table of all runs, what is against a reference, and what was found.

    Parameters
    ----------
    gains : ThrusterGains
        Of any number of runs.
    """
    if not gains.runs:
        why = "; ".join(f"{run}: {text}" for run, text in gains.why_no_run.items())
        return [f"Gains of the thrusters: not computed ({why})"] if why else []
    lines = ["Gains of the thrusters (1: as the vehicle file says; 95 % intervals):"]
    axes = list(dict.fromkeys(row.axis for row in gains.gains if row.axis != _ALL))
    shown = [_ALL, *(axis for axis in axes if _told(gains.gains, axis))]
    lines.append("  " + f"{'run, thruster':40}" + "".join(f"{axis:>22}" for axis in shown))
    for run in gains.runs:
        lines.append(f"  {run.run}")
        for name in run.thrust_std_n:
            own = {
                row.axis: row for row in gains.gains if row.run == run.run and row.thruster == name
            }
            cells = "".join(f"{_cell(own.get(axis)):>22}" for axis in shown)
            lines.append(f"    {name:38}{cells}{_against(own.get(_ALL))}")
    lines += [f"  {name}: not judged, {why}" for name, why in gains.not_judged.items()]
    lines += [f"  {run}: no gains, {why}" for run, why in gains.why_no_run.items()]
    if gains.findings:
        lines += [f"  found: {one.text}" for one in gains.findings]
    else:
        lines.append("  nothing out of the ordinary")
    return lines


def _told(rows: Sequence[ThrusterGain], axis: str) -> bool:
    return any(row.axis == axis and row.moves and row.judged for row in rows)


def _cell(row: ThrusterGain | None) -> str:
    if row is None or not row.moves or row.value is None or row.ci95 is None:
        return "-"
    if not row.judged:
        return "?"
    return f"{row.value:.2f} [{row.ci95[0]:.2f}, {row.ci95[1]:.2f}]"


def _against(row: ThrusterGain | None) -> str:
    known = None if row is None else row.reference
    if known is None or known.ratio is None or known.ratio_ci95 is None:
        return ""
    low, high = known.ratio_ci95
    return f"   {known.ratio:.2f} [{low:.2f}, {high:.2f}] of what it gave in {known.name}"


def identification_text(found: Identification) -> str:
    """Return the lines of an identification for a terminal."""
    runs = ", ".join(f"{run.name} ({run.seconds:.0f} s)" for run in found.runs)
    lines = [f"{found.vehicle} from {runs}"]
    if found.holdout:
        lines.append("held out: " + ", ".join(run.name for run in found.holdout))
    if found.whole_vehicle is not None:
        lines += ["", *_whole(found.whole_vehicle)]
    elif found.why_no_whole_vehicle:
        lines += ["", f"No whole-vehicle fit: {found.why_no_whole_vehicle}"]
    lines += ["", *_straight(found.straight_line, found.why_no_straight_line)]
    if found.gains is not None:
        lines += ["", *gains_text(found.gains)]
    return "\n".join(lines)


def _whole(fit: VehicleIdentification) -> list[str]:
    settled = "settled" if fit.converged else "DID NOT SETTLE"
    lines = [
        (
            f"Whole-vehicle fit: {fit.windows} windows of {fit.window_s:.0f} s, {fit.readings} "
            f"readings; {settled} after {fit.iterations} steps"
        ),
        (
            f"  {'parameter':25} {'value':>10} {'95 % interval':>23} {'vehicle file':>21} "
            f"{'corrected':>10}  unit"
        ),
    ]
    for one in fit.parameters:
        low, high = one.ci95
        prior = f"{one.prior_value:.4g} +- {one.prior_std:.2g}"
        mark = " " if one.stands else "?"
        filed = "as it was" if not one.stands or one.file_value is None else f"{one.file_value:.4g}"
        lines.append(
            f"{mark} {one.name:25} {one.value:10.4g} {low:10.4g} ... {high:<8.4g} {prior:>21} "
            f"{filed:>10}  {one.unit}"
        )
    lines.append("  The intervals hold what the uncertainty of the bench's thrust does.")
    lines += _thrust(fit)
    if fit.cannot_identify:
        lines += ["", "? Of these the runs do not tell enough to use them:"]
        lines += [f"  {sentence}" for sentence in fit.cannot_identify]
    lines += ["", *_quality(fit.quality, fit.holdout)]
    return [*lines, *(f"note: {note}" for note in fit.notes)]


def _thrust(fit: VehicleIdentification) -> list[str]:
    """Factors of the thrusters on what the file states, and the share that the hull takes."""
    factors = [one for one in fit.thrust if one.unit == "1"]
    if not factors:
        return []
    lines = ["", f"  {'thrust over the stated one':25} {'value':>10} {'95 % interval':>23}"]
    total = () if fit.thrust_deduction is None else (fit.thrust_deduction,)
    for one in (*factors, *total):
        low, high = one.ci95
        lines.append(
            f"  {one.name.removeprefix('thrust_') if one in factors else one.name:25} "
            f"{one.value:10.3f} {low:10.3f} ... {high:<8.3f}"
        )
    return lines


def _quality(quality: Sequence[ChannelQuality], holdout: Sequence[str]) -> list[str]:
    if not quality:
        return ["No window was left to judge the fit by; give --holdout RUN."]
    of = "runs" if holdout else "windows"
    lines = [
        (
            f"Prediction of {of} that were not used for the fit, over {quality[0].horizon_s:.0f} s "
            "(rms error):"
        ),
        (
            f"  {'channel':18} {'identified':>10} {'corrected':>10} {'file':>10} "
            f"{'last value':>10} {'black box':>10} {'sensor':>10}  unit"
        ),
    ]
    for one in quality:
        numbers = (
            one.rmse_identified,
            one.rmse_corrected_file,
            one.rmse_vehicle_file,
            one.rmse_last_value,
            one.rmse_black_box,
            one.sensor_noise,
        )
        cells = " ".join(f"{'-' if n is None else f'{n:.3g}':>10}" for n in numbers)
        lines.append(f"  {one.channel:18} {cells}  {one.unit}")
    lines.append(
        "  Corrected: the vehicle file with what stands and the factors of the thrusters, without "
        "the curves found."
    )
    return lines


def _straight(found: Sequence[StraightLineIdentification], why_not: dict[str, str]) -> list[str]:
    lines = []
    for one in found:
        lines.append(
            f"Slope of acceleration against thrust, {one.axis}: {len(one.segments)} straight "
            f"stretches, {one.seconds:.0f} s, {one.smoother}"
        )
        estimates = (*one.plain, *((one.with_terms,) if one.with_terms else ()))
        for estimate in estimates:
            if estimate.refused:
                lines.append(f"  {estimate.estimator:40} refused: {estimate.refused}")
                continue
            if estimate.ci95_kg is None:
                lines.append(f"  {estimate.estimator:40} bounds no mass")
                continue
            low, high = estimate.ci95_kg
            lines.append(
                f"  {estimate.estimator:40} {estimate.added_mass_kg:8.2f} kg "
                f"({low:.2f} to {high:.2f})"
            )
        lines += [f"  warning: {warning}" for warning in one.warnings]
    by_reason: dict[str, list[str]] = {}
    for axis, reason in why_not.items():
        by_reason.setdefault(reason, []).append(axis)
    lines += [f"No slope in {', '.join(axes)}: {why}" for why, axes in by_reason.items()]
    return lines
