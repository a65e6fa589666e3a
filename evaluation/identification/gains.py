"""Count whether intervals of gains hold: simulated runs with a thruster that is weak by a draw.

python -m evaluation.identification.gains rov8 --manoeuvre multisine --seeds 40
"""

import argparse
from pathlib import Path

import numpy as np

from pipeline.effects.library import apply_effects, parse_effect
from pipeline.inputs.gains import gains_of_runs
from pipeline.inputs.simulated_vehicle import SimulatedVehicle, load_simulated
from pipeline.records.run_table import RunTable
from pipeline.simulate.fly import fly
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.sensors import measure
from pipeline.vehicle.sensor_schema import Sensors


def weakened(
    one: SimulatedVehicle, manoeuvre: str, seed: int, run_s: float
) -> tuple[RunTable, str, float]:
    """Fly a manoeuvre with one thruster at a drawn share of its thrust.

    Parameters
    ----------
    one : SimulatedVehicle
        The vehicle.
    manoeuvre : str
        As `rig2sea simulate` names it.
    seed : int
        Draws the thruster, its share (0 to 0.9) and the noise.
    run_s : float
        Length of the run. [s]

    Returns
    -------
    RunTable, str, float
        The run, the thruster and its share.
    """
    generator = np.random.default_rng([seed, 7])
    name = str(generator.choice(one.packed.thruster_names))
    share = round(float(generator.uniform(0.0, 0.9)), 3)
    effect = parse_effect(
        f"thruster_degraded:thrust_fraction={share}@{name}", one.packed.thruster_names
    )
    vector = apply_effects(one.packed.vector, [effect], one.packed.context)
    plan = MANOEUVRES[manoeuvre].plan(one.packed, 1.0, run_s)
    trajectory = fly(one.packed, plan, vector=vector)
    sensors = one.vehicle.sensors or Sensors()
    log = measure(trajectory, one.packed, sensors, vector=vector, seed=seed)
    return table_of_log(log, sensors, name=f"seed-{seed}"), name, share


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("vehicle", nargs="?", default="rov8")
    parser.add_argument("--manoeuvre", default="multisine", choices=sorted(MANOEUVRES))
    parser.add_argument("--run-s", type=float, default=60.0)
    parser.add_argument("--seeds", type=int, default=40)
    wanted = parser.parse_args()
    one = load_simulated(wanted.vehicle, Path("raw"), Path())
    held = told = named = wrong = others = others_held = 0
    for seed in range(wanted.seeds):
        table, name, share = weakened(one, wanted.manoeuvre, seed, wanted.run_s)
        gains = gains_of_runs(one, [table])
        for row in gains.gains:
            if row.axis != "all" or not row.judged or row.ci95 is None:
                continue
            inside = row.ci95[0] <= (share if row.thruster == name else 1.0) <= row.ci95[1]
            if row.thruster == name:
                told, held = told + 1, held + inside
            else:
                others, others_held = others + 1, others_held + inside
        accused = {thruster for found in gains.findings for thruster in found.thrusters}
        named += name in accused
        wrong += bool(accused - {name})
        print(f"{seed}: {name} {share:.2f}, {sorted(accused)}", flush=True)
    print(f"weak: {held} of {told} intervals hold; sound: {others_held} of {others}")
    print(f"named {named} of {wanted.seeds}, another accused {wrong}")


if __name__ == "__main__":
    main()
