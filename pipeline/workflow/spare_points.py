"""Mooring points that were read without fault and that a row of Table 3 has no use for."""

from dataclasses import dataclass
from pathlib import Path

from pipeline.errors import InputError
from pipeline.plan import VehicleFolder, processed_file
from pipeline.provenance import read_envelope
from pipeline.records.measurements import MooringRecord
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.supply_voltage import is_at_supply
from pipeline.workflow.cell import Cell

_SIGNS = {"positive": 1, "negative": -1}


@dataclass(frozen=True)
class SparePoints:
    """Points of one sign of code that are not fitted.

    `dead` of them gave `thrust_dead_n` [N] or less, `other_supply` were taken at another supply
    voltage than the tables are for.
    """

    thrust_dead_n: float
    dead: int
    other_supply: int


def spare_points(cell: Cell, vehicle: VehicleFolder, out: Path) -> SparePoints | None:
    """Count them for a number of Table 3; None for any other, and where nothing can be counted."""
    sign = _SIGNS.get(cell.path.partition(".")[2].partition("[")[0])
    if cell.table != "table3" or sign is None:
        return None
    try:
        tables = load_vehicle(out / vehicle.vehicle_file).tables
        path = out / processed_file(vehicle.name, "mooring")
        record = read_envelope(path, "mooring", MooringRecord).record
    except InputError:
        return None
    if record is None:
        return None
    own = [one for one in record.points if not one.marks and sign * one.code > 0]
    near = [one for one in own if is_at_supply(one.voltage_v, tables.supply_voltage_v)]
    dead = sum(sign * one.thrust_n <= tables.thrust_dead_n for one in near)
    return SparePoints(tables.thrust_dead_n, dead, len(own) - len(near))
