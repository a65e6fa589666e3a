"""What the columns of an open-water test are called, in English and Russian."""

from pipeline.ingest.column_kinds import FIRST_RANK, NOT_MEASURED, NOT_OF_SHAFT, SECOND_RANK
from pipeline.ingest.vocabulary import Vocabulary, Words

_PRINTED = (
    *NOT_MEASURED,
    *("polynomial", "fit", "fitted", "regression", "расчет", "полином"),
)
VOCABULARY: Vocabulary = {
    "advance_ratio": Words(
        None,
        (
            "advance ratio",
            "advance coefficient",
            "advance number",
            "относительная поступь",
            "поступь",
            "lambda",
            "lambda p",
        ),
        symbols=("J", "j", "Jv", "J_v", "JV", "J_V", "λ", "λp", "λ_p", "λр", "λ_р", "Λ"),
    ),
    "thrust_coefficient": Words(
        None,
        (
            *("thrust coefficient", "kt", "k t", "ct", "c t", "коэффициент упора", "кт", "к т"),
            *("10kt", "10k t", "10ct", "10c t", "10кт", "10к т"),  # found so that they are refused
        ),
        symbols=("K1", "K_1", "К1", "К_1"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=(*_PRINTED, "loading", "нагрузки"),
    ),
    "torque_coefficient": Words(
        None,
        (
            "torque coefficient",
            "moment coefficient",
            *("kq", "k q", "km", "k m", "cq", "c q"),
            *("коэффициент момента", "км", "к м", "кq"),
        ),
        symbols=("K2", "K_2", "К2", "К_2"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=_PRINTED,
    ),
    "torque_coefficient_x10": Words(
        None,
        (
            *("10kq", "10 kq", "10k q", "10 k q", "kq 10", "k q 10", "kq x10", "kqx10"),
            *("10km", "10 km", "10k m", "10 k m", "km 10", "k m 10", "km x10"),
            *("10км", "10 км", "10к м", "10 к м", "10cq", "10 cq", "10 c q", "10c q"),
            *("10x kq", "10 x kq", "10 torque coefficient", "10 коэффициент момента"),
        ),
        symbols=("10K2", "10 K2", "10K_2", "10К2"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=_PRINTED,
    ),
    "power_coefficient": Words(
        None,
        ("power coefficient", "cp", "c p", "коэффициент мощности"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=_PRINTED,
    ),
    "efficiency": Words(
        "ratio",
        ("open water efficiency", "efficiency", "кпд", "eta", "eta o", "eta 0"),
        symbols=("η", "ηo", "η_o", "η0", "η_0", "ηр", "ηp"),
        never=(*NOT_MEASURED, "motor", "drive", "relative", "двигателя"),
        default_unit="1",
    ),
    "thrust": Words(
        "force",
        ("thrust", "force", "pull", "bollard pull", "load cell", "упор", "тяга", "усилие"),
        by_unit=True,
        symbols=("T", "Т"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=(*NOT_MEASURED, "coefficient", "коэффициент*", "efficiency"),
    ),
    "torque": Words(
        "torque",
        ("torque", "moment", "момент", "крутящий момент"),
        by_unit=True,
        symbols=("Q", "M", "М"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=(*NOT_MEASURED, "coefficient", "коэффициент*"),
    ),
    "shaft_speed": Words(
        "shaft_speed",
        by_unit=True,
        names=(
            "shaft speed",
            "rotational speed",
            "rotation rate",
            "propeller speed",
            "revolutions",
            "rpm",
            "rps",
            "частота вращения",
            "скорость вращения",
            "обороты",
            "частота",
        ),
        symbols=("n",),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=(*NOT_MEASURED, *NOT_OF_SHAFT),
        unit_words={"rpm": "rpm", "rps": "rps"},
    ),
    "speed": Words(
        "speed",
        by_unit=True,
        names=(
            "advance speed",
            "carriage speed",
            "inflow speed",
            "inflow",
            "flow speed",
            "velocity",
            "speed",
            "скорость потока",
            "скорость хода",
            "скорость",
        ),
        symbols=("V", "Va", "V_a", "VA", "V_A", "v"),
        prefer=FIRST_RANK,
        less=SECOND_RANK,
        never=(
            *NOT_MEASURED,
            *("rotation*", "shaft", "propeller", "вращения", "sound", "motor"),
        ),
    ),
}
