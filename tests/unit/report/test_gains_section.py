"""The section on the gains of thrusters: a row each, a picture, what was found, and why not."""

from dataclasses import replace

from pipeline.check.pool_runs import gains_text
from pipeline.records.gains import (
    GainFinding,
    GainReference,
    GainRun,
    PooledGain,
    ThrusterGain,
    ThrusterGains,
)
from pipeline.records.trial import PageReceipt, RunTrial
from pipeline.report.blocks import Figure, Table, Text
from pipeline.report.results import VehicleResults
from pipeline.report.sections.gains import (
    gain_warnings,
    run_gains_section,
    vehicle_gains_section,
)

KNOWN = GainReference(
    name="24 May",
    runs=("a", "b"),
    mean=0.9,
    ci95=(0.8, 1.0),
    between_runs=0.05,
    ratio=0.62,
    ratio_ci95=(0.52, 0.71),
)


def gain(thruster: str, axis: str, value: float, *, judged: bool = True) -> ThrusterGain:
    return ThrusterGain(
        run="zig-zag",
        thruster=thruster,
        axis=axis,
        moves=True,
        value=value,
        ci95=(value - 0.1, value + 0.1),
        judged=judged,
        reference=KNOWN if axis == "all" and thruster == "left" else None,
    )


GAINS = ThrusterGains(
    vehicle="auv",
    false_alarms=0.01,
    reference="24 May",
    runs=(GainRun(run="zig-zag", delay_s=0.2, thrust_std_n={"left": 5.0, "right": 4.0}),),
    gains=(
        gain("left", "all", 0.56),
        gain("left", "yaw", 0.55),
        gain("right", "all", 1.0),
        gain("right", "yaw", 1.02, judged=False),
    ),
    pooled=(
        PooledGain(
            thruster="left",
            axis="all",
            moves=True,
            value=0.56,
            ci95=(0.46, 0.66),
            between_runs=0.0,
            runs=("zig-zag",),
        ),
    ),
    findings=(
        GainFinding(
            kind="weak",
            thrusters=("left",),
            runs=("zig-zag",),
            value=0.56,
            ci95=(0.46, 0.66),
            p_value=0.001,
            text="left gives less than expected.",
        ),
    ),
    not_judged={"bow": "not commanded in any of these runs"},
)


def trial(gains: ThrusterGains | None, why: str = "") -> RunTrial:
    return RunTrial(
        vehicle="auv",
        run="zig-zag",
        day="2024-05-15",
        start_time_ns=0,
        duration_s=60.0,
        gains=gains,
        why_no_gains=why,
    )


def test_the_page_of_a_run_has_table_picture_finding_and_reference() -> None:
    """Numbers as intervals, a dash where nothing is judged, the ratio to the reference."""
    blocks = run_gains_section(trial(GAINS)).blocks
    assert any(isinstance(one, Figure) for one in blocks)
    texts = [one.text for one in blocks if isinstance(one, Text)]
    assert texts[0] == "left gives less than expected."
    assert any("0.20 s later" in text for text in texts)
    assert any("bow" in text for text in texts)
    table = next(one for one in blocks if isinstance(one, Table))
    assert table.header[:3] == ("Thruster", "all", "yaw")
    assert table.rows[0] == (
        "left",
        "0.56 (0.46 to 0.66)",
        "0.55 (0.45 to 0.65)",
        "0.62 (0.52 to 0.71)",
    )
    assert table.rows[1][2:] == ("–", "–")


def test_thrusters_stand_in_the_order_of_the_vehicle_file() -> None:
    """A stored record sorts its keys, so that the order is that of the rows."""
    turned = GAINS.model_copy(update={"gains": (*GAINS.gains[2:], *GAINS.gains[:2])})
    blocks = run_gains_section(trial(turned)).blocks
    table = next(one for one in blocks if isinstance(one, Table))
    assert [row[0] for row in table.rows] == ["right", "left"]


def test_a_run_without_gains_says_why() -> None:
    """The reason stands in the section, which is not linked as available."""
    section = run_gains_section(trial(None, "the vehicle has no model."))
    assert not section.available
    assert section.reason == "the vehicle has no model."
    assert not run_gains_section(None).available


def test_a_day_begins_with_what_was_found() -> None:
    assert gain_warnings(GAINS) == ["left gives less than expected."]
    assert gain_warnings(None) == []


def test_the_lines_for_a_terminal() -> None:
    """A table by run and thruster, the reference at the end of a row, then what was found."""
    lines = gains_text(GAINS)
    left = next(line for line in lines if line.strip().startswith("left "))
    assert "0.56 [0.46, 0.66]" in left
    assert left.endswith("0.62 [0.52, 0.71] of what it gave in 24 May")
    right = next(line for line in lines if line.strip().startswith("right "))
    assert right.rstrip().endswith("?")
    assert lines[-1] == "  found: left gives less than expected."


def test_a_day_that_tells_no_thruster_as_a_whole_costs_the_vehicle_no_page(
    results: VehicleResults,
) -> None:
    """A short hover tells axes without a lever alone: there is no bar to draw."""
    name = results.vehicle.thrusters[0].name

    def day(date: str, axis: str) -> PageReceipt:
        told = PooledGain(
            thruster=name, axis=axis, moves=axis == "all", value=0.8, ci95=(0.7, 0.9),
            between_runs=0.0, runs=("a",),
        )  # fmt: skip
        return PageReceipt(
            kind="day", name=date, files={}, title="", errors=0, warnings=0, line="", gains=(told,)
        )

    short, whole = day("2026-05-05", "yaw"), day("2026-05-04", "all")
    assert not vehicle_gains_section(replace(results, trials=(short,))).available
    blocks = vehicle_gains_section(replace(results, trials=(whole, short))).blocks
    table = next(one for one in blocks if isinstance(one, Table))
    assert table.header == ("Thruster", "2026-05-04")
    assert table.rows[0] == (name, "0.80 (0.70 to 0.90)")
