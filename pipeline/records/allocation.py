"""The allocator's wrench error map."""

from pipeline.records.base import Record
from pipeline.records.fits import Vector


class SpeedError(Record):
    """Wrench error at one speed: achieved less asked, as a fraction of the available range.

    The available range of a component at a speed is what the stern thrusters can make of it
    there: 4 T_max cos(delta) for surge, 2 T_max sin(delta) L_s for pitch and yaw, T_max the real
    thrust at the largest code; the error is divided by that one-sided value (`range_n_nm`), which
    is the stricter of the two readings (the range runs from minus to plus it). `worst` and `rms`
    are over surge, pitch and yaw of all demands that are within reach at this speed, need no
    thrust against the motion and leave no thruster inside the dead band of the inverse (0.5 N in
    the paper); `worst_with_dead_band` takes those in, `worst_opposed` is over the demands within
    reach that need thrust against the motion.
    """

    speed_mps: float
    worst: float
    rms: float
    worst_demand: Vector
    """(X_n, M_nm, N_nm) where the worst error occurs, SNAME."""
    reachable_share: float
    """Share of all demands that no limit or portion cuts at this speed."""
    opposed_share: float
    """Share of all demands that are within reach but need thrust against the motion."""
    worst_component: str = ""
    """"surge", "pitch" or "yaw"."""
    worst_asked: Vector = ()
    worst_achieved: Vector = ()
    """(X_n, M_nm, N_nm) at the worst demand."""
    worst_with_dead_band: float = 0.0
    worst_opposed: float = 0.0
    range_n_nm: Vector = ()
    """Available (X_n, M_nm, N_nm), one-sided."""


class AllocationMap(Record):
    """Errors with the mooring inverse and with the speed-compensated one, same demands.

    An error is the achieved value less what the variant asks for after its own
    portions and limits; the mooring variant's limit is that at rest at every speed.
    """

    form: str
    portions: Vector
    """Surge, heading, pitch."""
    mooring: tuple[SpeedError, ...]
    compensated: tuple[SpeedError, ...]
    speed_mps: Vector
    explanations: tuple[str, ...]
    mooring_inverse: str = ""
    compensated_inverse: str = ""
    thrust_dead_n: float = 0.5
