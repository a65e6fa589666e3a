"""The body of ``tables.json``: Tables 1-4 with intervals, quality and the published values."""

from collections.abc import Mapping
from typing import Any

from pipeline.control.paper_allocator import corrections_of
from pipeline.records.fit_values import largest_thrust_interval
from pipeline.records.fits import (
    Check,
    FitQuality,
    InverseCharacteristic,
    PolynomialFit,
    PropellerFit,
    StaticCharacteristic,
    StaticRow,
)
from pipeline.vehicle.schema import Vehicle

Json = dict[str, Any]


def build_tables(
    vehicle: Vehicle,
    propeller: PropellerFit | None,
    static: StaticCharacteristic | None,
    inverse: InverseCharacteristic | None,
    not_computed: Mapping[str, str] | None = None,
) -> Json:
    """Gather the four tables; one that could not be computed is None and says why.

    Parameters
    ----------
    vehicle : Vehicle
        Name, codes, published tables.
    propeller, static, inverse : record or None
        What the fits gave.
    not_computed : mapping, optional
        Stage name to the reason why it gave nothing.

    Returns
    -------
    dict
        JSON-ready; the keys are those of docs/formats.md.
    """
    corrected = _corrected_thrusters(vehicle)
    return {
        "vehicle": vehicle.name,
        **({"thrusters": corrected} if corrected else {}),
        **({"types": list(vehicle.tables.types)} if vehicle.tables.types else {}),
        "table1": _table1(propeller),
        "table2": _table2(static.table2, inverse) if static else None,
        "table3": _table3(inverse),
        "table4": _table4(inverse, static) if inverse and inverse.table4 else None,
        "quality": {
            "table1": {
                "KT": _quality(propeller.thrust.quality),
                "KM": _quality(propeller.torque.quality),
                "checks": _checks(propeller.checks),
            }
            if propeller
            else None,
            "table2": {
                "rows": [_quality(row.fit.quality) for row in static.table2],
                "checks": _checks(static.checks),
            }
            if static
            else None,
            "table3": {
                name: _quality(fit.quality)
                for name, fit in _signs(inverse).items()
                if fit is not None
            },
            "round_trip": [trip.model_dump() for trip in inverse.round_trip] if inverse else [],
            "checks": _checks(inverse.checks) if inverse else [],
        },
        "published": vehicle.published.model_dump() if vehicle.published else None,
        "firmware": inverse.firmware.model_dump() if inverse and inverse.firmware else None,
        **({"voltages": _voltages(inverse)} if inverse and inverse.voltages else {}),
        "not_computed": dict(not_computed or {}),
        "notes": [
            *(static.explanations if static else ()),
            *(inverse.explanations if inverse else ()),
        ],
    }


def _voltages(inverse: InverseCharacteristic) -> list[Json]:
    """Return T(N, V, U), by rising U: each sign on its speeds and codes, with its interval."""
    return [
        {
            "voltage_v": one.voltage_v,
            **{
                sign: side.model_dump(include={"speed_mps", "code", "thrust_n", "half95_n"})
                | {"between95_n": list(wide)}
                for sign, side, wide in zip(
                    ("positive", "negative"),
                    (one.family.positive, one.family.negative),
                    one.between95_n,
                    strict=True,
                )
            },
        }
        for one in inverse.voltages
    ]


def _corrected_thrusters(vehicle: Vehicle) -> Json:
    """Return the thrusters that give other than the tables say, with what they give of it."""
    own = corrections_of(vehicle)
    rows = zip(vehicle.thrusters, own.gain.tolist(), own.lost_code.tolist(), strict=True)
    return {
        one.name: {"gain": gain, "dead_zone_code": lost}
        for one, gain, lost in rows
        if gain != [1.0, 1.0] or lost
    }


def _table1(propeller: PropellerFit | None) -> Json | None:
    if propeller is None:
        return None
    return {
        "KT": list(propeller.thrust.coefficients),
        "KM": list(propeller.torque.coefficients),
        "ci95": {
            "KT": [list(pair) for pair in propeller.thrust.ci95],
            "KM": [list(pair) for pair in propeller.torque.ci95],
        },
    }


def _table2(rows: tuple[StaticRow, ...], inverse: InverseCharacteristic | None) -> Json:
    names = ("KF0", "KF1", "KF2")
    return {
        "speed_mps": [row.speed_mps for row in rows],
        **{name: [row.fit.coefficients[i] for row in rows] for i, name in enumerate(names)},
        "dead_zone_code": [row.dead_zone_code for row in rows],
        "T_max_n": [row.thrust_max_n for row in rows],
        "ci95": {
            **{name: [list(row.fit.ci95[i]) for row in rows] for i, name in enumerate(names)},
            "T_max_n": [list(largest_thrust_interval(row, inverse)) for row in rows],
        },
    }


def _table3(inverse: InverseCharacteristic | None) -> Json | None:
    fits = _signs(inverse)
    if not any(fits.values()):
        return None
    return {
        **{name: list(fit.coefficients) if fit else None for name, fit in fits.items()},
        "ci95": {
            name: [list(pair) for pair in fit.ci95] if fit else None for name, fit in fits.items()
        },
    }


def _signs(inverse: InverseCharacteristic | None) -> dict[str, PolynomialFit | None]:
    return {
        "positive": inverse.table3_positive if inverse else None,
        "negative": inverse.table3_negative if inverse else None,
    }


def _table4(inverse: InverseCharacteristic, static: StaticCharacteristic | None) -> Json:
    rows = inverse.table4
    names = ("KN0", "KN1", "KN2", "KN3")
    # T_max of Table 4 is that of Table 2, and so is what is known of it
    largest = (
        {row.speed_mps: list(largest_thrust_interval(row, inverse)) for row in static.table2}
        if static
        else {}
    )
    return {
        "speed_mps": [row.speed_mps for row in rows],
        "T_max_n": [row.thrust_max_n for row in rows],
        **{name: [row.coefficients[i] for row in rows] for i, name in enumerate(names)},
        "ci95": {
            **{name: [list(row.ci95[i]) for row in rows] for i, name in enumerate(names)},
            **(
                {"T_max_n": [largest[row.speed_mps] for row in rows]}
                if all(row.speed_mps in largest for row in rows)
                else {}
            ),
        },
    }


def _quality(quality: FitQuality) -> Json:
    return quality.model_dump(
        include={
            "points",
            "r_squared",
            "residual_std",
            "unit",
            "valid_range",
            "order_reason",
            "outliers",
        }
    )


def _checks(checks: tuple[Check, ...]) -> list[Json]:
    return [check.model_dump() for check in checks]
