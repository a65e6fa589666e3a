"""Added masses from shapes: the papers' figures, the moved parts, and a section that is read."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from pipeline.actions.design import design_added_mass
from pipeline.bundled.design import design_example
from pipeline.cli import cli
from pipeline.vehicle.model_schema import AddedMass
from pipeline.vehicle.yaml_text import parse


def test_the_vehicle_of_the_paper() -> None:
    found = design_added_mass(design_example("added-mass", "potapov"))
    diagonal = np.diag(found.matrix)
    np.testing.assert_allclose(diagonal, [12.02, 12.02, 26.87, 1.15, 1.15, 0.0], atol=0.006)
    assert np.count_nonzero(found.matrix - np.diag(diagonal)) == 0


def test_a_hull_and_its_motor_housings_as_a_section_of_the_vehicle_file() -> None:
    found = design_added_mass(design_example("added-mass", "mmt300"))
    stated = parse(found.section.encode(), "a.yaml").plain()["added_mass"]
    section = AddedMass.model_validate(stated, strict=False)
    assert section.matrix is not None
    np.testing.assert_allclose(section.matrix, found.matrix, atol=1e-4)
    # the vehicle file's own estimates: Lamb's spheroid of the hull, housings as cylinders in roll
    surge, sway, heave, roll, _, yaw = np.diag(found.matrix)
    assert surge == pytest.approx(3.94, rel=0.1)
    assert sway == pytest.approx(heave, rel=0.02)
    assert sway == pytest.approx(97.7, rel=0.06)
    assert 0.04 < roll < 0.09
    # the hull is fuller towards its ends than the spheroid
    assert 18.9 < yaw < 25.0
    # housings behind the origin: their water makes sway and yaw go together
    assert found.matrix[1, 5] < 0.0 < found.matrix[2, 4]


def test_the_command_writes_the_section_and_names_a_wrong_shape(tmp_path: Path) -> None:
    file = tmp_path / "one.yaml"
    text = design_example("added-mass", "potapov").read_text(encoding="utf-8")
    file.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(cli, ["design", "added-mass", str(file), "--to", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert "diagonal: [12.01" in done.output
    assert (tmp_path / "potapov-added-mass.yaml").read_text() in done.output
    assert len(json.loads((tmp_path / "potapov-added-mass.json").read_text())["matrix"]) == 6
    file.write_text(text.replace("inner_side_m: 0.24", "inner_side_m: 0.4"), encoding="utf-8")
    done = CliRunner().invoke(cli, ["design", "added-mass", str(file)])
    assert done.exit_code == 1
    assert "inner_side_m must be below outer_side_m" in done.output
