"""Diagnosis of mooring tables: every effect found, its size, and honesty where there is doubt."""

import bench_table_cases as cases
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import spearmanr

from pipeline.diagnose.bench.answer import PRIOR, rank
from pipeline.diagnose.bench.effects import predict
from pipeline.diagnose.bench.engine import diagnose_bench
from pipeline.diagnose.bench.fit import BenchComparison, fit_effects, fit_nothing
from pipeline.diagnose.bench.model import ReferenceCurve, bench_model
from pipeline.diagnose.bench.noise import smooth
from pipeline.diagnose.bench.shrink import held_out_codes
from pipeline.diagnose.bench.table import bench_table
from pipeline.errors import CannotComputeError
from pipeline.types import FloatArray

CODE = cases.codes()
NOMINAL = cases.thrust(CODE)


def lost(code: FloatArray, codes: float) -> FloatArray:
    """Codes left of a dead zone, written anew."""
    return np.sign(code) * np.maximum(np.abs(code) - codes, 0.0) * 127.0 / (127.0 - codes)


@pytest.mark.parametrize(
    ("effect", "parameter", "value", "thrust_n"),
    [
        ("dead_zone", "codes", 15.0, cases.thrust(lost(CODE, 15.0))),
        ("reverse_thrust", "fraction", 0.8, np.where(CODE < 0.0, 0.8, 1.0) * NOMINAL),
        ("thruster_degraded", "thrust_fraction", 0.7, 0.7 * NOMINAL),
    ],
)
def test_each_effect_is_first_and_its_size_is_right(
    effect: str, parameter: str, value: float, thrust_n: FloatArray
) -> None:
    record = diagnose_bench(cases.model(volts=False), cases.table(thrust_n))
    assert record.verdict.effects == (effect,)
    found = record.ranking[0].parameters[parameter]
    assert found.ci95[0] < value < found.ci95[1]
    assert found.value == pytest.approx(value, rel=0.1)
    assert record.shrink.gap_closed is not None
    assert record.shrink.gap_closed > 0.9


def test_a_low_supply_is_sure_with_the_voltage_and_shares_the_answer_without_it() -> None:
    thrust_n = cases.thrust(0.85 * CODE)
    shown = diagnose_bench(cases.model(), cases.table(thrust_n, 0.85 * cases.VOLTS))
    assert shown.verdict.effects == ("voltage_sag",)
    assert shown.verdict.ambiguous_with == ()
    assert shown.ranking[0].parameters["drop"].value == pytest.approx(0.15, abs=0.02)
    hidden = diagnose_bench(cases.model(volts=False), cases.table(thrust_n))
    assert "voltage_sag" in {*hidden.verdict.effects, *hidden.verdict.ambiguous_with}


def test_a_weak_thruster_is_never_told_from_thrust_deduction() -> None:
    record = diagnose_bench(cases.model(volts=False), cases.table(0.8 * NOMINAL))
    assert record.verdict.effects == ("thruster_degraded",)
    assert record.verdict.detail.thruster == "stern"
    assert record.verdict.ambiguous_with == ("thrust_deduction", "voltage_sag")
    assert ("thrust_deduction", "thruster_degraded", 1.0) in record.confusable
    assert record.next_run is not None


@pytest.mark.parametrize("seed", range(3))
def test_a_healthy_table_is_none(seed: int) -> None:
    scale = 1.0 + 0.015 * (seed - 1)
    record = diagnose_bench(cases.model(volts=False), cases.table(scale * NOMINAL, seed=seed))
    assert record.verdict.effects == ("none",)
    assert record.shrink.gap_closed is None


def test_another_propeller_is_unknown() -> None:
    bent = NOMINAL * (1.0 + 0.5 * np.sin(2.0 * np.pi * np.abs(CODE) / 127.0))
    record = diagnose_bench(cases.model(volts=False), cases.table(bent))
    assert record.verdict.effects == ("unknown",)
    assert record.leftover.axes["thrust"] > 1.5


@pytest.mark.parametrize("share", [1.0, 0.85])
def test_two_ways_of_being_unknown_are_one_answer_with_one_prior(share: float) -> None:
    """With a voltage: of any shape at the bench's supply, and at the one that was read."""
    bent = cases.thrust(share * CODE) * (1.0 + 0.5 * np.sin(2.0 * np.pi * np.abs(CODE) / 127.0))
    problem = BenchComparison(cases.model(), cases.table(bent, share * cases.VOLTS))
    ranking, _ = rank(problem)
    nothing = fit_nothing(problem)
    sag = fit_effects(problem, ("voltage_sag",))
    ways = [
        fit_nothing(problem, unknown=True),
        fit_nothing(problem, unknown=True, beside=sag),
    ]
    evidence = [one.log_evidence - nothing.log_evidence for one in ways]
    assert ranking[0].name == "unknown"
    assert ranking[0].log_evidence == pytest.approx(max(evidence))
    odds = {one.name: one.probability for one in ranking}
    assert np.log(odds["none"] / odds["unknown"]) == pytest.approx(
        np.log(PRIOR["none"] / (PRIOR["unknown"] / 2.0)) - np.logaddexp(*evidence)
    )


def test_what_is_left_goes_with_the_code_by_rank() -> None:
    stepped = NOMINAL * np.where(np.abs(CODE) > 70.0, 0.65, 0.3)
    record = diagnose_bench(cases.model(volts=False), cases.table(stepped))
    assert record.verdict.effects == ("unknown",)
    ours = record.by_code[0]
    # nothing is added to the model, and the fit saw what was not held out
    seen = ~np.array(ours.held_out)
    left = (np.array(ours.measured) - np.array(ours.after))[seen]
    expected = spearmanr(left, np.array(ours.code)[seen]).statistic
    assert record.leftover.correlation == pytest.approx(expected)


def test_a_step_that_tells_look_alikes_of_unknown_apart_shows_their_difference() -> None:
    stepped = NOMINAL * np.where(np.abs(CODE) > 70.0, 0.65, 0.3)
    record = diagnose_bench(cases.model(volts=False), cases.table(stepped))
    assert record.verdict.ambiguous_with == ("thrust_deduction", "thruster_degraded")
    weak = next(one for one in record.ranking if one.effect == "thruster_degraded")
    share = weak.parameters["thrust_fraction"].value
    assert record.next_run is not None
    # 2 % of scale of either test
    assert record.next_run.expected_separation_sigma == pytest.approx(
        (1.0 - share) / (0.02 * np.sqrt(2.0))
    )


def test_of_a_pair_a_weak_thruster_is_not_told_from_its_look_alikes_either() -> None:
    both = 0.7 * cases.thrust(lost(CODE, 60.0))
    hidden = diagnose_bench(cases.model(volts=False), cases.table(both))
    assert hidden.verdict.effects == ("dead_zone", "thruster_degraded")
    assert hidden.verdict.ambiguous_with == ("thrust_deduction", "voltage_sag")
    assert hidden.next_run is not None
    assert "supply voltage" in hidden.next_run.manoeuvre
    assert set(hidden.ranking[0].parameters) == {
        "dead_zone.codes",
        "thruster_degraded.thrust_fraction",
    }
    held = {"dead_zone+thruster_degraded", "dead_zone+voltage_sag"}
    assert hidden.verdict.probability == pytest.approx(
        sum(one.probability for one in hidden.ranking if one.effect in held), abs=1e-6
    )
    shown = diagnose_bench(cases.model(), cases.table(both, cases.VOLTS))
    assert shown.verdict.ambiguous_with == ("thrust_deduction",)


def test_the_missing_voltage_at_full_code_is_said_whole() -> None:
    sagging = cases.thrust(CODE * (0.9 - 0.25 * (CODE / 127.0) ** 2))
    record = diagnose_bench(cases.model(volts=False), cases.table(sagging))
    values = record.ranking[0].parameters
    whole = values["drop"].value + values["load_drop"].value
    assert whole == pytest.approx(0.35, abs=0.05)
    assert f"at full code {100.0 * whole:.3g} % less" in record.verdict.sentence


def test_every_code_lies_in_one_range_of_the_gap() -> None:
    code = np.concatenate([np.arange(-120.0, 0.0, 10.0), np.arange(10.0, 121.0, 10.0)])
    model = cases.model(volts=False)
    weak = bench_table(cases.points(code, 0.6 * cases.thrust(code)), model, name="new")
    regimes = diagnose_bench(model, weak).gap.where.regimes
    assert len(regimes) == 6
    assert sum(one.share for one in regimes) == pytest.approx(1.0)
    assert [one.share_of_time for one in regimes] == pytest.approx([1.0 / 6.0] * 6)


def test_channels_that_carry_the_gap_come_with_the_largest_first() -> None:
    sagged = cases.table(cases.thrust(0.85 * CODE), 0.5 * cases.VOLTS)
    gap = diagnose_bench(cases.model(), sagged).gap
    assert gap.where.channels == ("voltage", "thrust")
    assert gap.channels["voltage"].ratio > gap.channels["thrust"].ratio


def test_a_channel_that_some_codes_lack_is_named() -> None:
    read = cases.points(CODE, NOMINAL, cases.VOLTS)
    read[3] = read[3].model_copy(update={"voltage_v": None})
    model = cases.model()
    record = diagnose_bench(model, bench_table(read, model, name="new"))
    (said,) = [note for note in record.notes if "voltage was read" in note]
    assert said.startswith(f"In new voltage was read at {CODE.size - 1} of {CODE.size} codes")
    assert not any("Not in the table" in note and "voltage," in note for note in record.notes)


def test_the_order_of_rows_and_the_name_change_nothing() -> None:
    given_points = cases.points(CODE, 0.7 * NOMINAL)
    first = diagnose_bench(
        cases.model(volts=False), bench_table(given_points, cases.model(volts=False), name="a")
    )
    second = diagnose_bench(
        cases.model(volts=False),
        bench_table(given_points[::-1], cases.model(volts=False), name="none"),
    )
    assert first.ranking == second.ranking


@given(st.floats(-0.5, 0.5))
def test_voltage_follows_the_drop_and_neutral_values_change_nothing(drop: float) -> None:
    channels = ("thrust", "voltage")
    sagged = predict(cases.model(), {("voltage_sag", "drop"): drop}, CODE, channels)
    assert sagged["voltage"] == pytest.approx((1.0 - drop) * cases.VOLTS)
    neutral = {("thruster_degraded", "thrust_fraction"): 1.0, ("dead_zone", "codes"): 0.0}
    assert predict(cases.model(), neutral, CODE, channels)["thrust"] == pytest.approx(
        cases.model().channels["thrust"].at(CODE)
    )


def test_beyond_the_last_code_thrust_goes_on_as_a_power() -> None:
    code = np.linspace(-100.0, 100.0, 201)
    square = ReferenceCurve(code, code * np.abs(code), np.zeros(201))
    assert square.at([200.0, -150.0]) == pytest.approx([40000.0, -22500.0], rel=1e-3)


def test_shape_errors_keep_together_along_one_sign_only() -> None:
    together = smooth(np.array([-50.0, 50.0, 60.0, 127.0]), 127.0)
    assert together[0, 1] == 0.0
    assert 1.0 > together[1, 2] > together[1, 3] > 0.0
    assert np.linalg.eigvalsh(together).min() > 0.0


def test_held_out_codes_have_both_signs() -> None:
    marked = held_out_codes(CODE)
    assert marked[CODE > 0.0].sum() == marked[CODE < 0.0].sum() == 6


@pytest.mark.parametrize(
    ("chosen", "factor", "message"),
    [
        (CODE > 0.0, 1.0, "no negative code beyond the dead zone"),
        (np.abs(CODE) < 40.0, 1.0, "at least 5 of each sign"),
        (CODE != 0.0, 8.0, "8.0 times that of tug"),
        (CODE != 0.0, -1.0, "points the other way"),
    ],
)
def test_a_hopeless_table_is_refused(chosen: FloatArray, factor: float, message: str) -> None:
    with pytest.raises(CannotComputeError, match=message):
        bench_table(
            cases.points(CODE[chosen.astype(bool)], factor * NOMINAL[chosen.astype(bool)]),
            cases.model(),
            name="new",
        )


def test_a_vehicle_without_thruster_model_is_told_what_to_do(repository: object) -> None:
    from pathlib import Path

    from pipeline.vehicle.load import load_vehicle

    vehicle = load_vehicle(Path(str(repository)) / "raw" / "mmt300")
    with pytest.raises(CannotComputeError, match="has no thruster model"):
        bench_model(vehicle, None, None)
