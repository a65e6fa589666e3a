"""Do the 95 % intervals hold? Simulated runs whose truth is known, and the count of who covers.

For each seed the free parameters, the factor of each thruster's thrust and the shape of the curves
are drawn about the vehicle file from the very priors that the fit uses, runs are flown and measured
with them, the vehicle is identified, and each interval is compared with the truth.
`evaluation.identification` runs many seeds and keeps their lines.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from pipeline.errors import CannotComputeError
from pipeline.identify.thrust_uncertainty import thrust_uncertainty
from pipeline.identify.vehicle_fit import fit_vehicle
from pipeline.identify.vehicle_parameters import (
    FreeParameter,
    free_parameters,
    values_from_steps,
    vector_with,
)
from pipeline.records.run_table import RunTable
from pipeline.simulate.context import model_of
from pipeline.simulate.fly import fly, general_allocator
from pipeline.simulate.log_table import table_of_log
from pipeline.simulate.manoeuvres import MANOEUVRES
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.sensors import measure
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors

#: Manoeuvres of a campaign's runs, one run each, and their length [s].
EXCITING = ("multisine", "zig_zag", "surge_steps", "heave_steps")
RUN_S = 32.0
#: Draws beyond this many prior standard deviations are drawn in.
LARGEST_DRAW = 2.5
FAMILY_WISE = 0.01


@dataclass(frozen=True)
class Campaign:
    """What every seed of a campaign shares. `thrust` False leaves the thrust as the bench says."""

    vehicle: Vehicle
    packed: PackedVehicle
    manoeuvres: tuple[str, ...] = EXCITING
    run_s: float = RUN_S
    thrust: bool = True


@dataclass(frozen=True)
class Truth:
    """A drawn vehicle: free parameters, their values (p,), parameter vector, thrust curves."""

    parameters: tuple[FreeParameter, ...]
    values: FloatArray
    vector: FloatArray
    packed: PackedVehicle


def drawn_truth(campaign: Campaign, seed: int) -> Truth:
    """Draw the vehicle of a seed."""
    generator = np.random.default_rng([seed, 2])
    uncertainty = model_of(campaign.vehicle).uncertainty
    parameters = free_parameters(campaign.packed, uncertainty)
    draws = np.clip(generator.standard_normal(len(parameters)), -LARGEST_DRAW, LARGEST_DRAW)
    # where the file says zero damping, a negative one is no truth
    unstated = np.array([p.nominal == 0.0 and "damping" in p.name for p in parameters])
    draws = np.where(unstated, np.abs(draws), draws)
    values = values_from_steps(parameters, draws)
    vector = vector_with(campaign.packed.vector, parameters, values)
    packed = campaign.packed
    if campaign.thrust:
        doubt = thrust_uncertainty(packed, uncertainty)
        steps = doubt.drawn(generator, LARGEST_DRAW)
        doubt.write(vector, steps)
        packed = doubt.packed(packed, steps)
    return Truth(parameters, values, vector, packed)


def simulated_runs(
    campaign: Campaign, vector: FloatArray, seed: int, packed: PackedVehicle | None = None
) -> list[RunTable]:
    """Fly and measure the campaign's manoeuvres with a true vector, and true curves of thrust."""
    sensors = _sensors(campaign.vehicle)
    true = campaign.packed if packed is None else packed
    # the vehicle's own allocator believes the bench
    allocator = general_allocator(campaign.packed)
    runs = []
    for number, name in enumerate(campaign.manoeuvres):
        plan = MANOEUVRES[name].plan(campaign.packed, 1.0, campaign.run_s)
        trajectory = fly(true, plan, vector=vector, allocator=allocator)
        noise = int(np.random.default_rng([seed, 1, number]).integers(2**31))
        log = measure(trajectory, campaign.packed, sensors, vector=vector, seed=noise)
        runs.append(table_of_log(log, sensors, name=name))
    return runs


def one_seed(campaign: Campaign, seed: int, threads: int = 1) -> dict[str, Any]:
    """Identify one drawn vehicle; what is kept of it for the coverage."""
    truth = drawn_truth(campaign, seed)
    runs = simulated_runs(campaign, truth.vector, seed, truth.packed)
    begin = time.perf_counter()
    fit = fit_vehicle(
        campaign.packed,
        _sensors(campaign.vehicle),
        runs,
        uncertainty=model_of(campaign.vehicle).uncertainty,
        hold_out=False,
        threads=threads,
    )
    return {
        "seed": seed,
        "elapsed_s": round(time.perf_counter() - begin, 2),
        "converged": fit.settled,
        "parameters": {
            p.name: {
                "truth": float(true),
                "value": p.value,
                "std": p.std,
                "ci95": p.ci95,
                "prior_std": p.prior_std,
                "identified": p.identified,
                "inflation": p.inflation,
            }
            for p, true in zip(fit.found, truth.values, strict=True)
        },
    }


def summary(lines: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Coverage of each parameter over the seeds that identified it, with its own interval and test.

    Returns
    -------
    list of dict
        name, seeds, covered, coverage, low and high (95 % Clopper-Pearson), p (two-sided binomial
        test of 0.95), rejected (Holm, family-wise 1 % over the parameters), median_error (share of
        the truth), median_ratio (standard deviation over the prior's).
    """
    rows = []
    for name in lines[0]["parameters"]:
        found = [line["parameters"][name] for line in lines]
        found = [one for one in found if one["identified"]]
        if not found:
            continue
        inside = sum(one["ci95"][0] <= one["truth"] <= one["ci95"][1] for one in found)
        test = stats.binomtest(inside, len(found), 0.95)
        between = test.proportion_ci(0.95, method="exact")
        errors = [abs(one["value"] / one["truth"] - 1) for one in found if one["truth"]]
        rows.append(
            {
                "name": name,
                "seeds": len(found),
                "covered": inside,
                "coverage": inside / len(found),
                "low": float(between.low),
                "high": float(between.high),
                "p": float(test.pvalue),
                "median_error": float(np.median(errors)),
                "median_ratio": float(np.median([one["std"] / one["prior_std"] for one in found])),
            }
        )
    # Holm: the smallest p against alpha / m, the next against alpha / (m - 1) ...
    still = True
    for place, row in enumerate(sorted(rows, key=lambda row: float(row["p"]))):
        still = still and row["p"] < FAMILY_WISE / (len(rows) - place)
        row["rejected"] = still
    return rows


def table(lines: Sequence[dict[str, Any]]) -> str:
    """Return the summary as a Markdown table with a closing line."""
    rows = summary(lines)
    text = [
        "| parameter | seeds | covered | 95 % interval | p | median error | std / prior |",
        "|---|---|---|---|---|---|---|",
    ]
    text += [
        f"| {row['name']} | {row['seeds']} | {100 * row['coverage']:.1f} % | "
        f"{100 * row['low']:.1f}-{100 * row['high']:.1f} % | {row['p']:.3f} | "
        f"{100 * row['median_error']:.2f} % | {row['median_ratio']:.3f} |"
        for row in rows
    ]
    rejected = [row["name"] for row in rows if row["rejected"]]
    masses = [
        abs(one["value"] / one["truth"] - 1)
        for line in lines
        for name, one in line["parameters"].items()
        if name.startswith("added_mass") and one["identified"]
    ]
    inside = sum(row["covered"] for row in rows)
    every = sum(row["seeds"] for row in rows)
    text.append(
        f"\nAll together {inside} of {every} ({100 * inside / every:.2f} %). Rejected at "
        f"{100 * FAMILY_WISE:g} % family-wise: {', '.join(rejected) or 'none'}. Median added-mass "
        f"error {100 * float(np.median(masses)):.2f} %. {len(lines)} seeds, "
        f"{sum(not line['converged'] for line in lines)} did not settle, median "
        f"{float(np.median([line['elapsed_s'] for line in lines])):.1f} s each."
    )
    return "\n".join(text)


def _sensors(vehicle: Vehicle) -> Sensors:
    if vehicle.sensors is None:
        raise CannotComputeError(f"{vehicle.name} states no sensors, so nothing is measured")
    return vehicle.sensors
