"""One load-test table: readings with branches and marks, and what is odd about them."""

from collections.abc import Sequence

from pipeline.errors import Problem
from pipeline.ingest.blocks import Block
from pipeline.ingest.commands import codes_in_range, command_in_codes, pwm_problems
from pipeline.ingest.load_test_checks import check_magnitudes, check_powers, drop_dead_channels
from pipeline.ingest.load_test_codes import TableCode
from pipeline.ingest.load_test_rows import RowWords, mark_early, with_words
from pipeline.ingest.load_test_signs import check_signs, two_curves, with_signs_of_codes
from pipeline.ingest.load_test_sweeps import mark_drift, with_branches
from pipeline.ingest.load_test_words import ANY_POWER
from pipeline.ingest.readings import Reading
from pipeline.ingest.row_directions import signed_codes
from pipeline.ingest.rows import counted, listed
from pipeline.ingest.settled_steps import settle_loads
from pipeline.ingest.vocabulary import name_score, split_header, unit_fits
from pipeline.vehicle.schema import Vehicle


def read_table(
    block: Block,
    readings: Sequence[Reading],
    code: TableCode,
    words: RowWords,
    vehicle: Vehicle,
) -> tuple[list[Reading], list[Problem]]:
    """Tell code, direction, branch and steadiness of a table's readings, and check them.

    Parameters
    ----------
    block : Block
        Where it stands and what its columns are.
    readings : sequence of Reading
        Its rows as they stand.
    code : TableCode
        Its control code, where no column holds it.
    words : RowWords
        What headings and words say of the rows.
    vehicle : Vehicle
        Range of codes, propeller and water, what it states about load tests.

    Returns
    -------
    tuple of (list of Reading, list of Problem)
        Readings in the order of the rows, marked where they are not to be fitted; none of a table
        that is left out.
    """
    mapping, drive = vehicle.columns.load_test, vehicle.drive
    problems = [*words.problems, *pwm_problems(block, readings, vehicle, "shaft_speed")]
    if is_refused(problems):
        return [], problems
    done = command_in_codes(block, readings, vehicle, "load_test", problems)
    done = with_words(done, words, code.value, drive.code_max)
    if mapping.warm_up_s is not None:
        done = mark_early(done, mapping.warm_up_s)
    steps = settle_loads(block.place(), done)
    problems += steps.problems
    codes = {one.row: one.values["code"] for one in steps.readings if "code" in one.values}
    signed, wrong = signed_codes(block, codes, mapping.direction, "load_test")
    problems += wrong
    if signed is None or is_refused(steps.problems):
        return [], problems
    done = [
        one.with_values(code=signed[one.row]) if one.row in signed else one
        for one in steps.readings
    ]
    for check in (with_signs_of_codes, drop_dead_channels, _sweeps, check_signs):
        done, wrong = check(block, done)
        problems += wrong
    done = codes_in_range(block, done, drive, problems)
    curves = two_curves(block, done)
    if curves is not None:
        return [], [*problems, curves]
    problems += check_powers(block, done)
    problems += check_magnitudes(
        block, done, vehicle.water.density_kgpm3, vehicle.propeller.diameter_m
    )
    return done, [
        *problems,
        *_no_clock(block, readings, mapping.warm_up_s),
        *_powers_not_read(block),
    ]


def _no_clock(block: Block, readings: Sequence[Reading], warm_up_s: float | None) -> list[Problem]:
    if warm_up_s is None or any("time" in one.values for one in readings):
        return []
    what = f"vehicle.yaml states warm_up_s: {warm_up_s:g}, but there is no time to count it by."
    remedy = "Add one, or mark the rows with a word (warm-up) in a column named status."
    return [Problem("warning", block.place(block.header_row), what, "a time column.", remedy)]


def is_refused(problems: Sequence[Problem]) -> bool:
    """Tell whether one of the problems of a table leaves it out."""
    return any(problem.severity == "error" for problem in problems)


def _sweeps(block: Block, readings: Sequence[Reading]) -> tuple[list[Reading], list[Problem]]:
    """Tell branches and warm-up, code by code, in the order of the rows."""
    by_code: dict[float | None, list[int]] = {}
    for index, reading in enumerate(readings):
        if not reading.marks:
            by_code.setdefault(reading.values.get("code"), []).append(index)
    done = list(readings)
    problems: list[Problem] = []
    for code, indices in by_code.items():
        sweep, drifting = mark_drift([readings[index] for index in indices])
        if drifting:
            rows = [reading.row for reading in sweep[:drifting]]
            problems.append(
                Problem(
                    "note",
                    block.place(rows[0]),
                    f"{listed(rows)}{_at(code)}: no load and a speed that still drifts; taken for "
                    "warm-up and not fitted.",
                    "",
                    "To say it yourself, add a time column and warm_up_s in vehicle.yaml, or a "
                    'column "status".',
                )
            )
        settled = with_branches(sweep[drifting:])
        for index, reading in zip(indices, [*sweep[:drifting], *settled], strict=True):
            done[index] = reading
    return done, problems


def _at(code: float | None) -> str:
    return "" if code is None else f", code {code:g}"


def _powers_not_read(block: Block) -> list[Problem]:
    return [
        Problem(
            "note",
            block.place(block.header_row),
            f'"{header}" says neither input nor output power; it was not read.',
            "input (electric) or output (shaft) power in the name.",
            "Rename it, or state it in vehicle.yaml under columns: load_test: input_power or "
            "output_power.",
        )
        for header in block.other_headers
        if _is_power(header)
    ]


def _is_power(header: str) -> bool:
    return any(
        name_score(text, ANY_POWER) > 0 and (text.unit is None or unit_fits(text.unit, ANY_POWER))
        for text in split_header(header)
    )


def summary(readings: Sequence[Reading], code: TableCode) -> str:
    """Return one line about a table, for a person."""
    codes = sorted({one.values["code"] for one in readings if "code" in one.values})
    if not codes:
        what = "no control code"
    elif len(codes) == 1:
        what = f"code {codes[0]:g} ({code.found_in})"
    else:
        what = f"{len(codes)} codes from {codes[0]:g} to {codes[-1]:g} ({code.found_in})"
    speeds = [one.values["shaft_speed"] for one in readings]
    torques = [one.values["torque"] for one in readings]
    return (
        f"{what}, {counted(len(readings), 'point')}, {min(speeds):.0f} to {max(speeds):.0f} rpm, "
        f"{min(torques):.3g} to {max(torques):.3g} N m"
    )
