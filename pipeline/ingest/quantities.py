"""What the quantities of a pool-run log are, by the table in ``topics.toml``."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass

from pipeline.ingest.data_files import data_of
from pipeline.ingest.unit_text import is_same_unit
from pipeline.records.pool_schema import CLOCK_UNITS_NS, UNITS

#: Units of logs, and what stands for none.
KNOWN_UNITS = (
    *("%", *dict.fromkeys(one for units in UNITS.values() for one in units)),
    *(*CLOCK_UNITS_NS, "min", "h", "days"),
)
NO_UNIT = ("", "-", "nan", "<NA>", "None", "quat")


@dataclass(frozen=True)
class QuantityFacts:
    """A line of the table: what is not stated there is empty."""

    columns: tuple[str, ...] = ()
    each: str = ""
    axes: str = ""
    sensor: str = ""
    largest: float = float("inf")
    channel: str = ""
    same: str = ""


QUANTITIES: Mapping[str, QuantityFacts] = {
    name: QuantityFacts(**(one | {"columns": tuple(one.get("columns", ()))}))
    for name, one in data_of("topics")["quantities"].items()
}
#: Quantities with an element for each thruster.
PER_THRUSTER = tuple(name for name, one in QUANTITIES.items() if one.each)


def same_quantities(quantity: str) -> tuple[str, ...]:
    """Return the quantities of which one is wanted, this one among them.

    >>> same_quantities("pressure"), same_quantities("voltage")
    (('depth', 'pressure'), ('voltage',))
    """
    wanted = QUANTITIES[quantity].same
    alike = tuple(name for name, one in QUANTITIES.items() if one.same == wanted)
    return alike if wanted else (quantity,)


@functools.cache
def known_unit(unit: str) -> str:
    """Return a unit as the quantities of a log have it, however it is written.

    >>> [known_unit(one) for one in ("м/с", "m/s²", "°/s", "dps", "Pa", "feet", "K")]
    ['m/s', 'm/s2', 'deg/s', 'deg/s', 'Pa', 'ft', 'K']
    """
    if unit in KNOWN_UNITS or unit in NO_UNIT:
        return unit
    spelled = (one for one, others in data_of("topics")["spelled"].items() if unit in others)
    alike = (one for one in KNOWN_UNITS if is_same_unit(unit, one))
    return next(spelled, None) or next(alike, unit)


def largest(channel: str) -> float:
    """Return the largest size that can be believed of a channel, in the units of the records."""
    return QUANTITIES[channel].largest if channel in QUANTITIES else float("inf")
