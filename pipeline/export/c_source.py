"""Render the header and the source of the firmware."""

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.control.inverse import thrust_grid
from pipeline.export import c_text
from pipeline.export.c_text import SingleTables, single_tables
from pipeline.export.fixed_point import Q16_ONE, FixedTables, fixed_tables
from pipeline.export.grid_check import FLAGS
from pipeline.physics.thrust_grid import thrust_limits
from pipeline.records.fits import (
    FirmwareBranch,
    FirmwareCharacteristic,
    InverseCharacteristic,
)
from pipeline.types import FloatArray
from pipeline.vehicle.bench_schema import is_at_supply

if TYPE_CHECKING:
    import jinja2

#: Supply voltage [V] and the tables at it, rising; none, or two and more.
VoltageTables = tuple[tuple[float, FirmwareCharacteristic], ...]


@dataclass(frozen=True)
class Identity:
    """What the generated files say about where they come from."""

    vehicle: str
    tables_digest: str
    tool_version: str

    @property
    def identifier(self) -> str:
        """The vehicle's name as a C identifier."""
        return c_text.c_identifier(self.vehicle)

    @property
    def stem(self) -> str:
        """File name without suffix."""
        return f"{self.vehicle}_thruster"

    @property
    def macro(self) -> str:
        """Prefix of the macros."""
        return f"{self.identifier.upper()}_THRUSTER"


def render_header(
    identity: Identity,
    characteristic: FirmwareCharacteristic,
    failed_checks: Sequence[str] = (),
    voltages: VoltageTables = (),
) -> str:
    """Return the text of ``<vehicle>_thruster.h``; `failed_checks` of the tables are told in it."""
    positive, negative = characteristic.positive, characteristic.negative
    _, reverse = thrust_limits(
        -np.asarray(negative.speed_mps),
        positive=thrust_grid(positive),
        negative=thrust_grid(negative),
        code_min=characteristic.code_min,
    )
    nominal = next((volts for volts, one in voltages if one == characteristic), 0.0)
    return render(
        "thruster.h.j2",
        identity,
        code_min=characteristic.code_min,
        code_max=characteristic.code_max,
        dead_n=characteristic.thrust_dead_n,
        thrust_min=float(reverse.min()),
        thrust_max=max(positive.thrust_max_n),
        # + 0.0: a minus before zero is a sign of nothing
        speed_min=-negative.speed_mps[-1] + 0.0,
        speed_max=positive.speed_mps[-1],
        reverses=characteristic.code_min < 0,
        at_rest_only=characteristic.at_rest_only,
        tested=characteristic.fastest_tested_mps,
        voltage=characteristic.supply_voltage_v,
        sources=_comment_lines(["from " + ", ".join(characteristic.sources)])
        if characteristic.sources
        else [],
        basis=[_BASIS[positive.basis], _BASIS[negative.basis]],
        reverse_measured=negative.basis == "measured" and characteristic.code_min < 0,
        flags=FLAGS,
        mirrored=_mirrors(characteristic),
        failed_checks=_comment_lines(failed_checks),
        volts=[volts for volts, _ in voltages],
        nominal_f32=c_text.float_literal(nominal),
        nominal_q=round(nominal * Q16_ONE),
    )


_BASIS = {
    "measured": "measured at rest",
    "calculated": "calculated from drive and propeller",
    "mirrored": "mirrored",
    None: "not told",
}


def _comment_lines(texts: Sequence[str]) -> list[str]:
    return [
        line for text in texts for line in textwrap.wrap(c_text.c_comment(text), c_text.WIDTH - 5)
    ]


def _mirrors(characteristic: FirmwareCharacteristic) -> bool:
    """Tell whether the negative branch is the positive one once more: nothing of it was tested."""
    negative = characteristic.negative
    return negative == characteristic.positive.model_copy(
        update={
            "sign": negative.sign,
            "against_motion": negative.against_motion,
            "basis": negative.basis,
        }
    )


def render_source(
    identity: Identity, characteristic: FirmwareCharacteristic, voltages: VoltageTables = ()
) -> str:
    """Return the text of ``<vehicle>_thruster.c``; `voltages` as `voltage_tables` gives them."""
    volts, every = [volts for volts, _ in voltages], [one for _, one in voltages]
    return render(
        "thruster.c.j2",
        identity,
        single=_block(_SINGLE, every or [characteristic]),
        fixed=_block(_FIXED, every or [characteristic]),
        single_tested=c_text.float_literal(characteristic.fastest_tested_mps),
        fixed_tested=c_text.unsigned_literal(fixed_tables(characteristic).tested_q16),
        volts_f32=[c_text.float_literal(one) for one in volts],
        volts_q=[c_text.unsigned_literal(round(one * Q16_ONE)) for one in volts],
    )


def voltage_tables(inverse: InverseCharacteristic) -> VoltageTables:
    """Return the tables of each supply voltage, those of `inverse.firmware` among them, rising.

    Empty where one voltage was moored, or none is told.
    """
    made = inverse.firmware
    if made is None or not inverse.voltages or made.supply_voltage_v is None:
        return ()
    rows = {one.voltage_v: one.firmware for one in inverse.voltages}
    mine = next((v for v in rows if is_at_supply(v, made.supply_voltage_v)), made.supply_voltage_v)
    return tuple(sorted((rows | {mine: made}).items()))


def render(template: str, identity: Identity, **values: object) -> str:
    """Fill in one of the templates beside this module."""
    return (
        _environment()
        .get_template(template)
        .render(
            id=identity.identifier,
            macro=identity.macro,
            stem=identity.stem,
            vehicle=identity.vehicle,
            digest=identity.tables_digest,
            version=identity.tool_version,
            **values,
        )
    )


@cache
def _environment() -> "jinja2.Environment":
    """Return the environment of the templates, which keeps those that were read."""
    import jinja2

    environment = jinja2.Environment(
        autoescape=False,  # noqa: S701  C source, not HTML; texts pass the filters below
        keep_trailing_newline=True,
        loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"),
        lstrip_blocks=True,
        trim_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["comment"] = c_text.c_comment
    environment.filters["literal"] = c_text.c_string
    environment.filters["string_size"] = c_text.c_string_size
    return environment


@dataclass(frozen=True)
class _Variant:
    """How one of the two C variants writes its tables.

    `members`: a table's member of the C struct, where its numbers are found in a branch, and its
    comment; `dead` where the dead zone is.
    """

    tables: Callable[[FirmwareCharacteristic], SingleTables | FixedTables]
    ctype: str
    literal: Callable[[Any], str]
    suffix: str
    members: tuple[tuple[str, str, str], ...]
    dead: str


_SINGLE = _Variant(
    single_tables,
    "float",
    c_text.float_literal,
    "_f32",
    (
        ("speed", "speed_mps", "Speed along the thrust. [m/s]"),
        ("thrust_max", "thrust_max_n", "T_max. [N]"),
        ("fraction", "fraction", "Thrust / T_max. [-]"),
        ("code", "code", "Magnitude of the code. [-]"),
        ("drag", "drag_n", "Drag at code 0. [N]"),
    ),
    "thrust_dead_n",
)
_Q16, _Q30 = "UQ16.16, 65536 is 1", "UQ2.30, 1073741824 is 1"
_FIXED = _Variant(
    fixed_tables,
    "uint32_t",
    c_text.unsigned_literal,
    "",
    (
        ("speed", "speed_q16", f"Speed along the thrust; {_Q16} m/s."),
        ("thrust_max", "thrust_max_q16", f"T_max; {_Q16} N."),
        ("fraction", "fraction_q30", f"Thrust / T_max; {_Q30}."),
        ("code", "code_q16", f"Magnitude of the code; {_Q16}."),
        ("drag", "drag_q16", f"Drag at code 0; {_Q16} N."),
    ),
    "thrust_dead_q16",
)


class _Arrays:
    """Tables of constants; one that repeats an earlier one is not written again."""

    def __init__(self, variant: _Variant) -> None:
        self._variant = variant
        self._names: dict[tuple[str, ...], str] = {}
        self.texts: list[str] = []

    def add(
        self, member: str, name: str, comment: str, values: FloatArray, titles: Sequence[str]
    ) -> str:
        """Return the name under which the numbers of a table are to be found."""
        rows = [
            [self._variant.literal(value) for value in row]
            for row in values.reshape(len(titles), -1).tolist()
        ]
        key = (member, *(literal for row in rows for literal in row))
        if key not in self._names:
            self._names[key] = name
            titled = list(zip(titles, rows, strict=True))
            self.texts.append(c_text.c_array(self._variant.ctype, name, titled, comment=comment))
        return self._names[key]


def _block(variant: _Variant, every: Sequence[FirmwareCharacteristic]) -> dict[str, object]:
    """Return what the template needs for one variant: tables, branches, the dead zone.

    `every` has the tables of each supply voltage; their names are counted where there are several.
    """
    arrays, made = _Arrays(variant), [variant.tables(one) for one in every]
    branches = []
    for name in ("positive", "negative"):
        rendered = []
        for k, (one, tables) in enumerate(zip(every, made, strict=True)):
            source: FirmwareBranch = getattr(one, name)
            speeds = [f"at {speed:g} m/s" for speed in source.speed_mps]
            counted = f"{name}_{k}" if len(every) > 1 else name
            members = {
                member: arrays.add(
                    member,
                    f"{counted}_{what}{variant.suffix}",
                    comment,
                    getattr(getattr(tables, name), what),
                    speeds if member == "code" else [""],
                )
                for member, what, comment in variant.members
            }
            sizes = {"speeds": len(source.speed_mps), "fractions": len(source.fraction)}
            rendered.append({**sizes, **members})
        branches.append({"name": name, "rows": rendered})
    dead = variant.literal(np.asarray(getattr(made[0], variant.dead)).item())
    return {"dead": dead, "arrays": arrays.texts, "branches": branches}
