"""``rig2sea simulate``."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pipeline.commands.common.options import AS_JSON, OUT, RAW, ValuesCommand, several, to_file
from pipeline.commands.common.say import print_json, say, warn

if TYPE_CHECKING:
    from pipeline.actions.simulation import SimulationResult


@click.command(cls=ValuesCommand)
@click.argument("vehicle", required=False)
@click.option("--manoeuvre", metavar="NAME", help="A named manoeuvre; --list shows them.")
@click.option(
    "--run",
    "log",
    type=click.Path(path_type=Path),
    metavar="LOG",
    help="A log whose commands are simulated in place of a manoeuvre.",
)
@click.option(
    "--effect",
    "effects",
    multiple=True,
    metavar="ID:KEY=VALUE...",
    help="Switch an effect on, ID:key=value[,key=value][@thruster]; may be given several times.",
)
@several(
    "--release",
    "MODULE@S...",
    "Release a payload module of the vehicle file after so many seconds.",
)
@several("--attach", "MODULE@S...", "Attach one that lies still.")
@several(
    "--winch",
    "SPEED@S...",
    "Drive the tether's winch from S seconds on, m/s, positive pays out, 0 brakes.",
)
@to_file("The log to write, *.mcap.")
@click.option(
    "--amplitude", type=float, default=1.0, show_default=True, help="Size of the manoeuvre."
)
@click.option(
    "--duration",
    "duration_s",
    type=float,
    metavar="S",
    help="Length in seconds.  [default: the manoeuvre's]",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Seed of the sensor noise.")
@click.option(
    "--allocator",
    type=click.Choice(["general", "paper", "paper-mooring"]),
    default="general",
    show_default=True,
    help="How a wanted wrench becomes codes: any arrangement, or eq. (6) of Kostenko 2023, with "
    "N(T, V) or with the mooring inverse N(T).",
)
@click.option(
    "--step",
    "step_s",
    type=float,
    metavar="S",
    help="Integration step in seconds.  [default: 0.02, less where a shaft needs it]",
)
@click.option(
    "--start",
    metavar="TIME",
    help="When the log begins, e.g. 2024-05-14T09:30 (UTC).  [default: a fixed day]",
)
@click.option("--list", "show_list", is_flag=True, help="List the manoeuvres and end.")
@AS_JSON
@RAW
@OUT
def simulate(
    *,
    vehicle: str | None,
    manoeuvre: str | None,
    log: Path | None,
    to: Path | None,
    show_list: bool,
    as_json: bool,
    **request: Any,  # noqa: ANN401 - fields of the request
) -> None:
    r"""Simulate a manoeuvre, or the commands of a log, and write what would have been logged.

    VEHICLE is a name under raw/, a path to a folder that holds vehicle.yaml, or a bundled vehicle
    (rov8, cargo_carrier). Effects (see rig2sea effects) change the vehicle that is simulated, not
    what its autopilot and allocator believe. The log is MCAP with standard ROS 2 messages; what no
    sensor saw, the true motion above all, is in it under /sim. The same command gives the same
    file. A LOG is copied to the output as it was recorded, the simulation beside it under /sim.

    \b
    Examples:
      rig2sea simulate mmt300 --manoeuvre zig_zag --to zig_zag.mcap
      rig2sea simulate rov8 --manoeuvre hover --effect current:north_mps=0.2 --to hover.mcap
      rig2sea simulate cargo_carrier --manoeuvre hover --release module_1@20 --to drop.mcap
      rig2sea simulate cargo_carrier --manoeuvre straight --winch 0.3@10 --to paid-out.mcap
      rig2sea simulate mmt300 --run trial.mcap --to trial-simulated.mcap
      rig2sea simulate --list
    """
    if show_list:
        _list_manoeuvres(as_json=as_json)
        return
    if vehicle is None:
        raise click.UsageError("Missing argument 'VEHICLE'.")
    if (manoeuvre is None) == (log is None):
        raise click.UsageError("Give either --manoeuvre NAME or --run LOG.")
    if to is None:
        raise click.UsageError("Missing option '--to': the file to write.")
    if log is not None and not log.is_file():
        raise click.UsageError(f"--run: there is no file {log}.")
    from pipeline.actions.simulation import SimulationRequest, simulate_to_file

    request |= {"manoeuvre": manoeuvre, "log": log}
    result = simulate_to_file(SimulationRequest(vehicle, to, **request))
    if as_json:
        print_json(result.to_json())
        return
    warn(result.warnings)
    say(_text(result))


def _text(result: "SimulationResult") -> str:
    run = result.summary
    effects = ", ".join(result.effects) or "none"
    sensors = ", ".join(f"{name} {count}" for name, count in run.channels.items())
    surge, depth = (f"{low:.2f} to {high:.2f}" for low, high in (run.surge_mps, run.depth_m))
    lines = [
        f"{result.vehicle}: {result.flown}, {run.duration_s:g} s, effects: {effects}",
        f"  surge {surge} m/s, depth {depth} m, tilt at most {run.tilt_deg:.1f} deg",
        f"  largest code {run.largest_code:g}, at its limit {run.at_limit_share:.0%} of the time",
        *(f"  {event}" for event in result.events),
        *_tether(result),
        *_latches(result),
        f"  readings: {sensors}",
        str(result.path),
    ]
    return "\n".join(lines)


def _tether(result: "SimulationResult") -> list[str]:
    tether = result.tether
    if tether is None:
        return []
    ends = (tether.tension_at_vehicle_n, tether.tension_at_top_n)
    vehicle, top = (f"{low:.1f} to {high:.1f} N" for low, high in ends)
    out = "{:.1f} to {:.1f} m".format(*tether.paid_out_m)
    return [f"  tether: tension at the vehicle {vehicle}, at its top {top}, paid out {out}"]


def _latches(result: "SimulationResult") -> list[str]:
    lines = []
    for latch in result.latches:
        closing = f", {latch.closing_n:.0f} N on closing" if latch.closing_n else ""
        lines.append(
            f"  latch of {latch.module}: at most {latch.largest_n:.0f} N{closing}, "
            f"{latch.largest_share:.0%} of its strength"
        )
    return lines


def _list_manoeuvres(*, as_json: bool) -> None:
    from pipeline.simulate.manoeuvres import MANOEUVRES

    every = MANOEUVRES.values()
    if as_json:
        keys = ("name", "purpose", "duration_s")
        rows = [{key: getattr(one, key) for key in keys} for one in every]
        print_json({"schema": "rig2sea/manoeuvres/1", "manoeuvres": rows})
        return
    width = max(len(name) for name in MANOEUVRES)
    say("\n".join(f"{one.name:{width}}  {one.duration_s:4g} s  {one.purpose}" for one in every))
