"""How well what may cause a motion explains it, however either of them is read.

The score is the share of a motion (velocity, angular acceleration) that its causes leave
unexplained. A motion may be read in other axes, by a matrix; causes, such as the efforts of
thrusters, act by arms, which may be exchanged; each axis has a gain of its own, which is not
negative. Sums of products are all it needs, so that any number of readings costs next to nothing.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from pipeline.ingest.pool_run_resample import TABLE_HZ
from pipeline.records.run_table import RunTable
from pipeline.types import BoolArray, FloatArray

#: Rows of a second.
SECOND = round(TABLE_HZ)
#: More rows say no more.
_ENOUGH_ROWS = 20_000
_NONE = 1e-9


@dataclass(frozen=True)
class Sums:
    """Sums of products of a motion (n, 3) with itself and with its causes (n, k), and of these."""

    motion: FloatArray
    along: FloatArray
    causes: FloatArray

    @classmethod
    def of(cls, motion: FloatArray, causes: FloatArray, *, centred: bool = False) -> "Sums":
        """Add up all rows, less their means where these say nothing."""
        if centred:
            motion, causes = motion - motion.mean(axis=0), causes - causes.mean(axis=0)
        return cls(motion.T @ motion, motion.T @ causes, causes.T @ causes)

    def power(self, arms: FloatArray) -> FloatArray:
        """Return the sum of squares of what causes do by these arms (3,)."""
        return np.asarray(np.einsum("ki,kl,li->i", arms, self.causes, arms))

    def gained(self, matrices: FloatArray, arms: FloatArray) -> FloatArray:
        """Return what causes with these arms (k, 3) explain of the motion by each matrix (c, 3)."""
        along = np.einsum("cij,jk,ki->ci", matrices, self.along, arms)
        power = self.power(arms)
        known = power > max(1e-4 * float(power.max()), _NONE)
        return np.asarray(
            np.where(known, np.maximum(along, 0.0) ** 2 / np.where(known, power, 1.0), 0.0)
        )

    def left_by_own_gains(self, arms: FloatArray, most: float) -> float:
        """Return the share of the motion that is left where causes have gains of their own.

        On each axis they are up to `most` times more or less than the common one.
        """
        from scipy.optimize import lsq_linear

        gained = 0.0
        for axis, power in enumerate(self.power(arms)):
            arm = arms[:, axis]
            common = float(self.along[axis] @ arm) / max(float(power), _NONE)
            acts = np.flatnonzero(np.abs(arm) > 1e-6 * np.abs(arms).max())
            if common <= 0.0 or not acts.size:
                continue
            both = self.causes[np.ix_(acts, acts)] * np.outer(arm[acts], arm[acts])
            root = np.linalg.cholesky(both + 1e-9 * np.trace(both) * np.eye(acts.size)).T
            along = arm[acts] * self.along[axis, acts]
            bounds = (common / most, common * most)
            gain = lsq_linear(root, np.linalg.solve(root.T, along), bounds).x
            gained += float(2.0 * along @ gain - gain @ both @ gain)
        return 1.0 - gained / max(float(np.trace(self.motion)), _NONE)


@dataclass(frozen=True)
class Meaning:
    """A reading by its share that is left, in the whole run and in its halves (3,)."""

    left: FloatArray
    how: str
    kind: str
    fitted: bool = True

    def is_plainly_better(self, than: "Meaning", most: float, most_of_half: float) -> bool:
        """Tell whether it leaves so much less, in the whole run and in each half of it."""
        whole = self.left[0] < most * than.left[0]
        return bool(whole and (self.left[1:] < most_of_half * than.left[1:]).all())


def left_of(
    references: Sequence[tuple[Sequence[Sums], FloatArray]], matrices: FloatArray
) -> FloatArray:
    """Return the share of a motion that is left by each matrix (c,), in each part (parts, c).

    A reference is sums over the parts of a run, and arms; on each axis the best of them counts.
    """
    found = []
    for part, first in enumerate(references[0][0]):
        total = np.einsum("cij,jk,cik->c", matrices, first.motion, matrices)
        gained = np.max([sums[part].gained(matrices, arms) for sums, arms in references], axis=0)
        found.append(1.0 - gained.sum(axis=1) / np.maximum(total, _NONE))
    return np.array(found)


def sums_of_parts(
    motion: FloatArray, causes: FloatArray, rows: BoolArray, *, centred: bool = False
) -> list[Sums]:
    """Return the sums over some rows, and over the first and the second half of them."""
    there = np.flatnonzero(rows)
    there = there[:: 1 + there.size // _ENOUGH_ROWS]
    half = there.size // 2
    return [
        Sums.of(motion[part], causes[part], centred=centred)
        for part in (there, there[:half], there[half:])
    ]


def mean_over(values: FloatArray | BoolArray, rows: int) -> FloatArray:
    """Return the mean of values (n, k) over so many rows about each; what is not known is 0."""
    from scipy.ndimage import uniform_filter1d

    there = np.nan_to_num(np.asarray(values, float))
    return np.asarray(uniform_filter1d(there, rows, axis=0, mode="constant"))


def rate_of(values: FloatArray) -> FloatArray:
    """Return the rate (n, k) over a second about each row of a table [1/s]; nan at its ends."""
    half, rate = SECOND // 2, np.full_like(values, np.nan)
    rate[half:-half] = (values[2 * half :] - values[: -2 * half]) * TABLE_HZ / (2.0 * half)
    return rate


def effort_of(table: RunTable) -> FloatArray:
    """Return what thrusters do (n, thrusters) by their commands, the largest of which is 1.

    Between a linear and a quadratic characteristic.
    """
    code = np.nan_to_num(table.values["command"])
    share = code / max(float(np.abs(code).max(initial=0.0)), _NONE)
    return np.asarray(share * np.sqrt(np.abs(share)))


def freed(others: FloatArray, *motions: FloatArray) -> list[FloatArray]:
    """Take out of motions (n, k) what others (n, j) explain, and their means."""
    others = others - others.mean(axis=0)
    scale = np.linalg.norm(others, axis=0)
    others = others[:, scale > 0.0] / scale[scale > 0.0]
    # what the others span, in orthonormal columns; those that say nothing new are dropped
    power, turn = np.linalg.eigh(others.T @ others)
    basis = others @ (turn[:, power > 1e-9] / np.sqrt(power[power > 1e-9]))
    away = [one - one.mean(axis=0) for one in motions]
    return [one - basis @ (basis.T @ one) for one in away]


def rearranged(arms: FloatArray, names: Sequence[str]) -> Iterator[tuple[str, FloatArray]]:
    """Yield arms (thrusters, k) with two exchanged or one turned round; those that differ."""
    changes = []
    for i, j in combinations(range(len(arms)), 2):
        changes.append((f"{names[i]} and {names[j]} are swapped", arms.copy()))
        changes[-1][1][[i, j]] = arms[[j, i]]
    for i, name in enumerate(names):
        changes.append((f"{name} is reversed", arms.copy()))
        changes[-1][1][i] *= -1.0
    yield from ((how, changed) for how, changed in changes if np.abs(changed - arms).max() > 1e-3)


def about_down(turn_deg: float) -> FloatArray:
    """Return the matrix that turns a vector about the vertical."""
    cos, sin = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
