"""The bundled day with a weak thruster, told against the day before, when the vehicle was sound."""

import json
import shutil
from pathlib import Path

import pytest
from bundled_bench import bench_of_mmt300
from click.testing import CliRunner

from pipeline.cli import cli

SOUND = ("2024-05-14-heave-steps", "2024-05-14-surge-steps", "2024-05-14-zig-zag")
DAY = ("2024-05-15-pitch-steps", "2024-05-15-straight", "2024-05-15-zig-zag")


def test_the_weak_thruster_is_named_in_the_run_that_shows_it(
    repository: Path, tmp_path_factory: pytest.TempPathFactory, tmp_path: Path
) -> None:
    """The upper thruster gives 0.70 in the zig-zag; the other two runs are as they should be."""
    bench = bench_of_mmt300(repository, tmp_path_factory)
    for top in ("raw", "processed"):
        shutil.copytree(bench / top, tmp_path / top)
    shutil.copytree(
        repository / "raw/mmt300/pool", tmp_path / "raw/mmt300/pool", dirs_exist_ok=True
    )
    places = ["--raw", str(tmp_path / "raw"), "--out", str(tmp_path)]
    done = CliRunner().invoke(cli, ["diagnose", "mmt300", *DAY, "--healthy", *SOUND, *places])
    assert done.exit_code == 0, done.output
    (file,) = (tmp_path / "processed/mmt300").glob("**/diagnosis.json")
    verdict = json.loads(file.read_text())
    ranking, verdict = verdict["ranking"], verdict["verdict"]
    assert verdict["effects"] == ["thruster_degraded"]
    assert verdict["detail"]["thruster"] == "upper"
    assert verdict["runs"] == ["2024-05-15-zig-zag"]
    assert verdict["probability"] > 0.5
    low, high = ranking[0]["parameters"]["thrust_fraction"]["ci95"]
    assert low < 0.70 < high
