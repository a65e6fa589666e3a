"""Measured tank runs with something withheld: what is injected, and plain refusals."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.diagnose.engine import diagnose
from pipeline.diagnose.kinematics.instruments import instrument_errors
from pipeline.errors import Rig2SeaError
from pipeline.records.run_table import RunTable
from pipeline.stages.measured_withheld_cases import (
    AS_IT_IS,
    TANK,
    Injection,
    WithheldCase,
    read_wrong,
)
from pipeline.stages.measured_withheld_runs import (
    altered_run,
    case_to_diagnose,
    logs_named,
    logs_of,
)
from pipeline.stages.simulated_vehicle import SimulatedVehicle, load_simulated

#: The vehicle as its file states it: nothing is identified for these.
CASE = WithheldCase("tank", TANK[0], AS_IT_IS, healthy=False)


@pytest.fixture(scope="module")
def rov(repository: Path) -> SimulatedVehicle:
    return load_simulated(str(repository / "tests/acceptance/brov2_tank"), Path("raw"), Path())


@pytest.fixture(scope="module")
def logs(
    shared_data: Path, repository: Path, tmp_path_factory: pytest.TempPathFactory
) -> list[Path]:
    if not list((shared_data / "brov2_tank_mocap").glob("*.npz")):
        pytest.skip("no tank runs")
    converter = repository / "docs/examples/brov2_tank_to_mcap.py"
    return logs_of("tank", shared_data, tmp_path_factory.mktemp("tank"), converter)


def altered(case: WithheldCase, rov: SimulatedVehicle, logs: list[Path]) -> RunTable:
    (path,) = logs_named(case.fold.runs, logs)
    return altered_run(path, rov, path.parent.parent, case, inject=True)


@pytest.mark.parametrize(("scale", "delay_s"), [(1.1, 0.0), (0.9, 0.0), (1.0, 0.15), (1.0, 0.3)])
def test_the_velocity_is_wrong_by_what_is_withheld(
    rov: SimulatedVehicle, logs: list[Path], scale: float, delay_s: float
) -> None:
    """The way by the velocity against that by the position, which is left alone."""
    plain = altered(CASE, rov, logs)
    wrong = altered(replace(CASE, injection=read_wrong(scale, delay_s)), rov, logs)
    for name in set(plain.values) - {"velocity"}:
        np.testing.assert_array_equal(wrong.values[name], plain.values[name])
    late = round(delay_s / 0.02)
    count = plain.time_s.size - late
    both = plain.valid["velocity"][:count] & wrong.valid["velocity"][late:]
    assert both.mean() > 0.9
    before = plain.values["velocity"][:count][both]
    after = wrong.values["velocity"][late:][both]
    # readings lie between the samples of the table: half a sample of the fastest change
    step = np.abs(np.diff(plain.values["velocity"], axis=0))
    assert np.abs(after - scale * before).max() <= np.nanmax(step) + 1e-12
    if delay_s == 0.0:
        quaternion = plain.values["attitude"][:, [1, 2, 3, 0]]
        good = wrong.valid["velocity"] & wrong.valid["position"] & wrong.valid["attitude"]
        earth = Rotation.from_quat(quaternion[good]).apply(wrong.values["velocity"][good])
        moved = np.gradient(wrong.values["position"], wrong.time_s, axis=0)[good]
        ratio = (earth[:, :2] * moved[:, :2]).sum() / (moved[:, :2] ** 2).sum()
        plainly = Rotation.from_quat(quaternion[good]).apply(plain.values["velocity"][good])
        stated = (plainly[:, :2] * moved[:, :2]).sum() / (moved[:, :2] ** 2).sum()
        assert ratio / stated == pytest.approx(scale, abs=1e-9)


@pytest.mark.parametrize(
    ("case", "told"),
    [
        (replace(CASE, most_s=20.0), "last 20 s in all, and a diagnosis needs at least 30 s"),
        (replace(CASE, hidden=("command",)), "no commands of the thrusters were recorded"),
        (
            replace(CASE, hidden=("velocity", "position", "attitude", "angular_velocity", "depth")),
            "no channel that a fit can use was measured",
        ),
    ],
)
def test_hopeless_measured_runs_get_the_reason(
    rov: SimulatedVehicle, logs: list[Path], case: WithheldCase, told: str
) -> None:
    with pytest.raises(Rig2SeaError, match=told):
        diagnose(case_to_diagnose(case, rov, logs), threads=1)


@pytest.mark.parametrize(
    ("injection", "effect"),
    [
        (AS_IT_IS, None),
        (read_wrong(1.1), "dvl_scale"),
        (read_wrong(0.9), "dvl_scale"),
        (read_wrong(delay_s=0.15), "dvl_delay"),
        (read_wrong(delay_s=0.3), "dvl_delay"),
    ],
)
@pytest.mark.parametrize("healthy", [False, True])
def test_dead_reckoning_knows_what_is_wrong_with_the_velocity(
    rov: SimulatedVehicle,
    logs: list[Path],
    injection: Injection,
    effect: str | None,
    healthy: bool,
) -> None:
    case = case_to_diagnose(replace(CASE, injection=injection, healthy=healthy), rov, logs)
    found = instrument_errors(case.vehicle, case.packed, case.candidates, case.runs, case.healthy)
    if effect is None:
        assert found is None
        return
    assert found is not None
    assert found.effects == (effect,)
    for name, value in injection.value.items():
        low, high = found.parameters[effect][name].ci95
        assert low < value < high
        assert high - low < 0.15


def test_a_wrong_velocity_is_named_beside_what_the_vehicle_of_the_literature_lacks(
    rov: SimulatedVehicle, logs: list[Path]
) -> None:
    """Another exemplar, an autopilot in between, a tether: no effect explains what is left."""
    case = replace(CASE, fold=TANK[1], injection=read_wrong(1.1))
    found = diagnose(case_to_diagnose(case, rov, logs), threads=1)
    assert found.verdict.effects == ("dvl_scale", "unknown")
    assert max(found.leftover.axes.values()) > 3.0
    assert any("no healthy runs" in note for note in found.notes)
