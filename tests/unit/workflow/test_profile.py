"""A profile is found by name or path; one that cannot be used is refused before anything runs."""

from pathlib import Path

import pytest

from pipeline.errors import InputError
from pipeline.workflow.profile import FILE, find_profile


def profile(folder: Path, text: str) -> Path:
    folder.mkdir()
    (folder / FILE).write_text(text, encoding="utf-8")
    return folder


def test_folder_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    profile(tmp_path / "mine", "executor: local\ncores: 2\n")
    monkeypatch.chdir(tmp_path)
    assert find_profile("mine") == tmp_path / "mine"
    assert find_profile(str(tmp_path / "mine")) == tmp_path / "mine"


def test_shipped_profile_is_found_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pipeline.workflow.profile.find_spec", lambda _name: object())
    found = find_profile("slurm")
    text = (found / FILE).read_text(encoding="utf-8")
    assert "executor: slurm" in text
    assert "retries: 2" in text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("executor: no-such\n", "pip install snakemake-executor-plugin-no-such"),
        ("- a\n- list\n", "options of the workflow engine in YAML"),
        ("a: [1\n", "options of the workflow engine in YAML"),
        ("x" * 1_000_001, "options of the workflow engine in YAML"),
    ],
)
def test_unusable_profile_is_refused(tmp_path: Path, text: str, said: str) -> None:
    folder = profile(tmp_path / "mine", text)
    with pytest.raises(InputError) as caught:
        find_profile(str(folder))
    assert said in str(caught.value)
    assert FILE in str(caught.value)


def test_missing_plugin_of_the_shipped_profile_names_the_extra(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("pipeline.workflow.profile.find_spec", lambda _name: None)
    with pytest.raises(InputError, match=r'pip install "rig2sea\[cluster\]"'):
        find_profile("slurm")


@pytest.mark.parametrize("name", ["slrum", "", "..", "../profiles"])
def test_unknown_profile_names_those_there_are(name: str) -> None:
    with pytest.raises(InputError) as caught:
        find_profile(name)
    assert "slurm" in str(caught.value)
