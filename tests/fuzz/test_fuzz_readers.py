"""Whatever a file holds, a reader reads it or says in the project's own words why not.

A short, repeatable part of the search; ``make fuzz`` goes on for as long as it is told.
"""

from pathlib import Path
from random import Random

import pytest
from fuzz_attacks import ATTACKS, Attack
from fuzz_campaign import LARGEST, corpus, search
from fuzz_targets import TARGETS, Target, TooSlowError, bounded, fault
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pipeline.errors import Rig2SeaError

#: Small files, in seconds of the processor; the largest of the attacks takes about 2.
ATTACK_CPU_S = 15.0


@pytest.mark.parametrize("name", TARGETS)
@settings(max_examples=15, suppress_health_check=list(HealthCheck))
@given(seed=st.integers(0, 2**32))
def test_a_damaged_file_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, name: str, seed: int
) -> None:
    folder = tmp_path_factory.getbasetemp()
    data = TARGETS[name].make(Random(seed))  # noqa: S311 - not for secrets
    error = fault(TARGETS[name], data, folder)
    assert error is None, repr(error)


@pytest.mark.parametrize("name", TARGETS)
def test_the_files_that_once_broke_a_reader(tmp_path: Path, name: str) -> None:
    for path in corpus(name):
        assert path.stat().st_size <= LARGEST
        error = fault(TARGETS[name], path.read_bytes(), tmp_path)
        assert error is None, f"{path.name}: {error!r}"


def test_every_folder_of_the_corpus_has_its_reader() -> None:
    folder = Path(__file__).parent / "corpus"
    assert {path.name for path in folder.iterdir()} <= set(TARGETS)


@pytest.mark.parametrize("name", ATTACKS)
def test_an_attack_is_cheap_and_answered(tmp_path: Path, name: str) -> None:
    attack = ATTACKS[name]
    path = tmp_path / f"attack{TARGETS[attack.target].suffix}"
    path.write_bytes(attack.make())
    said = ""
    with bounded(cpu_s=ATTACK_CPU_S):
        try:
            TARGETS[attack.target].read(path)
        except Rig2SeaError as error:
            said = str(error)
    assert attack.says in said
    assert len(said) < 5000


# --- The search itself can fail -------------------------------------------------------------------


def _reader(action: str) -> Target:
    def read(path: Path) -> None:
        if not path.read_bytes().startswith(b"!"):
            return
        if action == "raise":
            raise KeyError("odd")
        if action == "loop":
            while True:
                pass
        bytearray(8_000_000_000)

    return Target(".bin", read, lambda chance: chance.choice((b"!", b"?")))


@pytest.mark.parametrize(("action", "kind"), [("raise", KeyError), ("grow", MemoryError)])
def test_a_fault_is_a_fault(tmp_path: Path, action: str, kind: type[BaseException]) -> None:
    assert isinstance(fault(_reader(action), b"!", tmp_path), kind)
    assert fault(_reader(action), b"?", tmp_path) is None


def test_what_takes_too_long_is_a_fault(tmp_path: Path) -> None:
    with pytest.raises(TooSlowError), bounded(cpu_s=0.2):
        _reader("loop").read(_file(tmp_path))


def _file(folder: Path) -> Path:
    path = folder / "a.bin"
    path.write_bytes(b"!")
    return path


def test_a_search_finds_a_planted_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(TARGETS, "planted", _reader("raise"))
    tally = search("planted", 1.5, seed=1)
    assert [one.what for one in tally.findings] == ["KeyError: 'odd'"]
    assert tally.findings[0].data.startswith(b"!")


def test_attacks_are_for_targets_that_exist() -> None:
    assert all(isinstance(one, Attack) and one.target in TARGETS for one in ATTACKS.values())
