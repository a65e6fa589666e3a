"""What channels say of each other and of the vehicle file: suspicions, told and nothing else."""

from collections.abc import Iterator, Sequence

from pipeline.errors import CannotComputeError, Problem
from pipeline.ingest.pool_run_meant import meant_otherwise, over_the_earth, readings_of
from pipeline.ingest.pool_run_pairs import compared, late, pairs_of
from pipeline.ingest.pool_run_resample import on_one_base
from pipeline.ingest.pool_run_shafts import shafts_against_commands, shafts_too_slow, tips_too_fast
from pipeline.ingest.pool_run_sizes import (
    depth_too_fast,
    doubtful_depths,
    down_apart,
    impossible_readings,
    sizes,
    supply,
)
from pipeline.ingest.pool_run_thrusters import moments_without_turning, thrusters_against_rates
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.records.run_table import RunTable
from pipeline.vehicle.schema import Vehicle


def consistency_problems(run: PoolRun, vehicle: Vehicle) -> Iterator[Problem]:
    """Compare channels with each other and with the vehicle file.

    Warns of units off by a factor, impossible readings, two opinions of where down is, shaft speeds
    that contradict commands, thrusters that seem to be swapped or reversed. It changes nothing.
    """
    yield from sizes(run)
    yield from tips_too_fast(run, vehicle)
    yield from impossible_readings(run)
    yield from supply(run, vehicle)
    yield from doubtful_depths(run, vehicle)
    try:  # what follows lays the readings on a common time base
        table = on_one_base(run)
        yield from contradictions(run, vehicle, table)
        yield from shafts_against_commands(run, table)
        yield from shafts_too_slow(run, table, vehicle)
        yield from moments_without_turning(run, table, vehicle)
        yield from thrusters_against_rates(run, table, vehicle)
    except CannotComputeError as error:
        yield run.place.warning(
            f"channels were not compared with each other: {error}.",
            remedy="Check the clock of the recorder; cut a log of many days into runs.",
        )


def contradictions(
    run: PoolRun, vehicle: Vehicle, table: RunTable, others: Sequence[RunChannel] = ()
) -> Iterator[Problem]:
    """Say where attitude, rates, specific force, velocity, depth and position contradict another.

    `others` are velocities beside that of the run. Raises `CannotComputeError` where the times of
    the run make no table.
    """
    yield from depth_too_fast(run, table)
    yield from down_apart(run, table)
    readings = readings_of(run, table)
    pairs = list(pairs_of(run, table, vehicle.water.gravity_mps2, readings))
    told = [problem for pair in pairs for problem in compared(run, pair)]
    yield from told
    if readings:
        said = [over_the_earth(run, table, readings, one) for one in others]
        if not any(said) and not any("{" in one.what for one in told):  # what would agree
            said = [meant_otherwise(run, table, readings, vehicle)]
        channel = run.channels.get("velocity") or run.channels["velocity_earth"]
        yield from (
            run.place.warning(
                f"the velocity ({channel.topic}) {one}",
                remedy="Check its axes, sign and unit under pool: channels in vehicle.yaml.",
            )
            for one in said
            if one
        )
    for pair in pairs:
        yield from late(run, pair)
