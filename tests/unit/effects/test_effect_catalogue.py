"""The page of effects, and the same for machines."""

import json
import runpy
from pathlib import Path

import pytest

from pipeline.effects.catalogue import markdown, records
from pipeline.effects.library import effects, parse_effect


def test_page_is_up_to_date(repository: Path) -> None:
    page = (repository / "docs" / "effects.md").read_text(encoding="utf-8")
    assert page == markdown(), "run: python -m pipeline.effects.catalogue > docs/effects.md"


def test_page_names_every_effect_and_parameter() -> None:
    page = markdown()
    for effect in effects().values():
        assert f"\n## {effect.id}\n" in page
        for parameter in effect.parameters:
            assert f"| `{parameter.name}` | {parameter.unit} | {parameter.neutral:g} |" in page
    for verdict in ("none", "unknown"):
        assert f"- `{verdict}`: " in page


def test_effects_of_the_pages_example_are_valid() -> None:
    words = markdown().split("--effect ")[1:]
    assert [parse_effect(word.split()[0]).id for word in words] == ["current", "thruster_degraded"]


def test_command_prints_the_page(capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(
        str(Path(__file__).parents[3] / "pipeline/effects/catalogue.py"), run_name="__main__"
    )
    assert capsys.readouterr().out == markdown()


def test_records_are_json() -> None:
    """Strict JSON: a limit that is not there is null, not Infinity."""
    back = json.loads(json.dumps(records(), allow_nan=False))
    assert [entry["id"] for entry in back] == list(effects())
    dead_zone = next(entry for entry in back if entry["id"] == "dead_zone")
    assert dead_zone["parameters"][0]["possible"] == [0.0, None]
    assert dead_zone["parameters"][0]["unit"] == "code"
