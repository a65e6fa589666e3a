"""Reference pages are what the schemas and the library say."""

import re
from pathlib import Path
from typing import get_args

import pytest
from pydantic import BaseModel

from evaluation.reference import (
    SCHEMAS,
    columns_page,
    commands_page,
    effects_page,
    rooms_page,
    schema_page,
    topics_page,
)
from pipeline.cli import cli
from pipeline.effects.library import effects, parse_effect
from pipeline.vehicle.model_schema import Model
from pipeline.vehicle.schema import Vehicle
from pipeline.vehicle.sensor_schema import Sensors


def test_the_page_of_effects_is_up_to_date(repository: Path) -> None:
    page = (repository / "docs" / "effects.md").read_text(encoding="utf-8")
    assert page == effects_page(), "run: python -m evaluation.reference effects > docs/effects.md"


def test_every_effect_has_its_row_and_its_file(repository: Path) -> None:
    page = effects_page()
    for effect in effects().values():
        (row,) = (line for line in page.splitlines() if line.startswith(f"| [`{effect.id}`]"))
        for one in effect.parameters:
            low, high = one.plausible
            assert re.search(rf"`{one.name}`( `\w+`)* {low:g} to {high:g}", row)
        assert (repository / f"pipeline/effects/{effect.id}.py").is_file()


def test_effects_of_the_pages_example_are_valid() -> None:
    words = effects_page().split("--effect ")[1:]
    assert [parse_effect(word.split()[0]).id for word in words] == ["current", "thruster_degraded"]


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


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_page_has_every_key(name: str) -> None:
    page = schema_page(name)
    assert {key for key in keys(SCHEMAS[name]) if f"- `{key}` (" not in page} == set()


def test_a_key_is_told_with_type_bounds_default_and_meaning() -> None:
    page = schema_page("vehicle")
    assert "- `density_kgpm3` (number, gt=500, lt=1500, needed)\n" in page
    assert "- `lag_s` (number, ge=0, le=60 | null, optional): Its own time constant" in page
    assert "- `thrust_dead_n` (number, gt=0, default 0.5)" in page


def test_the_formats_name_every_section_of_the_vehicle_file(repository: Path) -> None:
    text = (repository / "docs" / "formats.md").read_text(encoding="utf-8")
    sections = {*Vehicle.model_fields, *Model.model_fields, *Sensors.model_fields}
    assert {key for key in sections if f"`{key}`" not in text} == {"command_rate_hz"}


@pytest.mark.parametrize("name", SCHEMAS)
def test_the_formats_name_every_page(name: str, repository: Path) -> None:
    text = (repository / "docs" / "formats.md").read_text(encoding="utf-8")
    assert f"`{name}`" in text


def test_the_page_of_columns_has_names_symbols_and_units() -> None:
    page = columns_page()
    assert "- `torque` (torque): torque, shaft torque, " in page
    assert "`Mz`" in page
    assert "- `current` (current, A assumed): " in page
    assert "кгс см" in page


def test_the_page_of_topics_has_rules_with_their_patterns() -> None:
    page = topics_page()
    rows = [line for line in page.splitlines() if line.startswith("| `depth` | ")]
    assert rows[0] == "| `depth` | `depth` |  |  |"
    assert rows[1].startswith(r"| `depth` | `data` | depth | (^\|[/_])(error\|rate")
    assert "- `attitude_euler`: roll pitch yaw; roll pitch heading; phi theta psi\n" in page


def test_the_page_of_rooms_has_every_room(repository: Path) -> None:
    page = rooms_page()
    rooms = [file.parent.name for file in (repository / "pipeline").glob("*/__init__.py")]
    assert {room for room in rooms if not re.search(rf"- `{room}`: \w", page)} == set()
    assert "- `diagnose/gap`: Where a gap lies" in page


def test_the_page_of_commands_has_every_command_and_option() -> None:
    page = commands_page()
    for name, command in cli.commands.items():
        if command.hidden:
            continue
        text = page.split(f"\n## rig2sea {name}\n")[1].split("\n## ", maxsplit=1)[0]
        long = {one for param in command.params for one in param.opts if one.startswith("--")}
        assert {one for one in long if one not in text} == set(), name
