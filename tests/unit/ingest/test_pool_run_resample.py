"""One time base: exact where it must be, nothing made up in gaps."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pool_logs import SECOND_NS, START_NS, ticks
from scipy.spatial.transform import Rotation

from pipeline.errors import CannotComputeError
from pipeline.ingest.pool_run_health import rhythm_of, time_marks, value_marks
from pipeline.ingest.pool_run_resample import resample
from pipeline.records.pool_run import ChannelRead, ClockRead
from pipeline.records.run_arrays import PoolRun, RunChannel
from pipeline.types import BoolArray, FloatArray, IntArray


def channel(
    quantity: str,
    columns: tuple[str, ...],
    time_ns: IntArray,
    values: FloatArray,
    *,
    delay_s: float = 0.0,
    marks: Mapping[str, BoolArray] | None = None,
) -> RunChannel:
    rhythm = rhythm_of(time_ns)
    read = ChannelRead(
        quantity=quantity,
        topic="/t",
        message_type="",
        encoding="cdr",
        fields=(),
        unit="",
        unit_from="assumed",
        mapped_by="test",
    )
    found = time_marks(time_ns, values, rhythm) | value_marks(values, rhythm.period_s)
    return RunChannel(
        quantity,
        "/t",
        columns,
        time_ns,
        time_ns,
        values,
        found if marks is None else marks,
        ClockRead(used="log", why=""),
        read,
        delay_s,
        quantity == "thruster_command",
        rhythm.period_s,
        rhythm.is_regular,
    )


def run(**channels: RunChannel) -> PoolRun:
    times = np.concatenate([part.log_time_ns for part in channels.values()])
    return PoolRun("v", "f.mcap", channels, (), (), int(times.min()), int(times.max()), True, 0, 0)


def depth(time_ns: IntArray, values: FloatArray, **options: object) -> RunChannel:
    return channel("depth", ("depth_m",), time_ns, values[:, None], **options)


def test_the_rate_of_the_sensor_gives_its_readings_back() -> None:
    time_ns = ticks(200, 100.0)
    values = np.random.default_rng(0).standard_normal(200)
    table = resample(run(depth=depth(time_ns, values, marks={})), 100.0)
    np.testing.assert_array_equal(table.values["depth"][:, 0], values)
    assert table.valid["depth"].all()


@given(rate_hz=st.floats(5.0, 200.0), slope=st.floats(-3, 3))
def test_a_line_stays_a_line(rate_hz: float, slope: float) -> None:
    time_ns = ticks(101, 20.0)
    values = 1.0 + slope * np.arange(101) / 20.0
    table = resample(run(depth=depth(time_ns, values, marks={})), rate_hz)
    np.testing.assert_allclose(table.values["depth"][:, 0], 1.0 + slope * table.time_s, atol=1e-9)
    assert all(there.all() for there in table.valid.values())


def test_a_known_delay_is_taken_off() -> None:
    """A reading of 3 s that was taken 0.5 s before stands at 2.5 s."""
    time_ns = ticks(101, 10.0)
    values = np.arange(101) / 10.0
    table = resample(run(depth=depth(time_ns, values, marks={}, delay_s=0.5)), 10.0)
    there = table.valid["depth"]
    np.testing.assert_allclose(table.values["depth"][:, 0][there], table.time_s[there] + 0.5)
    assert table.time_s[there].max() == pytest.approx(9.5)


def test_nothing_is_made_up_in_a_gap() -> None:
    time_ns = ticks(400, 100.0)
    keep = np.r_[0:150, 250:400]
    part = depth(time_ns[keep], np.arange(400.0)[keep])
    assert part.marks["after_gap"].sum() == 1
    table = resample(run(depth=part), 100.0)
    inside = (table.time_s > 1.495) & (table.time_s < 2.495)
    assert not table.valid["depth"][inside].any()
    assert np.isnan(table.values["depth"][inside]).all()
    assert table.valid["depth"][~inside].all()


def test_left_out_readings_are_counted_and_bridged_only_if_they_are_few() -> None:
    time_ns = ticks(400, 100.0)
    values = np.sin(np.arange(400) / 40.0) + 1e-3 * np.random.default_rng(0).standard_normal(400)
    clean = resample(run(depth=depth(time_ns, values)), 100.0).values["depth"][:, 0]
    spoiled = values.copy()
    spoiled[100] = 50.0
    spoiled[200:260] = np.nan
    table = resample(run(depth=depth(time_ns, spoiled)), 100.0)
    assert table.left_out == {"depth": {"spike": 1, "not_a_number": 60}}
    assert table.values["depth"][:, 0][100] == pytest.approx(clean[100], abs=0.01)
    assert not table.valid["depth"][201:259].any()
    assert table.valid["depth"][:199].all()


def test_commands_hold_until_the_next() -> None:
    time_ns = START_NS + np.array([0, 3 * SECOND_NS, 3_500_000_000, 9 * SECOND_NS])
    codes = np.array([[10.0], [20.0], [-5.0], [0.0]])
    part = channel("thruster_command", ("command.bow",), time_ns, codes)
    table = resample(run(c=part), 10.0)
    column = table.values["command"][:, 0]
    assert column[[0, 29, 30, 34, 35, 89, 90]].tolist() == [10, 10, 20, 20, -5, -5, 0]
    assert all(there.all() for there in table.valid.values())


@pytest.mark.parametrize("offset_ms", [0, 1, 9, 11, 19])
def test_a_command_between_rows_acts_for_as_long_as_it_is_held(offset_ms: int) -> None:
    """The step in which it comes has the share of it; all of it would be early or late."""
    time_ns = START_NS + np.array([0, SECOND_NS + offset_ms * 1_000_000, 2 * SECOND_NS])
    part = channel("thruster_command", ("command.bow",), time_ns, np.array([[0.0], [5.0], [5.0]]))
    table = resample(run(c=part), 50.0, by_step=True)
    column = table.values["command"][:, 0]
    assert column[[49, 51]].tolist() == [0.0, 5.0]
    before_s = 0.02 * np.sum(1.0 - column / 5.0)
    assert before_s == pytest.approx(1.0 + offset_ms / 1000.0, abs=1e-6)


def test_attitudes_take_the_shorter_way() -> None:
    angle = np.linspace(0.0, 3.0, 31)
    q = Rotation.from_euler("z", angle[:, None]).as_quat()[:, [3, 0, 1, 2]]
    q[::2] *= -1.0
    part = channel("attitude", ("qw", "qx", "qy", "qz"), ticks(31, 10.0), q, marks={})
    table = resample(run(a=part), 40.0)
    found = Rotation.from_quat(table.values["attitude"][:, [1, 2, 3, 0]]).as_euler("ZYX")[:, 0]
    np.testing.assert_allclose(found, table.time_s, atol=1e-4)
    np.testing.assert_allclose(np.linalg.norm(table.values["attitude"], axis=1), 1.0)


def test_before_the_first_and_after_the_last_there_is_nothing() -> None:
    early = depth(ticks(50, 10.0), np.arange(50.0), marks={})
    late = channel(
        "voltage", ("supply_v",), ticks(50, 10.0, START_NS + 2 * SECOND_NS), np.ones((50, 1))
    )
    table = resample(run(depth=early, voltage=late), 10.0)
    assert table.valid["depth"].sum() == 50
    assert not table.valid["voltage"][:20].any()
    assert table.valid["voltage"][20:70].all()


def test_shuffled_readings_give_the_same_table() -> None:
    time_ns, values = ticks(100, 10.0), np.random.default_rng(0).standard_normal(100)
    order = np.random.default_rng(1).permutation(100)
    ordered = resample(run(depth=depth(time_ns, values, marks={})), 7.0)
    shuffled = depth(time_ns, values, marks={})
    shuffled = RunChannel(
        **{**shuffled.__dict__, "time_ns": time_ns[order], "values": values[order][:, None]}
    )
    table = resample(
        PoolRun(
            "v", "f", {"depth": shuffled}, (), (), int(time_ns[0]), int(time_ns[-1]), True, 0, 0
        ),
        7.0,
    )
    np.testing.assert_array_equal(table.values["depth"], ordered.values["depth"])


def test_wishes_that_cannot_be_met_are_refused() -> None:
    one = run(depth=depth(ticks(50, 10.0), np.arange(50.0)))
    with pytest.raises(CannotComputeError, match="no speed; the run has depth"):
        resample(one, 10.0, quantities=("speed",))
    for rate_hz in (0.0, -1.0, float("nan"), 1e9):
        with pytest.raises(CannotComputeError, match="no table"):
            resample(one, rate_hz)


def attitude(time_ns: IntArray, turn: Rotation) -> RunChannel:
    q = np.broadcast_to(turn.as_quat()[[3, 0, 1, 2]], (time_ns.size, 4)).copy()
    return channel("attitude", ("qw", "qx", "qy", "qz"), time_ns, q, marks={})


@given(angles=st.tuples(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-3, 3)))
def test_a_velocity_over_the_earth_is_turned_into_the_body(angles: tuple[float, ...]) -> None:
    time_ns, turn = ticks(20, 10.0), Rotation.from_euler("ZYX", angles)
    earth = np.tile([1.0, -2.0, 0.5], (20, 1))
    part = channel("velocity_earth", ("vn_mps", "ve_mps", "vd_mps"), time_ns, earth, marks={})
    table = resample(run(v=part, a=attitude(time_ns, turn)), 10.0)
    np.testing.assert_allclose(table.values["velocity"], turn.inv().apply(earth), atol=1e-12)
    assert table.notes == ("velocity: measured over the earth and turned by the attitude",)
    assert set(table.values) == {"attitude", "velocity"}


def test_thrusters_of_several_topics_come_in_the_order_of_the_vehicle_file() -> None:
    time_ns = ticks(30, 10.0)
    stern = channel("thruster_command", ("command.stern",), time_ns, np.full((30, 1), 7.0))
    bow = channel("thruster_command", ("command.bow",), time_ns[10:], np.full((20, 1), -3.0))
    shaft = channel("shaft_speed", ("shaft_speed_rpm.stern",), time_ns, np.full((30, 1), 900.0))
    whole = replace(run(a=stern, b=bow, c=shaft), thrusters=("bow", "spare", "stern"))
    table = resample(whole, 10.0)
    assert table.thrusters == ("bow", "spare", "stern")
    assert table.values["command"][20].tolist() == [-3.0, 0.0, 7.0]
    assert table.valid["command"].tolist() == [False] * 10 + [True] * 20
    np.testing.assert_array_equal(table.values["shaft_speed"][0], [np.nan, np.nan, 900.0])
    assert table.valid["shaft_speed"].all()
    assert table.notes == (
        "command: none in the log for spare; 0 is taken",
        "shaft_speed: none in the log for bow, spare; not measured",
    )


def test_readings_are_told_from_what_lies_between_them() -> None:
    time_ns = ticks(11, 5.0)
    table = resample(run(depth=depth(time_ns, np.arange(11.0), marks={}, delay_s=0.1)), 50.0)
    rows = np.flatnonzero(table.reading["depth"])
    # the first reading is older than the table
    np.testing.assert_array_equal(rows, np.arange(5, 100, 10))
    np.testing.assert_allclose(table.values["depth"][rows, 0], np.arange(1.0, 11.0))
    assert table.start_time_ns == time_ns[0]
    assert table.name == "f"
