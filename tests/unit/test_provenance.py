"""Digests and envelopes: what is believed, what is refused, what makes a stage run again."""

import errno
import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline import provenance
from pipeline.errors import InputError, Place, Problem
from pipeline.provenance import (
    UNREADABLE,
    Envelope,
    canonical_json,
    code_digest,
    content_digest,
    file_digest,
    read_envelope,
    read_raw_envelope,
    read_tables,
    tables_text,
    unwritable,
    write_atomically,
    write_envelope,
)
from pipeline.records.fits import Check

CHECK = Check(name="rises", passed=True, text="T rises with N")


def envelope(record: Check | None = CHECK) -> Envelope[Check]:
    return Envelope(
        kind="drive",
        vehicle="a",
        inputs={"raw/a/vehicle.yaml": "00"},
        code="c0",
        record=record,
        why_not=None if record else "no data",
        problems=() if record else (Problem("warning", Place("a.xlsx", row=3), "odd"),),
    )


@pytest.mark.parametrize("record", [CHECK, None])
def test_envelope_comes_back_as_it_was(tmp_path: Path, record: Check | None) -> None:
    path = tmp_path / "drive.json"
    write_envelope(path, envelope(record))
    assert read_envelope(path, "drive", Check) == envelope(record)


def test_same_content_gives_same_bytes_without_time_or_place(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        write_envelope(tmp_path / folder / "drive.json", envelope())
    first = (tmp_path / "one/drive.json").read_bytes()
    assert first == (tmp_path / "two/drive.json").read_bytes()
    assert str(tmp_path).encode() not in first


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda text: text[: len(text) // 2], "half-written"),
        (lambda _: "", "half-written"),
        (lambda _: "[1, 2]", "has the schema 'list'"),
        (lambda text: text.replace("rig2sea/drive/1", "rig2sea/drive/2"), "rig2sea/drive/2"),
        (lambda text: text.replace("T rises", "T falls"), "changed after it was written"),
        (lambda text: text.replace('"code"', '"kode"'), "does not hold what the schema"),
    ],
)
def test_spoilt_envelope_is_refused_with_its_reason(
    tmp_path: Path, spoil: Callable[[str], str], message: str
) -> None:
    path = tmp_path / "drive.json"
    write_envelope(path, envelope())
    path.write_text(spoil(path.read_text()))
    with pytest.raises(InputError, match=message) as refused:
        read_envelope(path, "drive", Check)
    assert str(path) in str(refused.value)


def test_record_that_does_not_fit_its_model_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "drive.json"
    write_envelope(path, envelope())
    body = json.loads(path.read_text())
    body["record"]["colour"] = "red"
    body["record_sha256"] = content_digest(body["record"])
    path.write_text(json.dumps(body))
    with pytest.raises(InputError, match="does not hold what the schema"):
        read_envelope(path, "drive", Check)


def test_absent_envelope_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist"):
        read_raw_envelope(tmp_path / "drive.json", "drive")


def test_failed_write_leaves_the_old_file_and_no_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "drive.json"
    write_atomically(path, "old")

    def full_disk(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full_disk)
    with pytest.raises(InputError, match="No space left on device"):
        write_atomically(path, "new")
    assert path.read_text() == "old"
    assert [file.name for file in tmp_path.iterdir()] == ["drive.json"]


def test_place_that_cannot_be_written_is_one_message(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(InputError, match=r"cannot be written: .*\n.*write permission"):
        write_atomically(tmp_path / "file" / "drive.json", "x")


def test_a_full_disk_has_a_remedy_of_its_own() -> None:
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert str(unwritable(Path("a.json"), full)).splitlines() == [
        "a.json: cannot be written: No space left on device.",
        "Expected a folder with write permission and free space.",
        "The disk is full: free some space and run again. What is finished is kept.",
    ]


def test_unreadable_file_has_a_digest_of_its_own(tmp_path: Path) -> None:
    assert file_digest(tmp_path / "absent") == UNREADABLE
    (tmp_path / "empty").touch()
    # the SHA-256 of nothing, FIPS 180-4
    assert file_digest(tmp_path / "empty").startswith("e3b0c44298fc1c149afbf4c8996fb924")


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
)  # fmt: skip


@given(st.dictionaries(st.text(), json_values))
def test_order_of_keys_does_not_matter(value: dict[str, object]) -> None:
    turned = dict(reversed(value.items()))
    assert content_digest(turned) == content_digest(value)
    assert json.loads(canonical_json(value)) == value


def test_not_a_number_is_not_written() -> None:
    with pytest.raises(ValueError, match="JSON"):
        canonical_json({"x": float("nan")})


def test_tables_keep_their_keys_and_refuse_an_edit(tmp_path: Path) -> None:
    path = tmp_path / "tables.json"
    path.write_text(tables_text({"table1": {"KT": (0.139,)}}, inputs={"a": "00"}, code="c0"))
    body = read_tables(path)
    assert body["table1"] == {"KT": [0.139]}
    assert body["provenance"]["inputs"] == {"a": "00"}
    path.write_text(path.read_text().replace("0.139", "0.14"))
    with pytest.raises(InputError, match="changed after it was written"):
        read_tables(path)
    path.write_text("{")
    with pytest.raises(InputError, match="not a whole"):
        read_tables(path)


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of the real one's name: a stage, what it imports in each way, and a stranger."""
    root = tmp_path / "pipeline"
    files = {
        "__init__.py": "",
        "stages/__init__.py": "",
        "stages/one.py": (
            "from pipeline.room import (\n    first,  # a module\n    second,\n)\n"
            "import numpy as np\n"
            "def run():\n    from pipeline.late import thing\n"
        ),
        "room/__init__.py": "",
        "room/first.py": "import pipeline.deep.down\n",
        "room/second.py": "",
        "room/style.css": "a {}",
        "deep/__init__.py": "",
        "deep/down.py": "",
        "late.py": "",
        "stranger.py": "",
    }
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    monkeypatch.setattr(provenance, "PACKAGE", root)
    return root


@pytest.mark.parametrize(
    "name",
    ["stages/one.py", "room/first.py", "room/second.py", "room/style.css", "room/__init__.py",
     "deep/down.py", "late.py", "__init__.py"],
)  # fmt: skip
def test_code_digest_changes_with_everything_imported(package: Path, name: str) -> None:
    before = code_digest("pipeline.stages.one")
    assert code_digest("pipeline.stages.one") == before
    (package / name).write_text("# changed\n" + (package / name).read_text())
    assert code_digest("pipeline.stages.one") != before


def test_code_digest_ignores_what_is_not_imported(package: Path) -> None:
    before = code_digest("pipeline.stages.one")
    (package / "stranger.py").write_text("x = 1\n")
    assert code_digest("pipeline.stages.one") == before


@pytest.mark.usefixtures("package")
def test_code_digest_knows_versions_of_other_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    before = code_digest("pipeline.stages.one")
    monkeypatch.setattr(provenance, "_installed_version", lambda _: "99")
    assert code_digest("pipeline.stages.one") != before


def test_code_digest_refuses_an_unknown_module() -> None:
    with pytest.raises(ModuleNotFoundError, match=r"pipeline\.stages\.nothing"):
        code_digest("pipeline.stages.nothing")


def test_what_the_package_offers_to_notebooks_is_no_part_of_a_stage() -> None:
    members, _ = provenance._closure(["pipeline.stages.bench_records"])
    assert provenance.PACKAGE / "stages/bench_records.py" in members
    assert provenance.PACKAGE / "library.py" not in members
    assert not any("diagnose" in member.parts for member in members)
