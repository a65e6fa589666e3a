"""Vehicles that the tests of the blind check share."""

from pathlib import Path

import pytest
from bundled_models import mmt300_bench

from pipeline.blind.generate import CaseSpec, GeneratedCase, generate
from pipeline.blind.subject import BlindSubject, subject_from
from pipeline.blind.truth.craft import Craft, craft_of
from pipeline.bundled.vehicles import bundled_vehicle


@pytest.fixture(scope="session")
def rov8() -> BlindSubject:
    return subject_from(bundled_vehicle("rov8"))


@pytest.fixture(scope="session")
def carrier() -> BlindSubject:
    return subject_from(bundled_vehicle("cargo_carrier"))


@pytest.fixture(scope="session")
def mmt300(repository: Path, tmp_path_factory: pytest.TempPathFactory) -> BlindSubject:
    bench = mmt300_bench(repository, tmp_path_factory)
    return subject_from(repository / "raw" / "mmt300", bench.static)


@pytest.fixture(scope="session")
def rov8_craft(rov8: BlindSubject) -> Craft:
    return craft_of(rov8.vehicle)


@pytest.fixture(scope="session")
def sagging(rov8: BlindSubject) -> GeneratedCase:
    """A short case: the supply voltage of a ROV is low."""
    return generate(
        rov8,
        CaseSpec("single", ("voltage_sag",), severity=3.0, healthy=1, duration_s=30.0, seed=4),
    )


@pytest.fixture
def verdict_file(tmp_path: Path) -> Path:
    path = tmp_path / "diagnosis.json"
    path.write_text("{}", encoding="utf-8")
    return path
