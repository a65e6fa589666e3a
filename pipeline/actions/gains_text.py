"""Gains of thrusters as lines for a terminal."""

from collections.abc import Sequence

from pipeline.records.gains import ThrusterGain, ThrusterGains

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
