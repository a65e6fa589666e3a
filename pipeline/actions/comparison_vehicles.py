"""Two vehicle files and their firmware tables -> what they state otherwise, codes that changed."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.actions.comparison_sides import FoundSide
from pipeline.control.inverse import firmware_grid
from pipeline.errors import CannotComputeError, InputError
from pipeline.plan import processed_file
from pipeline.provenance import read_envelope
from pipeline.records.comparison import CodeChange, Curve, Difference
from pipeline.records.fits import InverseCharacteristic


def vehicle_differences(first: FoundSide, second: FoundSide, out: Path) -> dict[str, Any]:
    """Compare what vehicle files state, and codes of their tables; fields of the `Comparison`."""
    assert first.vehicle is not None  # noqa: S101 - a vehicle file was read
    assert second.vehicle is not None  # noqa: S101 - a vehicle file was read
    stated = [
        dict(_leaves(found.vehicle.model_dump())) for found in (first, second) if found.vehicle
    ]
    differences = []
    for key in dict.fromkeys([*stated[0], *stated[1]]):
        a, b = stated[0].get(key), stated[1].get(key)
        if a == b:
            continue
        ratio = b / a if a is not None and b is not None and a * b > 0.0 else None
        share = f", {ratio:.3g} times" if ratio is not None else ""
        shown = ["not stated" if one is None else f"{one:g}" for one in (a, b)]
        differences.append(
            Difference(
                kind="stated",
                what=key,
                unit="",
                a=a,
                b=b,
                ratio=ratio,
                text=f"{key}: {shown[0]} in A, {shown[1]} in B{share}.",
            )
        )
    codes, count, curve, why = _codes(first, second, out)
    return {
        "cautions": why,
        "differences": tuple(differences),
        "codes": codes,
        "codes_compared": count,
        "curves": curve,
    }


def _leaves(value: object, at: str = "") -> Iterator[tuple[str, float]]:
    """Yield every number that a file states, by its key."""
    if isinstance(value, dict):
        for key, inner in value.items():
            if key not in {"name", "published"}:
                yield from _leaves(inner, f"{at}.{key}" if at else str(key))
    elif isinstance(value, list | tuple):
        for number, inner in enumerate(value):
            label = inner.get("name") if isinstance(inner, dict) else None
            yield from _leaves(inner, f"{at}[{label or number}]")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield at, float(value)


def _codes(
    first: FoundSide, second: FoundSide, out: Path
) -> tuple[tuple[CodeChange, ...], int, tuple[Curve, ...], tuple[str, ...]]:
    """Compare the codes at rest of both sides' tables, at 201 thrusts that both reach."""
    grids = []
    for found in (first, second):
        path = out / processed_file(found.side.vehicle, "inverse")
        try:
            envelope = read_envelope(path, "inverse", InverseCharacteristic)
            if envelope.record is not None:
                grids.append(firmware_grid(envelope.record))
        except (InputError, CannotComputeError, OSError):
            pass
        if not grids or len(grids) < 1 + (found is second):
            why = f"{found.side.vehicle} has no tables, so no codes are compared."
            return (), 0, (), (why,)
    limits = [grid.limits(0.0) for grid in grids]
    thrust = np.linspace(
        -min(one.reverse_n for one in limits), min(one.forward_n for one in limits), 201
    )
    a, b = (np.asarray(grid.code(thrust, 0.0), float) for grid in grids)
    changed = tuple(
        CodeChange(thrust_n=float(t), a=int(x), b=int(y))
        for t, x, y in zip(thrust, np.rint(a), np.rint(b), strict=True)
        if x != y
    )
    values = [tuple(one.tolist()) for one in (thrust, a, b)]
    curve = Curve(
        title="Code against thrust at rest",
        x_label="thrust  [N]",
        y_label="control code",
        points=False,
        a_x=values[0],
        a_y=values[1],
        b_x=values[0],
        b_y=values[2],
    )
    return changed, thrust.size, (curve,), ()
