"""A text is found again in the catalogue, or stays as it is."""

import time

import pytest

from pipeline.language.catalogue import Catalogue
from pipeline.language.po import read_po

RULE = (
    r"Plural-Forms: nplurals=3; plural=(n%10==1 && n%100!=11 ? 0 : n%10>=2 && n%10<=4 && "
    r"(n%100<10 || n%100>=20) ? 1 : 2);\n"
)
CATALOGUE = f"""\
msgid ""
msgstr "{RULE}"

msgid "{{0}} point"
msgid_plural "{{0}} points"
msgstr[0] "{{0}} точка"
msgstr[1] "{{0}} точки"
msgstr[2] "{{0}} точек"

msgid "row {{0}}"
msgstr "строка {{0}}"

msgid "sheet \\"{{0}}\\""
msgstr "лист \\"{{0}}\\""

msgid "error: {{0}}"
msgstr "ошибка: {{0}}"

msgid "the file is empty."
msgstr "файл пуст."

msgid "{{0}} left out of {{1}}, which is {{2}} too many"
msgstr "из {{1}} отброшено {{0}}, это на {{2}} больше, чем надо"

msgid "Copy it again."
msgstr "Скопируйте снова."

msgid "surge"
msgstr "ход"

msgid "heave"
msgstr "вертикаль"

msgid "; a healthy vehicle leaves {{0}}"
msgstr "; исправный оставляет {{0}}"

msgid "error of {{0}} before"
msgstr "ошибка {{0}} до"

msgid "--step {{0}}: a whole number is expected"
msgstr "--step {{0}}: ожидается целое число"

msgid "{{0}} \\"{{1}}\\" is not a number."
msgstr "{{0}} \\"{{1}}\\" — не число."

msgid "not yet said"
msgstr ""
"""


@pytest.fixture(scope="module")
def catalogue() -> Catalogue:
    return Catalogue(read_po(CATALOGUE))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1 point", "1 точка"),
        ("2 points", "2 точки"),
        ("5 points", "5 точек"),
        ("11 points", "11 точек"),
        ("21 points", "21 точка"),
        ("112 points", "112 точек"),
        ("The file is empty", "Файл пуст"),
        (
            "raw/a.csv: the file is empty.\nCopy it again.",
            "raw/a.csv: файл пуст.\nСкопируйте снова.",
        ),
        (
            'error: raw/a b.xlsx, sheet "Code 1.5", row 14: the file is empty.',
            'ошибка: raw/a b.xlsx, лист "Code 1.5", строка 14: файл пуст.',
        ),
        (
            # the first name between quotation marks is the sheet's
            'error: raw/a b.xlsx, sheet "Code 1.5", row 14: surge "x" is not a number.',
            'ошибка: raw/a b.xlsx, лист "Code 1.5", строка 14: ход "x" — не число.',
        ),
        (
            "3 points left out of 12 points, which is 2.5 too many",
            "из 12 точек отброшено 3 точки, это на 2,5 больше, чем надо",
        ),
        ("surge, heave and surge", "ход, вертикаль и ход"),
        ("  surge  [m/s]", "  ход  [м/с]"),
        (
            "error of 1.5 N before; a healthy vehicle leaves 0.5 N",
            "ошибка 1,5 Н до; исправный оставляет 0,5 Н",
        ),
        ("--step 0.3: a whole number is expected", "--step 0.3: ожидается целое число"),
        ("heave 1.5 to 3.0 m", "вертикаль 1,5…3,0 м"),
        ("2 points: the file is empty. Copy it again.", "2 точки: файл пуст. Скопируйте снова."),
    ],
)
def test_texts_made_of_messages(catalogue: Catalogue, text: str, said: str) -> None:
    assert catalogue.say(text) == said


@pytest.mark.parametrize(
    "text",
    [
        "",
        "\n",
        "upper",
        "not yet said",
        "raw/surge/heave.csv",
        "the surge of the tide and its heave are not our business",
        "points",
        "x point",
        "<script>alert(1)</script>",
    ],
)
def test_what_is_not_known_stays(catalogue: Catalogue, text: str) -> None:
    assert catalogue.say(text) == text


@pytest.mark.parametrize(
    "text",
    [
        "a to " * 700,
        "; ".join(f"surge {i}: heave and row {i}, x" for i in range(300)),
        ": " * 1500,
        "(" * 1000 + ")" * 1000,
        "[" * 2000,
        "1 " * 1900,
        "x" * 1_000_000,
        "row " * 900 + "left out of which is too many",
    ],
)
def test_a_hostile_text_costs_little(catalogue: Catalogue, text: str) -> None:
    begin = time.process_time()
    catalogue.say(text)
    assert time.process_time() - begin < 3.0


def test_a_line_for_the_vehicle_file_stays() -> None:
    line = '      row: {header: "Row 3", unit: ...}'
    known = Catalogue(
        read_po('msgid "{0}: {1}"\nmsgstr "«{0}» {1}"\n\nmsgid "row"\nmsgstr "ряд"\n')
    )
    assert known.say(line) == line


def test_two_sentences_of_one_kind_are_two() -> None:
    """A long template may hold whole sentences in a value, but not its own sentence again."""
    message = "{0} readings of this kind cannot carry {1} coefficients; at least {2} are needed"
    said = "{0} отсчётов не определяют {1} коэффициентов; нужно не менее {2}"
    head = f'msgid ""\nmsgstr "{RULE}"\n\n'
    one = Catalogue(read_po(f'{head}msgid "{message}"\nmsgstr "{said}"\n'))
    texts = [message.format(count, 4, 6) for count in (0, 3)]
    expected = [said.format(count, 4, 6) for count in (0, 3)]
    assert one.say(". ".join(texts) + ".") == ". ".join(expected) + "."
