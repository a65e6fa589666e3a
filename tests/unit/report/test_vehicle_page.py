"""What the page says: order, completeness, escaping, determinism, missing parts."""

import dataclasses
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
import synthetic_records

from pipeline.errors import InputError, Place, Problem
from pipeline.records.base import AppliedChange, FileChange
from pipeline.records.fits import Check, InverseCharacteristic
from pipeline.report.bench_results import bench_line, vehicle_glance
from pipeline.report.blocks import Details, Figure
from pipeline.report.html import write_page
from pipeline.report.results import VehicleResults
from pipeline.report.sections.inputs import note_block
from pipeline.report.sections.propeller import working_points_section
from pipeline.report.vehicle_page import firmware_section, vehicle_page

VOID = {"meta", "link", "br", "img", "hr", "input"}


class Outline(HTMLParser):
    """Collects tags, text and ids, and checks that tags close in order."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)


def outline(page: str) -> Outline:
    parser = Outline()
    parser.feed(page)
    assert parser.open == []
    return parser


def text_of(page: str) -> str:
    return re.sub(r"\s+", " ", "".join(outline(page).text).replace("\N{NO-BREAK SPACE}", " "))


def table(page: str, caption: str) -> str:
    """The table whose caption starts so, as text with cells set apart."""
    for part in re.findall(r"<table>.*?</table>", page, re.DOTALL):
        plain = re.sub(r"<su[bp]>|</su[bp]>", "", part)
        found = re.search(r"<caption><span>(.*?)</span></caption>", plain, re.DOTALL)
        if found and found[1].startswith(caption):
            return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", "|", plain))
    raise AssertionError(f"no table {caption!r}")


def test_results_are_in_the_open_and_what_came_in_is_folded(page: str) -> None:
    assert re.findall(r'<h2 id="([a-z0-9-]+)"', page) == ["trials", "firmware"]
    assert re.findall(r'<summary id="([a-z0-9-]+)"', page) == [
        "warnings",
        "inverse",
        "static",
        "propeller",
        "drive",
        "working-points",
        "gap",
        "allocation",
        "outliers",
        "inputs",
        "provenance",
    ]
    first = page.index('id="fig-thrust"')
    assert page.index('class="matter"') < first < page.index('id="trials"')


def test_every_contents_link_has_its_target_and_no_id_is_used_twice(page: str) -> None:
    tags = outline(page).tags
    ids = [attrs["id"] for _, attrs in tags if "id" in attrs]
    assert len(ids) == len(set(ids))
    links = [attrs["href"] or "" for tag, attrs in tags if tag == "a"]
    assert {link[1:] for link in links if link.startswith("#")} <= set(ids)


def test_same_results_give_the_same_bytes(results: VehicleResults, page: str) -> None:
    assert vehicle_page(results) == page


def test_page_is_small_and_self_contained(page: str) -> None:
    assert ": thruster tables</title>" in page
    assert len(page.encode()) < 3_000_000
    tags = outline(page).tags
    assert not [tag for tag, _ in tags if tag in {"iframe", "object", "embed"}]
    assert not [tag for tag, _ in tags if tag == "script"]
    fetched = [
        value
        for tag, attrs in tags
        for name, value in attrs.items()
        if name in {"src", "xlink:href", "href"} and tag != "a" and value
    ]
    assert all(value.startswith(("data:", "#")) for value in fetched)
    assert not re.search(r"@import|url\((?!#)", page)


def test_no_date_and_no_path_of_the_machine(page: str) -> None:
    assert "dc:date" not in page
    assert str(Path.home()) not in page


@pytest.mark.parametrize(
    "field", ["sheet and problem", "title", "data note", "missing reason", "firmware file"]
)
def test_hostile_text_is_shown_and_not_run(results: VehicleResults, field: str, page: str) -> None:
    hostile = synthetic_records.HOSTILE
    bare = VehicleResults(vehicle=results.vehicle)
    if field == "title":
        vehicle = results.vehicle.model_copy(update={"title": hostile})
        page = vehicle_page(dataclasses.replace(bare, vehicle=vehicle))
    elif field == "data note":
        vehicle = results.vehicle.model_copy(update={"data_note": hostile})
        page = vehicle_page(dataclasses.replace(bare, vehicle=vehicle))
    elif field == "missing reason":
        page = vehicle_page(dataclasses.replace(bare, missing={"allocation": hostile}))
    elif field == "firmware file":
        page = vehicle_page(dataclasses.replace(bare, firmware_files=(hostile,)))
    assert "<script>" not in page
    assert "&lt;script&gt;alert(&#34;1&#34;)&lt;/script&gt;" in page


def test_a_link_cannot_carry_a_scheme(results: VehicleResults) -> None:
    page = vehicle_page(
        VehicleResults(vehicle=results.vehicle, firmware_files=("javascript:alert(1)",))
    )
    links = [attrs["href"] or "" for tag, attrs in outline(page).tags if tag == "a"]
    assert not [link for link in links if link.lower().startswith("javascript:")]


def test_every_figure_has_a_sentence_axes_and_a_description(page: str) -> None:
    figures = re.findall(r"<figure.*?</figure>", page, re.DOTALL)
    assert len(figures) == 9
    for figure in figures:
        lead = re.search(r'<p class="see">(.*?)</p>', figure, re.DOTALL)
        assert lead
        assert len(lead[1]) > 30
        label = re.search(r'<svg[^>]*role="img"[^>]*aria-label="([^"]+)"', figure)
        assert label
        assert len(label[1]) > 30
        assert re.search(r"\[[^\]]+\]", figure), "an axis without a unit"


def test_column_and_row_headings_have_scopes(page: str) -> None:
    headings = [attrs for tag, attrs in outline(page).tags if tag == "th"]
    assert headings
    assert {attrs.get("scope") for attrs in headings} == {"col", "row"}


def test_the_origin_of_the_data_stands_above_everything(page: str) -> None:
    note = page.index("These data are rebuilt from printed tables")
    assert note < page.index('id="warnings"')


def test_problems_are_shown_by_severity_with_place_and_remedy(page: str) -> None:
    problems = table(page, "Problems in the raw files")
    assert problems.index("broken.xlsx") < problems.index("row 14, column C")
    assert "Fix the cell." in problems
    assert "each of " in problems, "what is counted is that of one place"
    assert "and 3 more, listed below" in problems
    # all seven places of the grouped warning are on the page
    assert page.count("row 9") >= 7
    assert "1 error in the raw files." in page
    assert "1 of 2540 steps rise" in table(page, "Checks that failed")


def test_points_used_and_left_out_add_up(page: str) -> None:
    text = text_of(page)
    assert "672 points read, 648 used, 24 left out." in text
    assert "2 warm-up" in table(page, "Sheets and what became of their points")
    assert "|5–6|" in table(page, "Points left out, by row")
    assert "Обороты, об/мин" in table(page, "Columns and units as understood")
    assert "the falling sweeps read +0.20 N" in text
    assert "moved by up to 0.13 N" in text


def test_table1_shows_ours_published_and_difference(page: str) -> None:
    row = re.search(r"\|KT0\|.*?\|KT1\|", table(page, "Table 1."))
    assert row
    cells = [cell.strip() for cell in row[0].split("|") if cell.strip()]
    # 0.1391 against the printed 0.139
    assert cells[1].startswith("0.1391")
    assert cells[3] == "0.139"
    assert cells[4] == "+1.0·10⁻⁴"
    assert cells[5] == "yes"
    # 0.0001 / 0.139 = 0.0719 %
    assert "KT differs by at most 0.072 % of KT0" in text_of(page)


def test_coefficients_of_table_2_have_units_of_their_own(page: str) -> None:
    rows = table(page, "Table 2. T = KF0 sign N")
    for name in ("KF0, N|", "KF1, N per code|", "KF2, N per code²|"):
        assert name in rows


def test_full_code_thrust_stands_beside_both_published_tables(page: str) -> None:
    largest = table(page, "Thrust at the largest code, 127")
    # Table 2 gives -4 + 0.254 * 127 + 8.82e-4 * 127^2 = 42.48 N, Table 4 prints 42 N
    first = re.search(r"\|0\|.*?\|0\.5\|", largest)
    assert first
    cells = [cell.strip() for cell in first[0].split("|") if cell.strip()]
    assert cells[3] == "42.48"
    assert cells[5] == "42"
    # 24.8 against 25.40 at 2 m/s is the largest difference of the two
    assert "The two published tables differ from each other by up to 0.60 N here." in text_of(page)


def test_table3_and_the_gap_are_stated_in_codes_and_newtons(page: str) -> None:
    text = text_of(page)
    assert "at most 0.40 codes for positive thrust" in text
    assert "8 of the 8 published coefficients lie inside" in text
    assert re.search(r"The two routes to the thrust at rest differ by up to \d\.\d\d N", text)


def test_tables_two_and_four_are_in_the_layout_of_the_paper(page: str) -> None:
    table2 = table(page, "Table 2.")
    assert table2.count("|published|") == 4
    assert "|9.65·10⁻⁴|" in table2
    table4 = table(page, "Table 4. ")
    assert table4.count("|published|") == 5
    assert "1.21·10⁻³" in table4  # printed as 12.1*10^-4


def test_round_trip_is_given_for_all_three_forms(page: str) -> None:
    rows = table(page, "Largest error of T(N(T, V), V)")
    assert "|1| |0.200| |0.0300| |0.50| |0.76|" in rows
    # 0.02 + 0.01 * 1.9 between the tabulated speeds
    assert "off by at most 0.0390 N before rounding" in text_of(page)


def test_allocator_has_one_number_for_each_speed(page: str) -> None:
    # worst = 0.004 + 0.2 V and 0.004 + 0.004 V
    text = text_of(page)
    assert "to 40 % at 2 m/s; with it, it stays at or below 1.2 %." in text


def test_outliers_are_named_with_their_row(page: str) -> None:
    assert "synthetic/open_water/curves.csv, row 17" in table(page, "Outliers")


def test_mooring_alone_shows_what_there_is_and_why_the_rest_is_missing(
    results: VehicleResults,
) -> None:
    assert results.inverse is not None
    inverse: InverseCharacteristic = results.inverse.model_copy(
        update={"table4": (), "round_trip": ()}
    )
    vehicle = results.vehicle.model_copy(update={"allocator": None, "published": None})
    reason = "there is no open-water file, so K_T(J) and K_M(J) are unknown."
    page = vehicle_page(
        VehicleResults(
            vehicle=vehicle,
            mooring=results.mooring,
            inverse=inverse,
            missing={"propeller": reason, "drive": "there is no load test."},
        )
    )
    text = text_of(page)
    assert "KT(J) and KM(J) are unknown." in text
    assert "there is no load test." in text
    assert "Table 4 was not computed" in text
    assert "Table 3." in text
    assert len(re.findall(r"<figure", page)) == 2
    assert "Published" not in table(page, "Table 3.")
    assert "Not computed (" in text


@pytest.mark.usefixtures("undrawn")
def test_intervals_that_could_not_count_whole_sweeps_are_warned_of(
    results: VehicleResults, page: str
) -> None:
    assert results.drive is not None
    assert "The covariance is clustered by sweep" in text_of(page)
    few = results.drive.model_copy(update={"clustered": False, "clusters": 3})
    unsound = text_of(vehicle_page(dataclasses.replace(results, drive=few)))
    assert "The covariance is clustered by sweep" not in unsound
    assert "The 3 sweeps are too few for the" in unsound
    assert "could not be clustered by sweep" in unsound


@pytest.mark.usefixtures("undrawn")
def test_range_of_codes_is_the_drives(results: VehicleResults, page: str) -> None:
    inverse = results.inverse
    assert inverse is not None
    assert inverse.firmware is not None
    weak = inverse.firmware.model_copy(update={"code_min": -100})
    weak_results = dataclasses.replace(
        results, inverse=inverse.model_copy(update={"firmware": weak})
    )
    assert "The tables cover codes −127 to 127" in text_of(page)
    assert "The tables cover codes −100 to 127" in text_of(vehicle_page(weak_results))


def test_load_test_alone_shows_the_drive(results: VehicleResults) -> None:
    page = vehicle_page(
        VehicleResults(
            vehicle=results.vehicle, load_test=results.load_test, drive=results.drive, missing={}
        )
    )
    assert len(re.findall(r"<figure", page)) == 1
    assert "Scatter about the surface, by code" in page


def test_load_test_that_cannot_be_fitted_is_shown_as_measured(results: VehicleResults) -> None:
    page = vehicle_page(
        VehicleResults(
            vehicle=results.vehicle,
            load_test=results.load_test,
            missing={"drive": "there is no control code."},
        )
    )
    assert "Not computed: there is no control code." in text_of(page)
    assert "648 points; they stand here as measured" in text_of(page)


def test_propeller_alone_shows_its_demand(results: VehicleResults) -> None:
    page = vehicle_page(
        VehicleResults(
            vehicle=results.vehicle,
            open_water=results.open_water,
            propeller=results.propeller,
            missing={"drive": "there is no load test."},
        )
    )
    assert len(re.findall(r"<figure", page)) == 2
    assert "The working points were not computed: there is no load test." in text_of(page)


@pytest.mark.usefixtures("undrawn")
def test_tables_of_rest_alone_are_not_compared_with_another_speed(results: VehicleResults) -> None:
    tables = results.vehicle.tables.model_copy(update={"speed_mps": (0.0,)})
    vehicle = results.vehicle.model_copy(update={"tables": tables})
    (figure,) = working_points_section(dataclasses.replace(results, vehicle=vehicle)).blocks
    assert isinstance(figure, Figure)
    assert figure.lead.endswith("at 0 m/s.")
    assert "the faster the inflow" not in figure.lead


def test_the_fastest_speed_of_the_firmware_is_not_rounded(results: VehicleResults) -> None:
    assert results.inverse is not None
    firmware = results.inverse.firmware
    assert firmware is not None
    speeds = (*firmware.positive.speed_mps[:-1], 2.25)
    positive = firmware.positive.model_copy(update={"speed_mps": speeds})
    inverse = results.inverse.model_copy(
        update={"firmware": firmware.model_copy(update={"positive": positive})}
    )
    section = firmware_section(dataclasses.replace(results, inverse=inverse))
    assert "speeds to 2.25 m/s along the thrust" in str(section.blocks)


def test_nothing_at_all_is_still_a_page(results: VehicleResults) -> None:
    page = vehicle_page(VehicleResults(vehicle=results.vehicle))
    assert "Not computed (" in page
    assert "Nothing was measured yet." in page
    assert "<figure" not in page


def test_measurements_that_give_no_tables_say_what_is_lacking(results: VehicleResults) -> None:
    why = "Table 3: no. No firmware tables: thrust was measured at 4 codes; 5 are the least."
    glance = vehicle_glance(
        VehicleResults(vehicle=results.vehicle, mooring=results.mooring, missing={"inverse": why})
    )
    assert glance.light == "amber"
    assert glance.matter == "What was measured gives no tables yet."
    (advice,) = glance.do
    assert advice.text.endswith("lacking: thrust was measured at 4 codes; 5 are the least.")


def test_a_characteristic_of_one_direction_says_what_its_tables_lack(
    results: VehicleResults,
) -> None:
    assert results.inverse is not None
    why = (
        "Table 3 is there.",
        "No firmware tables: negative codes: none was measured.",
        "At 16 V.",
    )
    ahead_alone = results.inverse.model_copy(update={"firmware": None, "explanations": why})
    glance = vehicle_glance(
        VehicleResults(
            vehicle=results.vehicle,
            mooring=results.mooring,
            open_water=results.open_water,
            inverse=ahead_alone,
        )
    )
    assert glance.matter == "What was measured gives no tables yet."
    (advice,) = glance.do
    assert advice.text.endswith("lacking: negative codes: none was measured.")


def test_what_is_told_first_names_a_warning(results: VehicleResults) -> None:
    assert results.mooring is not None
    odd = results.mooring.model_copy(update={"problems": (Place("b.csv").warning("1.13 times."),)})
    glance = vehicle_glance(VehicleResults(vehicle=results.vehicle, mooring=odd))
    assert glance.light == "amber"
    assert "See a warning: b.csv: 1.13 times." in [one.text for one in glance.do]


def test_what_is_told_first_names_all_checks_that_failed(results: VehicleResults) -> None:
    assert results.inverse is not None
    names = ("thrust rises with the code", "outliers are few")
    checks = tuple(Check(name=one, passed=False, text="") for one in names)
    glance = vehicle_glance(
        VehicleResults(
            vehicle=results.vehicle,
            inverse=results.inverse.model_copy(update={"checks": checks}),
        )
    )
    told = "See 2 checks that failed: thrust rises with the code, outliers are few."
    assert told in [one.text for one in glance.do]


def test_what_is_no_file_counts_as_an_error(results: VehicleResults) -> None:
    link = Place("boat/mooring/b.csv").error("this is no file, or a link to one that is not there.")
    glance = vehicle_glance(VehicleResults(vehicle=results.vehicle, ignored=(link,)))
    assert glance.light == "red"
    assert "Not read: boat/mooring/b.csv." in [one.text for one in glance.do]


def test_an_unwritable_place_is_one_clear_message(tmp_path: Path) -> None:
    taken = tmp_path / "reports"
    taken.write_text("a file where a folder is wanted")
    with pytest.raises(InputError, match=r"the report cannot be written"):
        write_page("<p>", taken / "page.html")


def test_writing_leaves_no_half_page_beside_it(results: VehicleResults, tmp_path: Path) -> None:
    target = tmp_path / "a" / "index.html"
    write_page(vehicle_page(VehicleResults(vehicle=results.vehicle)), target)
    assert [path.name for path in target.parent.iterdir()] == ["index.html"]
    assert target.read_bytes().endswith(b"</html>\n")


@pytest.mark.usefixtures("undrawn")
def test_changes_of_the_vehicle_file_are_listed_with_digests(results: VehicleResults) -> None:
    change = FileChange(path="thrusters.0.gain_ahead", old=1.0, value=0.69, ci95=(0.63, 0.76))
    entry = AppliedChange(
        number=1, date_utc="2026-05-16 10:00:00", reason="diagnosis of a", source="d.json",
        source_sha256="d" * 64, runs=("a",), before_sha256="1" * 64, after_sha256="2" * 64,
        former="vehicle.yaml.1.before", changes=(change,),
    )  # fmt: skip
    undone = entry.model_copy(update={"number": 2, "undone_utc": "2026-05-17 10:00:00"})
    text = vehicle_page(replace(results, changes=(entry, undone)))
    for part in (
        *("thrusters.0.gain_ahead", "0.6900 [0.6300, 0.7600]", "diagnosis of a"),
        *("undone 2026-05-17 10:00:00 UTC", "111111111111 → 222222222222"),
    ):
        assert part in text
    assert 'id="changes"' not in vehicle_page(results)


def test_as_many_notes_are_counted_as_the_table_has_rows() -> None:
    places = [(f"{name}.xlsx", "warm-up") for name in "ab"]
    found = note_block([Problem("note", Place(file), what) for file, what in (*places, places[0])])
    assert isinstance(found, Details)
    assert found.summary == "1 note: what was assumed"
    assert note_block([Problem("warning", Place("a.xlsx"), "odd")]) is None


def test_a_drive_that_does_not_reverse_has_no_thrust_astern(results: VehicleResults) -> None:
    inverse = results.inverse
    assert inverse is not None
    assert inverse.firmware is not None
    assert " / " in bench_line("rov", inverse)
    one_way = inverse.model_copy(
        update={"firmware": inverse.firmware.model_copy(update={"code_min": 0})}
    )
    assert re.search(r"rov: \d+\.\d N at rest", bench_line("rov", one_way))
