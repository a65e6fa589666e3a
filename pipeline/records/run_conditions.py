"""What is known of a run that its vehicle file does not say: bodies aboard, water, a cable's force.

Held in memory beside the table of the run. A fit simulates windows of a run; each has the
conditions of its stretch of time (`simulate.vector_under` makes parameters of them).
"""

from dataclasses import dataclass, replace

import numpy as np

from pipeline.types import FloatArray, IntArray


@dataclass(frozen=True)
class KnownBody:
    """Something put onto the vehicle of the file, or taken off (negative numbers).

    `mass_kg` in air, `volume_m3` the water that it displaces, `position_m` body axes;
    `inertia_kgm2` I_xx, I_yy, I_zz about its own centre.
    """

    name: str
    mass_kg: float
    volume_m3: float
    position_m: tuple[float, float, float]
    inertia_kgm2: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Conditions:
    """How a vehicle differs from its file for a while; `density_kgpm3` None: as in the file."""

    bodies: tuple[KnownBody, ...] = ()
    density_kgpm3: float | None = None
    gravity_mps2: float = 9.81

    @property
    def as_stated(self) -> bool:
        """Whether nothing differs."""
        return not self.bodies and self.density_kgpm3 is None


#: Conditions of a run of which nothing else is known.
AS_STATED = Conditions()


@dataclass(frozen=True)
class KnownOfRun:
    """What is known of a run, by its own time.

    `from_s` (k,) are the times from which `conditions` hold, the first at or before the first row;
    `force` (m, 6) is what acts on the vehicle from outside at every row of the table, body axes,
    about the origin: its cable's [N, N m]. `notes` are for whoever reads the result.
    """

    from_s: tuple[float, ...] = (0.0,)
    conditions: tuple[Conditions, ...] = (AS_STATED,)
    force: FloatArray | None = None
    notes: tuple[str, ...] = ()

    def at(self, time_s: float) -> Conditions:
        """Return the conditions at a time [s]."""
        place = int(np.searchsorted(self.from_s, time_s + 1e-9, side="right")) - 1
        return self.conditions[max(place, 0)]

    def rows_of_changes(self, time_s: FloatArray) -> IntArray:
        """Rows of a table with these times at which something else begins to hold."""
        rows = np.searchsorted(time_s, np.array(self.from_s[1:]) - 1e-9)
        return np.unique(rows[(rows > 0) & (rows < time_s.size)])

    def part(self, rows: slice, begin_s: float) -> "KnownOfRun":
        """Return what is known of some rows, counted from `begin_s` on. [s]."""
        return replace(
            self,
            from_s=tuple(one - begin_s for one in self.from_s),
            force=None if self.force is None else self.force[rows],
        )
