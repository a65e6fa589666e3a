"""A reference as text for a terminal."""

from collections.abc import Sequence

from pipeline.language import as_it_is
from pipeline.records.reference import Prediction, ReferenceRecord, Width

#: Widths that are shown.
_SHOWN = 8


def reference_text(record: ReferenceRecord) -> str:
    """Tell by how much sound runs differ, and whether the reference helps."""
    lines = [f"reference of {record.vehicle} from {len(record.runs)} sound runs:"]
    lines += [f"  {as_it_is(run.name)} ({run.because})" for run in record.runs]
    lines += ["", "by how much sound runs differ (standard deviation; before they were seen)"]
    lines += [f"  {width_text(one)}" for one in most_changed(record.widths)[:_SHOWN]]
    lines += ["", "rms error of what was left out (each run in turn)"]
    lines += [f"  {row}" for row in prediction_rows(record.predictions)]
    verb = "is used by the diagnosis" if record.used else "is NOT used"
    lines += ["", f"The reference {verb}: {record.why}"]
    lines += [f"note: {note}" for note in record.notes]
    return "\n".join(lines)


def most_changed(widths: Sequence[Width]) -> list[Width]:
    """Widths that the runs moved most."""
    return sorted(widths, key=lambda one: one.learned / one.stated, reverse=True)


def width_text(one: Width) -> str:
    """Write a width with what it was taken for before."""
    unit = "" if one.unit == "1" else f" {one.unit}"
    return f"{as_it_is(one.name)} {one.learned:.2g}{unit} ({one.stated:.2g}{unit})"


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
