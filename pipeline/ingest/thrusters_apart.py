"""Several thrusters in one file: each apart, compared, and one that differs left out of the fit."""

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from pipeline.errors import Place, Problem
from pipeline.records.measurements import MooringPoint

#: Specimens of one type differ by a few per cent.
_ALIKE = 0.1
_LARGE = 0.2
DIFFERS = "thruster differs"


def compare_thrusters(
    tables: Sequence[tuple[Place, str | None]],
    points: Sequence[tuple[MooringPoint, ...]],
    problems: list[Problem],
) -> list[tuple[MooringPoint, ...]]:
    """Compare the thrusters of a file with their median, and mark those that differ.

    Parameters
    ----------
    tables : sequence of (Place, str or None)
        Each table, and the thruster that it is of.
    points : sequence of tuple of MooringPoint
        Of each table.
    problems : list of Problem
        What was found is added here.

    Returns
    -------
    list of tuple of MooringPoint
        The same points, each with its thruster.
    """
    named = [at for at, (_, name) in enumerate(tables) if name is not None and points[at]]
    done = list(points)
    if len(named) < 2:
        return done
    curves = [_by_code(points[at]) for at in named]
    codes = sorted(set.intersection(*(set(curve) for curve in curves)))
    thrust = np.array([[curve[code] for code in codes] for curve in curves])
    if not thrust.size:
        return done
    middle = np.median(thrust, axis=0)
    large = np.abs(middle) > _LARGE * np.abs(middle).max()
    shares = np.median(thrust[:, large] / middle[large], axis=1)
    for at, share in zip(named, shares.tolist(), strict=True):
        place, name = tables[at]
        differs = abs(share - 1.0) > _ALIKE
        if differs:
            problems.append(
                Problem(
                    "warning",
                    place,
                    f'thruster "{name}" gives {share:.2f} of the thrust of the others; kept but '
                    "not fitted.",
                    "thrusters of one type within 10 %.",
                    "Choose one in vehicle.yaml: columns: {mooring: {thrust: {header: ...}}}.",
                )
            )
        done[at] = tuple(
            point.model_copy(
                update={
                    "thruster": name,
                    "marks": (*point.marks, DIFFERS) if differs else point.marks,
                }
            )
            for point in points[at]
        )
    if len(named) > 1 and not any(abs(share - 1.0) > _ALIKE for share in shares):
        what = f"{len(named)} thrusters, {min(shares):.2f} to {max(shares):.2f} of their median; "
        what += "fitted together."
        problems.append(Problem("note", Place(tables[0][0].file), what))
    return done


def _by_code(points: Sequence[MooringPoint]) -> dict[float, float]:
    thrust: dict[float, list[float]] = defaultdict(list)
    for point in points:
        if not point.marks:
            thrust[point.code].append(point.thrust_n)
    return {code: float(np.mean(values)) for code, values in thrust.items()}
