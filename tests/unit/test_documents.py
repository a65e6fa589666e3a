"""What the documents say of the program is what the program is."""

import importlib.util
import re
import tomllib
from pathlib import Path
from typing import get_args

import pytest
from pydantic import BaseModel

from pipeline.effects.library import effects
from pipeline.records.allocation import AllocationMap
from pipeline.records.bench_diagnosis import BenchDiagnosisRecord
from pipeline.records.fits import (
    DriveFit,
    InverseCharacteristic,
    PropellerFit,
    StaticCharacteristic,
)
from pipeline.records.identification import Identification
from pipeline.records.measurements import LoadTestRecord, MooringRecord, OpenWaterRecord
from pipeline.records.pool_run import PoolRunRecord
from pipeline.records.reference import ReferenceRecord
from pipeline.records.trial import DayTables, RunTrial, TrialDay
from pipeline.records.validation import AllocatorValidation

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


def test_every_key_of_a_diagnosis_is_documented() -> None:
    text = (ROOT / "docs/formats_diagnosis.md").read_text(encoding="utf-8")
    told = {word for code in re.findall(r"`([^`\n]+)`", text) for word in re.findall(r"\w+", code)}
    assert keys(BenchDiagnosisRecord) - told == set()
    assert keys(ReferenceRecord) - told == set()


@pytest.mark.parametrize(
    "record",
    [
        *(LoadTestRecord, MooringRecord, OpenWaterRecord, PropellerFit, DriveFit),
        *(StaticCharacteristic, InverseCharacteristic, AllocationMap, AllocatorValidation),
        *(Identification, PoolRunRecord, RunTrial, TrialDay, DayTables),
    ],
)
def test_every_key_of_a_result_is_documented(record: type[BaseModel]) -> None:
    pages = [ROOT / "docs/formats.md", ROOT / "docs/formats_pool.md"]
    told = re.findall(r"\w+", " ".join(page.read_text(encoding="utf-8") for page in pages))
    assert keys(record) - set(told) == set()


def test_every_parameter_of_an_effect_is_documented() -> None:
    page = (ROOT / "docs/formats.md").read_text(encoding="utf-8")
    text = page.partition("\n## effects --json\n")[2]
    for effect in effects().values():
        row = re.search(rf"(?m)^\| `{effect.id}`[^|]*\| (.+) \|$", text)
        assert row is not None, effect.id
        units = ["" if one.unit == "1" else f" [{one.unit}]" for one in effect.parameters]
        told = [f"`{one.name}`{unit}" for one, unit in zip(effect.parameters, units, strict=True)]
        assert row[1] == ", ".join(told)


def keys(model: type[BaseModel]) -> set[str]:
    """Names of the fields of a record and of all records in it."""
    found = set(model.model_fields)
    for field in model.model_fields.values():
        found |= {key for inner in records_in(field.annotation) for key in keys(inner)}
    return found


def records_in(annotation: object) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [one for part in get_args(annotation) for one in records_in(part)]


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
