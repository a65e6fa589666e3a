"""The command line in Russian."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from pipeline.cli import cli
from pipeline.reader_language import current

VEHICLE = """\
name: boat
title: boat
water: {density_kgpm3: 1000.0, gravity_mps2: 9.81}
propellers: {p: {diameter_m: 0.1}}
drives: {d: {code_min: -127, code_max: 127}}
tables: {propeller: p, drive: d}
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with one vehicle and one workbook that is none."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "raw/boat/mooring"
    folder.mkdir(parents=True)
    (tmp_path / "raw/boat/vehicle.yaml").write_text(VEHICLE)
    rows = [f"{code};{0.002 * code * abs(code):.3f}" for code in range(-120, 121, 20)]
    (folder / "good.csv").write_text("код;упор, Н\n" + "\n".join(rows) + "\n", encoding="utf-8")
    (folder / "bad.xlsx").write_bytes(b"PK\x03\x04 cut short")
    return tmp_path


def call(*arguments: str, **environment: str) -> Result:
    return CliRunner().invoke(cli, arguments, prog_name="rig2sea", env=environment)


@pytest.mark.parametrize(
    "arguments",
    [
        ("--language", "ru", "check", "raw/boat"),
        ("check", "raw/boat", "--language", "ru"),
        ("check", "--language=ru", "raw/boat"),
    ],
)
def test_a_refused_file_is_told_of_in_russian(here: Path, arguments: tuple[str, ...]) -> None:
    assert here.is_dir()
    done = call(*arguments)
    assert done.exit_code == 1
    assert "ошибка: raw/boat/mooring/bad.xlsx: книга повреждена или обрезана" in done.output
    assert "Ожидалось: целый файл .xlsx." in done.output
    assert "коды -120…120; -28,8…28,8 Н" in done.output
    assert "2 файла" not in done.output
    assert "3 файла: 1 ошибка, 0 предупреждений, 0 замечаний." in done.output
    assert current() == "en"


def test_the_locale_and_the_variable_choose(here: Path) -> None:
    assert here.is_dir()
    russian = {"RIG2SEA_LANGUAGE": "", "LC_ALL": "ru_RU.UTF-8"}
    assert "ошибка: " in call("check", "raw/boat", **russian).output
    assert "ошибка: " in call("check", "raw/boat", RIG2SEA_LANGUAGE="ru").output
    assert "error: " in call("check", "raw/boat", "--language", "en", **russian).output


def test_what_a_machine_reads_is_english(here: Path) -> None:
    assert here.is_dir()
    english = call("check", "raw/boat", "--json")
    assert call("--language", "ru", "check", "raw/boat", "--json").output == english.output
    assert json.loads(english.output)["ok"] is False


@pytest.mark.parametrize("command", ["", *sorted(set(cli.commands))])
def test_help_is_russian_throughout(command: str) -> None:
    text = call(*command.split(), "--language", "ru", "--help").output
    assert text.startswith("Использование: rig2sea")
    assert "Показать эту справку и выйти." in text
    prose = " ".join(line for line in text.splitlines() if "rig2sea " not in line)
    for word in ("the", "and", "is", "of", "default", "Example", "Options", "exit"):
        assert f" {word} " not in prose.replace(":", " ").replace("[", " "), word


def test_wrong_usage_is_told_of_in_russian() -> None:
    done = call("run", "--cores", "0", "--language", "ru")
    assert done.exit_code == 2
    assert "Справка: 'rig2sea run --help'." in done.output
    assert "Ошибка: " in done.output
    assert "Ошибка: Нет такой команды 'nonsense'." in call("--language", "ru", "nonsense").output
    assert call("--language", "de").exit_code == 2


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("run --cores 0", "0 вне допустимого диапазона x>=1."),
        ("run --cores x", "'x' — не целое число."),
        ("simulate a --amplitude x", "'x' — не число."),
        ("simulate a --allocator x", "возможно одно из 'general', 'paper', 'paper-mooring'."),
        ("simulate a --to raw", "'raw' — папка, а не файл."),
        ("export a --to raw/boat/vehicle.yaml", "'raw/boat/vehicle.yaml' — файл, а не папка."),
        ("check a --vehicle none", "'none' не существует."),
        ("simulate a --effec x", "Нет такого параметра '--effec'. (Возможно, имелось в виду: "),
        # what is to be typed stays as it is: a tether is no word here
        ("design", "Возможно одно из: balance, propeller, tether, added-mass\n"),
        ("design tether --example x", 'нет примера "x" для tether; есть'),
        ("simulate rov8 --manoeuvre hover --to x.mcap --allocator paper", "ошибка: у rov8 нет"),
    ],
)
@pytest.mark.usefixtures("here")
def test_what_is_wrong_is_told_of_in_russian(words: str, told: str) -> None:
    assert told in call(*words.split(), "--language", "ru").output


@pytest.mark.usefixtures("here")
def test_channels_to_be_typed_stay_as_they_are() -> None:
    done = call("--language", "ru", "identify", "rov8", "a.mcap", "--without", "no")
    assert done.exit_code == 2
    assert (
        "одно из angular_velocity, specific_force, attitude, velocity, depth, position."
        in done.output
    )
