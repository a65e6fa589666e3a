"""A planned day: what it holds, what fits the pool, and what became of the one before."""

import csv
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from pipeline.actions.pool_day import PoolDayFiles, plan_day
from pipeline.cli import cli
from pipeline.errors import CannotComputeError
from pipeline.identify import pool_plan
from pipeline.identify.identifiability import information_of_run
from pipeline.identify.pool_plan import MARGIN, WANTED
from pipeline.report.plain_words import manoeuvre_words
from pipeline.simulate.manoeuvres import MANOEUVRES


def quiet(_text: str) -> None:
    """Tell nobody."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A raw folder with a vehicle, and a short list of manoeuvres to try."""
    folder = tmp_path_factory.mktemp("day")
    made = CliRunner().invoke(
        cli, ["new", "fish", "--like", "remus100", "--raw", str(folder / "raw")]
    )
    assert made.exit_code == 0, made.output
    with (folder / "raw/fish/vehicle.yaml").open("a", encoding="utf-8") as file:
        file.write("\nbattery_minutes: 0.2\n")
    few = {name: MANOEUVRES[name] for name in ("straight", "surge_ramp", "zig_zag")}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pool_plan, "MANOEUVRES", few)
        yield folder


@pytest.fixture(scope="module")
def made(folder: Path) -> PoolDayFiles:
    return plan_day("fish", 5.0, pool_m=None, to=None, raw=folder / "raw", out=folder, tell=quiet)


def test_the_list_is_the_shortest_that_reaches_what_is_wanted(made: PoolDayFiles) -> None:
    record = made.record
    assert record.minutes == 0.2, "the battery lasts no longer"
    assert record.total_s <= 60.0 * record.minutes
    assert 0.0 < record.mean_share <= record.usual_mean_share
    for one in record.promises:
        assert one.half_width <= one.half_width_before
        assert one.reached == (one.half_width <= one.wanted * (1.0 + 1e-9))
        assert one.wanted == pytest.approx(WANTED * one.half_width_before)
    assert MARGIN > 1.0
    assert any("zig_zag cannot be flown" in why for why in record.left_out)


def test_codes_and_a_log_to_play_lie_beside_the_page(made: PoolDayFiles) -> None:
    (run, *_) = made.record.runs
    rows = list(csv.reader((made.page.parent / run.codes).read_text("utf-8").splitlines()))
    assert rows[0] == ["time_s", "stern"]
    codes = np.array(rows[1:], float)
    assert np.all(np.diff(codes[:, 0]) > 0.0)
    assert np.abs(codes[:, 1]).max() <= 100.0
    assert (made.page.parent / run.log).stat().st_size > 1000
    assert manoeuvre_words(run.manoeuvre) in made.page.read_text(encoding="utf-8")


def test_the_second_plan_says_what_was_flown_of_the_first(folder: Path, made: PoolDayFiles) -> None:
    (run, *_) = made.record.runs
    pool = folder / "raw/fish/pool"
    shutil.copy(made.page.parent / run.log, pool / f"monday-{run.manoeuvre}.mcap")
    again = plan_day(
        "fish", 0.2, pool_m=None, to=folder / "again", raw=folder / "raw", out=folder, tell=quiet
    )
    assert again.flown[0].log == f"monday-{run.manoeuvre}.mcap"
    assert "flown as monday" in again.flown[0].text
    text = again.page.read_text(encoding="utf-8")
    assert "Of the last plan were flown 1 of" in text
    assert "rig2sea run fish" in text
    assert 'class="told' in text


def test_a_pool_too_small_and_a_wrong_size_are_said(folder: Path) -> None:
    with pytest.raises(CannotComputeError, match="more than the pool has"):
        plan_day(
            "fish",
            0.1,
            pool_m=(0.01, 0.01, 0.01),
            to=None,
            raw=folder / "raw",
            out=folder,
            tell=quiet,
        )
    wrong = CliRunner().invoke(cli, ["plan", "fish", "--pool", "10by5", "--raw", "raw"])
    assert wrong.exit_code == 2
    assert "25x10x3" in wrong.output


def test_a_run_that_tells_nothing_is_left_out_and_no_other(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = information_of_run
    asked: list[str] = []

    def of_some(*args: object, **kwargs: object) -> object:
        asked.append("")
        if len(asked) == 1:
            raise CannotComputeError("its windows cannot be simulated")
        return known(*args, **kwargs)  # type: ignore[arg-type]

    monkeypatch.setattr(pool_plan, "information_of_run", of_some)
    made = plan_day(
        "fish", 0.2, pool_m=None, to=tmp_path, raw=folder / "raw", out=folder, tell=quiet
    )
    assert "straight: its windows cannot be simulated" in made.record.left_out
    assert made.record.runs
