"""Which problems of a new mooring table stop its diagnosis."""

from pathlib import Path

import pytest

from pipeline.actions import bench_diagnosis
from pipeline.actions.bench_diagnosis import diagnose_table_to_file
from pipeline.actions.diagnosis import DiagnosisRequest
from pipeline.errors import CannotComputeError, InputError

VEHICLE = """\
name: boat
title: a boat
water: {density_kgpm3: 1000.0, gravity_mps2: 9.81}
propellers: {screw: {diameter_m: 0.1}}
drives: {drive: {code_min: -100, code_max: 100}}
tables: {propeller: screw, drive: drive}
"""


def table(folder: Path, text: str) -> Path:
    (folder / "vehicle.yaml").write_text(VEHICLE, encoding="utf-8")
    file = folder / "new.csv"
    file.write_text(text, encoding="utf-8")
    return file


def diagnosed(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench_diagnosis, "_model", lambda *_: (None, ()))
    diagnose_table_to_file(DiagnosisRequest(str(file.parent), (str(file),)))


def test_a_fault_is_told_whatever_words_its_column_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = table(tmp_path, "code,thrust at supply 16 V [furlong]\n10,1\n20,2\n-10,-1\n")
    with pytest.raises((InputError, CannotComputeError), match=r"furlong|supply 16 V"):
        diagnosed(file, monkeypatch)


def test_several_supplies_and_a_single_code_are_left_to_the_diagnosis(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = table(tmp_path, "code,thrust [N],voltage [V]\n0,0,16\n10,1,16\n10,1.1,12\n0,0,12\n")
    seen: list[str] = []

    def bench_table(*_: object, name: str, **__: object) -> None:
        seen.append(name)
        raise CannotComputeError("too few codes")

    monkeypatch.setattr(bench_diagnosis, "bench_table", bench_table)
    with pytest.raises(CannotComputeError, match="too few codes"):
        diagnosed(file, monkeypatch)
    assert seen == ["new"]
