"""The workflow on a Slurm of its own, two nodes of one slot on this machine: ``make cluster``."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from synthetic_bench import Bench

SLURM = Path(__file__).parents[2] / ".ci/throwaway_slurm.sh"
PATIENCE_S = 1200.0

pytestmark = pytest.mark.skipif(
    os.environ.get("RIG2SEA_CLUSTER") != "1", reason="takes minutes and needs root: make cluster"
)


@pytest.fixture(scope="module")
def cluster() -> Iterator[dict[str, str]]:
    """Give the environment in which the commands of Slurm find the throw-away cluster."""
    with tempfile.TemporaryDirectory(prefix="slurm-", dir="/tmp") as folder:  # sockets: short
        try:
            subprocess.run([str(SLURM), "start", folder], check=True, timeout=60)
            yield {**os.environ, "SLURM_CONF": f"{folder}/slurm.conf"}
        finally:
            subprocess.run([str(SLURM), "stop", folder], check=False, timeout=60)


def jobs(environment: dict[str, str]) -> list[tuple[str, str, str, str]]:
    """Return number, state, node and rule of every job, past ones too."""
    listed = subprocess.run(
        ["squeue", "--noheader", "--states=all", "--format=%i|%T|%N|%k"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    rows = [line.split("|") for line in listed.stdout.splitlines()]
    return [(row[0], row[1], row[2], row[3]) for row in rows]


def stage_process(root: Path) -> int | None:
    """Return the number of a process that runs stages in a folder."""
    for entry in Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
            if (
                words[1:4] == [b"-m", b"pipeline", b"stages"]
                and (entry / "cwd").resolve() == root.resolve()
            ):
                return int(entry.name)
        except OSError:
            continue
    return None


def start(root: Path, environment: dict[str, str]) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-m", "pipeline", "run", "--profile", "slurm"],
        cwd=root,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def test_results_are_those_of_a_local_run_and_killed_jobs_are_submitted_again(
    finished: Bench, fresh: Bench, cluster: dict[str, str]
) -> None:
    shutil.copytree(fresh.root / "raw/boat", fresh.root / "raw/launch")  # a job for each node
    begun = time.monotonic()
    run = start(fresh.root, cluster)
    cancelled = killed = None
    while run.poll() is None and time.monotonic() - begun < PATIENCE_S:
        running = [row for row in jobs(cluster) if row[1] == "RUNNING"]
        if cancelled is None and running:  # by the administrator
            cancelled = running[0][0]
            subprocess.run(["scancel", cancelled], env=cluster, check=True, timeout=60)
        elif killed is None and any(row[0] != cancelled for row in running):
            killed = stage_process(fresh.root)  # by the kernel, short of memory
            if killed is not None:
                os.kill(killed, signal.SIGKILL)
        time.sleep(0.02)
    run.kill()
    printed = run.communicate()[0]
    assert run.returncode == 0, printed
    assert killed is not None
    seen = jobs(cluster)
    assert (cancelled, "CANCELLED") in {(number, state) for number, state, _, _ in seen}
    states = [state for _, state, _, name in seen if name.startswith("rule_stages_")]
    assert states.count("COMPLETED") == 3, states  # two vehicles and the index
    assert len(states) == 5, states
    assert {node for _, _, node, _ in seen} >= {"node1", "node2"}
    found = fresh.contents()
    assert {name: found[name] for name in finished.contents() if "boat" in name} == {
        name: own for name, own in finished.contents().items() if "boat" in name
    }
    print(f"\n{len(seen)} jobs in {time.monotonic() - begun:.0f} s, two of them killed")


def test_stopped_run_cancels_its_jobs(fresh: Bench, cluster: dict[str, str]) -> None:
    before = {number for number, *_ in jobs(cluster)}
    run = start(fresh.root, cluster)
    begun = time.monotonic()
    while time.monotonic() - begun < PATIENCE_S:
        mine = [row for row in jobs(cluster) if row[0] not in before]
        if any(state == "RUNNING" for _, state, _, _ in mine):
            break
        time.sleep(0.1)
    run.send_signal(signal.SIGTERM)
    printed = run.communicate(timeout=120)[0]
    assert run.returncode == 1, printed
    assert "stopped. The next run goes on from here." in printed
    time.sleep(2.0)  # the nodes end what they run
    left = [
        row for row in jobs(cluster) if row[0] not in before and row[1] in {"PENDING", "RUNNING"}
    ]
    assert left == []
