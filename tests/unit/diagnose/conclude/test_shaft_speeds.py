"""Shafts that turn more slowly at their codes are those of a low supply, not of weak propellers."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bundled_models import mmt300_bench
from diagnosis_cases import small_case

from pipeline.diagnose.case import Case, channels_of
from pipeline.diagnose.conclude.shaft_speeds import ShaftsSeen, by_shaft_speeds, shafts_seen
from pipeline.diagnose.engine import diagnose
from pipeline.diagnose.inference.infer import infer
from pipeline.diagnose.rules.calibration import calibration
from pipeline.diagnose.rules.shares import Share
from pipeline.effects.library import apply_effects, parse_effect
from pipeline.physics.parameters import MOST_THRUSTERS, read
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import PackedVehicle, pack_vehicle
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle

PERIOD_S = 0.02
#: Shares of the largest code, each held for four seconds.
STEPS = (0.3, 0.45, -0.35, 0.6, -0.6, 0.75, 0.9)
SURGE_MPS = 0.8


def run(
    packed: PackedVehicle, turns: Callable[[int, FloatArray, FloatArray], FloatArray]
) -> RunTable:
    """All thrusters at the same codes; `turns` says how fast, by thruster, code and speed."""
    largest = np.abs(packed.code_limits).max(axis=1)
    share = np.repeat(STEPS, round(4.0 / PERIOD_S))
    along = SURGE_MPS * read(packed.vector, "thruster_direction")[: len(largest), 0]
    command = share[:, None] * largest
    shaft = np.stack(
        [
            turns(i, command[:, i], np.maximum(np.sign(share) * along[i], 0.0))
            for i in range(len(largest))
        ],
        axis=1,
    )
    velocity = np.tile([SURGE_MPS, 0.0, 0.0], (len(share), 1))
    values = {"command": command, "shaft_speed": shaft, "velocity": velocity}
    valid = {name: np.ones(len(share), bool) for name in values}
    return RunTable("run", PERIOD_S * np.arange(len(share)), values, valid)


def with_runs(case: Case, now: RunTable, *healthy: RunTable) -> Case:
    return replace(case, runs=(now,), holdout=(), healthy=healthy)


@pytest.fixture(scope="module")
def mmt300(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> Case:
    vehicle = load_vehicle(repository / "raw/mmt300/vehicle.yaml")
    packed = pack_vehicle(vehicle, mmt300_bench(repository, tmp_path_factory))
    return Case("mmt300", vehicle, packed, ())


@pytest.fixture(scope="module")
def rov8() -> Case:
    return small_case(
        ("voltage_sag:drop=0.2",), effects=("voltage_sag", "thrust_deduction"), seconds=16.0
    )


def of_bench(packed: PackedVehicle, share: float) -> RunTable:
    """Shafts that turn as the bench's do at a share of their codes."""
    kinds = read(packed.vector, "thruster_type").astype(int)

    def turns(i: int, code: FloatArray, along: FloatArray) -> FloatArray:
        speed = packed.shaft_speed(int(kinds[i]), np.abs(code) * share, along)
        return np.copysign(speed, code)

    return run(packed, turns)


def by_power(packed: PackedVehicle, share: float) -> RunTable:
    """Shafts of which no bench knows, at a share of their codes."""
    return run(packed, lambda _, code, __: np.copysign(20.0 * np.abs(share * code) ** 0.8, code))


@pytest.mark.parametrize("share", [0.85, 0.96, 1.0])
def test_the_bench_says_at_what_share_of_their_codes_shafts_turn(
    mmt300: Case, share: float
) -> None:
    seen = shafts_seen(with_runs(mmt300, of_bench(mmt300.packed, share)))
    assert seen is not None
    assert seen.against == "the bench"
    assert seen.thrusters.size == 5
    assert seen.middle == pytest.approx(share, abs=0.01)
    low = apply_effects(
        mmt300.packed.vector,
        [parse_effect(f"voltage_sag:drop={1.0 - share}")],
        mmt300.packed.context,
    )
    assert seen.off(low) == pytest.approx(0.0, abs=0.01)


def test_a_dead_zone_is_no_low_supply(mmt300: Case) -> None:
    packed = mmt300.packed
    wide = apply_effects(packed.vector, [parse_effect("dead_zone:codes=10")], packed.context)
    kinds = read(packed.vector, "thruster_type").astype(int)

    def turns(i: int, code: FloatArray, along: FloatArray) -> FloatArray:
        largest = np.abs(packed.code_limits[i]).max()
        size = (np.abs(code) - 10.0) * largest / (largest - 10.0)
        return np.copysign(packed.shaft_speed(int(kinds[i]), size, along), code)

    seen = shafts_seen(with_runs(mmt300, run(packed, turns)))
    assert seen is not None
    assert seen.middle < 0.95
    assert seen.off(wide) == pytest.approx(0.0, abs=0.01)
    assert seen.log_likelihood(wide) > seen.log_likelihood(packed.vector) + 5.0


def test_healthy_runs_bear_the_bench_out(mmt300: Case) -> None:
    # all shafts turn a little faster than the bench's, as in warmer water
    well, sick = of_bench(mmt300.packed, 1.03), of_bench(mmt300.packed, 1.03 * 0.9)
    seen = shafts_seen(with_runs(mmt300, sick, well))
    assert seen is not None
    assert seen.against == "the bench and healthy runs"
    assert seen.middle == pytest.approx(0.9, abs=0.01)


def test_without_a_bench_healthy_runs_say_how_fast(rov8: Case) -> None:
    sick, well = by_power(rov8.packed, 0.85), by_power(rov8.packed, 1.0)
    seen = shafts_seen(with_runs(rov8, sick, well))
    assert seen is not None
    assert seen.against == "the healthy runs"
    assert seen.middle == pytest.approx(0.85, abs=0.02)
    assert shafts_seen(with_runs(rov8, sick)) is None


def test_one_thruster_that_turns_otherwise_does_not_count(rov8: Case) -> None:
    well, sick = by_power(rov8.packed, 1.0), by_power(rov8.packed, 1.0)
    sick.values["shaft_speed"][:, 0] *= 0.5
    seen = shafts_seen(with_runs(rov8, sick, well))
    assert seen is not None
    assert seen.middle == pytest.approx(1.0, abs=0.01)


def test_a_measured_voltage_is_asked_instead(mmt300: Case) -> None:
    now = of_bench(mmt300.packed, 0.9)
    now.values["voltage"] = np.full((now.time_s.size, 1), 43.0)
    now.valid["voltage"] = np.ones(now.time_s.size, bool)
    assert shafts_seen(with_runs(mmt300, now)) is None


def test_what_is_no_shaft_speed_is_not_used(mmt300: Case) -> None:
    now = of_bench(mmt300.packed, 1.0)
    now.values["shaft_speed"] *= 7.0  # pole pairs of the motor
    assert shafts_seen(with_runs(mmt300, now)) is None


def test_codes_that_never_rest_say_nothing(mmt300: Case) -> None:
    now = of_bench(mmt300.packed, 1.0)
    now.values["command"] *= 1.0 + 0.3 * np.sin(6.0 * now.time_s)[:, None]
    assert shafts_seen(with_runs(mmt300, now)) is None


def _seen(packed: PackedVehicle, share: float) -> ShaftsSeen:
    count, codes = 100, np.zeros((100, MOST_THRUSTERS))
    codes[:, :8] = 0.5 * np.abs(packed.code_limits).max(axis=1)
    thruster = np.arange(count) % 8
    return ShaftsSeen(np.full(count, share), codes, thruster, packed.vector, 0.02, "it")


def test_shafts_weigh_answers(rov8: Case) -> None:
    runs = (*rov8.runs, *rov8.holdout)
    found, answered = infer(rov8, runs, channels_of(rov8.vehicle, runs), calibration(), 1)
    sag = answered.of("voltage_sag")
    assert sag is not None
    alike = answered.reweighed(
        [Share("thrust_deduction", 0.5), Share("voltage_sag", 0.4), Share("unknown", 0.1)]
    )
    slow = by_shaft_speeds(found, alike, _seen(rov8.packed, 0.8))
    assert slow.ranking[0].name == "voltage_sag"
    assert slow.ranking[0].probability == pytest.approx(0.9, abs=1e-4)
    fast = by_shaft_speeds(found, alike, _seen(rov8.packed, 1.0))
    assert fast.ranking[0].name == "thrust_deduction"
    for one in (slow, fast):
        assert sum(row.probability for row in one.ranking) == pytest.approx(1.0)
        unknown = one.of("unknown")
        assert unknown is not None
        assert unknown.probability == pytest.approx(0.1)
    assert by_shaft_speeds(found, alike, None) is alike


def test_the_answer_says_what_the_shafts_showed(rov8: Case) -> None:
    well = small_case(effects=("voltage_sag", "thrust_deduction"), seconds=16.0)

    def turning(case: Case, share: float) -> tuple[RunTable, ...]:
        return tuple(
            replace(
                one,
                values={name: one.values[name] for name in one.values if name != "voltage"}
                | {"shaft_speed": 40.0 * share * one.values["command"]},
                valid=one.valid | {"shaft_speed": np.ones(one.time_s.size, bool)},
            )
            for one in case.runs
        )

    record = diagnose(replace(rov8, runs=turning(rov8, 0.8), healthy=turning(well, 1.0)), threads=1)
    assert record.verdict.effects == ("voltage_sag",)
    assert "turn as with 80.0%" in record.evidence.stages["actuators"]
    assert "by the healthy runs" in record.evidence.stages["actuators"]
