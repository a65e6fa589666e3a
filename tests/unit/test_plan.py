"""Which vehicles there are, by what name they are asked for, and which files are raw data."""

from pathlib import Path

import pytest

from pipeline.plan import (
    UsageError,
    VehicleFolder,
    choose,
    discover,
    is_raw,
    is_vehicle_name,
    seen_from,
)


@pytest.fixture
def raw(tmp_path: Path) -> Path:
    """A raw folder with two vehicles and two folders that are none."""
    for name in ("ant", "bee"):
        (tmp_path / "raw" / name).mkdir(parents=True)
        (tmp_path / "raw" / name / "vehicle.yaml").touch()
    (tmp_path / "raw" / ".hidden").mkdir()
    (tmp_path / "raw" / "notes").mkdir()
    return tmp_path / "raw"


def names(vehicles: tuple[VehicleFolder, ...]) -> list[str]:
    return [vehicle.name for vehicle in vehicles]


def test_every_folder_with_a_vehicle_file_is_a_vehicle(raw: Path) -> None:
    vehicles, problems = discover(raw, raw.parent)
    assert names(vehicles) == ["ant", "bee"]
    assert [vehicle.folder for vehicle in vehicles] == ["raw/ant", "raw/bee"]
    assert problems == ()


def test_folder_that_looks_like_a_vehicle_is_a_problem(raw: Path) -> None:
    (raw / "cow" / "mooring").mkdir(parents=True)
    (raw / "2 dogs").mkdir()
    (raw / "2 dogs" / "vehicle.yaml").touch()
    vehicles, problems = discover(raw, raw.parent)
    assert names(vehicles) == ["ant", "bee"]
    dogs, cow = problems
    assert "cannot be the name of a vehicle" in str(dogs)
    assert "has mooring but no vehicle.yaml" in str(cow)


@pytest.mark.parametrize(
    "name",
    [
        *("design", "Design", "assets", "ASSETS"),  # folders of reports/
        *("", ".", "..", "../ant", "/etc", "a/b", "a\\b", "a\0b", "a\n", "a b", "-a", "_a", "1a"),
        *(
            "a" * 49,
            "\u0430nt",
            "ant\u202e",
            "\uff41nt",
            "ant\u0301",
            "a.b",
            "a%2fb",
            "$(a)",
            "a;b",
        ),
    ],
)
def test_what_cannot_be_a_name(name: str) -> None:
    assert not is_vehicle_name(name)


def test_a_vehicle_named_as_a_folder_of_the_reports_is_refused(raw: Path) -> None:
    (raw / "design").mkdir()
    (raw / "design" / "vehicle.yaml").touch()
    vehicles, (problem,) = discover(raw, raw.parent)
    assert names(vehicles) == ["ant", "bee"]
    assert 'name "design" cannot be the name of a vehicle' in problem.what
    assert "folders of reports/ already" in problem.expected


def test_absent_raw_folder_holds_nothing(tmp_path: Path) -> None:
    assert discover(tmp_path / "raw", tmp_path) == ((), ())


@pytest.mark.parametrize("text", ["bee", "raw/bee", "raw/bee/", "raw/bee/vehicle.yaml"])
def test_vehicle_is_asked_for_by_name_or_path(
    raw: Path, text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(raw.parent)
    vehicles, _ = choose([text], Path("raw"), Path())
    assert [(vehicle.name, vehicle.folder) for vehicle in vehicles] == [("bee", "raw/bee")]


def test_vehicle_asked_for_from_within_its_folder(
    raw: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(raw / "bee")
    vehicles, _ = choose(["."], Path("raw"), Path())
    assert [(v.name, v.folder) for v in vehicles] == [("bee", (tmp_path / "raw/bee").as_posix())]


def test_same_name_twice_is_refused(raw: Path, tmp_path: Path) -> None:
    (tmp_path / "other/bee").mkdir(parents=True)
    (tmp_path / "other/bee/vehicle.yaml").touch()
    assert names(choose(["bee", "bee"], raw, tmp_path)[0]) == ["bee"]
    with pytest.raises(UsageError, match="have the same name"):
        choose(["bee", str(tmp_path / "other/bee")], raw, tmp_path)


def test_folder_within_out_is_seen_relative_so_that_both_may_move(tmp_path: Path) -> None:
    assert seen_from(tmp_path / "raw/a", tmp_path) == "raw/a"
    assert seen_from(tmp_path / "x/../raw/a", tmp_path) == "raw/a"
    assert seen_from(tmp_path / "raw/a", tmp_path / "out") == (tmp_path / "raw/a").as_posix()


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("drive.xlsx", True),
        ("drive.XLSX", True),
        ("drive.xls", True),  # to be refused with a message, not passed over
        ("~$drive.xlsx", False),
        (".drive.xlsx", False),
        ("README.txt", False),
        ("photo.jpg", False),
    ],
)
def test_raw_data_is_told_from_notes(name: str, expected: bool) -> None:
    assert is_raw(name) is expected


def test_names_that_the_engine_would_misread_are_set_apart(raw: Path) -> None:
    folder = raw / "ant/mooring"
    folder.mkdir()
    for name in ("b 'q' $X.csv", "a.csv", "{code}.csv", "two\nlines.csv"):
        (folder / name).touch()
    (folder / "folder.csv").mkdir()
    ant = VehicleFolder("ant", "raw/ant")
    assert ant.raw_files("mooring", raw.parent) == (
        "raw/ant/mooring/a.csv",
        "raw/ant/mooring/b 'q' $X.csv",
    )
    assert ant.misnamed_files("mooring", raw.parent) == ("two?lines.csv", "{code}.csv")
    assert ant.raw_files("load_test", raw.parent) == ()


def test_path_with_braces_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "{x}" / "ant"
    folder.mkdir(parents=True)
    (folder / "vehicle.yaml").touch()
    vehicles, problems = choose([str(folder)], tmp_path / "raw", tmp_path / "out")
    assert vehicles == ()
    assert "holds a brace" in str(problems[0])


def test_raw_data_that_nothing_reads_is_pointed_out(raw: Path) -> None:
    ant = raw / "ant"
    for name in (
        "load_test/a.xlsx",
        "b.xlsx",
        "c.mcap",
        "photo.jpg",
        "runs/d.MCAP",
        "Pools/e.mcap",
    ):
        (ant / name).parent.mkdir(exist_ok=True)
        (ant / name).touch()
    (ant / "drawings").mkdir()
    (ant / "drawings" / "hull.step").touch()
    found = VehicleFolder("ant", "raw/ant").misplaced_problems(raw.parent)
    assert [one.severity for one in found] == ["warning"] * 4
    told = {one.place.file: str(one) for one in found}
    assert set(told) == {"ant/b.xlsx", "ant/c.mcap", "ant/runs", "ant/Pools"}
    assert "Move it into pool/." in told["ant/c.mcap"]
    assert "holds raw files (1) that are not read" in told["ant/runs"]
    assert "Rename it to pool." in told["ant/Pools"]


def test_a_tidy_folder_has_nothing_misplaced(raw: Path) -> None:
    assert VehicleFolder("bee", "raw/bee").misplaced_problems(raw.parent) == ()
    assert VehicleFolder("wasp", "raw/wasp").misplaced_problems(raw.parent) == ()
