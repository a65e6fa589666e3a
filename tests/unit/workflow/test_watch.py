"""A log is taken when it is whole: not while it is copied, not twice, and a broken one is named."""

import time
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from season_cases import FIRST_NS, make_season, write_log

from pipeline.errors import InputError, Place, Problem
from pipeline.journal import Event
from pipeline.plan import VehicleFolder
from pipeline.provenance import Envelope, write_envelope
from pipeline.records.trial import PageReceipt
from pipeline.workflow.outcome import Outcome, Result, page_lines
from pipeline.workflow.progress import Progress
from pipeline.workflow.run import RunRequest
from pipeline.workflow.watch import UNCLOSED_FACTOR, Watcher

SETTLE_S = 3.0


@dataclass
class Scene:
    """A raw folder, a clock that is turned by hand, and a run that only writes down its request."""

    root: Path
    clock_s: float = 0.0
    requests: list[RunRequest] = field(default_factory=list)
    fault: InputError | None = None
    pages: tuple[str, ...] = ()
    failed: tuple[Event, ...] = ()
    stopped: str = ""

    def watcher(self, *vehicles: str) -> Watcher:
        def do_run(request: RunRequest, _progress: Progress) -> Result:
            self.requests.append(request)
            if self.fault is not None:
                raise self.fault
            done = tuple(Path(one).name for one in request.vehicles)
            outcomes = tuple(Outcome(name, (), ()) for name in done)
            complete = not (self.failed or self.stopped)
            return Result(
                *(done, (), outcomes, self.failed, 1, complete, self.pages), stopped=self.stopped
            )

        request = RunRequest(vehicles, self.root / "raw", self.root)
        return Watcher(request, SETTLE_S, lambda: self.clock_s, do_run)

    def log(self, name: str) -> Path:
        return self.root / "raw/boat/pool" / name

    def waiting(self) -> frozenset[str]:
        return self.requests[-1].waiting.get("boat", frozenset())


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    (tmp_path / "raw/boat/pool").mkdir(parents=True)
    (tmp_path / "raw/boat/vehicle.yaml").write_text("name: boat\n")
    return Scene(tmp_path)


def settle(scene: Scene, watcher: Watcher, seconds: float = SETTLE_S) -> list[str]:
    watcher.look()
    scene.clock_s += seconds
    return watcher.look()


def test_first_look_runs_what_is_there_once_it_has_settled(scene: Scene) -> None:
    watcher = scene.watcher()
    watcher.look()
    assert scene.requests == []
    scene.clock_s += SETTLE_S
    watcher.look()
    assert len(scene.requests) == 1
    scene.clock_s += 100.0
    watcher.look()
    assert len(scene.requests) == 1, "nothing is new"


def test_log_that_grows_is_left_until_it_stands_still(scene: Scene) -> None:
    watcher = scene.watcher()
    settle(scene, watcher)
    write_log(scene.log("a.mcap"), FIRST_NS, closed=False)
    for _ in range(10):
        with scene.log("a.mcap").open("ab") as file:
            file.write(b"more")
        watcher.look()
        scene.clock_s += SETTLE_S / 2
    assert len(scene.requests) == 1, "the log still grows"
    write_log(scene.log("a.mcap"), FIRST_NS)
    settle(scene, watcher)
    assert len(scene.requests) == 2
    assert scene.waiting() == frozenset()


def test_log_that_was_not_closed_is_taken_later(scene: Scene) -> None:
    watcher = scene.watcher()
    settle(scene, watcher)
    write_log(scene.log("a.mcap"), FIRST_NS, closed=False)
    settle(scene, watcher, SETTLE_S + 0.1)
    assert len(scene.requests) == 1
    assert watcher.still_coming == [str(scene.log("a.mcap"))]
    scene.clock_s += UNCLOSED_FACTOR * SETTLE_S
    watcher.look()
    assert len(scene.requests) == 2
    assert watcher.still_coming == []


def test_log_that_was_cut_off_long_ago_holds_nothing_up(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With results of an earlier run it held its vehicle back in every ``watch --once``."""
    write_log(scene.log("a.mcap"), FIRST_NS, closed=False)
    (scene.root / "processed/boat/pool").mkdir(parents=True)
    (scene.root / "processed/boat/pool/a.json").write_text("{}")
    now_s = time.time()
    settle(scene, scene.watcher())
    assert scene.requests == [], "it may still come"
    monkeypatch.setattr(time, "time", lambda: now_s + UNCLOSED_FACTOR * SETTLE_S + 1.0)
    watcher = scene.watcher()
    settle(scene, watcher)
    assert len(scene.requests) == 1
    assert scene.waiting() == frozenset()
    assert watcher.still_coming == []


def test_other_logs_do_not_wait_for_one_that_is_copied(scene: Scene) -> None:
    watcher = scene.watcher()
    settle(scene, watcher)
    write_log(scene.log("slow.mcap"), FIRST_NS, closed=False)
    write_log(scene.log("whole.mcap"), FIRST_NS)
    settle(scene, watcher)
    assert len(scene.requests) == 2
    assert scene.waiting() == frozenset({"slow.mcap"})


def test_log_waits_for_its_notes(scene: Scene) -> None:
    watcher = scene.watcher()
    write_log(scene.log("a.mcap"), FIRST_NS)
    settle(scene, watcher)
    scene.log("a.yaml").write_text("what: x\n")
    write_log(scene.log("b.mcap"), FIRST_NS)
    watcher.look()
    scene.clock_s += SETTLE_S
    scene.log("a.yaml").write_text("what: more of it\n")
    watcher.look()
    assert scene.waiting() == frozenset({"a.mcap"})


def test_log_that_is_copied_anew_keeps_its_results_until_it_is_whole(scene: Scene) -> None:
    make_season(scene.root, VehicleFolder("boat", "raw/boat"), 0)
    write_log(scene.log("a.mcap"), FIRST_NS)
    (scene.root / "processed/boat/pool").mkdir(parents=True)
    (scene.root / "processed/boat/pool/a.json").write_text("{}")
    watcher = scene.watcher()
    settle(scene, watcher)
    write_log(scene.log("a.mcap"), FIRST_NS, closed=False)
    settle(scene, watcher, SETTLE_S + 1.0)
    assert len(scene.requests) == 1


def test_bench_file_on_its_way_holds_its_vehicle_alone(scene: Scene) -> None:
    other = scene.root / "raw/other"
    other.mkdir()
    (other / "vehicle.yaml").write_text("name: other\n")
    watcher = scene.watcher()
    settle(scene, watcher)
    (scene.root / "raw/boat/mooring").mkdir()
    for length in range(1, 4):
        (scene.root / "raw/boat/mooring/a.csv").write_text("x" * length)
        (other / "pool").mkdir(exist_ok=True)
        write_log(other / "pool/a.mcap", FIRST_NS)
        watcher.look()
        scene.clock_s += SETTLE_S / 2
    scene.clock_s += SETTLE_S / 2
    (scene.root / "raw/boat/mooring/a.csv").write_text("y" * 9)
    watcher.look()
    assert [Path(one).name for one in scene.requests[-1].vehicles] == ["other"]


def test_link_that_leads_round_stops_nothing(scene: Scene) -> None:
    (scene.root / "raw/boat/mooring").mkdir()
    for folder in ("mooring", "pool"):
        (scene.root / "raw/boat" / folder / "round").symlink_to("round")
    settle(scene, scene.watcher())
    assert len(scene.requests) == 1


def test_vehicle_may_appear_later(tmp_path: Path) -> None:
    scene = Scene(tmp_path)
    watcher = scene.watcher()
    # a folder that is misspelt would be watched for ever without a word
    assert watcher.look() == [f"Waiting: {tmp_path / 'raw'} holds no vehicle yet."]
    assert settle(scene, watcher) == []
    (tmp_path / "raw/late").mkdir(parents=True)
    (tmp_path / "raw/late/vehicle.yaml").write_text("name: late\n")
    settle(scene, watcher)
    assert [Path(one).name for one in scene.requests[0].vehicles] == ["late"]


def test_vehicle_that_was_named_is_waited_for_aloud(scene: Scene) -> None:
    watcher = scene.watcher("baot")
    (line,) = watcher.look()
    assert line.startswith('Waiting for it: there is no vehicle "baot"')
    assert 'Did you mean "boat"?' in line
    assert watcher.look() == []
    (scene.root / "raw/boat").rename(scene.root / "raw/baot")
    settle(scene, watcher)
    assert [Path(one).name for one in scene.requests[0].vehicles] == ["baot"]


def test_run_that_could_not_start_is_tried_again_and_told_once(scene: Scene) -> None:
    scene.fault = InputError(Problem("error", Place("here"), "another rig2sea is at work here."))
    watcher = scene.watcher()
    assert settle(scene, watcher) == ["error: here: another rig2sea is at work here."]
    assert watcher.look() == []
    assert watcher.failed
    scene.fault = None
    watcher.look()
    assert not watcher.failed
    assert len(scene.requests) == 3
    watcher.look()
    assert len(scene.requests) == 3


def test_stage_that_failed_is_told_by_its_title(scene: Scene) -> None:
    scene.failed = (Event("failed", "boat", "run_trial", "the disk is full.", item="dive1"),)
    watcher = scene.watcher()
    told = settle(scene, watcher)
    assert told == ["error: boat, dive1, pool run against simulation: the disk is full."]
    scene.failed = ()
    write_log(scene.log("b.mcap"), FIRST_NS)
    settle(scene, watcher)
    assert watcher.failed, "what failed once has failed"


def test_engine_that_stopped_is_told(scene: Scene) -> None:
    """Nothing was said, or that all is up to date, and the new file was taken for done."""
    scene.stopped = "error: the workflow engine stopped: no space left."
    watcher = scene.watcher()
    assert settle(scene, watcher) == [scene.stopped]
    assert watcher.failed


def test_restart_asks_the_results_and_not_its_memory(scene: Scene) -> None:
    settle(scene, scene.watcher())
    settle(scene, scene.watcher())
    assert len(scene.requests) == 2, "a new start lets the workflow find what is to be done"


def test_one_line_says_what_came_and_where_it_is(scene: Scene) -> None:
    receipt = PageReceipt(
        kind="run", name="a", files={}, title="a", errors=0, warnings=2, line="60 s; 2 warnings"
    )
    envelope = Envelope("run_page", "boat", {}, "c0", receipt)
    write_envelope(scene.root / "processed/boat/run_pages/a.json", envelope)
    page = "reports/boat/runs/a.html"
    result = Result(("boat",), (), (), (), 8, complete=True, pages=(page,))
    (line,) = page_lines(result, scene.root)
    assert line == f"boat: run a: 60 s; 2 warnings: {scene.root / page}"
