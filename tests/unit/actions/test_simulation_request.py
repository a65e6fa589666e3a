"""What a simulation is not asked for, and which option says so."""

from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer

from pipeline.actions.simulation_request import SimulationRequest, check_request
from pipeline.plan import UsageError


@pytest.mark.parametrize("name", ["x.txt", "noext", "run.mcap.gz", "mcap"])
def test_a_log_is_written_under_the_name_of_a_log(name: str) -> None:
    with pytest.raises(UsageError, match=r"--to .*\*\.mcap"):
        check_request(SimulationRequest("rov8", Path(name), manoeuvre="hover"))


@pytest.mark.parametrize("name", ["x.mcap", "a/b.MCAP"])
def test_either_case_will_do(name: str) -> None:
    check_request(SimulationRequest("rov8", Path(name), manoeuvre="hover"))


@pytest.mark.parametrize("link", ["", "link_to", "symlink_to"])
def test_the_log_that_is_simulated_is_not_written_over(tmp_path: Path, link: str) -> None:
    """A replay of a log that was cut off would leave nothing of the rest."""
    log = to = tmp_path / "run.mcap"
    log.write_bytes(b"measured")
    if link == "link_to":
        to = tmp_path / "same.mcap"
        to.hardlink_to(log)
    elif link == "symlink_to":
        to = tmp_path / "same.mcap"
        to.symlink_to(log)
    with pytest.raises(UsageError, match=r"--to .* is the log of --run"):
        check_request(SimulationRequest("rov8", to, log=log))
    check_request(SimulationRequest("rov8", tmp_path / "other.mcap", log=log))


@pytest.mark.parametrize(
    "shape", [{"duration_s": 5.0}, {"amplitude": 3.0}, {"allocator": "paper-mooring"}]
)
def test_what_shapes_a_manoeuvre_is_not_passed_over_with_a_log(shape: dict[str, Any]) -> None:
    option = f"--{next(iter(shape)).removesuffix('_s')}"
    with pytest.raises(UsageError, match=f"{option} shapes a manoeuvre"):
        check_request(SimulationRequest("rov8", Path("x.mcap"), log=Path("run.mcap"), **shape))
    check_request(SimulationRequest("rov8", Path("x.mcap"), manoeuvre="hover", **shape))


def test_a_log_of_another_program_is_not_written_over(tmp_path: Path) -> None:
    with (tmp_path / "measured.mcap").open("wb") as stream:
        Writer(stream).start(profile="ros2", library="rosbag2")
    (tmp_path / "empty.mcap").touch()
    with pytest.raises(UsageError, match=r"--to .*measured\.mcap: this file .* not written by"):
        check_request(SimulationRequest("rov8", tmp_path / "measured.mcap", manoeuvre="hover"))
    for name in ("empty.mcap", "new.mcap"):
        check_request(SimulationRequest("rov8", tmp_path / name, manoeuvre="hover"))


def test_a_simulated_log_may_be_written_anew(repository: Path) -> None:
    bundled = repository / "raw/mmt300/pool/2024-05-15-straight.mcap"  # simulated as well
    check_request(SimulationRequest("rov8", bundled, manoeuvre="hover"))
