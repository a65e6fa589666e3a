"""What the bench leaves uncertain of the thrust, as unknowns of the fit.

A factor for each thruster, of the standard uncertainty that the vehicle file states of thrust and
thrust deduction, and the shape of each characteristic at knots of the code, at rest and at speed
(docs/methods/identification.md). Small thrusts are where a bench is worst, and a factor cannot say
so. Fitted beside the parameters with this prior, they are integrated out (nuisance parameters;
Gelman et al. 2013, Bayesian Data Analysis, section 3.1).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pipeline.physics.parameters import read
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty

#: Correlation of the factors of two thrusters with one characteristic.
ALIKE = 0.5
#: Codes over the largest at which the curve may be off, and by how much of u at the largest thrust.
KNOTS = (0.1, 0.3, 0.6)
CURVE_SHARE = 0.25
#: The second of the speeds at which it may be, over the highest of the table; beyond it the same.
SPEED_KNOT = 0.5
#: Below so many standard deviations of its error a thrust is off in proportion: a thruster that
#: gives nothing in its dead zone gives nothing with another curve either.
_FULL_FROM = 2.0
_SMALLEST_FACTOR = 0.05


@dataclass(frozen=True)
class ThrustUncertainty:
    """Unknowns of the thrust (q,), counted in prior standard deviations.

    The first `gains` are the factors of the thrusters, in their order; then come the knots of each
    characteristic. `correlation` (q, q) is that of their prior; `curves` (q - gains, types, 2,
    speeds, codes) what one standard deviation of a knot adds to the tables of thrust [N].
    """

    share: float
    gains: int
    names: tuple[str, ...]
    errors_n: tuple[float, ...]
    """Standard deviation of each knot [N]."""
    correlation: FloatArray
    curves: FloatArray

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.names)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of each unknown."""
        return ("1",) * self.gains + ("N",) * len(self.errors_n)

    @property
    def scales(self) -> FloatArray:
        """Prior standard deviations (q,) in those units."""
        return np.concatenate([np.full(self.gains, self.share), self.errors_n])

    @property
    def lowest_step(self) -> float:
        """Smallest factor, in steps from 1."""
        return (_SMALLEST_FACTOR - 1.0) / self.share if self.gains else -np.inf

    @cached_property
    def precision(self) -> FloatArray:
        """Inverse of the prior's covariance (q, q)."""
        return np.asarray(np.linalg.inv(self.correlation), float)

    def write(self, vector: FloatArray, steps: FloatArray) -> None:
        """Write the factors of steps (q,) into a parameter vector, in place."""
        if self.gains:
            own = np.maximum(1.0 + self.share * steps[: self.gains], _SMALLEST_FACTOR)
            read(vector, "thrust_gain")[: self.gains] *= own

    def packed(self, packed: PackedVehicle, steps: FloatArray) -> PackedVehicle:
        """Return the vehicle with the curves of steps (q,)."""
        own = steps[self.gains :]
        if not own.any():
            return packed
        tables = packed.thrust_tables + np.einsum("k,ktsvc->tsvc", own, self.curves)
        return replace(packed, thrust_tables=tables)

    def factors(self) -> "ThrustUncertainty":
        """Return the factors of the thrusters alone."""
        count = self.gains
        names, correlation = self.names[:count], self.correlation[:count, :count]
        return ThrustUncertainty(self.share, count, names, (), correlation, self.curves[:0])

    def drawn(self, generator: np.random.Generator, largest: float) -> FloatArray:
        """Draw steps (q,) from the prior, none further out than `largest` before correlation."""
        draws = np.clip(generator.standard_normal(self.size), -largest, largest)
        if not self.size:
            return draws
        return np.asarray(np.linalg.cholesky(self.correlation) @ draws, float)


EXACT_THRUST = ThrustUncertainty(0.0, 0, (), (), np.zeros((0, 0)), np.zeros((0, 1, 2, 1, 1)))


def thrust_uncertainty(packed: PackedVehicle, uncertainty: Uncertainty) -> ThrustUncertainty:
    """Set up the unknowns of a vehicle's thrust; without doubt in the thrust there are none.

    Factors of all thrusters; knots of the characteristics whose thrust is static. Where the torque
    balance is solved in time the thrust is the propeller's, and has a factor alone.
    """
    bench, hull = uncertainty.thrust, packed.context.deduction_std or 0.0
    share, count = float(np.hypot(bench, hull)), len(packed.thruster_names)
    if share <= 0.0 or not count:
        return EXACT_THRUST
    kinds = read(packed.vector, "thruster_type")[:count].astype(int)
    alike = np.where(kinds[:, None] == kinds, ALIKE, 0.0)
    np.fill_diagonal(alike, 1.0)
    if hull > 0.0:
        alike = (bench**2 * alike + hull**2) / share**2
    in_time = read(packed.vector, "rotor_inertia")[:count] > 0.0
    names = [f"thrust_{name}" for name in packed.thruster_names]
    curves: list[FloatArray] = []
    errors_n: list[float] = []
    for kind in np.unique(kinds[~in_time]).tolist():
        first = int(np.flatnonzero(kinds == kind)[0])
        largest_code = float(read(packed.vector, "code_max")[first])
        error_n = CURVE_SHARE * bench * float(packed.thrust_tables[kind][:, 0].max())
        added = _curves(packed, kind, largest_code, error_n)
        names += [f"curve_{kind}_at_{place}" for place in added]
        errors_n += [error_n] * len(added)
        curves += added.values()
    correlation = np.eye(len(names))
    correlation[:count, :count] = alike
    shape = (0, *packed.thrust_tables.shape)
    return ThrustUncertainty(
        share,
        count,
        tuple(names),
        tuple(errors_n),
        correlation,
        np.stack(curves) if curves else np.zeros(shape),
    )


def _curves(
    packed: PackedVehicle, kind: int, largest_code: float, error_n: float
) -> dict[str, FloatArray]:
    """Compute what one standard deviation of each knot of a characteristic adds to the tables."""
    tables = packed.thrust_tables[kind]
    level = np.arange(tables.shape[2]) * packed.steps[kind, 1] / largest_code
    rows = tables.shape[1]
    under_way = np.minimum(np.arange(rows) / max(SPEED_KNOT * (rows - 1), 1.0), 1.0)
    speeds = {"rest": 1.0 - under_way, "speed": under_way} if rows > 1 else {"rest": np.ones(1)}
    found = {}
    for number, knot in enumerate(KNOTS):
        left = KNOTS[number - 1] if number else 0.0
        last = number + 1 == len(KNOTS)
        right = 1.0 if last else KNOTS[number + 1]
        # beyond the last knot the error stays; the factor says what is off at full code
        size = np.interp(level, [left, knot, right], [0.0, 1.0, 1.0 if last else 0.0])
        inside = error_n * size * np.minimum(tables / (_FULL_FROM * error_n), 1.0)
        for place, share in speeds.items():
            added = np.zeros_like(packed.thrust_tables)
            added[kind] = inside * share[:, None]
            found[f"{100 * knot:.0f}_%_{place}"] = added
    return found
