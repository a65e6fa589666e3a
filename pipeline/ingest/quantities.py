"""What the quantities of a pool-run log are, by the table in ``topics.toml``."""

from collections.abc import Mapping
from dataclasses import dataclass

from pipeline.ingest.data_files import data_of


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


def largest(channel: str) -> float:
    """Return the largest size that can be believed of a channel, in the units of the records."""
    return QUANTITIES[channel].largest if channel in QUANTITIES else float("inf")
