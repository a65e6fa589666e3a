"""A reference as text for a terminal."""

from collections.abc import Sequence

from pipeline.language import as_it_is
from pipeline.records.reference import Departure, Prediction, ReferenceRecord

#: Departures that are shown.
_SHOWN = 8


def reference_text(record: ReferenceRecord) -> str:
    """Tell what the file lacked, what of it is always the same, and whether the reference helps."""
    lines = [f"reference of {record.vehicle} from {len(record.runs)} sound runs:"]
    lines += [f"  {as_it_is(run.name)} ({run.because})" for run in record.runs]
    lines += [
        "",
        "rms force that the vehicle file lacks, share that every run has alike, what is left",
    ]
    lines += [
        f"  {axis:<6} {one.lacked:8.3g} {one.unit:<4} {one.same_share:5.0%} {one.left:10.3g} "
        f"{one.unit:<4} ({one.left_in_run:.3g} with what is each run's own)"
        for axis, one in record.axes.items()
    ]
    shown = standing_out(record.departures)[:_SHOWN]
    lines += ["", "what surely differs from the vehicle file" if shown else _NOTHING]
    lines += [f"  {departure_text(one)}" for one in shown]
    lines += ["", f"rms error of what was left out ({record.held_out})"]
    lines += [f"  {row}" for row in prediction_rows(record.predictions)]
    verb = "is used by the diagnosis" if record.used else "is NOT used"
    lines += ["", f"The reference {verb}: {record.why}"]
    lines += [f"note: {note}" for note in record.notes]
    return "\n".join(lines)


_NOTHING = "nothing surely differs from the vehicle file"


def standing_out(departures: Sequence[Departure]) -> list[Departure]:
    """Departures that surely differ from the file, the surest first."""
    return sorted((one for one in departures if one.stands_out), key=_sureness, reverse=True)


def departure_text(one: Departure) -> str:
    """Write a departure with its interval."""
    unit = "" if one.unit == "1" else f" {one.unit}"
    low, high = one.ci95
    return (
        f"{as_it_is(one.name)} {one.value:.3g} [{low:.3g}, {high:.3g}]{unit}, "
        f"+-{one.scatter:.2g} between runs (file: {one.neutral:.3g})"
    )


def prediction_rows(predictions: Sequence[Prediction]) -> list[str]:
    """Write a line for each quantity and time ahead, with all methods."""
    found: dict[tuple[str, float, str], list[str]] = {}
    for row in predictions:
        place = (row.quantity, row.ahead_s, row.unit)
        found.setdefault(place, []).append(f"{row.method} {row.rmse:.3g}")
    return [
        f"{_word(quantity)}, {seconds:g} s ahead [{unit}]: {', '.join(texts)}"
        for (quantity, seconds, unit), texts in found.items()
    ]


def _word(quantity: str) -> str:
    return "rates" if quantity == "angular_velocity" else quantity


def _sureness(one: Departure) -> float:
    low, high = one.ci95
    return abs(one.value - one.neutral) / max(high - low, 1e-12)
