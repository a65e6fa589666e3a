"""Pool runs through the workflow: pages come, a broken log stops nothing, nothing is done twice."""

import dataclasses
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from run_log_cases import make_log
from shared_runs import rig2sea
from synthetic_bench import Bench

from pipeline.export.mcap_log import write_run_log
from pipeline.simulate.sensors import Log
from pipeline.workflow.pool_plan import DAY_STAGES

THRUSTERS = ("upper", "lower", "left", "right")
START_NS = 1_777_000_000_000_000_000
BROKEN = "brö{ken} <b>&.mcap"
STAGES = ("pool_run", "run_page", "run_trial", "run_diagnosis")


def write_log(path: Path, start_ns: int) -> None:
    log: Log = make_log(6.0)
    command = log["command"]
    codes = 60.0 * np.sin(command.valid_s[:, None] + np.arange(len(THRUSTERS)))
    log["command"] = dataclasses.replace(command, columns=THRUSTERS, values=np.round(codes))
    kept = {name: log[name] for name in ("command", "imu", "depth")}
    write_run_log(
        path,
        kept,
        vehicle_name="boat",
        density_kgpm3=1000.0,
        gravity_mps2=9.81,
        start_time_ns=start_ns,
    )


@pytest.fixture(scope="module")
def trials(
    _finished: tuple[Path, str], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Bench, str]:
    """Two good runs of two days and a broken one, run once; what it printed."""
    root = tmp_path_factory.mktemp("trials") / "bench"
    shutil.copytree(_finished[0], root)
    pool = root / "raw/boat/pool"
    write_log(pool / "first.mcap", START_NS)
    (pool / "first.yaml").write_text("what: sines <i>at</i> the wall\nwho: [Ann]\n")
    write_log(pool / "second.mcap", START_NS + 86_400_000_000_000)
    (pool / BROKEN).write_bytes(b"forty bytes that are no log whatsoever...")
    bench = Bench(root)
    done = bench.run("--cores", "1")  # the run that comes later has two
    assert done.returncode == 1
    return bench, done.stdout


def page(bench: Bench, name: str) -> str:
    return (bench.root / "reports" / name).read_text(encoding="utf-8")


def test_every_run_and_day_has_its_page(trials: tuple[Bench, str]) -> None:
    bench, _ = trials
    runs = sorted(path.stem for path in (bench.root / "reports/boat/runs").iterdir())
    assert runs[1:] == ["first", "second"]
    assert runs[0].startswith("br_ken_b-")
    days = sorted(path.stem for path in (bench.root / "reports/boat/trials").iterdir())
    assert days == ["2026-04-24", "2026-04-25", "undated"]


def test_broken_log_is_named_and_the_others_are_read(trials: tuple[Bench, str]) -> None:
    bench, printed = trials
    errors = re.findall(r"^error: (.*)", printed, re.MULTILINE)
    assert len(errors) == 1
    assert errors[0].startswith(f"raw/boat/pool/{BROKEN}: this is not MCAP")
    broken = next((bench.root / "reports/boat/runs").glob("br_ken*")).read_text(encoding="utf-8")
    assert "this is not MCAP" in broken
    assert "<b>&" not in broken
    assert "&lt;b&gt;&amp;" in broken


def test_page_leads_with_what_is_wrong_and_says_what_to_add(trials: tuple[Bench, str]) -> None:
    text = page(trials[0], "boat/runs/first.html")
    order = [
        text.index(f' id="{anchor}"') for anchor in ("warnings", "manoeuvres", "run", "health")
    ]
    assert order == sorted(order)
    assert "has no model: section" in text
    assert "A vehicle file with a model: section" in text
    assert "sines &lt;i&gt;at&lt;/i&gt; the wall" in text
    assert "/thrusters/command" in text
    assert 'id="fig-commands"' in text
    assert not re.search(r'(src|href|action)="(http|//)', text), "nothing from a network"


def test_pages_lead_to_each_other(trials: tuple[Bench, str]) -> None:
    bench = trials[0]
    reports = bench.root / "reports"
    for name in ("index.html", "boat/index.html", "boat/trials/2026-04-24.html",
                 "boat/trials/undated.html", "boat/runs/first.html"):  # fmt: skip
        folder = (reports / name).parent
        for address in re.findall(r'href="([^"#:]+)"', page(bench, name)):
            assert (folder / address).exists(), (name, address)
    assert "boat/trials/2026-04-25.html" in page(bench, "index.html")
    assert "runs/first.html" in page(bench, "boat/index.html")


def test_export_leaves_pool_runs_and_pages_alone(trials: tuple[Bench, str]) -> None:
    bench = trials[0]
    spoilt = bench.root / "processed/boat/run_trials/first.json"
    whole = spoilt.read_bytes()
    before = bench.results()
    spoilt.write_text("half")
    (bench.root / "processed/boat/firmware.json").unlink()
    # no page is written, so it does not matter that none could be
    reports, aside = bench.root / "reports", bench.root / "aside"
    reports.rename(aside)
    reports.write_text("in the way")
    done = rig2sea(bench.root, "export", "boat", "--to", "firmware")
    reports.unlink()
    aside.rename(reports)
    assert done.returncode == 0, done.stderr
    assert [stage for _, stage in bench.stages_run()] == ["firmware"]
    assert spoilt.read_text() == "half"
    spoilt.write_bytes(whole)
    assert bench.contents() == {name: own for name, (_, own) in before.items()}


def test_second_execution_does_nothing_and_one_more_run_is_one_more_run(
    trials: tuple[Bench, str],
) -> None:
    bench = trials[0]
    before = bench.results()
    done = bench.run()
    assert "Nothing to do" in done.stdout
    assert bench.stages_run() == []
    assert bench.results() == before

    write_log(bench.root / "raw/boat/pool/third.mcap", START_NS + 2 * 86_400_000_000_000)
    (bench.root / "raw/boat/pool" / BROKEN).unlink()
    done = rig2sea(bench.root, "watch", "--once", "--settle", "0.2")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert [line.partition(":")[0] for line in lines] == ["boat", "boat"]
    assert lines[0].startswith("boat: run third: not judged yet; 6 s; ")
    assert lines[0].endswith(": reports/boat/runs/third.html")
    assert lines[1].endswith(": reports/boat/trials/2026-04-26.html")
    made = [stage for _, stage in bench.stages_run()]
    assert sorted(made) == sorted([*STAGES, *DAY_STAGES, "vehicle_page", "index_page"])
    after = bench.results()
    for name, mark in before.items():
        if "br_ken" in name or ("undated" in name and "day_tables" not in name):
            assert name not in after
        elif "vehicle_page" not in name and not name.endswith("index.html"):
            assert after[name] == mark, name
