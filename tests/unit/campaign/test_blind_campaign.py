"""A campaign with a made-up diagnosis: sealed, resumed, stopped, counted, written down."""

import json
import signal
import time
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from evaluation.blind_page import write_page
from evaluation.campaign_page import write_rates
from pipeline.blind.generate import CaseSpec, GeneratedCase
from pipeline.blind.rates import at_least, rate
from pipeline.blind.score import CampaignScore
from pipeline.campaign import blind_case
from pipeline.campaign.blind_case import BlindRequest, run_campaign
from pipeline.campaign.campaign import CampaignResult, read_lines
from pipeline.cli import cli
from pipeline.errors import InputError
from pipeline.simulate.pack import PackedVehicle


def says_none(
    case: GeneratedCase, _packed: PackedVehicle, _without: tuple[str, ...]
) -> Mapping[str, Any]:
    """Answer a case with none, whatever it is; a case shows no label in its tables."""
    assert case.runs
    return {
        "verdict": {"effects": ["none"], "probability": 0.9, "ambiguous_with": []},
        "gap": {"where": {"channels": [], "regimes": [], "times": []}},
        "ranking": [],
        "shrink": {"before": 1.0, "after": 1.0, "noise_floor": 1.0, "gap_closed": None},
        "confusable": [],
        "elapsed_s": 1.0,
    }


@pytest.fixture
def place(tmp_path: Path, repository: Path, monkeypatch: pytest.MonkeyPatch) -> BlindRequest:
    """A campaign of one vehicle with short runs and the made-up diagnosis."""
    whole = blind_case.generate

    def short(subject: Any, spec: CaseSpec) -> GeneratedCase:  # noqa: ANN401
        return whole(subject, CaseSpec(**{**spec.__dict__, "duration_s": 12.0, "healthy": 0}))

    run = blind_case.run_case
    monkeypatch.setattr(blind_case, "generate", short)
    monkeypatch.setattr(
        blind_case, "run_case", lambda number, request: run(number, request, says_none)
    )
    return BlindRequest(
        to=tmp_path / "blind",
        raw=repository / "raw",
        out=repository,
        vehicles=("rov8",),
        processes=1,
    )


@pytest.fixture
def heeds_ctrl_c() -> Iterator[None]:
    """Heed Ctrl-C also where the tests run in a shell's background, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeds_ctrl_c")
@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
def test_a_campaign_is_resumed_where_it_was_stopped(
    place: BlindRequest, by: signal.Signals
) -> None:
    """By Ctrl-C, or as a machine stops what runs in its background."""
    heard: list[str] = []

    def stop_after_two(done: int, _wanted: int, line: str) -> None:
        heard.append(line)
        if done == 2 and len(heard) == 2:
            signal.raise_signal(by)

    first = run_campaign(replace(place, cases=4), stop_after_two)
    assert first.done == 2
    assert "--resume" in heard[-1]
    before = read_lines(place.to / "cases.jsonl")
    # a line that was cut off is made again
    with (place.to / "cases.jsonl").open("a") as stream:
        stream.write('{"number": 2, "sco')
    second = run_campaign(replace(place, cases=4, resume=True))
    assert second.done == 4
    lines = read_lines(place.to / "cases.jsonl")
    assert lines[:2] == before
    assert [line["number"] for line in lines] == [0, 1, 2, 3]
    assert len(list((place.to / "sealed").iterdir())) == 4
    for line in lines:
        verdict = place.to / "verdicts" / line["score"]["case"] / "diagnosis.json"
        assert json.loads(verdict.read_text())["verdict"]["effects"] == ["none"]


def test_one_case_is_made_again_by_its_number(place: BlindRequest, tmp_path: Path) -> None:
    whole = run_campaign(replace(place, cases=2))
    alone = replace(place, to=tmp_path / "alone")
    request = replace(alone, cases=2, only=(1,))
    one = run_campaign(request)
    assert (whole.done, one.done, one.wanted) == (2, 1, 1)
    (again,) = read_lines(alone.to / "cases.jsonl")
    before = read_lines(place.to / "cases.jsonl")[1]
    for line in (before, again):
        del line["score"]["elapsed_s"]
    assert again == before
    write_page(alone.to, tmp_path / "page.md")
    assert "    rig2sea blind --only 1 --seed 0 " in (tmp_path / "page.md").read_text()


def quick_case(number: int, request: BlindRequest) -> dict[str, Any]:
    """Leave a trace, as a case leaves its verdict; other processes take it from this module."""
    time.sleep(0.1)
    (request.to / f"{number}.txt").touch()
    return {"number": number, "not_made": "nothing was flown"}


def test_cases_that_wait_are_not_run_when_a_campaign_is_stopped(
    place: BlindRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its processes went on with all of them after a SIGTERM, and nobody counted what they did."""
    monkeypatch.setattr(blind_case, "run_case", quick_case)

    def stop(done: int, _wanted: int, line: str) -> None:
        if done == 2 and "--resume" not in line:
            signal.raise_signal(signal.SIGTERM)

    result = run_campaign(replace(place, cases=60, processes=2), stop)
    assert result.done == 2
    done = len(list(place.to.glob("*.txt")))
    time.sleep(1.0)
    assert len(list(place.to.glob("*.txt"))) == done < 60


def test_a_folder_that_is_taken_is_left_alone(place: BlindRequest) -> None:
    run_campaign(replace(place, cases=1))
    with pytest.raises(InputError, match="--resume"):
        run_campaign(replace(place, cases=1))
    other = replace(place, seed=1)
    with pytest.raises(InputError, match="another seed"):
        run_campaign(replace(other, cases=1, resume=True))


@pytest.mark.parametrize("text", ["", "[1, 2]", "{"])
def test_a_damaged_header_is_one_message(place: BlindRequest, text: str) -> None:
    place.to.mkdir()
    (place.to / "cases.jsonl").touch()
    (place.to / "campaign.json").write_text(text)
    with pytest.raises(InputError, match=r"campaign\.json: is not the header of a campaign"):
        run_campaign(replace(place, cases=1, resume=True))
    assert (place.to / "campaign.json").read_text() == text


def test_the_page_names_the_command_and_has_its_pictures(
    place: BlindRequest, tmp_path: Path
) -> None:
    run_campaign(replace(place, cases=2))
    (place.to / "baselines.jsonl").write_text(
        '{"number": 0, "answers": {"plain": "none", "sparse": "current"}}\n', encoding="utf-8"
    )
    write_page(place.to, tmp_path / "docs" / "blind_check.md")
    text = (tmp_path / "docs" / "blind_check.md").read_text()
    assert "rig2sea blind --cases 2 --seed 0 --run-s 60 --vehicle rov8" in text
    assert "healthy vehicle called ill" in text
    (case,) = (line for line in text.splitlines() if line.startswith("| plain | "))
    (other,) = (line for line in text.splitlines() if line.startswith("| sparse | "))
    assert case.endswith("| 1 of 1 |")
    assert other.endswith("| 0 of 1 |")
    assert "false alarm on none" in (tmp_path / "docs" / "blind_check_rates.csv").read_text()
    for name in ("blind-confusion.svg", "blind-rates.svg"):
        assert f"images/{name}" in text
        picture = (tmp_path / "docs" / "images" / name).read_text()
        assert picture.startswith("<svg")
        assert picture.count('xmlns="http://www.w3.org/2000/svg"') == 1


def test_every_rate_stands_beside_the_page_once(tmp_path: Path) -> None:
    asked = rate("first", "gap 1-3, separable", [True] * 6 + [False] * 4, at_least(0.7))
    write_rates(tmp_path / "blind_check.md", (asked, rate("first", "gap >= 3, no dvl", [None])))
    table = (tmp_path / "blind_check_rates.csv").read_text().splitlines()
    assert table[1:] == ['first,"gap 1-3, separable",6,10,0.600,0.262,0.878,>= 70 %,missed']


def test_every_goal_and_every_miss_stands_on_the_page(place: BlindRequest, tmp_path: Path) -> None:
    """An answer of none to everything misses all effects and raises no alarm."""
    result = run_campaign(replace(place, cases=9))
    write_page(place.to, tmp_path / "blind_check.md")
    lines = (tmp_path / "blind_check.md").read_text().splitlines()
    score = result.score
    rows = [line for line in lines if line.startswith("| single, gap 1-3 | in the answer set | ")]
    ill = [one for one in score.missed if one.score.kind == "single"]
    assert ill
    (wanted,) = (
        one
        for one in score.goals
        if (one.stratum, one.question) == ("single, gap 1-3", "in the answer set")
    )
    assert [f"{wanted.yes} of {wanted.cases} = " in row for row in rows] == [True]
    first = ill[0].score
    name = f"{int(first.case[-5:])},rov8,{first.truth[0]},{first.gap_ratio:.1f},"
    table = (tmp_path / "blind_check_missed.csv").read_text().splitlines()
    assert len(table) == 1 + len(score.missed)
    assert any(row.startswith(name) and row.endswith(f",{ill[0].fault}") for row in table)
    assert "[blind_check_missed.csv](blind_check_missed.csv)" in "\n".join(lines)


def test_the_command_says_what_a_taken_folder_needs(place: BlindRequest) -> None:
    run_campaign(replace(place, cases=1))
    result = CliRunner().invoke(
        cli,
        ["blind", "--cases", "1", "--vehicle", "rov8", "--to", str(place.to)],
        prog_name="rig2sea",
    )
    assert result.exit_code == 1


def test_a_stopped_campaign_does_not_end_as_a_whole_one_does(
    place: BlindRequest, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A script that writes the page of a campaign would take the part for all of it."""

    def stop(_done: int, _wanted: int, line: str) -> None:
        if "--resume" not in line:
            signal.raise_signal(signal.SIGTERM)

    def stopped(_request: BlindRequest, _said: object) -> CampaignResult[CampaignScore]:
        return run_campaign(replace(place, cases=3), stop)

    command = ["blind", "--cases", "3", "--vehicle", "rov8", "--to", str(place.to), "--json"]
    monkeypatch.setattr(blind_case, "run_campaign", stopped)
    result = CliRunner().invoke(cli, command, prog_name="rig2sea")
    assert json.loads(result.stdout)["cases"] == 1
    assert result.exit_code == 1
    monkeypatch.setattr(blind_case, "run_campaign", run_campaign)
    result = CliRunner().invoke(
        cli, [*command, "--resume", "--processes", "1"], prog_name="rig2sea"
    )
    assert json.loads(result.stdout)["cases"] == 3
    assert result.exit_code == 0


def test_the_campaign_lies_in_the_folder_of_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[BlindRequest] = []

    def stop(request: BlindRequest, _said: object) -> None:
        asked.append(request)
        raise KeyboardInterrupt

    monkeypatch.setattr(blind_case, "run_campaign", stop)
    CliRunner().invoke(cli, ["blind", "--out", str(tmp_path / "results")])
    assert asked[0].to == tmp_path / "results/processed/blind"


def test_a_folder_that_cannot_be_made_names_the_option_for_it(
    place: BlindRequest, tmp_path: Path
) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"another folder with --to"):
        run_campaign(replace(place, cases=1, to=tmp_path / "file/x"))
