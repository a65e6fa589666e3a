"""Why the points that were read are more than those that a row of Table 3 was fitted to."""

from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.commands.why import as_text
from pipeline.plan import VehicleFolder
from pipeline.provenance import Envelope, write_envelope
from pipeline.records.base import Source
from pipeline.records.measurements import MooringPoint, MooringRecord
from pipeline.workflow.cell import Cell
from pipeline.workflow.why import Link, SparePoints, Why, spare_points

BOAT = VehicleFolder("boat", "raw/boat")
VEHICLE = """\
name: boat
title: boat
water: {density_kgpm3: 1000.0, gravity_mps2: 9.81}
propellers: {p: {diameter_m: 0.1}}
drives: {d: {code_min: -127, code_max: 127}}
tables: {propeller: p, drive: d, supply_voltage_v: 48.0, thrust_dead_n: 0.5}
"""
POSITIVE = Cell("table3", "table3.positive[1]", 4.3, unit="code/N")


def point(code: float, thrust_n: float, volts: float = 48.0, *marks: str) -> MooringPoint:
    source = Source(file="boat/mooring/a.csv", sheet=None, row=1)
    return MooringPoint(
        source=source, code=code, thrust_n=thrust_n, voltage_v=volts, sweep="up", marks=marks
    )


@pytest.fixture
def out(tmp_path: Path) -> Path:
    (tmp_path / "raw/boat").mkdir(parents=True)
    (tmp_path / "raw/boat/vehicle.yaml").write_text(VEHICLE)
    (tmp_path / "processed/boat").mkdir(parents=True)
    points = (
        point(0.0, 0.0, 48.0, "zero reading"),
        point(10.0, -0.1),
        point(12.0, 0.5),
        point(20.0, 1.9),
        point(30.0, 4.0, 48.0, "commented out"),
        point(40.0, 5.0, 36.0),
        point(-10.0, -0.2),
        point(-20.0, -1.5),
    )
    record = MooringRecord(points=points, sheets=(), problems=())
    write_envelope(
        tmp_path / "processed/boat/mooring.json", Envelope("mooring", "boat", {}, "c0", record)
    )
    return tmp_path


def test_points_of_little_thrust_and_of_another_supply_are_counted_apart(out: Path) -> None:
    assert spare_points(POSITIVE, BOAT, out) == SparePoints(0.5, dead=2, other_supply=1)
    negative = replace(POSITIVE, path="table3.negative[0]")
    assert spare_points(negative, BOAT, out) == SparePoints(0.5, dead=1, other_supply=0)


def test_nothing_is_counted_where_nothing_can_be(out: Path) -> None:
    assert spare_points(Cell("table4", "table4.KN1[0]", 3.0), BOAT, out) is None
    (out / "processed/boat/mooring.json").unlink()
    assert spare_points(POSITIVE, BOAT, out) is None


def test_they_are_told_beside_the_fit() -> None:
    chain = Link("p", "tables", "tables", "0", "0", "c", "c", "now", None, (), (), ())
    text = as_text(Why("boat", POSITIVE, chain, SparePoints(0.5, dead=2, other_supply=1)))
    assert "not fitted: 2 of the dead thrust of 0.5 N or less (tables.thrust_dead_n)" in text
    assert "not fitted: 1 at another supply voltage" in text
