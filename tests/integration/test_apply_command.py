"""A finding written into vehicle.yaml: shown first, traced afterwards, taken back to the byte."""

import difflib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from allocator_model import allocate_single
from bundled_bench import bench_of_mmt300
from click.testing import CliRunner, Result
from single_model import single_tables, thrust_from_code

from pipeline.actions.found_changes import diagnosed_changes
from pipeline.cli import cli
from pipeline.control.inverse import firmware_grid
from pipeline.effects.library import parse_effect
from pipeline.export.allocator_layout import allocator_layout
from pipeline.inputs.simulated_vehicle import load_inverse, load_simulated
from pipeline.provenance import Envelope, canonical_json, file_digest, write_envelope
from pipeline.records.day_findings import DayDiagnosis, DayFinding, RunDiagnosis
from pipeline.records.diagnosis import (
    Detail,
    DiagnosisRecord,
    Evidence,
    Gap,
    Leftover,
    ParameterEstimate,
    RankedEffect,
    Shrink,
    Verdict,
    Where,
)
from pipeline.vehicle.load import load_vehicle

RUN = "2024-05-15-zig-zag"


def record() -> DiagnosisRecord:
    """What a diagnosis says of an upper thruster with 0.69 of its thrust."""
    fraction = ParameterEstimate(value=0.69, unit="1", ci95=(0.63, 0.76))
    weak = RankedEffect(
        effect="thruster_degraded", probability=0.99, parameters={"thrust_fraction": fraction},
        gap_closed=0.97, thruster="upper", log_evidence=40.0,
    )  # fmt: skip
    return DiagnosisRecord(
        vehicle="mmt300", runs=(RUN,), holdout=(), ranking=(weak,), confusable=(), next_run=None,
        gap=Gap(channels={}, where=Where(channels=(), regimes=(), times=())),
        verdict=Verdict(
            effects=("thruster_degraded",), probability=0.99, ambiguous_with=(),
            detail=Detail(thruster="upper"), sentence="The upper thruster is weak.",
        ),
        shrink=Shrink(before=1.5, after=0.2, noise_floor=1.0, gap_closed=1.0, ci95=None,
                      channels={}, held_out="every 4th window"),
        leftover=Leftover(axes={}, worst_axis="surge", time_course="even", depends_on=None,
                          correlation=None),
        evidence=Evidence(windows=1, window_s=6.0, readings=1, linearisations=1, force_scale=1.0,
                          noise={}, stages={}, calibrated="", healthy_runs=()),
        series=(), notes=(), elapsed_s=0.0,
    )  # fmt: skip


@pytest.fixture
def folder(repository: Path, tmp_path_factory: pytest.TempPathFactory, tmp_path: Path) -> Path:
    """mmt300 with its bench results and a diagnosis."""
    bench = bench_of_mmt300(repository, tmp_path_factory)
    shutil.copytree(bench / "processed/mmt300", tmp_path / "processed/mmt300")
    (tmp_path / "raw/mmt300").mkdir(parents=True)
    shutil.copy(repository / "raw/mmt300/vehicle.yaml", tmp_path / "raw/mmt300")
    one = load_simulated("mmt300", tmp_path / "raw", tmp_path)
    spec = parse_effect("thruster_degraded:thrust_fraction=0.69@upper")
    changes = diagnosed_changes(one, record().ranking[0], [spec])
    told = record().model_copy(update={"changes": changes, "vehicle_file_sha256": one.file_digest})
    file = tmp_path / "processed/mmt300/diagnosis/diagnosis.json"
    file.parent.mkdir(exist_ok=True)
    file.write_text(canonical_json(told.model_dump(mode="json")), encoding="utf-8")
    return tmp_path


def said(folder: Path, *words: str) -> Result:
    places = ["--raw", str(folder / "raw"), "--out", str(folder)]
    return CliRunner().invoke(cli, [*words, *places], catch_exceptions=False)


def test_from_a_diagnosis_to_the_firmware_and_back(folder: Path) -> None:
    file = folder / "raw/mmt300/vehicle.yaml"
    first, before = file.read_bytes(), load_vehicle(file)
    grid = firmware_grid(load_inverse("mmt300", folder))

    # shown, and nothing written
    shown = said(folder, "apply", "mmt300", "diagnosis", "--json")
    assert shown.exit_code == 0, shown.output
    told = json.loads(shown.output)
    assert file.read_bytes() == first
    assert told["applied"] is None
    assert [(one["path"], one["old"], one["value"]) for one in told["changes"]] == [
        ("thrusters.0.gain_ahead", 1.0, pytest.approx(0.69)),
        ("thrusters.0.gain_reverse", 1.0, pytest.approx(0.69)),
    ]
    assert told["changes"][0]["ci95"] == pytest.approx([0.63, 0.76])
    assert told["codes_stay"] == ["lower", "left", "right", "bow"]
    assert [one["speed_mps"] for one in told["codes"]] == list(before.tables.speed_mps)
    for row in told["codes"]:
        thrust, speed = np.array(row["thrust_n"]), np.full(10, row["speed_mps"])
        assert (np.abs(grid.code(thrust, speed) - row["old"]) <= 0.51).all()
        assert (np.abs(grid.code(thrust / 0.69, speed) - row["new"]) <= 0.51).all()

    # written: two lines more, all comments there, each number traced
    done = said(folder, "apply", "mmt300", "diagnosis", "--yes")
    assert done.exit_code == 0, done.output
    after = load_vehicle(file)
    assert after.thrusters[0].gain_ahead == after.thrusters[0].gain_reverse == 0.69
    moved = [
        line
        for line in difflib.ndiff(first.decode().splitlines(), file.read_text().splitlines())
        if line[0] in "+-"
    ]
    assert len(moved) == 2
    assert all("ci95: [0.63, 0.76]" in line and RUN in line for line in moved)
    for key in ("gain_ahead", "gain_reverse"):
        why = said(folder, "why", "mmt300", f"thrusters.upper.{key}").output
        assert "0.63 to 0.76" in why
        assert "diagnosis.json" in why
        assert "as it was read" in why

    # flown on the weak vehicle the error of the exported allocator falls to that of the sound one
    characteristic = load_inverse("mmt300", folder).firmware
    assert characteristic is not None
    tables = single_tables(characteristic)
    wrench = np.random.default_rng(1).uniform(-1, 1, (200, 6)) * [40, 0, 10, 0, 6, 6]
    errors, codes = {}, {}
    for name, vehicle, gain in (
        ("sound", before, 1.0), ("weak", before, 0.69), ("corrected", after, 0.69),
    ):  # fmt: skip
        layout = allocator_layout(vehicle, characteristic)
        meant, codes[name], _ = allocate_single(layout, [tables], wrench, np.zeros((200, 3)))
        given = thrust_from_code(tables, codes[name], np.zeros((200, 5))).astype(float)
        given[:, 0] *= gain
        left = (given - meant) @ layout.allocation.matrix.T
        errors[name] = float(np.sqrt(np.mean(left[:, [0, 4]] ** 2)))
    assert errors["weak"] > 3.0 * errors["sound"]
    assert errors["corrected"] < 1.3 * errors["sound"]

    # once is enough, and back to the byte
    again = said(folder, "apply", "mmt300", "diagnosis", "--yes")
    assert again.exit_code == 1
    assert "already" in again.output
    undone = said(folder, "apply", "mmt300", "--undo")
    assert undone.exit_code == 0, undone.output
    assert file.read_bytes() == first
    assert said(folder, "apply", "mmt300", "--undo").exit_code == 1
    assert sorted(path.name for path in file.parent.iterdir()) == [
        "vehicle.yaml", "vehicle.yaml.1.json",
    ]  # fmt: skip


def test_the_fault_of_a_trial_day(folder: Path) -> None:
    """The day's diagnosis named it in one of its runs: the same changes, and no others."""
    day = DayDiagnosis(
        vehicle="mmt300", day="2024-05-15", against="the vehicle file",
        findings=(
            DayFinding(effects=("thruster_degraded",), thruster="upper", runs=(RUN,), by="run",
                       probability=0.99, ranked=record().ranking[0]),
            DayFinding(effects=("none",), thruster=None, runs=("2024-05-15-straight",), by="run",
                       probability=0.9),
        ),
    )  # fmt: skip
    file = folder / "raw/mmt300/vehicle.yaml"
    inputs = {"raw/mmt300/vehicle.yaml": file_digest(file)}
    path = folder / "processed/mmt300/day_diagnoses/2024-05-15.json"
    write_envelope(path, Envelope("day_diagnosis", "mmt300", inputs, "", day))
    alone = RunDiagnosis(
        vehicle="mmt300", run=RUN, day="2024-05-15", against="the vehicle file", record=record()
    )
    own = folder / f"processed/mmt300/run_diagnoses/{RUN}.json"
    write_envelope(own, Envelope("run_diagnosis", "mmt300", inputs, "", alone))
    # the page of the run names the run, that of the day the day
    of_run = json.loads(said(folder, "apply", "mmt300", RUN, "--json").output)
    of_day = json.loads(said(folder, "apply", "mmt300", "2024-05-15", "--json").output)
    assert of_run["changes"] == of_day["changes"]
    assert of_run["held_out"]
    done = said(folder, "apply", "mmt300", "2024-05-15", "--yes")
    assert done.exit_code == 0, done.output
    assert f"gap of {RUN}, in healthy floors: " in done.output
    after = load_vehicle(file).thrusters
    assert [one.gain_ahead for one in after] == [0.69, 1.0, 1.0, 1.0, 1.0]
    assert f"diagnosis of {RUN}" in file.read_text()
    assert "changed after" in said(folder, "apply", "mmt300", "2024-05-15").output


def test_what_was_edited_since_is_not_lost(folder: Path) -> None:
    file = folder / "raw/mmt300/vehicle.yaml"
    assert said(folder, "apply", "mmt300", "diagnosis", "--yes").exit_code == 0
    file.write_text(file.read_text() + "# my note\n")
    done = said(folder, "apply", "mmt300", "--undo")
    assert done.exit_code == 1
    assert "vehicle.yaml.1.before" in done.output


@pytest.mark.parametrize(
    ("words", "code", "says"),
    [
        (("mmt300", "2024-05-16"), 2, "no result"),
        (("mmt300",), 2, "--undo"),
        (("rov8", "diagnosis"), 2, "rig2sea new NAME --like rov8"),
    ],
)
def test_what_cannot_be_applied(folder: Path, words: tuple[str, ...], code: int, says: str) -> None:
    done = said(folder, "apply", *words)
    assert done.exit_code == code
    assert says in done.output


def test_a_file_that_is_another_now_is_refused(folder: Path) -> None:
    file = folder / "raw/mmt300/vehicle.yaml"
    file.write_text(
        file.read_text().replace("  - name: upper", "  - gain_ahead: 0.9\n    name: upper")
    )
    done = said(folder, "apply", "mmt300", "diagnosis", "--yes")
    assert done.exit_code == 1
    assert "started from 1.0" in done.output
