"""Notes of a run: everything documented is accepted, everything else refused with its line."""

from pathlib import Path

import pytest

from pipeline.errors import InputError
from pipeline.vehicle.run_notes import notes_file, read_run_notes

WHOLE = """\
what: zig-zag at half speed
who: [Ivanova, Petrov]
when: 2024-05-14
where: towing tank, east end
battery_v: 25.2
healthy: true
ballast:
  - {what: lead, mass_kg: 0.5, displaced_kg: 0.044, position_m: [0.2, 0.0, 0.1]}
  - {what: foam block taken off, mass_kg: -0.1, displaced_kg: -0.6}
water: {kind: fresh, density_kgpm3: 998.2, temperature_c: 19.5, depth_m: 3.0, waves: none}
tether: {attached: true, paid_out_m: 25, diameter_mm: 7.5, note: held by hand}
changed: new propeller on the upper thruster
text: |
  The vehicle touched the wall at 70 s.
"""


def read(path: Path, text: str) -> object:
    path = path / "run.yaml"
    path.write_text(text, encoding="utf-8")
    return read_run_notes(path, "auv/pool/run.yaml")


def test_everything_that_is_documented_is_read(tmp_path: Path) -> None:
    read(tmp_path, WHOLE)
    notes = read_run_notes(tmp_path / "run.yaml", "auv/pool/run.yaml")
    assert notes.who == ("Ivanova", "Petrov")
    assert notes.when == "2024-05-14"
    assert notes.changed == ("new propeller on the upper thruster",)
    assert notes.ballast[0].position_m == (0.2, 0.0, 0.1)
    assert notes.ballast[1].mass_kg == -0.1
    assert notes.water is not None
    assert notes.water.density_kgpm3 == 998.2
    assert notes.tether is not None
    assert notes.tether.paid_out_m == 25.0
    assert notes.text == "The vehicle touched the wall at 70 s.\n"
    assert notes.file == "auv/pool/run.yaml"


@pytest.mark.parametrize("text", ["", "# nothing yet\n", "\n  \n"])
def test_empty_notes_are_notes(tmp_path: Path, text: str) -> None:
    assert read(tmp_path, text) == read(tmp_path, "what: ''\n")


@pytest.mark.parametrize(
    ("text", "row", "says"),
    [
        ("who: A\nbalast: []\n", 2, 'Did you mean "ballast"?'),
        ("water: {density_kgpm3: 1.0}\n", 1, "water.density_kgpm3 is 1.0."),
        ("battery_v: '25'\n", 1, "Remove the quotes."),
        ("tether: {}\n", 1, 'key "attached" is missing in tether'),
        ("ballast:\n  - {what: lead, mass_kg: 0,5}\n", 2, 'unknown key "5"'),
        ("what: [1\n", 2, "YAML"),
        (f"text: {'x' * 20_001}\n", 1, "text"),
        ("- a\n- b\n", 1, ""),
    ],
)
def test_what_is_wrong_is_named_with_its_line(
    tmp_path: Path, text: str, row: int, says: str
) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert caught.value.problem.place.file == "auv/pool/run.yaml"
    assert caught.value.problem.place.row == row
    assert says in str(caught.value)


def test_notes_are_bounded(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="larger than 100 kB"):
        read(tmp_path, f"text: {'x' * 100_001}\n")


def test_notes_stand_beside_the_log(tmp_path: Path) -> None:
    log = tmp_path / "a.b.mcap"
    assert notes_file(log) is None
    (tmp_path / "a.b.yml").write_text("what: x\n")
    assert notes_file(log) == tmp_path / "a.b.yml"
    (tmp_path / "a.b.yaml").write_text("what: y\n")
    assert notes_file(log) == tmp_path / "a.b.yaml"
