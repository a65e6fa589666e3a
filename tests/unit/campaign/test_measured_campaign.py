"""The measured blind check: effects put into the runs of a folder, scored, gone on with, shown."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from evaluation.campaign_page import write_block
from evaluation.measured_page import write_page
from pipeline.blind.verdict_score import CaseScore
from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.campaign import measured_campaign, measured_cases
from pipeline.campaign.measured_campaign import (
    MeasuredLine,
    MeasuredRequest,
    measured_lines,
    run_measured,
    score_measured,
)
from pipeline.campaign.measured_cases import MeasuredCase, measured_case
from pipeline.campaign.measured_subjects import MeasuredSubject, load_subjects
from pipeline.commands.blind import blind
from pipeline.errors import InputError
from pipeline.records.run_table import RunTable
from pipeline.simulate.pack import pack_vehicle
from pipeline.simulate.run import run
from pipeline.vehicle.load import load_vehicle

PERIOD_S = 0.02


def flown(subject_vehicle: Any, seed: int) -> RunTable:  # noqa: ANN401 - a packed vehicle
    """16 s of held codes, one thruster at rest."""
    generator = np.random.default_rng(seed)
    levels = generator.uniform(-0.4, 0.4, (16, len(subject_vehicle.thruster_names)))
    levels[:, 4:], levels[:, 7] = levels[:, 4:5], 0.0
    codes = np.repeat(levels, 50, axis=0) * subject_vehicle.code_limits[:, 1]
    made = run(subject_vehicle, codes, dt_s=PERIOD_S)
    rows = len(codes)
    values = {
        "command": codes,
        "angular_velocity": made.nu[:-1, 3:] + 2e-3 * generator.standard_normal((rows, 3)),
        "velocity": made.nu[:-1, :3] + 4e-3 * generator.standard_normal((rows, 3)),
        "attitude": made.quaternion[:-1],
    }
    valid = dict.fromkeys(values, np.ones(rows, bool))
    return RunTable(f"run_{seed}", made.time_s[:-1], values, valid)


@pytest.fixture(scope="module")
def rov() -> MeasuredSubject:
    vehicle = load_vehicle(bundled_vehicle("rov8"))
    packed = pack_vehicle(vehicle)
    return MeasuredSubject("rov", vehicle, packed, tuple(flown(packed, k) for k in range(4)))


@pytest.fixture(autouse=True)
def _one_run_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measured_cases, "ENOUGH_S", 10.0)


@pytest.fixture
def here(rov: MeasuredSubject, monkeypatch: pytest.MonkeyPatch) -> MeasuredSubject:
    monkeypatch.setattr(measured_campaign, "subjects_of", lambda *_: (rov,))
    return rov


def says(*effects: str, thruster: str | None = None, sure: bool = True) -> Any:  # noqa: ANN401
    def diagnose(case: MeasuredCase) -> Mapping[str, Any]:
        assert {one.name for one in case.runs}.isdisjoint(one.name for one in case.healthy)
        answer = {"effects": list(effects), "probability": 0.9, "detail": {"thruster": thruster}}
        return {"verdict": answer | {"ambiguous_with": [] if sure else ["current"]}}

    return diagnose


def test_each_run_is_left_out_in_turn_and_only_it_is_altered(rov: MeasuredSubject) -> None:
    for turn, kind in ((0, "thruster"), (3, "none"), (7, "dead")):
        case = measured_case(turn, 1, (rov,))
        assert case.kind == kind
        assert case.runs[0].name == f"run_{turn % 4}"
        assert {one.name for one in (*case.runs, *case.healthy)} == {f"run_{k}" for k in range(4)}
        for one in case.healthy:
            assert any(one is same for same in rov.runs)
        same = np.array_equal(case.runs[0].values["command"], rov.runs[turn % 4].values["command"])
        assert same == (kind == "none")
    assert case.spec is not None
    assert (case.spec.target, case.spec.values) == (
        rov.packed.thruster_names[7], {"thrust_fraction": 0.0}
    )  # fmt: skip


def test_a_case_is_drawn_from_seed_and_number_alone(rov: MeasuredSubject) -> None:
    one, two, other = (measured_case(1, seed, (rov,)) for seed in (1, 1, 2))
    assert one.spec == two.spec
    assert one.sizes == two.sizes
    assert (one.spec, one.wanted) != (other.spec, other.wanted)
    assert one.size >= measured_cases.LEAST_SIZE
    assert one.share >= measured_cases.LEAST_SHARE


def test_a_campaign_is_scored_and_goes_on(here: MeasuredSubject, tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    request = MeasuredRequest(
        data=tmp_path / "data", to=tmp_path / "to", seed=1, processes=1, only=(0, 3)
    )
    told: list[str] = []
    weak = measured_case(0, 1, (here,)).spec
    assert weak is not None
    answers = says("thruster_degraded", thruster=weak.target)
    result = run_measured(request, lambda *said: told.append(said[-1]), answers)
    assert (result.done, result.wanted, result.not_made) == (2, 2, 0)
    assert told[0].startswith(f"case 0: rov, thruster_degraded {weak.target} at ")
    first, calm = measured_lines(result.lines)
    assert first.first
    assert not first.surely_wrong
    assert calm.sure_effect
    with pytest.raises(InputError, match="there is a campaign in this folder already"):
        run_measured(request, diagnose=answers)
    again = replace(request, resume=True)
    assert run_measured(again, diagnose=says("current")).lines == result.lines
    page = tmp_path / "page.md"
    write_page(request.to, page)
    text = page.read_text(encoding="utf-8")
    assert "| runs as they are | a sure effect | 1 of 1 = 100 %" in text
    assert "rig2sea blind --measured DATA --only 0 --only 3 --seed 1 --to DIR" in text
    assert (tmp_path / "images" / "measured-rates.svg").is_file()
    cases = (tmp_path / "page_cases.csv").read_text(encoding="utf-8").splitlines()
    assert [row.split(",")[0] for row in cases] == ["case", "0", "3"]


@pytest.mark.usefixtures("here")
def test_the_command_prints_what_came_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        measured_campaign,
        "run_measured",
        lambda request, said: run_measured(request, said, says("none")),
    )
    asked = [
        "--measured",
        str(tmp_path),
        "--only",
        "3",
        "--seed",
        "1",
        "--to",
        str(tmp_path / "to"),
    ]
    told = CliRunner().invoke(blind, asked)
    assert told.exit_code == 0, told.output
    assert "runs as they are: a sure effect: 0 of 1" in told.output
    told = CliRunner().invoke(blind, [*asked, "--resume", "--json"])
    content = json.loads(told.stdout)
    assert (content["schema"], content["cases"]) == ("rig2sea/blind_measured/1", 1)
    told = CliRunner().invoke(blind, [*asked, "--vehicle", "rov8"])
    assert told.exit_code == 2
    assert "belong to generated cases" in told.output


def line(kind: str, size: float, told: tuple[str, ...], **more: Any) -> MeasuredLine:  # noqa: ANN401
    truth = {"none": "none"}.get(kind, more.get("effect", "thruster_degraded"))
    beside = more.get("beside", ())
    score = CaseScore(
        case="case",
        vehicle="rov",
        kind="none" if kind == "none" else "single",
        healthy=True,
        missing=(),
        manoeuvres="",
        gap_ratio=size,
        truth=(truth,),
        verdict=told,
        ambiguous_with=beside,
        probability=more.get("probability", 0.9),
        abstained=bool(beside) or told == ("none",),
        in_set=truth in (*told, *beside),
        set_size=1,
        confidently_wrong=truth not in told and not beside and told != ("none",),
        elapsed_s=1.0,
    )
    return MeasuredLine(
        number=0,
        subject="rov",
        kind=kind,
        runs=(),
        healthy=(),
        effect=None if kind == "none" else truth,
        thruster=more.get("thruster"),
        parameters={},
        size=size,
        wanted=3.0,
        channel_sizes={},
        share=1.0,
        told_thruster=more.get("told_thruster"),
        score=score,
    )


def test_the_thruster_must_be_the_right_one() -> None:
    weak = ("thruster_degraded",)
    right = line("thruster", 4.0, weak, thruster="a", told_thruster="a")
    other = line("thruster", 4.0, weak, thruster="a", told_thruster="b")
    unsure = line("thruster", 4.0, weak, thruster="a", told_thruster="a", probability=0.4)
    small = line("thruster", 2.0, ("none",), thruster="a")
    common = line("none", 0.0, ("thrust_deduction",))
    assert (right.first, right.in_set, right.surely_wrong) == (True, True, False)
    assert (other.first, other.in_set, other.surely_wrong) == (False, False, True)
    assert (unsure.first, unsure.in_set) == (False, True)
    assert not common.sure_effect
    goals = {
        (one.stratum, one.question): (one.yes, one.cases)
        for one in score_measured([right, other, unsure, small, common]).goals
    }
    assert goals["a thruster weak, 3 floors or more", "thruster first, 0.5 or more"] == (1, 3)
    assert goals["runs as they are", "a sure effect"] == (0, 1)
    assert goals["all effects put in", "surely wrong"] == (1, 4)


def test_a_folder_without_vehicles_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no measured vehicle in this folder"):
        load_subjects(tmp_path, tmp_path / "cache")


def test_a_page_keeps_what_a_person_wrote(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    write_block(page, "the table", "A page", "one")
    before = page.read_text(encoding="utf-8").replace("# A page", "# A page of mine")
    page.write_text(before, encoding="utf-8")
    write_block(page, "the table", "A page", "two")
    assert page.read_text(encoding="utf-8") == before.replace("one", "two")
    with pytest.raises(InputError, match="has no place for another"):
        write_block(page, "another", "A page", "three")
