"""A small part of the campaign of bench files; all of it is a command of its own."""

from pathlib import Path

from evaluation.bench_files.__main__ import LEAST_RIGHT
from evaluation.bench_files.judge import judge_file, summary

FILES, SEED = 60, 7


def test_nothing_is_read_wrongly_in_silence(tmp_path: Path) -> None:
    files = [judge_file(SEED, number, tmp_path) for number in range(FILES)]
    assert not [one for one in files if one.outcome == "silently wrong"], summary(files)
    clean = [one for one in files if not one.corruptions]
    right = [one for one in clean if one.outcome == "right"]
    assert len(right) >= LEAST_RIGHT * len(clean), summary(files)
    refused = [one for one in files if one.outcome == "refused"]
    assert all(one.has_way_out for one in refused), summary(files)


def test_the_same_numbers_give_the_same_file(tmp_path: Path) -> None:
    assert judge_file(SEED, 5, tmp_path) == judge_file(SEED, 5, tmp_path)
