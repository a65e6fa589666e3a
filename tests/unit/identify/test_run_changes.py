"""Two bundled zig-zags, one with a thruster at 0.7: that is found, and no other thruster."""

from pathlib import Path

import pytest
from bundled_models import bundled, mmt300_bench

from pipeline.identify.run_changes import changes_between
from pipeline.inputs.runs_to_identify import read_run
from pipeline.inputs.simulated_vehicle import SimulatedVehicle
from pipeline.simulate.context import model_of
from pipeline.simulate.pack import pack_vehicle
from pipeline.vehicle.sensor_schema import Sensors


def test_the_weak_thruster_is_found_between_two_runs(
    repository: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    vehicle = bundled(repository, "mmt300")
    packed = pack_vehicle(vehicle, mmt300_bench(repository, tmp_path_factory))
    raw = repository / "raw"
    one = SimulatedVehicle("mmt300", raw / "mmt300/vehicle.yaml", vehicle, packed, ())
    days = ("2024-05-14-zig-zag", "2024-05-15-zig-zag")
    runs = [read_run(raw / f"mmt300/pool/{day}.mcap", one, raw)[1].rows(0, 2000) for day in days]
    found = changes_between(
        packed, vehicle.sensors or Sensors(), runs[:1], runs[1:], model_of(vehicle).uncertainty
    )
    first = max(found.changes, key=lambda change: change.gain)
    assert (first.shift.kind, first.shift.name) == ("thruster", "upper")
    assert (first.base + first.value) / first.base == pytest.approx(0.70, abs=0.05)
    # the others were asked, beside it, and are as they were
    others = {c.shift.name: c for c in found.asked if c.shift.kind == "thruster"}
    assert all(others[name].p_value > 0.05 for name in ("lower", "left", "right"))
