"""``rig2sea identify`` on logs of the simulator, and what it says to bad ones."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.cli import cli
from pipeline.vehicle.load import load_vehicle

Rig2sea = Callable[..., Result]


def rig2sea(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(one) for one in arguments])


#: Factor on the added mass in heave of the vehicle that is identified.
HEAVIER = 1.4


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two short runs of rov8."""
    folder = tmp_path_factory.mktemp("logs")
    for name, seconds in (("multisine", 24), ("surge_steps", 20), ("heave_steps", 3)):
        flown = rig2sea(
            *("simulate", "rov8", "--manoeuvre", name, "--duration", seconds),
            *("--to", folder / f"{name}.mcap"),
        )
        assert flown.exit_code == 0, flown.output
    return folder


def test_values_intervals_and_a_vehicle_file_come_out(logs: Path, tmp_path: Path) -> None:
    # a vehicle that its file does not describe: of one that it does no file would predict better
    heavy = logs / "heavy_multisine.mcap"
    flown = rig2sea(
        *("simulate", "rov8", "--manoeuvre", "multisine", "--duration", 40, "--to", heavy),
        *("--effect", f"added_mass:heave={HEAVIER}"),
    )
    assert flown.exit_code == 0, flown.output
    found = rig2sea("identify", "rov8", heavy, "--no-advice", "--to", tmp_path)
    assert found.exit_code == 0, found.output
    assert "added_mass_heave" in found.stdout
    assert "vehicle file with these values" in found.stdout
    record = json.loads((tmp_path / "identification.json").read_text())
    by_name = {one["name"]: one for one in record["whole_vehicle"]["parameters"]}
    heave = by_name["added_mass_heave"]
    assert heave["value"] == pytest.approx(HEAVIER * 18.68, rel=0.05)
    assert heave["stands"]
    written = load_vehicle(tmp_path / "vehicle_identified.yaml")
    assert written.model is not None
    assert written.model.added_mass.diagonal is not None
    assert written.model.added_mass.diagonal[2] == pytest.approx(heave["file_value"], rel=1e-6)
    own = (Path(bundled_vehicle("rov8")) / "vehicle.yaml").read_text(encoding="utf-8")
    assert "# Table A1: metacentric height 10 mm" in own
    kept = (tmp_path / "vehicle_identified.yaml").read_text(encoding="utf-8")
    assert "# Table A1: metacentric height 10 mm" in kept


def test_the_slope_alone_as_json(logs: Path, tmp_path: Path) -> None:
    found = rig2sea(
        *("identify", "rov8", logs / "surge_steps.mcap", "--method", "straight-line"),
        *("--smoother", "moving-average", "--json", "--to", tmp_path),
    )
    assert found.exit_code == 0, found.output
    record = json.loads(found.stdout)
    assert record["whole_vehicle"] is None
    (surge,) = [one for one in record["straight_line"] if one["axis"] == "surge"]
    assert surge["smoother"].startswith("moving average")
    assert not (tmp_path / "vehicle_identified.yaml").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (("rov8", "nowhere"), 2, 'no run "nowhere"'),
        (("rov8", "multisine.mcap", "multisine.mcap"), 2, "named twice"),
        (("rov8", "multisine.mcap", "--without", "smell"), 2, "--without smell"),
        (("rov8", "multisine.mcap", "--only", "sideways"), 2, "--only sideways: there are added"),
        (("rov8", "heave_steps.mcap"), 1, "the run is 3.0 s long"),
        (("cargo_carrier", "multisine.mcap"), 1, "the log is of the vehicle rov8"),
        (
            ("rov8", "multisine.mcap", "--holdout", "multisine.mcap"),
            1,
            "given both to fit and to judge",
        ),
        (
            (
                *("rov8", "multisine.mcap", "--without", "velocity", "--without", "attitude"),
                *("--without", "angular_velocity", "--without", "specific_force"),
                *("--without", "depth", "--without", "position"),
            ),
            1,
            "no channel that a fit can use",
        ),
    ],
)
def test_bad_input_is_one_clear_message(
    logs: Path, tmp_path: Path, arguments: tuple[str, ...], code: int, says: str
) -> None:
    given = [logs / one if one.endswith(".mcap") else one for one in arguments]
    found = rig2sea("identify", *given, "--to", tmp_path)
    assert found.exit_code == code, found.output
    assert says in found.output
    assert "Traceback" not in found.output
