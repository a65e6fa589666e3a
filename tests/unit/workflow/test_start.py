"""The engine's end, as the run that started it tells of it."""

import io
from pathlib import Path

import pytest

from pipeline.workflow import start as module
from pipeline.workflow.progress import Progress
from pipeline.workflow.start import start


def test_engine_that_ended_by_itself_is_kept_for_who_does_not_print(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def engine(*_: object, **__: object) -> int:
        (tmp_path / "workflow.log").write_text("OSError: no space left\n", encoding="utf-8")
        return 1

    monkeypatch.setattr(module, "_engine", engine)
    for quiet, printed in ((False, True), (True, False)):
        stream = io.StringIO()
        progress = Progress(stream, quiet=quiet)
        assert not start(tmp_path / "config.json", tmp_path, 1, progress)
        said = "error: the workflow engine stopped: OSError: no space left\n"
        assert progress.stopped == f"{said}Its log: {tmp_path / 'workflow.log'}"
        assert (said in stream.getvalue()) is printed
