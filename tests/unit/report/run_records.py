"""A pool run of made-up curves, as its page takes it."""

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.records.pool_run import ChannelRead, ChannelSummary, ClockRead, TopicRead
from pipeline.records.run_table import COMPONENTS, RunTable
from pipeline.records.trial import ChannelError, ManoeuvreFound, RunTrial, StoredRun
from pipeline.report.results import RunResults
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Vehicle

RATE_HZ = 20.0
#: Quantity -> columns in a table.
COLUMNS = {
    "velocity": 3, "angular_velocity": 3, "attitude": 4, "depth": 1, "position": 3,
    "specific_force": 3, "voltage": 1,
}  # fmt: skip


def run_results(vehicle: Vehicle, *, seconds: float = 20.0, name: str = "zig-zag") -> RunResults:
    """Every channel at 20 Hz, noisy, so that nothing can be packed well."""
    generator = np.random.default_rng(1)
    time_s = np.arange(0.0, seconds, 1 / RATE_HZ)
    thrusters = tuple(one.name for one in vehicle.thrusters)

    def columns(count: int, size: float) -> FloatArray:
        waves = np.sin(0.3 * time_s[:, None] + np.arange(count))
        return waves + size * generator.standard_normal((time_s.size, count))

    def attitude(size: float) -> FloatArray:
        own = 0.05 * columns(4, size) + np.array([1.0, 0.0, 0.0, 0.0])
        return np.asarray(own / np.linalg.norm(own, axis=1, keepdims=True))

    def table(size: float) -> RunTable:
        values = {one: columns(count, size) for one, count in COLUMNS.items()}
        values["attitude"] = attitude(size)
        values["shaft_speed"] = 900 * columns(len(thrusters), size)
        values["command"] = 90 * np.sign(columns(len(thrusters), 0.0))
        everywhere = {one: np.ones(time_s.size, bool) for one in values}
        return RunTable(name, time_s, values, everywhere, thrusters=thrusters)

    return RunResults(
        vehicle=vehicle,
        vehicle_name="boat",
        run=name,
        shown_path=f"raw/boat/pool/{name}.mcap",
        stored=_stored(name, seconds),
        trial=RunTrial(
            vehicle="boat", run=name, day="2026-05-04", start_time_ns=0, duration_s=seconds,
            horizon_s=10.0, lead_s=2.5, windows=int(seconds / 10), channels=_errors(thrusters),
            manoeuvres=(
                ManoeuvreFound(
                    name="zig_zag", from_s=2.0, to_s=0.8 * seconds,
                    sentence="20 deg to either side",
                ),
            ),
            warnings=("Over 10 s the model predicts u worse than holding the last reading.",),
        ),
        measured=table(0.1),
        windows=table(0.05),
        files=(("Log with measured and simulated channels (MCAP)", "../../../x.mcap"),),
        provenance={"rig2sea": "0.1.0"},
    )  # fmt: skip


def _errors(thrusters: tuple[str, ...]) -> tuple[ChannelError, ...]:
    return tuple(
        ChannelError(
            channel=channel, quantity=quantity, unit=unit, readings=400, sensor_noise=0.1,
            rmse_windows=0.2, mean_windows=0.01, worst_windows=0.7, worst_at_s=3.0,
            rmse_last_value=0.5,
        )
        for quantity, named in COMPONENTS.items()
        for channel, unit in (named or tuple((thruster, "rpm") for thruster in thrusters))
    )  # fmt: skip


def _stored(name: str, seconds: float) -> StoredRun:
    read = ChannelRead(
        quantity="velocity", topic="/dvl/velocity", message_type="geometry_msgs/TwistStamped",
        encoding="cdr", fields=("twist.linear.x",), unit="m/s", unit_from="message",
        mapped_by="default",
    )  # fmt: skip
    return StoredRun(
        vehicle="boat", file=f"boat/pool/{name}.mcap", start_time_ns=1_777_000_000_000_000_000,
        duration_s=seconds, complete=True, read_bytes=1, size_bytes=1_000_000,
        channels=(
            ChannelSummary(
                name="velocity", read=read, clock=ClockRead(used="header", why="stated"),
                columns=("u", "v", "w"), readings=100, rate_hz=5.0, is_regular=True, delay_s=0.0,
                first_s=0.0, last_s=seconds, longest_gap_s=0.3, marks={"gap": 4}, lowest=(0.0,),
                highest=(1.0,),
            ),
        ),
        topics=(
            TopicRead(
                topic="/a/topic/with/a/name/that/is/longer/than/a/telephone/is/wide",
                message_type="std_msgs/msg/String", encoding="cdr", messages=3,
            ),
        ),
        problems=(
            Problem(
                severity="warning", place=Place(file=f"boat/pool/{name}.mcap"), what="a gap of 3 s",
                expected="readings all the time", remedy="Look at the cable.",
            ),
        ),
        run=name, day="2026-05-04", table_rate_hz=RATE_HZ, quantities=tuple(COLUMNS), files={},
    )  # fmt: skip
