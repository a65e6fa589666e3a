"""Several thrusters in one file: each apart, compared, and one that differs left out of the fit."""

from collections import defaultdict
from collections.abc import Iterable, Sequence

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

    `tables` are places, each with the name of its thruster, if any. Returns the same points, each
    with its thruster.
    """
    named = [at for at, (_, name) in enumerate(tables) if name is not None and points[at]]
    done = list(points)
    if len(named) < 2:
        _compare_sheets(tables, points, problems)
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


def _compare_sheets(
    tables: Sequence[tuple[Place, str | None]],
    points: Sequence[tuple[MooringPoint, ...]],
    problems: list[Problem],
) -> None:
    """Warn of tables of one voltage that differ: they may be of several thrusters."""
    if sum(map(bool, points)) < 2:
        return
    by_voltage: dict[float | None, list[int]] = defaultdict(list)
    for at, own in enumerate(points):
        volts = [point.voltage_v for point in own if point.voltage_v is not None]
        if own:
            by_voltage[round(float(np.median(volts))) if volts else None].append(at)
    for group in by_voltage.values():
        curves = {at: _by_code(points[at]) for at in group}
        shares = {at: _share(curve, curves.values()) for at, curve in curves.items()}
        odd = {at: share for at, share in shares.items() if abs(share - 1.0) > _ALIKE}
        if len(group) > 1 and odd:
            at = max(odd, key=lambda one: abs(odd[one] - 1.0))
            problems.append(
                Problem(
                    "warning",
                    tables[at][0],
                    f"this table gives {odd[at]:.2f} of the thrust that the tables of the file "
                    "give in the middle; all of them are fitted together.",
                    "tables of one thruster, at one voltage, in one water.",
                    "Leave the others out by columns: {mooring: {sheets: [...]}} in vehicle.yaml.",
                )
            )


def _share(curve: dict[float, float], others: Iterable[dict[float, float]]) -> float:
    """Return the thrust of one table over the middle one of all, at the codes of both."""
    every = list(others)
    middle = {code: float(np.median([one[code] for one in every if code in one])) for code in curve}
    largest = max((abs(value) for value in middle.values()), default=0.0)
    ratios = [
        thrust / middle[code]
        for code, thrust in curve.items()
        if abs(middle[code]) > _LARGE * largest
    ]
    return float(np.median(ratios)) if ratios else 1.0


def _by_code(points: Sequence[MooringPoint]) -> dict[float, float]:
    thrust: dict[float, list[float]] = defaultdict(list)
    for point in points:
        if not point.marks:
            thrust[point.code].append(point.thrust_n)
    return {code: float(np.mean(values)) for code, values in thrust.items()}
