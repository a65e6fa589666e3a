"""The page of a diagnosis says what the record says, in order, and lets nothing through."""

import re
from pathlib import Path

import diagnosis_records
import numpy as np
import pytest

from pipeline.records.diagnosis import (
    BenchDiagnosisRecord,
    ChannelNoiseCheck,
    CodeSeries,
    Detail,
    DiagnosisRecord,
    Series,
    Verdict,
)
from pipeline.report import html
from pipeline.report.diagnosis_page import (
    diagnosis_line,
    diagnosis_page,
)
from pipeline.report.diagnosis_words import beside, in_words
from pipeline.report.sections.diagnosis_curves import curves, held_out
from pipeline.report.sections.diagnosis_gap import MOST_DRAWN, gap_lead, map_rows

EVIL = '<script>alert("x")</script>'


@pytest.fixture(scope="module")
def record() -> DiagnosisRecord:
    return diagnosis_records.diagnosis(channels=("w", "psi"), windows=4)


@pytest.fixture(scope="module")
def page(record: DiagnosisRecord) -> str:
    return diagnosis_page(record, files=(("The record (JSON)", "diagnosis.json"),))


def with_verdict(record: DiagnosisRecord, *effects: str) -> DiagnosisRecord:
    verdict = Verdict(
        effects=effects, probability=0.93, ambiguous_with=(), detail=Detail(), sentence="So."
    )
    return record.model_copy(update={"verdict": verdict})


def test_the_verdict_comes_first_and_the_notes_before_the_rest(
    page: str, record: DiagnosisRecord
) -> None:
    anchors = ("ranking", "shrink", "gap", "confusable", "next", "notes", "evidence", "files")
    places = [page.index('class="matter"'), *(page.index(f'id="{one}"') for one in anchors)]
    assert places == sorted(places)
    assert record.verdict.sentence.split(":")[0] in page


def test_every_answer_interval_and_group_is_on_the_page(page: str, record: DiagnosisRecord) -> None:
    for one in record.ranking:
        assert in_words(one.effect.split("+")[0]) in page
    assert "force 4.12\N{NO-BREAK SPACE}N (3.81 to 4.43)" in page
    assert "one answer unless the verdict names a thruster, axis or size" in page
    assert "Fly heave steps" in page
    assert "7.3 standard deviations" in page
    assert "skipped: neither shaft speed nor current was measured" in page
    assert "94\N{NO-BREAK SPACE}% of what can be closed" in page
    assert 'href="diagnosis.json"' in page


def test_every_picture_has_a_sentence_above_it_and_a_text_for_those_who_do_not_see_it(
    page: str,
) -> None:
    pictures = page.count('<svg class="plot"')
    assert pictures == 4
    assert len(re.findall(r'<p class="see">[^<]{20,}', page)) == pictures
    assert len(re.findall(r'role="img" aria-label="[^"]{20,}"', page)) == pictures


def test_without_assets_no_script_runs_and_the_pictures_are_there(page: str) -> None:
    assert "<script" not in page
    assert "script-src" not in page
    assert not re.search(r'(?:src|href)="https?:', page)


@pytest.mark.usefixtures("undrawn")
def test_with_assets_the_page_leads_to_one_shared_copy(
    record: DiagnosisRecord, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(html, "_library", lambda: b"// library")
    short = record.model_copy(update={"series": record.series[:1]})
    path = tmp_path / "reports" / "v" / "diagnoses" / "a" / "index.html"
    text = diagnosis_page(short, assets=html.placed(tmp_path / "reports" / "assets", path))
    assert '<script defer src="../../../assets/plotly.min.js"></script>' in text
    assert "script-src 'self' file:;" in text
    assert "unsafe-eval" not in text
    assert (tmp_path / "reports" / "assets" / "zoom.js").is_file()


@pytest.mark.usefixtures("undrawn")
def test_names_from_files_are_escaped(record: DiagnosisRecord) -> None:
    one = record.series[0].model_copy(update={"run": EVIL})
    ranking = (record.ranking[0].model_copy(update={"thruster": EVIL}), *record.ranking[1:])
    poisoned = record.model_copy(
        update={
            "vehicle": EVIL,
            "runs": (EVIL,),
            "notes": (EVIL,),
            "series": (one,),
            "ranking": ranking,
            "evidence": record.evidence.model_copy(update={"stages": {EVIL: EVIL}}),
        }
    )
    text = diagnosis_page(poisoned)
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert" in text


@pytest.mark.usefixtures("undrawn")
def test_none_and_unknown_have_pages_of_their_own(record: DiagnosisRecord) -> None:
    bare = record.model_copy(
        update={
            "series": (),
            "confusable": (),
            "next_run": None,
            "gap": record.gap.model_copy(
                update={
                    "by_regime": (),
                    "where": record.gap.where.model_copy(
                        update={"channels": (), "regimes": (), "times": ()}
                    ),
                }
            ),
            "shrink": record.shrink.model_copy(
                update={"after": record.shrink.before, "gap_closed": None, "ci95": None}
            ),
        }
    )
    healthy = with_verdict(bare, "none")
    text = diagnosis_page(healthy)
    assert 'class="told green"' in text
    assert "No channel stands out" in text
    assert "nothing is added to the model" in text
    assert "sure to 0.93" in text
    unknown = diagnosis_page(with_verdict(bare, "unknown"))
    assert "goes with speed (rank correlation −0.55)" in unknown
    assert "vary speed on its own" in unknown


def test_the_map_has_a_row_for_every_horizon_and_regime(record: DiagnosisRecord) -> None:
    rows = map_rows(record)
    assert [label for label, _ in rows[:6]] == [
        "all readings", "0.5 s ahead", "2 s ahead", "10 s ahead", "whole run",
        "speed 0.00 to 0.20 m/s",
    ]  # fmt: skip
    assert len(rows) == 5 + len(record.gap.by_regime)
    assert gap_lead(record).startswith(
        "Depth z is off most, 31 times what a sound vehicle leaves; 61 %"
    )


@pytest.mark.usefixtures("undrawn")
def test_a_large_gap_is_shaded_and_an_ordinary_one_is_not(record: DiagnosisRecord) -> None:
    page = diagnosis_page(record)
    shaded = [float(one) for one in re.findall(r'<td class="hot3">([\d.]+)</td>', page)]
    plain = re.findall(r"<td>([\d.]+)</td>", page.partition("Error over what a sound")[2])
    assert shaded
    assert min(shaded) >= 10.0
    assert min(map(float, plain[:3])) < 1.5


@pytest.mark.usefixtures("undrawn")
def test_a_verdict_that_adds_nothing_is_drawn_as_one_curve(record: DiagnosisRecord) -> None:
    first = record.series[0].model_copy(update={"after": record.series[0].before})
    text = diagnosis_page(record.model_copy(update={"series": (first,)}), assets="assets")
    assert '"name":"expected"' in text
    assert '"name":"with the answer"' not in text
    assert "with the answer added" not in text


@pytest.mark.usefixtures("undrawn")
def test_of_very_many_figures_the_last_are_named_and_not_drawn(record: DiagnosisRecord) -> None:
    first = record.series[0]
    many = tuple(first.model_copy(update={"run": f"run-{k:02}"}) for k in range(MOST_DRAWN + 2))
    text = diagnosis_page(record.model_copy(update={"series": many}), assets="assets")
    # and the picture of the first screen, and the bars of the answers
    assert text.count('class="zoom-data"') == MOST_DRAWN + 2
    assert f"Not drawn: w in run-{MOST_DRAWN}, w in run-{MOST_DRAWN + 1}." in text


def test_windows_are_joined_with_a_break_and_angles_do_not_jump() -> None:
    time_s = (0.0, 1.0)
    first = Series(
        run="a", channel="psi", unit="rad", time_s=time_s,
        measured=(3.1, -3.1), before=(-3.1, -3.0), after=(3.1, -3.1),
    )  # fmt: skip
    later = first.model_copy(update={"time_s": (2.0, 3.0)})
    (one,) = held_out((later, first))
    assert one.unit == "deg"
    assert one.time_s.tolist() == [0.0, 1.0, 2.0, 2.0, 3.0]
    assert np.isnan(one.measured[2])
    jump = np.degrees(2 * np.pi - 6.2)
    assert one.measured[1] - one.measured[0] == pytest.approx(jump)
    left = one.measured - one.before
    assert left[:2] == pytest.approx([-jump, -np.degrees(0.1)])
    assert one.errors[1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.usefixtures("undrawn")
def test_a_mooring_table_is_shown_over_its_codes(record: DiagnosisRecord) -> None:
    code = (60.0, -60.0, 0.0)
    curve = CodeSeries(
        channel="thrust", unit="N", code=code, measured=(20.0, -18.0, 0.0),
        before=(25.0, -20.0, 0.0), after=(20.0, -18.5, 0.0), held_out=(False, True, False),
    )  # fmt: skip
    values = {name: getattr(record, name) for name in type(record).model_fields}
    shrink = record.shrink.model_copy(update={"before": 3.0, "after": 1.0, "noise_floor": 0.5})
    values.update(series=(), runs=("new.xlsx",), shrink=shrink)
    table = BenchDiagnosisRecord(**values, by_code=(curve,))
    (one,) = curves(table)
    assert one.time_s.tolist() == [-60.0, 0.0, 60.0]
    text = diagnosis_page(table, assets="assets")
    assert "control code" in text
    assert "from 6.00 to 2.00 times what a sound vehicle leaves" in text
    assert "What to measure next" in text
    assert "No sound runs" not in text
    assert "1 mooring table: new.xlsx" in text
    assert "all channels" not in text
    assert "docs/diagnosis_bench.md" in text
    assert "it closes 94 % of the gap (95 % interval" in text.replace("\xa0", " ")
    assert "Next: measure heave steps." in text
    # of the code that took no part alone
    assert (
        "Thrust in new.xlsx, where it was not used for the fit: error 2.0 N before, 0.50 N after"
        in text.replace("\xa0", " ")
    )
    other = curve.model_copy(update={"held_out": (False, False, False)})
    text = diagnosis_page(table.model_copy(update={"by_code": (other,)}))
    assert (
        "Thrust in new.xlsx, which was used for the fit: error 3.1 N before, 0.29 N after"
        in text.replace("\xa0", " ")
    )


@pytest.mark.usefixtures("undrawn")
def test_what_an_unknown_cause_leaves_of_a_mooring_table_is_no_force_to_fly_for(
    record: DiagnosisRecord,
) -> None:
    values = {name: getattr(record, name) for name in type(record).model_fields}
    leftover = record.leftover.model_copy(
        update={
            "depends_on": "|code|",
            "correlation": 0.8,
            "time_course": "largest at code 90: 9 N",
        }
    )
    verdict = record.verdict.model_copy(update={"effects": ("unknown",)})
    values.update(series=(), leftover=leftover, verdict=verdict)
    text = diagnosis_page(BenchDiagnosisRecord(**values, by_code=()))
    assert "The thrust that is left goes with the size of the code (rank correlation 0.80)." in text
    assert "What is left: largest at code 90: 9\N{NO-BREAK SPACE}N." in text
    assert "in the next run" not in text


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("widened_by", "said"),
    [(1.0, "Nothing was widened for it."), (1.2, "how much wider")],
)
def test_noise_that_is_odd_is_said_to_be_widened_only_where_it_was(
    record: DiagnosisRecord, widened_by: float, said: str
) -> None:
    check = ChannelNoiseCheck(variance=0.9, lag1=-0.2, widened_by=widened_by)
    evidence = record.evidence.model_copy(update={"noise": {"depth": check}})
    text = diagnosis_page(record.model_copy(update={"evidence": evidence}))
    assert "The noise model does not fit depth" in text
    assert said in text


@pytest.mark.usefixtures("undrawn")
def test_the_same_record_gives_the_same_page(record: DiagnosisRecord) -> None:
    short = record.model_copy(update={"series": record.series[:1]})
    assert diagnosis_page(short) == diagnosis_page(short)


def test_a_list_says_the_answer_in_one_line(record: DiagnosisRecord) -> None:
    assert diagnosis_line(record) == (
        "residual buoyancy (96 %), not to be told from payload; pool-1 and pool-2"
    )


@pytest.mark.usefixtures("undrawn")
def test_how_closely_the_gap_goes_with_a_regime_is_told_where_it_is_known(
    record: DiagnosisRecord,
) -> None:
    assert "rank correlation −0.62" not in diagnosis_page(record)
    where = record.gap.where
    regimes = tuple(one.model_copy(update={"correlation": -0.62}) for one in where.regimes)
    gap = record.gap.model_copy(update={"where": where.model_copy(update={"regimes": regimes})})
    text = diagnosis_page(record.model_copy(update={"gap": gap}))
    assert "(rank correlation −0.62)" in text


def test_a_regime_that_carries_hardly_more_than_its_part_is_told_so(
    record: DiagnosisRecord,
) -> None:
    where = record.gap.where
    assert "hardly more" not in gap_lead(record)
    even = where.regimes[0].model_copy(update={"share": 0.44, "share_of_time": 0.4})
    where = where.model_copy(update={"regimes": (even,)})
    gap = record.gap.model_copy(update={"where": where})
    assert gap_lead(record.model_copy(update={"gap": gap})).endswith(
        "in 40 % of the time: hardly more than elsewhere."
    )


@pytest.mark.usefixtures("undrawn")
def test_where_only_one_channel_is_off_the_page_says_how_far_that_one_is_closed(
    record: DiagnosisRecord,
) -> None:
    overall = {"before": 1.05, "after": 0.31, "gap_closed": None, "ci95": None}
    shrink = record.shrink.model_copy(update=overall)
    text = diagnosis_page(record.model_copy(update={"shrink": shrink}))
    # as it is written, by the ratios of the made-up record
    assert "brings the gap of depth z from 31.00 to 1.20 times what a sound vehicle leaves" in text
    assert "Over all channels it goes from 1.05 to 0.31" in text
    none_closed = {
        name: one.model_copy(update={"gap_closed": None}) for name, one in shrink.channels.items()
    }
    shrink = shrink.model_copy(update={"channels": none_closed})
    text = diagnosis_page(record.model_copy(update={"shrink": shrink}))
    assert "There is next to nothing to close: the vehicle file" in text
    assert "leaves 1.05 times" in text


@pytest.mark.usefixtures("undrawn")
def test_what_no_file_states_may_close_a_part_of_the_gap_of_no_effect(
    record: DiagnosisRecord,
) -> None:
    unknown = with_verdict(record, "unknown")
    text = diagnosis_page(unknown)
    assert "none is added to the model. What no vehicle file states of a thruster" in text
    assert "that takes the gap from 9.40 to 1.50 times what a sound vehicle leaves" in text
    same = record.shrink.model_copy(update={"after": record.shrink.before, "gap_closed": 0.0})
    text = diagnosis_page(unknown.model_copy(update={"shrink": same}))
    assert "nothing is added to the model and nothing is closed: it leaves 9.40 times" in text


def test_a_pair_that_shares_an_effect_with_the_verdict_is_beside_it() -> None:
    verdict = Verdict(
        effects=("added_mass", "payload"),
        probability=0.9,
        ambiguous_with=("residual_buoyancy",),
        detail=Detail(),
        sentence="So.",
    )
    assert beside(verdict, "added_mass+residual_buoyancy")
    assert beside(verdict, "residual_buoyancy")
    for other in ("added_mass+payload", "added_mass", "lift+residual_buoyancy", "lift"):
        assert not beside(verdict, other)


@pytest.mark.usefixtures("undrawn")
def test_nothing_is_read_out_of_an_outside_force_that_is_ordinary(record: DiagnosisRecord) -> None:
    assert "mostly heave, about alike all the time. It goes with speed" in diagnosis_page(record)
    axes = dict.fromkeys(record.leftover.axes, 0.3) | {"yaw": 0.32}
    left = record.leftover.model_copy(update={"axes": axes, "worst_axis": "yaw"})
    page = diagnosis_page(record.model_copy(update={"leftover": left}))
    assert "What the answer leaves is ordinary: on no axis more than on a sound vehicle." in page
    assert "mostly yaw" not in page
    assert "It goes with" not in page
