"""What the documents say of the program is what the program is."""

import importlib.util
import re
import tomllib
from pathlib import Path

import pytest

from pipeline import __version__

ROOT = Path(__file__).parents[2]
DECISION = ROOT / "docs/decisions/0001-dependencies-and-workflow.md"


def test_drawing_of_the_import_contract_is_the_contract() -> None:
    spec = importlib.util.spec_from_file_location("draw_contract", ROOT / ".ci/draw_contract.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert "flowchart" in module.drawing()
    assert (ROOT / "docs/architecture.md").read_text(encoding="utf-8") == module.page(), (
        "the contract has changed: make drawing"
    )


def test_version_is_that_of_the_release_at_the_head_of_the_changelog() -> None:
    head = re.search(r"^## ([\d.]+)", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    with (ROOT / "pyproject.toml").open("rb") as file:
        stated = tomllib.load(file)["project"]["version"]
    assert head is not None
    assert head[1] == stated == __version__


def test_lock_files_share_no_package_and_name_no_registry() -> None:
    names = []
    for file in ("requirements.lock", "requirements-dev.lock"):
        text = (ROOT / file).read_text(encoding="utf-8")
        assert "://" not in text
        names.append(set(re.findall(r"^([A-Za-z0-9._-]+)==", text, re.MULTILINE)))
    of_run, of_development = names
    assert not of_run & of_development
    # what sets up is itself set up, and what tests is not
    assert {"uv", "hatchling", "snakemake", "statsmodels"} <= of_run
    assert {"pytest", "ruff", "mypy"} <= of_development


def test_every_dependency_has_its_line() -> None:
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    listed = {*project["dependencies"]}
    for extra in project["optional-dependencies"].values():
        listed.update(extra)
    names = {re.split(r"[\[<>=~!; ]", one)[0] for one in listed}
    text = DECISION.read_text(encoding="utf-8")
    rows = re.findall(r"(?m)^\| ([\w., -]+) \| .+ \|$", text)
    justified = {name for row in rows for name in row.split(", ")} - {"package"}
    assert justified == names


@pytest.mark.parametrize(
    "file",
    sorted(
        path.relative_to(ROOT)
        for pattern in ("*.md", "docs/**/*.md", "raw/**/*.md", "pipeline/bundled/**/*.md")
        for path in ROOT.glob(pattern)
    ),
    ids=str,
)
def test_rows_of_tables_follow_a_head(file: Path) -> None:
    """A blank line within a table turns the rows below it into raw text."""
    blocks = re.findall(r"(?:^\|.*\n)+", (ROOT / file).read_text(encoding="utf-8"), re.MULTILINE)
    for block in blocks:
        assert re.search(r"\A\|.*\n\|[ :|-]+\|\n", block), block
