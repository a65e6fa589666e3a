"""What the columns and headings of a mooring test are called, in English and Russian."""

import re

from pipeline.ingest.column_kinds import FIRST_RANK, NOT_MEASURED, NOT_OF_SHAFT, SECOND_RANK
from pipeline.ingest.vocabulary import Vocabulary, Words

VOCABULARY: Vocabulary = {
    "code": Words(
        None,
        (
            *("control code", "command code", "code", "command", "throttle", "duty cycle", "duty"),
            *("код управления", "код", "управление", "команда", "газ", "дроссель", "скважность"),
            *("stellgrad", "consigne", "commande"),
        ),
        symbols=("N", "u", "U_code"),
        never=("pwm", "шим", "voltage", "напряжение"),
    ),
    "pwm": Words(
        "pulse_width",
        (
            *("pwm", "pulse width", "pulse", "esc signal", "esc", "servo"),
            *("шим", "длительность импульса", "ширина импульса", "импульс"),
        ),
        default_unit="us",
        by_unit=True,
    ),
    "thrust": Words(
        "force",
        (
            *("thrust", "bollard pull", "force", "pull", "load cell"),
            *("упор*", "тяга", "сила", "усилие", "schub", "schubkraft", "zugkraft", "poussee"),
        ),
        symbols=("T", "F", "Т", "P"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=(
            *NOT_MEASURED,
            *("efficiency", "coefficient", "specific", "current"),
            *("коэффициент*", "эффективность"),
        ),
        with_unit=("load", "reading", "scale", "показания", "нагрузка", "весы"),
        by_unit=True,
    ),
    "shaft_speed": Words(
        "shaft_speed",
        (
            "shaft speed",
            "rotational speed",
            "rotation speed",
            "motor speed",
            "revolutions",
            "rpm",
            "частота вращения",
            "скорость вращения",
            "обороты",
            "частота",
            *("drehzahl", "vitesse de rotation"),
        ),
        symbols=("n", "ω", "omega"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=(*NOT_MEASURED, *NOT_OF_SHAFT),
        with_unit=("speed", "скорость"),
        default_unit="rpm",
        unit_words={"rpm": "rpm"},
    ),
    "voltage": Words(
        "voltage", ("voltage", "supply", "напряжение", "питание", "spannung"), symbols=("U", "V"),
        prefer=FIRST_RANK, less=SECOND_RANK, never=NOT_MEASURED, default_unit="V",
    ),
    "speed": Words(
        "speed",
        (
            *("speed", "velocity", "flow speed", "inflow", "water speed", "advance speed"),
            *("carriage speed", "current speed", "скорость", "скорость потока", "скорость хода"),
            "скорость воды",
        ),
        symbols=("V", "v", "Va"),
    ),
    "time": Words("time", ("time", "elapsed time", "timestamp", "время"), symbols=("t",)),
    "current": Words(
        "current", ("current", "ток", "сила тока", "strom"), symbols=("I", "Current"),
        prefer=FIRST_RANK, less=SECOND_RANK, never=NOT_MEASURED, default_unit="A",
    ),
}  # fmt: skip
UP = ("up", "rising", "increasing", "ascending", "вверх", "рост", "возрастание", "увеличение")
DOWN = ("down", "falling", "decreasing", "descending", "вниз", "спад", "убывание", "уменьшение")
#: What is done to a rig, and says nothing of the order of codes.
OF_THE_RIG = re.compile(
    r"\b(set|warm\w*|power\w*|start\w*|back|close|mock|wake) up\b"
    r"|\b(cool\w*|power\w*|shut|break|tear|strip|wind) down\b"
)
#: A lever between thruster and sensor, or a factor: whether the numbers hold it people must say.
LEVER = re.compile(
    r"\b(?:lever\w*|moment arm|arm ratio|arms?\b(?=.*\d)|pivot\w*|rocker|bell[ -]?crank|beam ratio"
    r"|рычаг\w*|плеч[оеа]\w*|коромысл\w*|балансир\w*|качалк\w*)\b"
    r"|\b(?:multipl\w*|divid\w*|умнож\w*|раздел[иеё]\w*|дел[ие]\w*|множител\w*)\b.{0,30}?\d",
    re.IGNORECASE,
)
