"""Text tables whose cells cannot be told apart, or where a quotation mark was never closed."""

import pytest

from pipeline.errors import InputError, Place
from pipeline.ingest.cells import Limits, Sheet
from pipeline.ingest.text_table import read_text_table


def table(text: str) -> Sheet:
    return read_text_table(text.encode(), Place("a.csv"), Limits())


@pytest.mark.parametrize(
    "text",
    [
        "code,thrust [N]\n30,4,41\n60,14,42\n90,26,0\n",
        "rpm,torque\n1324,5,0,378\n1100,2,0,4\n",
        "bench of May, drive 7, Ivanov, room 2\ncode,thrust\n,N\n30,4,41\n60,14,42\n0,0\n",
    ],
)
def test_decimal_commas_in_a_comma_parted_table_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="decimal sign and the separator") as caught:
        table(text)
    assert "semicolon" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "rows"),
    [
        ("code;thrust\n30;4;41\n60;14;42\n90;26;0\n", "rows 2-4"),
        ("code,thrust\n30,4.41,1\n60,14.42,2\n", "rows 2-3"),
        ("code,thrust\n30,4\n45,9,22\n60,14\n75,20\n", "row 3"),
    ],
)
def test_numbers_beyond_the_last_name_are_told(text: str, rows: str) -> None:
    (problem,) = table(text).problems
    assert problem.severity == "warning"
    assert "under 2 column names" in problem.what
    assert f"({rows})" in problem.what


@pytest.mark.parametrize(
    "text",
    [
        "code,thrust\n30,4,slow\n60,14,\n",
        "title, of two\ncode,thrust,speed\n30,4,600\n60,14,900\n",
        "code,thrust,remark\n,N\n30,4,1\n60,14,2\n",
        "speed;thrust\n#30;1;2\n30;1\n",
        'code,"thrust, N"\n30,"4,41"\n60,"14,42"\n',
    ],
)
def test_good_tables_are_left_alone(text: str) -> None:
    assert table(text).problems == ()


def test_a_quotation_mark_that_is_never_closed_is_refused() -> None:
    text = 'code,thrust,remark\n0,0,ok\n30,4.4,"first try\n60,14.4,ok\n90,26,ok\n'
    with pytest.raises(InputError, match="quotation mark is not closed") as caught:
        table(text)
    assert "row 3" in str(caught.value)
    assert "60,14.4,ok" in str(caught.value)


def test_cells_of_several_lines_are_read() -> None:
    sheet = table('code,"Thrust\n[N]",remark\n30,4.4,"one\ntwo; 3"\n60,14.4,ok\n')
    assert sheet.rows[0][1] == "Thrust\n[N]"
    assert len(sheet.rows) == 3


def test_names_that_were_cut_at_their_commas() -> None:
    text = "Code,Thrust, kgf,Speed, rpm\n1,2,3\n4,5,6\n"
    sheet = read_text_table(text.encode(), Place("a.csv"), Limits())
    assert sheet.rows[0] == ("Code", "Thrust, kgf", "Speed, rpm")
    text = "Code,Speed, of the shaft (rpm),Torque (N m)\n1,2,3\n"
    (problem,) = read_text_table(text.encode(), Place("a.csv"), Limits()).problems
    assert "4 names stand over 3 columns" in problem.what
