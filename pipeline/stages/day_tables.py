"""The inverse characteristic -> the codes in force on a trial day, kept as history."""

import numpy as np

from pipeline.control.inverse import firmware_grid
from pipeline.errors import CannotComputeError
from pipeline.provenance import content_digest
from pipeline.records.fits import InverseCharacteristic
from pipeline.records.trial import DayTables
from pipeline.stages.job import Job, leaves_record

SPEEDS_MPS = (0.0, 0.5, 1.0, 1.5, 2.0)
#: Thrusts to either side for which codes are kept.
THRUSTS = 200


@leaves_record
def run(job: Job) -> DayTables:
    """Write the codes; a vehicle without tables leaves why."""
    empty = DayTables(vehicle=job.vehicle_name, day=job.output.stem)
    try:
        inverse = job.needed("inverse", InverseCharacteristic)
        grid = firmware_grid(inverse)
    except CannotComputeError as error:
        return empty.model_copy(update={"why_not": str(error)})
    limits = grid.limits(0.0)
    # a power of two: the same thrusts on two days, unless their tables are worlds apart
    largest = 2.0 ** np.ceil(np.log2(max(limits.forward_n, limits.reverse_n, 1e-3)))
    thrust = largest / THRUSTS * np.arange(-THRUSTS, THRUSTS + 1)
    rows = []
    for speed in SPEEDS_MPS:
        limits = grid.limits(speed)
        code = grid.code(thrust, speed)
        inside = (thrust <= limits.forward_n) & (thrust >= -limits.reverse_n)
        rows.append(
            tuple(
                round(float(one), 3) if there else None
                for one, there in zip(code, inside, strict=True)
            )
        )
    return empty.model_copy(
        update={
            "speed_mps": SPEEDS_MPS,
            "thrust_n": tuple(thrust.tolist()),
            "code": tuple(rows),
            "tables_sha256": content_digest([list(row) for row in rows]),
        }
    )
