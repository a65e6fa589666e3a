"""The allocator's wrench error map."""

from pipeline.records.base import Record
from pipeline.records.fits import Matrix, Vector


class SpeedError(Record):
    """Wrench error at one speed: achieved less asked, as a fraction of the available range."""

    speed_mps: float
    worst: float
    rms: float
    worst_demand: Vector
    """(X_n, M_nm, N_nm) where the worst error occurs, SNAME."""
    reachable_share: float
    opposed_share: float
    """Share of the demands that need thrust against the motion; they are scored apart."""


class AllocationMap(Record):
    """Errors with the mooring inverse and with the speed-compensated one, same demands.

    `surge_*` are slices for the picture: error of surge force at pitch = yaw = 0, indexed
    [speed][demand]; `yaw_*` the error of the yaw moment at half of the surge range.
    """

    form: str
    portions: Vector
    mooring: tuple[SpeedError, ...]
    compensated: tuple[SpeedError, ...]
    speed_mps: Vector
    surge_demand_n: Vector
    surge_error_mooring: Matrix
    surge_error_compensated: Matrix
    yaw_demand_nm: Vector
    yaw_error_mooring: Matrix
    yaw_error_compensated: Matrix
    explanations: tuple[str, ...]
