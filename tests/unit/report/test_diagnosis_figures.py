"""The figures of a diagnosis: what is said above them, and the band that errors are read by."""

import diagnosis_records
import pytest

from pipeline.report.sections.diagnosis_curves import (
    curves,
    healthy_floor,
    resolution,
    run_figure,
)


def test_held_out_readings_are_compared_with_their_own_healthy_floor() -> None:
    record = diagnosis_records.diagnosis(channels=("z",), windows=3)
    held_out = record.shrink.channels["z"].model_copy(update={"noise_floor": 0.0123})
    shrink = record.shrink.model_copy(
        update={"channels": {**record.shrink.channels, "z": held_out}}
    )
    (drawn,) = curves(record)
    figure = run_figure(record.model_copy(update={"shrink": shrink}), drawn, 0, resolution(1))
    assert figure.lead.endswith("; a sound vehicle leaves 0.012 m.")
    # a channel without held-out readings has the floor of the whole runs
    bare = record.model_copy(update={"shrink": shrink.model_copy(update={"channels": {}})})
    assert healthy_floor(bare, "z") == pytest.approx(record.gap.channels["z"].healthy_floor)
