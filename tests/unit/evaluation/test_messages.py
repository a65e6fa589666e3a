"""Every message of the program is found, and is said in Russian."""

import re
from pathlib import Path

import pytest

from evaluation.messages import LANGUAGE, MORE, FoundMessage, messages, updated
from pipeline.language.po import Entry, read_po

FIELD = re.compile(r"\{(\d+)\}")
MODULE = '''
"""Not a message of any kind."""
import click

LABELS = {"some_key": "a label of two words"}


def said(count: int, name: str) -> str:
    """Neither is this one."""
    if count < 0:
        raise ValueError("this is for programmers alone")
    more = plural(count, "branch", "branches")
    return f"{name} has {count:.2f} too many.\\nLeave {more} out."


@click.command()
def go() -> None:
    r"""Do what is asked
    for.

    \\b
    Example:
      rig2sea go
    """
'''


@pytest.fixture(scope="module")
def found() -> list[FoundMessage]:
    return messages()


@pytest.fixture(scope="module")
def russian() -> dict[str, Entry]:
    text = (LANGUAGE / "ru.po").read_text(encoding="utf-8")
    return {entry.message: entry for entry in read_po(text)}


def test_what_is_found_in_a_module(tmp_path: Path) -> None:
    (tmp_path / "room.py").write_text(MODULE)
    (tmp_path / "page.html.j2").write_text('<p>{{ _("Way back") }}</p>')
    own = {entry.message: entry for entry in messages(tmp_path) if MORE.name not in entry.where}
    assert set(own) == {
        "a label of two words",
        "{0} branch",
        "{0} has {1} too many.",
        "Leave {0} out.",
        "Do what is asked for.",
        "Way back",
    }
    assert own["{0} branch"].plural == "{0} branches"
    assert own["{0} has {1} too many."].notes == ("{0}: name", "{1}: count")


def test_translations_stay_and_messages_that_are_gone_go() -> None:
    old = [Entry("kept {0}", forms=("оставлено {0}",)), Entry("gone", forms=("ушло",))]
    _, kept, new = updated(
        "ru", [FoundMessage("kept {0}"), FoundMessage("{0} run", "{0} runs")], old
    )
    assert kept.forms == ("оставлено {0}",)
    assert new.forms == ("", "", "")


def test_errors_readers_and_checks_are_wholly_translated(
    found: list[FoundMessage], russian: dict[str, Entry]
) -> None:
    rooms = ("errors.py", "ingest/", "check/", "vehicle/", "cli.py", "report/templates/")
    missing = [
        entry.message
        for entry in found
        if any(place.startswith(rooms) for place in entry.where)
        and not (entry.message in russian and russian[entry.message].translated)
    ]
    assert missing == []


def test_nearly_everything_is_translated(
    found: list[FoundMessage], russian: dict[str, Entry]
) -> None:
    known = [one for one in found if one.message in russian and russian[one.message].translated]
    assert len(found) > 2500
    assert len(known) >= 0.97 * len(found), "python -m evaluation.messages --check"


def test_no_translation_has_a_value_that_its_message_lacks(russian: dict[str, Entry]) -> None:
    for entry in russian.values():
        for form in entry.forms:
            assert set(FIELD.findall(form)) <= set(FIELD.findall(entry.message)), entry.message


def test_no_message_stands_twice_in_the_list_beside_the_program() -> None:
    lines = MORE.read_text(encoding="utf-8").splitlines()
    assert len(lines) == len(set(lines))
