"""What a simulation is not asked for, and which option says so."""

from pathlib import Path

import pytest

from pipeline.plan import UsageError
from pipeline.stages.simulation_request import SimulationRequest, check_request


@pytest.mark.parametrize("name", ["x.txt", "noext", "run.mcap.gz", "mcap"])
def test_a_log_is_written_under_the_name_of_a_log(name: str) -> None:
    with pytest.raises(UsageError, match=r"--to .*\*\.mcap"):
        check_request(SimulationRequest("rov8", Path(name), manoeuvre="hover"))


@pytest.mark.parametrize("name", ["x.mcap", "a/b.MCAP"])
def test_either_case_will_do(name: str) -> None:
    check_request(SimulationRequest("rov8", Path(name), manoeuvre="hover"))
