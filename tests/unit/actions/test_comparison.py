"""What can be compared and what cannot, found by the words that a person writes."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from pipeline.actions.comparison import compare, conditions_apart
from pipeline.actions.comparison_sides import FoundSide
from pipeline.cli import cli
from pipeline.plan import UsageError
from pipeline.records.comparison import Side
from pipeline.records.pool_run import BallastItem, RunNotes, WaterNotes
from pipeline.records.run_table import RunTable
from pipeline.report.comparison_page import comparison_page
from pipeline.vehicle.load import load_vehicle


def quiet(_text: str) -> None:
    """Tell nobody."""


def mooring(folder: Path, name: str, factor: float) -> Path:
    """A bench file of the bundled vehicle's drive."""
    rows = [f"{code},{factor * 0.0025 * code * abs(code):.3f}" for code in range(-120, 121, 20)]
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_text("Code,Thrust (N)\n" + "\n".join(rows) + "\n")
    return path


def test_bench_files_and_vehicles_by_their_names(repository: Path, tmp_path: Path) -> None:
    raw = repository / "raw"
    a, b = (mooring(tmp_path, f"{f}.csv", f) for f in (1.0, 0.8))
    found = compare(str(a), str(b), "mmt300", raw, tmp_path, quiet)
    assert found.comparable
    assert [one.kind for one in found.differences] == ["common_factor"]
    assert "B gives 0.80" in found.verdict
    again = compare(str(a), str(a), "mmt300", raw, tmp_path, quiet)
    assert (again.differences, again.verdict) == ((), "Nothing differs.")
    files = compare("bluerov2", "rov8", None, raw, tmp_path, quiet)
    assert {"model.rigid_body.mass_kg"} <= {one.what for one in files.differences}
    other = compare(str(a), "rov8", "mmt300", raw, tmp_path, quiet)
    assert not other.comparable
    assert "B is a vehicle file" in other.verdict
    page = comparison_page(found)
    assert "B gives 0.80" in page
    with pytest.raises(UsageError, match="of which vehicle"):
        compare(str(a), str(b), None, raw, tmp_path, quiet)
    with pytest.raises(UsageError, match="neither a folder under"):
        compare("nonsense", "rov8", None, raw, tmp_path, quiet)


def test_a_page_and_json_are_written_and_the_exit_code_says_whether(
    repository: Path, tmp_path: Path
) -> None:
    options = ["--raw", str(repository / "raw"), "--out", str(tmp_path), "--json"]
    same = CliRunner().invoke(cli, ["compare", "rov8", "bluerov2_heavy", *options])
    assert same.exit_code == 0
    assert '"verdict": "Nothing differs."' in same.output
    folder = tmp_path / "reports/comparisons/rov8-bluerov2_heavy"
    assert (folder / "comparison.html").is_file()
    assert (folder / "comparison.json").is_file()


def side(repository: Path, note: RunNotes, supply_v: float) -> FoundSide:
    count = 20
    table = RunTable(
        "run",
        np.arange(count) * 0.1,
        {"voltage": np.full((count, 1), supply_v)},
        {"voltage": np.ones(count, bool)},
    )
    vehicle = load_vehicle(repository / "raw/mmt300")
    return FoundSide(
        Side(name="day", kind="runs", vehicle="mmt300", holds=()),
        vehicle,
        runs=(table,),
        notes=(note,),
    )


def test_conditions_that_nobody_can_count_forbid_a_comparison(repository: Path) -> None:
    plain = side(repository, RunNotes(), 48.0)
    assert conditions_apart(plain, plain) == ([], [])
    (supply,), _ = conditions_apart(plain, side(repository, RunNotes(), 40.0))
    assert "48 V in A and 40 V in B" in supply
    loose = RunNotes(ballast=(BallastItem(what="lead", mass_kg=2.0),))
    (ballast,), _ = conditions_apart(plain, side(repository, loose, 48.0))
    assert "2 kg in B" in ballast
    counted = RunNotes(ballast=(BallastItem(what="lead", mass_kg=2.0, displaced_kg=0.2),))
    assert conditions_apart(plain, side(repository, counted, 48.0)) == ([], [])
    waters = [RunNotes(water=WaterNotes(kind=kind)) for kind in ("fresh", "salt")]
    (water,), _ = conditions_apart(*(side(repository, note, 48.0) for note in waters))
    assert "fresh in A and salt in B" in water
    dense = [
        note.model_copy(update={"water": WaterNotes(kind="pool", density_kgpm3=rho)})
        for note, rho in zip(waters, (1000.0, 1025.0), strict=True)
    ]
    assert conditions_apart(*(side(repository, note, 48.0) for note in dense))[0] == []
