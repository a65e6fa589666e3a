"""``rig2sea design`` as a user types it."""

import contextlib
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from click.testing import CliRunner

from pipeline.bundled.design import design_example, design_examples
from pipeline.cli import cli

Done = subprocess.CompletedProcess[str]
#: Every example that needs no bench results.
EXAMPLES = [
    ("balance", "pilgrim"),
    ("propeller", "pilgrim"),
    ("propeller", "remus"),
    ("tether", "mokeeva"),
    ("tether", "rov8"),
]


def design(folder: Path, *arguments: str) -> Done:
    with contextlib.chdir(folder):
        result = CliRunner().invoke(cli, ["design", *arguments], prog_name="rig2sea")
    return Done(arguments, result.exit_code, result.stdout, result.stderr)


def example(folder: Path, calculator: str, name: str = "") -> Path:
    done = design(folder, calculator, "--example", *([name] if name else []))
    assert done.returncode == 0, done.stderr
    path = folder / "my.yaml"
    path.write_text(done.stdout, encoding="utf-8")
    return path


def refused(done: Done) -> str:
    assert done.returncode == 1
    assert "Traceback" not in done.stdout + done.stderr
    assert done.stdout == ""
    return done.stderr


@pytest.mark.parametrize(("calculator", "name"), EXAMPLES)
def test_an_example_becomes_a_page_and_a_json_file(
    tmp_path: Path, calculator: str, name: str
) -> None:
    path = example(tmp_path, calculator, name)
    assert path.read_bytes() == design_example(calculator, name).read_bytes()
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("step_deg: 30", "step_deg: 90"), encoding="utf-8")  # quicker
    done = design(tmp_path, calculator, "my.yaml")
    assert done.returncode == 0, done.stderr
    page, data = (tmp_path / line for line in done.stdout.splitlines()[-2:])
    text = page.read_text(encoding="utf-8")
    assert '<script defer src="../assets/zoom.js"></script>' in text
    assert not re.search(r'(?:src|href)="https?:', text)
    assert text.count('<svg class="plot"') >= 2
    body = json.loads(data.read_text(encoding="utf-8"))
    assert body["schema"] == f"rig2sea/design-{calculator}/1"
    for row in body["printed"]:  # each printed number is on the page, with ours and a reason
        assert row["difference"] == pytest.approx(row["computed"] - row["printed"])
        assert row["within_rounding"] or row["reason"]
    assert ("Printed numbers beside ours" in text) == bool(body["printed"])
    assert sorted(p.name for p in page.parent.iterdir()) == sorted([page.name, data.name])


def test_the_same_file_gives_the_same_bytes(tmp_path: Path) -> None:
    example(tmp_path, "propeller")
    for to in ("a", "b"):
        assert design(tmp_path, "propeller", "my.yaml", "--to", to).returncode == 0
    for name in ("pilgrim-propeller.html", "pilgrim-propeller.json"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_json_goes_to_the_screen_and_no_file_is_written(tmp_path: Path) -> None:
    example(tmp_path, "balance")
    done = design(tmp_path, "balance", "my.yaml", "--json")
    assert json.loads(done.stdout)["exact"]["angle_of_attack_deg"] == pytest.approx(
        -2.97, abs=0.005
    )
    assert [path.name for path in tmp_path.iterdir()] == ["my.yaml"]


def test_the_names_of_the_examples_are_listed(tmp_path: Path) -> None:
    for calculator in ("balance", "propeller", "tether"):
        done = design(tmp_path, calculator, "--example", "list")
        assert tuple(done.stdout.split()) == design_examples(calculator)


@pytest.mark.parametrize(
    ("calculator", "old", "new", "message"),
    [
        ("balance", "speed_mps: 3.0\n", "speed: 3.0\n", r'row \d+: unknown key "speed".*speed_mps'),
        ("balance", "drag_n: 148.0", "drag_n: -148.0", r"drag_n is -148.*above 0"),
        ("balance", "angle_deg: 22.5", "angle_deg: 22,5", r"decimal point: 22.5"),
        ("balance", "speed_mps: 3.0\n", "speed_mps: 0.4\n", r"cannot be carried.*at most [\d.]+ N"),
        ("propeller", "thrust_n: 64.3", "thrust_n: 400", r"The most is [\d.]+ N"),
        ("propeller", "diameter_m: [0.10", "diameter_m: [0.30", r"smallest, largest"),
        ("propeller", "pitch_ratio: 1.3\n", "pitch_ratio: 1.9\n", r"pitch_ratio is 1.9.*1.4"),
        ("tether", "length_m: 200.0", "length_m: 60.0", r"at most 33.17 m"),
        ("tether", "step_deg: 30", "step_deg: 31", r"step_deg is 31"),
    ],
)
def test_a_wrong_or_impossible_wish_gets_one_sentence(
    tmp_path: Path, calculator: str, old: str, new: str, message: str
) -> None:
    path = example(tmp_path, calculator)
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    error = refused(design(tmp_path, calculator, "my.yaml"))
    assert re.search(message, error, re.DOTALL), error
    assert len(error) < 600
    assert not (tmp_path / "reports").exists()


def test_no_file_and_no_such_file(tmp_path: Path) -> None:
    done = design(tmp_path, "balance")
    assert done.returncode == 2
    assert "--example > my.yaml" in done.stderr
    done = design(tmp_path, "balance", "absent.yaml")
    assert done.returncode == 2
    assert "absent.yaml does not exist." in done.stderr
    assert "--example" in done.stderr
    assert "Traceback" not in done.stderr
    done = design(tmp_path, "balance", "--example", "nobody")
    assert done.returncode == 2
    assert "pilgrim" in done.stderr


def test_markup_in_a_file_does_not_reach_the_page(tmp_path: Path) -> None:
    path = example(tmp_path, "balance")
    text = path.read_text(encoding="utf-8")
    path.write_text(
        re.sub(r"title: .*", 'title: "<img src=x onerror=alert(1)> & K_T"', text), encoding="utf-8"
    )
    assert design(tmp_path, "balance", "my.yaml").returncode == 0
    page = (tmp_path / "reports/design/pilgrim-balance.html").read_text(encoding="utf-8")
    assert "<img" not in page
    assert "&lt;img" in page


def test_a_vehicle_with_tables_tells_codes_and_what_saturates(
    bench_folder: Path, tmp_path: Path
) -> None:
    path = example(tmp_path, "balance", "mmt300")
    done = design(bench_folder, "balance", str(path), "--json")
    assert done.returncode == 0, done.stderr
    body = json.loads(done.stdout)
    assert body["limit_kind"] == "the identified T(N, V) of mmt300, code 127"
    loads = {load["thruster"]: load for load in body["exact"]["loads"]}
    assert all(0 < load["code"] <= 127 and load["shaft_speed_rpm"] > 0 for load in loads.values())
    assert loads["upper"]["use"] == max(load["use"] for load in loads.values())
    first = body["saturation"][0]
    # alone, without buoyancy, four thrusters at full code just meet the drag at 2 m/s
    assert first["thruster"] == "upper"
    assert 1.5 < first["value"] < 2.0


def test_the_measured_drive_of_a_vehicle_drives_a_propeller(
    bench_folder: Path, tmp_path: Path
) -> None:
    path = example(tmp_path, "propeller")
    text = path.read_text(encoding="utf-8")
    drive = "drive:\n  kind: vehicle\n  vehicle: mmt300\n  code: 127\n"
    text = re.sub(r"drive:\n  kind: point\n.*?\n\n", f"{drive}\n", text, flags=re.DOTALL)
    text = text.replace("thrust_n: 64.3", "thrust_n: 25.0").replace(
        "speed_mps: 3.0", "speed_mps: 2.0"
    )
    text = re.sub(r"\ncandidate:.*", "\n", text, flags=re.DOTALL)
    path.write_text(text, encoding="utf-8")
    done = design(bench_folder, "propeller", str(path), "--json")
    assert done.returncode == 0, done.stderr
    best = json.loads(done.stdout)["ranked"][0]
    assert best["thrust_n"] == pytest.approx(25.0, rel=1e-4)
    assert best["full_power_thrust_n"] > 25.0
    # the drive's torque at that speed, from Tables 1 and 2 of Kostenko 2023: 0.53 to 0.73 N m
    assert 0.45 < best["full_power_torque_nm"] < 0.75


def test_without_bench_results_the_message_says_what_to_run(
    repository: Path, tmp_path: Path
) -> None:
    shutil.copytree(repository / "raw/mmt300", tmp_path / "raw/mmt300")
    path = example(tmp_path, "propeller")
    text = path.read_text(encoding="utf-8")
    drive = "drive: {kind: vehicle, vehicle: mmt300, code: 127}\n\n"
    path.write_text(
        re.sub(r"drive:\n  kind: point\n.*?\n\n", drive, text, flags=re.DOTALL), encoding="utf-8"
    )
    assert "rig2sea run mmt300" in refused(design(tmp_path, "propeller", "my.yaml"))
    example(tmp_path, "balance", "mmt300")
    done = design(tmp_path, "balance", "my.yaml")
    assert done.returncode == 0
    assert "rig2sea run mmt300" in done.stderr


def test_a_state_without_the_small_angle_form_has_its_page(tmp_path: Path) -> None:
    path = example(tmp_path, "balance")
    text = path.read_text(encoding="utf-8")
    for old, new in (
        ("metacentric_nm_per_rad: 0.70", "metacentric_nm_per_rad: 300.0"),
        ("\nspeed_mps: 3.0", "\nspeed_mps: 0.6"),
        ("\nresidual_buoyancy_n: 60.0", "\nresidual_buoyancy_n: 5.0"),
    ):
        assert text.count(old) == 1
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    done = design(tmp_path, "balance", "my.yaml")
    assert done.returncode == 0, done.stderr
    assert "The small-angle form is left out" in done.stderr
    assert "small angle" not in done.stdout
    page = (tmp_path / "reports/design/pilgrim-balance.html").read_text(encoding="utf-8")
    assert "most loaded thruster in the exact form" in page
    body = json.loads((tmp_path / "reports/design/pilgrim-balance.json").read_text("utf-8"))
    assert body["small_angle"] is None
