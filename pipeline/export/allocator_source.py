"""Render header and source of the allocator."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.control.bounded_allocation import (
    MOST_STEPS,
    SMALLEST_STEP,
    Arithmetic,
    Floats,
    largest_demand,
)
from pipeline.export import c_text
from pipeline.export.allocator_layout import AllocatorLayout, PaperConstants
from pipeline.export.c_source import Identity, render
from pipeline.export.fixed_point import LARGEST_PAPER, Q16_ONE, FixedArithmetic
from pipeline.types import FloatArray
from pipeline.vehicle.schema import Allocator

#: Functions of the tables: name, variant, result, parameters, what is passed on, the voltage.
_CALLS = tuple(
    (name, variant, result or number, parameters.replace("@", number), passed, supply)
    for variant, number, supply in (("f32", "float", "supply_v"), ("q", "int32_t", "supply_v_q16"))
    for name, result, parameters, passed in (
        ("thrust_max", "", "@ speed", "speed"),
        ("thrust_min", "", "@ speed", "speed"),
        ("code_from_thrust", "int16_t", "@ thrust, @ speed", "thrust, speed"),
        ("thruster_flags", "uint16_t", "@ thrust, @ speed", "thrust, speed"),
    )
)


@dataclass(frozen=True)
class Variant:
    """How one variant writes an operation in C; the template has the algorithm once."""

    name: str
    type: str
    input: str
    zero: str
    one: str
    epsilon: str
    half_epsilon: str
    smallest: str
    shift: int
    """Bits of the product of a matrix entry and the solution."""

    def mul(self, x: str, y: str, bits: int) -> str:
        """Product of a large and a small number; `bits` are those of the smaller one's format."""
        if self.name == "f32":
            return f"({x} * {y})"
        # the entry of a table is the factor below 2^31
        large, small = (y, x) if x.startswith(("scaled", "inverse", "lower")) else (x, y)
        return f"times_q({large}, {small}, {bits})"

    def square(self, x: str, y: str) -> str:
        """Product of two entries of the scaled matrix."""
        return f"({x} * {y})" if self.name == "f32" else f"(({x} * {y}) / 1073741824)"

    def quotient(self, x: str, y: str) -> str:
        """Entry of L."""
        if self.name == "f32":
            return f"{x} / {y}"
        return f"held_q(({x} * 16777216) / {y}, -INT32_MAX, INT32_MAX)"

    def solved(self, x: str, y: str) -> str:
        """Division by a pivot, into the format of the solution."""
        if self.name == "f32":
            return f"{x} / {y}"
        return f"({x} * ((int64_t)1 << {self.shift})) / {y}"

    def share(self, room: str, size: str) -> str:
        """Share of a step up to a limit."""
        if self.name == "f32":
            return f"{room} / {size}"
        return f"({room} * 1073741824) / {size}"

    def released(self, pull: str, release: str) -> str:
        """Step that a thruster let go would make by itself."""
        return f"{pull} * {release}" if self.name == "f32" else f"({pull} * {release}) / 256"


def render_allocator_header(
    identity: Identity, layout: AllocatorLayout, *, at: Sequence[bool] = ()
) -> str:
    """Return the text of ``<vehicle>_allocator.h``; `at`: which types' tables take the voltage."""
    paper, lost = layout.paper, layout.corrections.lost_code.tolist()
    places = zip(layout.names, layout.position_m, layout.direction, strict=True)
    return render(
        "allocator.h.j2",
        identity,
        **_names(identity, layout, at),
        at=any(at),
        paper=paper is not None,
        bow=paper is not None and paper.bow is not None,
        form="" if paper is None else paper.form,
        portions=() if paper is None else PaperConstants.of(paper).portions,
        steps=MOST_STEPS,
        names="{" + ", ".join(c_text.c_string(name) for name in layout.names) + "}",
        lines=[
            f"{i}  {name:<16} at ({_triple(at)}) m, pushes ({_triple(to)}), "
            f"gain {layout.gain[i, 0]:g} ahead, {layout.gain[i, 1]:g} in reverse"
            + (f", dead zone {lost[i]:g} codes" if lost[i] else "")
            + (f", type {layout.types[layout.kind[i] - 1]}" if layout.kind[i] else "")
            for i, (name, at, to) in enumerate(places)
        ],
    )


def _triple(values: FloatArray) -> str:
    return ", ".join(f"{value + 0.0:.4g}" for value in values.tolist())


def _names(identity: Identity, layout: AllocatorLayout, at: Sequence[bool]) -> dict[str, object]:
    at = at or (False,) * (1 + len(layout.types))
    files = [f"{identity.vehicle}-{one}" for one in layout.types]
    ids = [c_text.c_identifier(one) for one in (identity.vehicle, *files)]
    return {
        "file": f"{identity.vehicle}_allocator",
        "guard": f"{identity.identifier.upper()}_ALLOCATOR",
        "thruster": identity.stem,
        "prefix": identity.identifier.upper(),
        "count": layout.count,
        "types": [
            {"file": f"{one}_thruster", "id": name, "at": takes}
            for one, name, takes in zip(files, ids[1:], at[1:], strict=True)
        ],
        "nominal": next((one.upper() for one, takes in zip(ids, at, strict=True) if takes), ""),
        "pulses": [
            {
                "id": name,
                "prefix": name.upper(),
                "neutral_us": pulse.neutral_us,
                "half_us": pulse.half_range_us,
                "neutral_ns": f"(int64_t){round(1000 * pulse.neutral_us)}",
                "half_ns": f"(int64_t){round(1000 * pulse.half_range_us)}",
            }
            for name, pulse in zip(ids, layout.pulses, strict=True)
        ],
    }


def render_allocator_source(
    identity: Identity, layout: AllocatorLayout, *, at: Sequence[bool] = ()
) -> str:
    """Return the text of ``<vehicle>_allocator.c``; `at` as of the header."""
    paper = layout.paper
    lost = bool(layout.lost_q8.any())
    values: dict[str, object] = {"paper": paper is not None, "steps": MOST_STEPS}
    values |= {"lost": lost, "at": any(at), "first_at": any(at[:1])}
    kinds: list[tuple[str, str, Arithmetic]] = [
        ("f32", "float", Arithmetic(np.float32)),
        ("q", "int64_t", FixedArithmetic(layout.shift)),
    ]
    arrays = []
    for name, ctype, do in kinds:
        bits = "" if name == "f32" else ", Q1.30"
        arrays += [
            _matrix(ctype, f"flow_{name if name == 'f32' else 'q30'}",
                    do.small(layout.flow, 30), f"Inflow speed of a velocity{bits}. [-]"),
            _matrix(ctype, f"gain_{name if name == 'f32' else 'q24'}",
                    do.small(layout.gain, 24), "Thrust over that of the tables, ahead, reverse."),
        ]  # fmt: skip
    per_gain = kinds[1][2].small(1.0 / layout.divisor, 24)
    arrays += [
        _matrix("float", "divisor_f32", kinds[0][2].small(layout.divisor, 24),
                "What a thrust is divided by before the tables are asked."),
        _matrix("int64_t", "per_gain_q24", per_gain, "One over it, Q7.24. [-]"),
    ]  # fmt: skip
    if layout.lost_q8.any():
        arrays.append(_row("int64_t", "lost_q8", layout.lost_q8, "Dead zones of their own, Q8."))
    if paper is None:
        numbers = layout.allocation
        for name, ctype, do in kinds:
            most = do.large(largest_demand(numbers, layout.largest_n))
            arrays += [
                _matrix(ctype, f"scaled_{name}", do.small(numbers.scaled, 30),
                        "A: scale times B. [-]"),
                _matrix(ctype, f"inverse_{name}", do.small(numbers.inverse, 24),
                        "Thrusts of a demand. [-], [1/m]"),
                _row(ctype, f"scale_{name}", do.small(numbers.scale, 24),
                     "Newtons of a demand. [-], [1/m]"),
                _row(ctype, f"release_{name}", do.small(numbers.release, 8),
                     "One over the squared columns of A. [-]"),
                _row(ctype, f"most_{name}", most, "Most that a demand counts as. [N], [N m]"),
            ]  # fmt: skip
        values["variants"] = _variants(layout, kinds)
    else:
        arrays.append(_row("int", "stern", np.array(layout.stern), "Upper, lower, left, right."))
        values |= _paper_values(identity, layout, paper)
    if layout.types:
        ends = np.array(layout.code_range)
        arrays += [
            _row("int", "kind", np.array(layout.kind), "Type of each thruster, 0 the first."),
            _row("int64_t", "code_min", ends[:, 0], "Smallest code of each."),
            _row("int64_t", "code_max", ends[:, 1], "Largest code of each."),
        ][: 3 if lost else 1]
    return render(
        "allocator.c.j2",
        identity,
        **_names(identity, layout, at),
        **values,
        arrays=arrays,
        calls=_CALLS,
    )


def _variants(
    layout: AllocatorLayout, kinds: Sequence[tuple[str, str, Arithmetic]]
) -> Sequence[Variant]:
    found = []
    for name, ctype, do in kinds:
        numbers = (do.zero, do.one, do.epsilon, do.half_epsilon,
                   do.large(SMALLEST_STEP * layout.largest_n))  # fmt: skip
        zero, one, epsilon, half, smallest = _literals(ctype, np.array(numbers))
        found.append(
            Variant(
                name=name,
                type=ctype,
                input="float" if name == "f32" else "int32_t",
                zero=zero,
                one=one,
                epsilon=epsilon,
                half_epsilon=half,
                smallest=smallest,
                shift=do.solution_bits,
            )
        )
    return found


def _paper_values(
    identity: Identity, layout: AllocatorLayout, geometry: Allocator
) -> dict[str, object]:
    one, scaled = PaperConstants.of(geometry), geometry.form == "scaled"
    fixed = FixedArithmetic(layout.shift)
    numbers = {
        "stern_arm": one.stern_arm_m,
        "bow_share": one.bow_share_1pm,
        "surge": one.surge,
        "moment": one.moment_1pm,
        "portion_surge": one.portions[0],
        "portion_heading": one.portions[1],
        "portion_pitch": one.portions[2],
    }
    flag = "SATURATED" if scaled else "LIMITED_BY_PORTION"
    return {
        "f": {name: c_text.float_literal(value) for name, value in numbers.items()},
        "q": {name: str(int(fixed.small(value, 24))) for name, value in numbers.items()},
        "bow": layout.bow,
        "scaled": scaled,
        "cut_flag": f"{identity.identifier.upper()}_THRUSTER_{flag}",
        "largest_paper": f"{LARGEST_PAPER:.1f}",
        "largest_paper_q": f"(int64_t){int(LARGEST_PAPER) * Q16_ONE}",
    }


def _matrix(ctype: str, name: str, values: Floats, comment: str) -> str:
    rows = ["{" + ", ".join(_literals(ctype, row)) + "}" for row in values]
    body = ",\n    ".join(rows)
    size = f"[{values.shape[0]}][{values.shape[1]}]"
    return f"/* {comment} */\nstatic const {ctype} {name}{size} = {{\n    {body},\n}};"


def _row(ctype: str, name: str, values: Floats, comment: str) -> str:
    return c_text.c_array(ctype, name, [("", _literals(ctype, values))], comment=comment)


def _literals(ctype: str, values: Floats) -> list[str]:
    if ctype == "float":
        return [c_text.float_literal(value + 0.0) for value in values.tolist()]
    return [str(int(value)) for value in values.tolist()]
