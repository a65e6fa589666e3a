"""Printed numbers beside ours: what the author rounded to, and why a difference is larger."""

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field

from pipeline.records.design import Printed
from pipeline.vehicle.attachment_schema import ModelSection as Section

Text = Annotated[str, Field(max_length=1000)]


class PrintedValue(Section):
    """One printed number; the digits after its point tell how it was rounded."""

    table: Annotated[str, Field(max_length=80)] = ""
    quantity: Annotated[str, Field(max_length=80)]
    value: Annotated[float, Field(ge=-1e9, le=1e9)]
    decimals: Annotated[int, Field(ge=-3, le=9)] | None = None
    """Where trailing zeros were printed, or a whole number was rounded to tens (-1)."""
    reason: Text = ""


class PublishedFigures(Section):
    """Numbers somebody printed, to be shown beside ours; never used in the calculation."""

    source: Text
    values: tuple[PrintedValue, ...] = Field(max_length=400)


def rounding(value: float, decimals: int | None = None) -> float:
    """Half a unit of the last printed digit.

    >>> rounding(39.5), rounding(146.0), rounding(-2.97), rounding(1020.0, -1)
    (0.05, 0.5, 0.005, 5.0)
    """
    if decimals is None:
        text = f"{value:.9f}".rstrip("0")
        decimals = len(text) - text.index(".") - 1
    return 0.5 * 10.0 ** (-decimals)


def compare(
    published: PublishedFigures | None, computed: Mapping[str, tuple[float, str]]
) -> tuple[tuple[Printed, ...], tuple[str, ...]]:
    """Put the printed numbers beside ours, `computed`: value and unit by quantity.

    Warns of quantities that this calculation does not have.
    """
    if published is None:
        return (), ()
    rows: list[Printed] = []
    unknown: list[str] = []
    for one in published.values:
        if one.quantity not in computed:
            unknown.append(one.quantity)
            continue
        value, unit = computed[one.quantity]
        rows.append(
            Printed(
                table=one.table,
                quantity=one.quantity,
                unit=unit,
                printed=one.value,
                computed=value,
                rounding=rounding(one.value, one.decimals),
                reason=one.reason,
            )
        )
    warning = (
        f"published: {', '.join(unknown)} cannot be compared; there are {', '.join(computed)}."
    )
    return tuple(rows), (warning,) if unknown else ()
