"""The tests themselves can be collected, all together and from any folder."""

import subprocess
import sys
from collections import Counter
from pathlib import Path


def test_every_module_of_the_tests_has_a_name_of_its_own(repository: Path) -> None:
    """They are imported by their bare names."""
    names = Counter(path.name for path in (repository / "tests").rglob("*.py"))
    assert [name for name, count in names.items() if count > 1 and name != "conftest.py"] == []


def test_folders_with_a_conftest_each_are_collected_together(
    repository: Path, tmp_path: Path
) -> None:
    """Doctests are looked for in every module; those named conftest.py would collide."""
    for number, folder in enumerate(("", "inner", "inner/most", "other")):
        (tmp_path / folder).mkdir(exist_ok=True)
        (tmp_path / folder / "conftest.py").write_text("", encoding="utf-8")
        test = f"def test_{number}() -> None:\n    pass\n"
        (tmp_path / folder / f"test_{number}.py").write_text(test, encoding="utf-8")
    settings = ("-c", str(repository / "pyproject.toml"), f"--rootdir={tmp_path}", "--no-cov")
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *settings, "--collect-only", "-q", "inner", "other", "."],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert "4 tests collected" in done.stdout
