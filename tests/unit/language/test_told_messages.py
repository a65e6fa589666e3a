"""Messages with something before them, and of several sentences, are said whole in Russian."""

import pytest

from pipeline.language import catalogue
from pipeline.language.catalogue import Catalogue
from pipeline.plan import MISSING, TITLES
from pipeline.provenance import Envelope
from pipeline.records.base import Record
from pipeline.stages.job import Job, NotMeasuredError

NO_VEHICLE = (
    'there is no vehicle "{}": neither a folder under {} nor a path to one that holds '
    "vehicle.yaml.{} Under {}: mmt300, scout."
)


@pytest.fixture(scope="module")
def russian() -> Catalogue:
    return catalogue("ru")


@pytest.mark.parametrize("raw", ["raw", "/srv/my bench/raw"])
@pytest.mark.parametrize(
    ("before", "said"),
    [("", "нет"), ("error: ", "ошибка: нет"), ("Waiting for it: ", "Жду его: нет")],
)
def test_a_vehicle_that_is_not_there(russian: Catalogue, raw: str, before: str, said: str) -> None:
    for hint, meant in (("", ""), (' Did you mean "scout"?', ' Имелось в виду "scout"?')):
        assert russian.say(before + NO_VEHICLE.format("scuot", raw, hint, raw)) == (
            f'{said} аппарата "scuot": ни папки в {raw}, ни пути к папке, где есть '
            f"vehicle.yaml.{meant} В {raw} есть: mmt300, scout."
        )


@pytest.mark.parametrize("title", sorted(set(TITLES.values()) - {"tables.json"}))
def test_what_a_run_did_not_come_to_has_a_russian_title(russian: Catalogue, title: str) -> None:
    begin, _, last = russian.say(f"boat: the run did not come to this: {title}.").rpartition(": ")
    assert begin == "boat: запуск не дошёл до этого"
    assert not any(letter.isascii() and letter.isalpha() for letter in last)


def test_a_result_that_another_needs_and_that_is_not_there(russian: Catalogue) -> None:
    envelope = Envelope[Record]("propeller", "boat", {}, "c0", None, "no reason was given.")
    with pytest.raises(NotMeasuredError) as lacks:
        Job._whole("propeller", envelope)
    assert str(lacks.value).startswith(MISSING)
    title = "характеристика винта (таблица 1)"
    assert russian.say(str(lacks.value)) == f"Результата нет ({title}): причина не указана."


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Stopped.", "Остановлено."),
        (
            "Stopped. The next run goes on from here.",
            "Остановлено. Следующий запуск продолжит с этого места.",
        ),
    ],
)
def test_ctrl_c(russian: Catalogue, text: str, said: str) -> None:
    assert russian.say(text) == said


def test_what_was_said_before_stays_before(russian: Catalogue) -> None:
    """A value at the beginning of a template took up the sentence before."""
    said = russian.say(
        "Our Table 4 differs from the published one by at most 2.6 codes (at 0.6 N, 0 m/s). "
        "0 of the 20 published coefficients lie inside our 95 % intervals."
    )
    assert said.startswith("Наша таблица 4 отличается от опубликованной")
    assert said.endswith(" лежат 0 из 20 опубликованных коэффициентов.")


_VERDICTS_ON_TABLES = [
    (
        (
            "The cause is voltage_sag: the drive gets 10.4 % less than its supply, at full code "
            "36.3 % less (probability 0.976 together with its look-alikes); it closes 83 % of the"
            " gap at every third code of each sign. This table cannot tell it from "
            "thrust_deduction, thruster_degraded."
        ),
        (
            "Причина — voltage_sag: привод получает на 10,4 % меньше своего питания, при полном "
            "коде на 36,3 % меньше (вероятность 0,976 вместе с неотличимыми от него); закрывает "
            "83 % расхождения на каждый третий код каждого знака. Эта таблица не отличает его от "
            "thrust_deduction, thruster_degraded."
        ),
    ),
    (
        (
            "The cause is dead_zone: 25.2 codes more than stated give no thrust; reverse_thrust: "
            "astern the thrust is 0.509 of the stated one (probability 0.999)."
        ),
        (
            "Причина — dead_zone: кодов без упора на 25,2 больше указанного; reverse_thrust: "
            "назад упор составляет 0,509 указанного (вероятность 0,999)."
        ),
    ),
    (
        (
            "The table agrees with the thruster model of boat within what a healthy thruster may "
            "differ by (probability 0.977 together with its look-alikes). Too small to be seen "
            "here, if present: dead_zone."
        ),
        (
            "Таблица согласна с моделью движителя boat в пределах допустимого для исправного "
            "движителя (вероятность 0,977 вместе с неотличимыми от него). Слишком малы, чтобы "
            "увидеть здесь, если есть: dead_zone."
        ),
    ),
]


@pytest.mark.parametrize(("text", "said"), _VERDICTS_ON_TABLES)
def test_the_verdict_on_a_mooring_table(russian: Catalogue, text: str, said: str) -> None:
    assert russian.say(text) == said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        # "в 0,94 раз" and "после 21 шагов" would be wrong: no plural hangs on a value
        ("u to 0.039 m/s (0.94 times the noise)", "u: 0,039 м/с (отношение к шуму 0,94)"),
        ("0 of 2646 steps of the grid fall", "падает шагов сетки: 0 из 2646"),
        ("Why", "Причина"),
        ("sound; 90 s; no warnings: a.html", "исправен; 90 с; предупреждений нет: a.html"),
        ("code 20 (table heading), 57 points", "код 20 (заголовок таблицы), 57 точек"),
        ("steps of speed: 0.84, 1.63 m/s", "ступени скорости: 0,84; 1,63 м/с"),
        ("added mass in sway, A_22", "присоединённая масса (боковое движение), A_22"),
        ("12 different codes: 20, 30.", "12 разных кодов: 20, 30."),
        (
            "Expected a decimal number (point or comma), N, as the header says.",
            "Ожидалось: десятичное число (с точкой или запятой), N, как сказано в заголовке.",
        ),
        (
            "row 3: thrust is empty in row 3; left out.",
            "строка 3: упор: пусто, строка 3; отброшено.",
        ),
        (
            "  1. pseudo-random steps, 60 s: wake fraction",
            "  1. псевдослучайные ступени, 60 с: коэффициент попутного потока",
        ),
        ('unknown key "foo" in tables.', 'неизвестный ключ "foo" в разделе "tables".'),
        (
            "torque is empty in row 7; left out. 1 formula cell(s) hold no stored value: B7.",
            "момент: пусто, строка 7; отброшено. формулы без сохранённого значения (1): B7.",
        ),
        (
            'row 28: a.blades is "three". Expected a whole number of at least 1 and at most 12.',
            'строка 28: a.blades — это "three". Ожидалось: целое число не меньше 1 и не больше 12.',
        ),
        (
            'a.xlsx: no open-water curves found on any sheet: "20" has "M-Test. Part 1".',
            'a.xlsx: ни на одном листе нет: кривые винта в свободной воде: "20": "M-Test. Part 1".',
        ),
        (
            "Depth z is off most, 2.2 times what a sound vehicle leaves.",
            "Глубина z отклоняется больше всех, 2,2 к тому, что оставляет исправный аппарат.",
        ),
    ],
)
def test_numbers_and_headings_of_pages(russian: Catalogue, text: str, said: str) -> None:
    assert russian.say(text) == said
