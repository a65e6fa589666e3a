"""When a reference is used."""

from pipeline.diagnose.reference.judged import judged
from pipeline.records.reference import Prediction


def table(**rmse: tuple[float, float]) -> list[Prediction]:
    """Errors of velocity and rates 3 s ahead, by method."""
    return [
        Prediction.model_validate(
            {
                "method": method.replace("_", " "),
                "quantity": quantity,
                "unit": unit,
                "ahead_s": 3.0,
                "rmse": value,
                "readings": 10,
            }
        )
        for method, values in rmse.items()
        for quantity, unit, value in zip(
            ("velocity", "angular_velocity"), ("m/s", "rad/s"), values, strict=True
        )
    ]


def test_what_predicts_best_is_used_and_says_where_it_does_not() -> None:
    rows = table(reference=(0.1, 0.2), vehicle_file=(0.2, 0.4), black_box=(0.4, 0.1))
    used, why = judged(rows, 10.0, 3.0)
    assert used
    assert "0.50 times the vehicle file's" in why
    assert why.endswith("not better in rates 3 s ahead (black box).")


def test_what_predicts_no_better_than_one_of_them_is_not_used() -> None:
    rows = table(reference=(0.1, 0.2), vehicle_file=(0.2, 0.4), last_value=(0.09, 0.2))
    used, why = judged(rows, 10.0, 3.0)
    assert not used
    assert why.endswith("no better than that of the last value.")


def test_runs_that_show_no_more_than_the_file_make_no_reference() -> None:
    rows = table(reference=(0.1, 0.1), vehicle_file=(0.2, 0.2))
    used, why = judged(rows, 2.0, 3.0)
    assert not used
    assert "+2.0 a window" in why


def test_where_nothing_was_predicted_it_is_not_used() -> None:
    assert not judged(table(vehicle_file=(0.2, 0.2)), 9.0, 3.0)[0]
