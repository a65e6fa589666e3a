"""Whether a reference is used: it must be told by its runs, and predict best what took no part."""

from collections.abc import Sequence

import numpy as np

from pipeline.records.reference import Prediction


def judged(
    table: Sequence[Prediction], gain_per_window: float, least_gain: float
) -> tuple[bool, str]:
    """Say whether a reference is used, and why.

    Parameters
    ----------
    table : sequence of Prediction
        Of what was left out.
    gain_per_window : float
        Log evidence over the vehicle file's own widths. [nat]
    least_gain : float
        What it has to be.
    """
    if gain_per_window <= least_gain:
        return False, (
            "the sound runs show no more than the vehicle file says: log evidence "
            f"{gain_per_window:+.1f} a window, more than {least_gain:g} is needed."
        )
    own = {_place(row): row.rmse for row in table if row.method == "reference"}
    if not own:
        return False, "no velocity and no rate could be predicted of what was left out."
    over: dict[str, dict[tuple[str, float], float]] = {}
    for row in table:
        if row.method != "reference" and _place(row) in own and row.rmse > 0.0:
            over.setdefault(row.method, {})[_place(row)] = own[_place(row)] / row.rmse
    mean = {
        name: float(np.exp(np.mean(np.log(list(each.values()))))) for name, each in over.items()
    }
    better = [name for name, ratio in mean.items() if ratio >= 1.0]
    against = ", ".join(f"{ratio:.2f} times the {name}'s" for name, ratio in mean.items())
    told = f"of what took no part its rms error is {against} (mean over what is predicted)"
    places = [
        f"{_quantity(quantity)} {seconds:g} s ahead ({name})"
        for name, each in over.items()
        for (quantity, seconds), ratio in each.items()
        if ratio >= 1.0
    ]
    if better:
        return False, f"{told}, which is no better than that of the {' and the '.join(better)}."
    but = f"; not better in {', '.join(places)}" if places else ""
    return True, f"{told}{but}."


def _place(row: Prediction) -> tuple[str, float]:
    return row.quantity, row.ahead_s


def _quantity(name: str) -> str:
    return "rates" if name == "angular_velocity" else name
