"""Blind check of the bench diagnosis: mooring tables with a known fault, judged and scored.

    python -m benchmarks.bench_diagnosis --out DIR --cases 120 --seed 1

DIR holds ``processed/mmt300`` (made by ``rig2sea run mmt300 --out DIR``). The truth is the printed
Table 3 of the vehicle, not the model that the diagnosis judges by, and the faults are written here
anew: a drive whose dead zone follows the voltage only in part, blades whose loss grows with thrust,
a load cell with a scale and a zero of its own, hysteresis, correlated shape errors. Labels are
looked at after the verdict.
"""

import argparse
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

from evaluation.bundled.mmt300_truth import mooring_thrust
from pipeline.diagnose.bench.engine import diagnose_bench
from pipeline.diagnose.bench.model import ThrusterAtRest, bench_model
from pipeline.diagnose.bench.table import bench_table
from pipeline.plan import processed_file
from pipeline.provenance import read_envelope
from pipeline.records.base import Source
from pipeline.records.fits import StaticCharacteristic
from pipeline.records.measurements import MooringPoint, MooringRecord
from pipeline.vehicle.load import load_vehicle

CODE_MAX = 127.0
SIZES = np.arange(5.0, 128.0, 6.1)
#: Severity bands by gap over the healthy floor.
BANDS = ((0.0, 1.0, "below 1"), (1.0, 3.0, "1 to 3"), (3.0, np.inf, "above 3"))
KINDS = ("none", "dead_zone", "reverse_thrust", "voltage_sag", "thruster_degraded", "unknown")
TWINS = {"thruster_degraded", "thrust_deduction"}


def thrust_of(code: np.ndarray) -> np.ndarray:
    """Thrust of the healthy truth at signed codes, continued with the square of the code [N]."""
    size = np.minimum(np.abs(code), CODE_MAX)
    at_code = np.array([mooring_thrust(float(c)) for c in np.copysign(size, code)])
    return np.asarray(at_code * (np.abs(code) / np.maximum(size, 1e-9)) ** 2)


def faulty(kind: str, code: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, float]:
    """Thrust of a faulty thruster [N], and its share of the supply voltage."""
    if kind == "dead_zone":
        lost = rng.uniform(2.0, 30.0)
        size = np.maximum(np.abs(code) - lost, 0.0) * CODE_MAX / (CODE_MAX - lost)
        return thrust_of(np.copysign(size, code)), 1.0
    if kind == "reverse_thrust":
        share = rng.uniform(0.5, 0.95)
        return np.where(code < 0.0, share, 1.0) * thrust_of(code), 1.0
    if kind == "voltage_sag":
        share = 1.0 - rng.choice([-1.0, 1.0]) * rng.uniform(0.02, 0.3)
        load = rng.uniform(0.0, 0.08)
        held = rng.uniform(0.0, 12.0)  # codes of dead zone that do not follow the voltage
        drive = (share - load * (code / CODE_MAX) ** 2) * np.maximum(np.abs(code) - held, 0.0)
        return thrust_of(np.copysign(drive + np.minimum(np.abs(code), held), code)), share
    if kind == "thruster_degraded":
        share, bend = rng.uniform(0.3, 0.95), rng.uniform(-0.05, 0.05)
        return thrust_of(code) * (share + (1.0 - share) * bend * np.abs(code) / CODE_MAX), 1.0
    if kind == "unknown":  # another propeller: stalls, or bites, from a code on; a slipping hub
        knee, slope = rng.uniform(0.35, 0.75), rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 0.8)
        bent = 1.0 + slope * np.maximum(np.abs(code) / CODE_MAX - knee, 0.0) * 1.5
        if rng.uniform() < 0.5:
            bent = 1.0 + slope * np.sin(2.0 * np.pi * np.abs(code) / CODE_MAX)
        return thrust_of(code) * bent, 1.0
    return thrust_of(code), 1.0


def case(kind: str, rng: np.random.Generator, *, with_voltage: bool) -> list[MooringPoint]:
    """One table with its sensor's faults."""
    code = np.concatenate([SIZES, SIZES[::-1], -SIZES, -SIZES[::-1]])
    rising = np.repeat([True, False, True, False], SIZES.size)
    thrust, supply = faulty(kind, code, rng)
    largest = 42.0
    knots = rng.normal(0.0, 0.008 * largest, 7) * np.linspace(0.3, 1.0, 7)
    shape = np.interp(np.abs(code), np.linspace(0.0, CODE_MAX, 7), knots) * np.sign(code)
    lag = np.where(rising, -1.0, 1.0) * 0.003 * thrust
    read = (1.0 + rng.normal(0.0, 0.015)) * (thrust + shape * (thrust != 0.0) + lag)
    read = read + rng.normal(0.0, 0.05) + rng.normal(0.0, 0.1, code.size)
    volts = 48.0 * supply * (1.0 + rng.normal(0.0, 0.01)) + rng.normal(0.0, 0.03, code.size)
    return [
        MooringPoint(
            source=Source(file="case", sheet=None, row=i + 1),
            code=float(code[i]),
            thrust_n=float(read[i]),
            voltage_v=float(volts[i]) if with_voltage else None,
            sweep="up" if rising[i] else "down",
        )
        for i in range(code.size)
    ]


def model_from(out: Path, raw: Path) -> ThrusterAtRest:
    """Model of mmt300 from its results."""
    vehicle = load_vehicle(raw / "mmt300")
    static = read_envelope(out / processed_file("mmt300", "static"), "static", StaticCharacteristic)
    mooring = read_envelope(out / processed_file("mmt300", "mooring"), "mooring", MooringRecord)
    return bench_model(vehicle, static.record, mooring.record)


def main(arguments: list[str]) -> None:
    """Run the cases and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path())
    parser.add_argument("--raw", type=Path, default=Path("raw"))
    parser.add_argument("--cases", type=int, default=120)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args(arguments)
    model = model_from(chosen.out, chosen.raw)
    rng = np.random.default_rng(chosen.seed)
    counts: dict[tuple[str, str], dict[str, int]] = defaultdict(lambda: defaultdict(int))
    for number in range(chosen.cases):
        kind = KINDS[number % len(KINDS)]
        with_voltage = bool((number // len(KINDS)) % 2)
        table = bench_table(case(kind, rng, with_voltage=with_voltage), model, name=f"{number}")
        record = diagnose_bench(model, table)
        ratio = record.gap.channels["thrust"].ratio
        band = next(name for low, high, name in BANDS if low <= ratio < high)
        said = set(record.verdict.effects)
        truth = TWINS if kind == "thruster_degraded" else {kind}
        first, within = bool(said <= truth), bool(truth & (said | {*record.verdict.ambiguous_with}))
        count = counts[kind, "all" if kind == "none" else band]
        count["cases"] += 1
        count["first"] += first
        count["set"] += within
        count["sure and wrong"] += not within
        if not first:
            sys.stdout.write(
                f"  {number} {kind} ratio {ratio:.1f} voltage {with_voltage}: "
                f"{'+'.join(record.verdict.effects)} {record.verdict.probability:.2f} "
                f"or {record.verdict.ambiguous_with}\n"
            )
            sys.stdout.flush()
    for (kind, band), count in sorted(counts.items()):
        sys.stdout.write(
            f"| {kind} | {band} | {count['cases']} | {count['first']} | {count['set']} |\n"
        )


if __name__ == "__main__":
    main(sys.argv[1:])
