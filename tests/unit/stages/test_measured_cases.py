"""The cases on measured data: who takes part in what, and what is done to a log or a model."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import pack_vehicle
from pipeline.stages.measured_withheld_cases import (
    FOLDS,
    WEAK,
    Injection,
    all_cases,
    buoyant,
    loaded,
    weak_thruster,
)
from pipeline.stages.measured_withheld_runs import (
    _raised_codes,
    altered_model,
    logs_named,
)
from pipeline.stages.measured_withheld_table import outcome, table, with_table
from pipeline.stages.simulated_vehicle import SimulatedVehicle
from pipeline.vehicle.load import load_vehicle


@pytest.fixture(scope="module")
def rov(repository: Path) -> SimulatedVehicle:
    folder = repository / "tests/acceptance/exjobbrov"
    vehicle = load_vehicle(folder)
    return SimulatedVehicle("exjobbrov", folder, vehicle, pack_vehicle(vehicle), ())


def test_no_run_takes_part_twice() -> None:
    for folds in FOLDS.values():
        for fold in folds:
            every = (*fold.fit, *fold.runs, *fold.healthy)
            assert len(set(every)) == len(every)


def test_cases_are_told_apart_and_altered_models_have_no_healthy_runs() -> None:
    cases = all_cases()
    assert len({case.key for case in cases}) == len(cases)
    assert not [case.key for case in cases if case.injection.in_the_model and case.healthy]
    assert [case for case in cases if case.injection.truth is None]


def test_raised_codes_say_more_thrust_than_acted(rov: SimulatedVehicle) -> None:
    """The model gives for them what it gave for the logged ones over `WEAK`, up to full code."""
    packed = rov.packed
    i = packed.thruster_names.index("surge_left")
    codes = np.zeros((81, len(packed.thruster_names)))
    codes[:, i] = np.linspace(-400.0, 400.0, 81)
    codes[:, 0] = 77.0
    run = RunTable("run", 0.02 * np.arange(81), {"command": codes}, {"command": np.ones(81, bool)})
    raised = _raised_codes(run, packed, "surge_left").values["command"]
    np.testing.assert_array_equal(raised[:, 0], codes[:, 0])
    kind = int(read(packed.vector, "thruster_type")[i])

    def thrust(values: np.ndarray) -> np.ndarray:
        every = packed.steps[kind, 1] * np.arange(packed.thrust_tables.shape[3])
        ahead, astern = (
            np.interp(np.abs(values), every, packed.thrust_tables[kind, s, 0]) for s in (0, 1)
        )
        return np.where(values >= 0.0, ahead, -astern)

    full = np.abs(raised[:, i]) >= 400.0
    assert 0 < full.sum() < 40
    wanted = thrust(codes[:, i]) / WEAK
    assert thrust(raised[:, i])[~full] == pytest.approx(wanted[~full], abs=0.02)
    assert (np.abs(thrust(raised[:, i]))[full] <= np.abs(wanted[full]) + 1e-9).all()


def test_the_model_is_altered_the_other_way_round(rov: SimulatedVehicle) -> None:
    def slot(injection: Injection, name: str) -> np.ndarray:
        return np.asarray(read(altered_model(rov, injection)[1].vector, name))

    stated = rov.packed.vector
    assert slot(buoyant(8.0), "buoyancy") == pytest.approx(read(stated, "buoyancy") - 8.0)
    lighter = slot(loaded(0.8), "weight") - read(stated, "weight")
    assert lighter == pytest.approx(-0.8 * rov.vehicle.water.gravity_mps2)
    gains = slot(weak_thruster("vertical_rear"), "thrust_gain")[:6]
    weak = rov.packed.thruster_names.index("vertical_rear")
    assert gains[weak] == pytest.approx(1.0 / WEAK)
    assert np.delete(gains, weak).tolist() == [1.0] * 5


def line(effects: list[str], **other: Any) -> dict[str, Any]:  # noqa: ANN401
    detail = {"thruster": other.pop("found", None), "axes": []}
    verdict = {"effects": effects, "probability": 0.9, "ambiguous_with": [], "detail": detail}
    shrink = {"before": 2.0, "after": 1.0}
    return {
        "subject": "tank",
        "fold": "12_09",
        "injected": "as it is",
        "truth": None,
        "thruster": None,
        "value": {},
        "healthy": True,
        "hidden": [],
        "verdict": verdict | other.pop("verdict", {}),
        "rank": 1,
        "found": None,
        "shrink": shrink,
        "elapsed_s": 3.2,
    } | other


@pytest.mark.parametrize(
    ("one", "said"),
    [
        (line(["none"]), "right"),
        (line(["current"]), "other"),
        (line(["unknown"]), "unknown"),
        (line(["dvl_scale"], truth="dvl_scale"), "right"),
        (line(["current", "dvl_scale"], truth="dvl_scale"), "right among others"),
        (
            line(["none"], truth="dvl_scale", verdict={"ambiguous_with": ["dvl_scale"]}),
            "in the group",
        ),
        (
            line(["thruster_degraded"], truth="thruster_degraded", thruster="a", found="b"),
            "right effect, other thruster",
        ),
        (line(["none"], refused="no time to speak of"), "refused"),
        (line(["none"], noise={"attitude": 0.0, "velocity": 0.0}), "ran away"),
    ],
)
def test_what_came_of_a_case(one: dict[str, Any], said: str) -> None:
    assert outcome(one) == said
    assert f": {said} 1." in table([one])


@pytest.mark.parametrize("name", ["scale", "dvl_scale.scale"])
def test_the_value_found_is_told_beside_another_effect_too(name: str) -> None:
    found = {"parameters": {name: {"value": 0.911, "ci95": [0.891, 0.93]}}}
    one = line(["dvl_scale", "lift"], truth="dvl_scale", value={"scale": 0.9})
    assert "| scale 0.911 (0.891 to 0.93; true 0.9) |" in table([one | {"found": found}])


def test_the_table_of_a_page_is_replaced_and_nothing_else() -> None:
    page = "# Head\n<!-- the table -->\nold\n<!-- end of the table -->\ntail\n"
    new = with_table(page, table([line(["none"])]))
    assert new.startswith("# Head\n<!-- the table -->\n| vehicle, run |")
    assert new.endswith("right 1.\n<!-- end of the table -->\ntail\n")
    assert "old" not in new
    assert with_table(new, table([line(["none"])])) == new
    with pytest.raises(ValueError, match="no place for a table"):
        with_table("# Head\n", "")


def test_a_name_must_fit_one_log() -> None:
    logs = [Path("a_1.mcap"), Path("a_2.mcap"), Path("b.mcap")]
    assert logs_named(["b", "a_2"], logs) == [logs[2], logs[1]]
    with pytest.raises(CannotComputeError, match="2 logs begin with a"):
        logs_named(["a"], logs)
