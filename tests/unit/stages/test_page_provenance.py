"""A page says from what raw files, results and code it was made."""

from pipeline.provenance import Envelope
from pipeline.records.trial import TrialDay
from pipeline.stages.page_provenance import page_provenance

DAY: Envelope[TrialDay] = Envelope(
    "trial_day",
    "boat",
    {"raw/boat/vehicle.yaml": "1f", "processed/boat/pool/run.json": "2a"},
    "c0de",
    None,
    version="0.1.0",
)


def test_raw_files_code_and_version_are_listed() -> None:
    assert page_provenance([DAY]) == {
        "rig2sea": "0.1.0",
        "raw/boat/vehicle.yaml": "sha256 1f",
        "code of trial_day": "c0de",
    }


def test_a_page_of_results_names_those_they_were_made_from() -> None:
    assert page_provenance([DAY], results=True)["processed/boat/pool/run.json"] == "sha256 2a"


def test_without_results_there_is_nothing_to_list() -> None:
    assert page_provenance([]) == {}
