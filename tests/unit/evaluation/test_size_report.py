"""What the size report says when it cannot be made; integration tests make it."""

from pathlib import Path

import pytest

from evaluation.firmware import emulator, size_report


def test_wrong_usage() -> None:
    assert size_report.main([]) == 2
    assert size_report.main(["--help"]) == 2


def test_missing_compiler_is_said_plainly(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert size_report.main([str(tmp_path / "a_thruster.c")]) == 1
    assert "arm-none-eabi-gcc is not installed" in capsys.readouterr().err
    assert emulator.missing_tools() == (emulator.COMPILER, emulator.SIZE, emulator.EMULATOR)
