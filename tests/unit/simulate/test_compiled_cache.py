"""The cache of compiled code: one folder for each state of the sources."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pipeline import code_cache
from pipeline.code_cache import cache_root, kept_in
from pipeline.simulate import compiled
from pipeline.simulate.compiled import kernel_digest, kernel_sources, prune

PACKAGE = Path(compiled.__file__).parent.parent
SOURCES = [path.relative_to(PACKAGE).as_posix() for path in kernel_sources()]
DAY_S = 86400.0


@pytest.fixture
def copied_package(tmp_path: Path) -> Path:
    package = tmp_path / "pipeline"
    for name in SOURCES:
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(PACKAGE / name, package / name)
    return package


@pytest.fixture(autouse=True)
def _forget_the_folder() -> Iterator[None]:
    """Leave the folder that this process compiles into alone."""
    yield
    compiled.cache_folder.cache_clear()


def test_the_copy_has_the_same_digest(copied_package: Path) -> None:
    assert kernel_digest(copied_package) == kernel_digest()


@pytest.mark.parametrize("name", SOURCES)
def test_a_change_in_any_source_changes_the_digest(copied_package: Path, name: str) -> None:
    before = kernel_digest(copied_package)
    source = copied_package / name
    source.write_text(source.read_text(encoding="utf-8") + "# a change\n", encoding="utf-8")
    assert kernel_digest(copied_package) != before


def test_a_file_that_the_kernel_comes_to_import_counts(copied_package: Path) -> None:
    before = kernel_digest(copied_package)
    (copied_package / "physics" / "waves.py").write_text("A = 1\n")
    assert kernel_digest(copied_package) == before
    kernel = copied_package / "simulate" / "kernel_hull.py"
    kernel.write_text(kernel.read_text(encoding="utf-8") + "from pipeline.physics import waves\n")
    assert copied_package / "physics" / "waves.py" in kernel_sources(copied_package)


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("from pipeline.physics.waves import A", True),
        ("from pipeline.physics import (waves, other)", True),
        ("import pipeline.physics.waves", True),
        ("    from pipeline.physics.waves import (\n    A,\n)", True),
        ("# from pipeline.physics.waves import A", False),
    ],
)
def test_imports_are_found_however_written(copied_package: Path, line: str, *, found: bool) -> None:
    waves = copied_package / "physics" / "waves.py"
    waves.write_text("A = 1\n")
    (copied_package / "simulate" / "kernel_new.py").write_text(f"def f():\n    pass\n{line}\n")
    assert (waves in kernel_sources(copied_package)) is found


def test_everything_that_is_compiled_is_a_source() -> None:
    """Every module of the package that asks for the compiler is in the digest."""
    asking = {
        path
        for path in PACKAGE.rglob("*.py")
        if "simulate.compiled import" in path.read_text(encoding="utf-8")
    }
    assert asking <= set(kernel_sources())


def test_a_function_from_elsewhere_is_not_compiled() -> None:
    def double(x: float) -> float:
        return 2.0 * x

    with pytest.raises(RuntimeError, match="would go unnoticed"):
        compiled.compiled(double)


def make_cache(root: Path, number: int, age_s: float, now_s: float) -> Path:
    folder = root / f"kernel-{number:016x}"
    folder.mkdir()
    (folder / "code").write_text("")
    os.utime(folder, (now_s - age_s, now_s - age_s))
    return folder


def test_old_caches_go_and_the_newest_and_the_used_stay(tmp_path: Path) -> None:
    now_s = 1e9
    ages = [0.0, 1.0, 2.0, 3.0, 0.9, 40.0, 50.0]  # days; by age 0.9 is the second
    folders = [make_cache(tmp_path, k, age * DAY_S, now_s) for k, age in enumerate(ages)]
    deleted = prune(tmp_path, now_s)
    assert set(deleted) == {folders[3], folders[5], folders[6]}
    assert {path for path in folders if path.exists()} == set(folders) - set(deleted)


def test_a_busy_day_of_changes_is_left_alone(tmp_path: Path) -> None:
    for k in range(20):
        make_cache(tmp_path, k, 60.0 * k, 1e9)
    assert prune(tmp_path, 1e9) == []


def test_only_caches_are_deleted(tmp_path: Path) -> None:
    for k in range(6):
        make_cache(tmp_path, k, 10 * DAY_S, 1e9)
    other = [tmp_path / "kernel-notes", tmp_path / "else", tmp_path / "kernel-0123456789abcdeg"]
    outside = tmp_path.parent / "outside"
    for folder in (*other, outside):
        folder.mkdir()
        os.utime(folder, (0, 0))
    link = tmp_path / "kernel-aaaaaaaaaaaaaaaa"
    link.symlink_to(outside, target_is_directory=True)
    assert len(prune(tmp_path, 1e9)) == 2
    assert all(folder.exists() for folder in (*other, outside, link))


def test_the_variable_names_the_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RIG2SEA_CACHE", str(tmp_path / "place"))
    assert cache_root() == tmp_path / "place"


def test_a_home_that_cannot_be_written_is_said_once_and_worked_around(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file stands where the folder should be: not even root can write in it."""
    home, temporary = tmp_path / "home", tmp_path / "temporary"
    home.write_text("")
    temporary.mkdir()
    monkeypatch.delenv("RIG2SEA_CACHE", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    compiled.cache_folder.cache_clear()
    folder = compiled.cache_folder()
    assert compiled.cache_folder() == folder
    assert folder.is_dir()
    assert folder.is_relative_to(temporary)
    assert folder.parent.stat().st_mode & 0o077 == 0
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "RIG2SEA_CACHE" in said


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no owners of files here")
def test_a_temporary_folder_that_others_can_write_is_not_trusted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    planted = tmp_path / f"rig2sea-{os.getuid()}"
    planted.mkdir()
    planted.chmod(0o777)
    root = code_cache._temporary_root()
    assert root != planted
    assert root.is_relative_to(tmp_path)


def test_another_copy_of_the_same_sources_uses_the_kept_code(tmp_path: Path) -> None:
    def compiled_copy(place: str, text: str, folder: str) -> tuple[float, int]:
        file = tmp_path / place / "kernel_small.py"
        file.parent.mkdir(parents=True)
        file.write_text(text, encoding="utf-8")
        names: dict[str, Any] = {}
        exec(compile(text, str(file), "exec"), names)  # noqa: S102 - as an import would
        twice = kept_in(tmp_path / folder, names["twice"])
        return twice(2.0), sum(twice.stats.cache_hits.values())

    text = "def twice(x):\n    return 2.0 * x\n"
    assert compiled_copy("one/simulate", text, "digest-1") == (4.0, 0)
    assert compiled_copy("two/simulate", text, "digest-1") == (4.0, 1)
    other = text.replace("2.0", "3.0")
    assert compiled_copy("three/simulate", other, "digest-2") == (6.0, 0)


def test_one_process_compiles_and_the_others_wait_for_it(tmp_path: Path) -> None:
    (tmp_path / "kernel_slow.py").write_text(
        "import os, sys\n"
        "from pathlib import Path\n"
        "from pipeline.code_cache import kept_in\n"
        "def total(x):\n    found = 0.0\n    for one in x:\n        found += one\n"
        "    return found\n"
        "def mean(x):\n    return total(x) / len(x)\n"
        "total = kept_in(Path('code'), total)\nmean = kept_in(Path('code'), mean)\n"
        "assert mean((1.0, 3.0)) == 2.0\n"
        "print(sum(mean.stats.cache_hits.values()))\n",
        encoding="utf-8",
    )
    command = [sys.executable, "kernel_slow.py"]
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
    processes = [
        subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    hits = sorted(process.communicate(timeout=120)[0].strip() for process in processes)
    assert hits == ["0", "1", "1"]


def test_who_waits_too_long_compiles_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(code_cache, "_LOOKS", 2)
    path = tmp_path / "small.lock"
    held = code_cache._locked(path)
    assert held is not None
    assert code_cache._locked(path) is None
    held.close()
    again = code_cache._locked(path)
    assert again is not None
    again.close()
