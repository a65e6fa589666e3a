"""A number of the tables is found by the names that people give it, or what there is is said."""

import pytest

from pipeline.plan import UsageError
from pipeline.workflow.cell import find_cell

TABLES = {
    "table1": {"KT": [0.139, -0.155], "ci95": {"KT": [[0.13, 0.14], [-0.16, -0.15]]}},
    "table2": {
        "speed_mps": [0.0, 0.5, 1.5],
        "KF1": [0.25, 0.22, 0.2],
        "ci95": {"KF1": [[0.2, 0.3], [0.2, 0.3], [0.15, 0.25]]},
    },
    "table3": {"positive": [12.7, 4.3], "negative": None, "ci95": {"positive": [[1, 2], [3, 4]]}},
    "table4": None,
    "firmware": {"positive": {"code": [[1.0, 2.0], [3.0, 4.0]]}},
    "quality": {
        "table1": {"KT": {"points": 50}},
        "table2": {"rows": [{"points": 1}, {"points": 2}, {"points": 3}]},
        "table3": {},
    },
    "published": {"table2": {"speed_mps": [0.0, 1.5], "KF1": [0.254, 0.21]}},
    "not_computed": {"static": "There are no load-test files."},
}


@pytest.mark.parametrize(
    "words", [("table2.KF1[2]",), ("table2", "1.5", "KF1"), ("KF1", "table2", "1,5")]
)
def test_one_number_has_several_names(words: tuple[str, ...]) -> None:
    cell = find_cell(TABLES, words)
    assert (cell.path, cell.value, cell.speed_mps) == ("table2.KF1[2]", 0.2, 1.5)
    assert cell.interval == (0.15, 0.25)
    assert cell.printed == 0.21  # by speed: the published table has fewer rows
    assert cell.fit == {"points": 3}
    assert cell.stage == "static"


def test_number_of_the_coefficient_where_there_is_no_speed() -> None:
    cell = find_cell(TABLES, ("table1", "KT", "1"))
    assert (cell.value, cell.speed_mps, cell.printed) == (-0.155, None, None)
    assert cell.fit == {"points": 50}
    assert find_cell(TABLES, ("table3.positive[0]",)).interval == (1, 2)


def test_firmware_grid_is_reached_by_its_path() -> None:
    cell = find_cell(TABLES, ("firmware.positive.code[1][0]",))
    assert (cell.value, cell.interval, cell.stage) == (3.0, None, "inverse")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("table9", "KT", "1"), "There are: table1, table2"),
        (("quality.table1[0]",), "There are: table1, table2"),
        (("table2", "KF1", "1.7"), "table2 has no row for 1.7 m/s. There are: 0, 0.5, 1.5."),
        (("table2.KF9[0]",), 'table2 has no "KF9". There is: speed_mps, KF1, ci95.'),
        (("table2.KF1[3]",), "has no [3]: it is a list of 3"),
        (("table2.KF1",), "is not a number but a list of 3"),
        (("table4", "KN1", "1.0"), "table4 was not computed.\nThere are no load-test files."),
        (("table3.negative[0]",), "has no [0]: it is nothing"),
        (("table2",), "names no number"),
        (("table1", "KT", "0.5"), "is not a number"),
        (("table1", "KT", "nan"), "is not a number"),
        (("table1", "KT", "-1"), "table1.KT has no [-1]: it is a list of 2"),
        (("../../etc/passwd",), "names no number"),
    ],
)
def test_what_is_not_there_is_refused_with_what_is(words: tuple[str, ...], said: str) -> None:
    with pytest.raises(UsageError) as caught:
        find_cell(TABLES, words)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("words", "unit"),
    [
        (("table1.KT[0]",), ""),
        (("table2.KF1[0]",), "N/code"),
        (("table3.positive[0]",), "code"),
        (("table3.positive[1]",), "code/N"),
        (("firmware.positive.code[0][1]",), "code"),
    ],
)
def test_a_number_has_its_unit(words: tuple[str, ...], unit: str) -> None:
    assert find_cell(TABLES, words).unit == unit


def test_each_reason_of_a_table_that_is_not_there_stands_on_a_line_of_its_own() -> None:
    both = {"propeller": "There is no open water", "static": "There is no load test: put one in x/"}
    with pytest.raises(UsageError) as caught:
        find_cell({**TABLES, "not_computed": both}, ("table4.KN1[0]",))
    assert str(caught.value).splitlines()[1:] == list(both.values())
