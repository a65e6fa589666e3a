"""Reference pages that follow from the program: nothing in them is written by hand.

python -m evaluation.reference                 the names
python -m evaluation.reference drive           the keys of one file, as Markdown
python -m evaluation.reference columns         names of columns and units that bench files may have
python -m evaluation.reference topics          by which names the channels of a log are found
python -m evaluation.reference rooms           what is in each room of the package
python -m evaluation.reference commands        the options of every command
python -m evaluation.reference --to DIR        a page for each name
python -m evaluation.reference effects > docs/effects.md
"""

import argparse
import ast
import inspect
import re
import textwrap
import tomllib
from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin

import click
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from pipeline.cli import cli
from pipeline.effects.effect import Effect, Parameter
from pipeline.effects.library import VERDICTS, effects
from pipeline.records.comparison import Comparison
from pipeline.records.diagnosis import BenchDiagnosisRecord, DiagnosisRecord
from pipeline.records.gains import ThrusterGains
from pipeline.records.identification import Identification
from pipeline.records.pool_day import PoolDay
from pipeline.records.pool_run import RunNotes
from pipeline.records.reference import ReferenceRecord
from pipeline.records.trial import DayTables, RunTrial, StoredRun, TrialDay
from pipeline.stages.vehicle_page import MODELS
from pipeline.vehicle.schema import Vehicle

#: Name of a file or of a stage -> the model that it is checked against.
SCHEMAS: dict[str, type[BaseModel]] = {
    "vehicle": Vehicle,
    "notes": RunNotes,
    **MODELS,
    "pool_run": StoredRun,
    "run_trial": RunTrial,
    "trial_day": TrialDay,
    "day_tables": DayTables,
    "gains": ThrusterGains,
    "identification": Identification,
    "reference": ReferenceRecord,
    "diagnosis": DiagnosisRecord,
    "bench_diagnosis": BenchDiagnosisRecord,
    "comparison": Comparison,
    "plan": PoolDay,
}

_INGEST = Path(__file__).parents[1] / "pipeline/ingest"

_NAMES: dict[object, str] = {
    float: "number",
    int: "whole number",
    str: "text",
    bool: "true | false",
    NoneType: "null",
}

_EFFECTS = """\
# Effects: the causes that rig2sea knows

<!-- Written by `python -m evaluation.reference effects > docs/effects.md`. -->

An effect is one physical cause of a difference between the nominal model (the vehicle file) and the
vehicle, constant over a run. At the neutral values of its parameters the simulation is the nominal
one, bit for bit. What happens in the water, the formula, what it is easily taken for and its source
stand at the head of its file. To add one: [add_an_effect.md](add_an_effect.md).

On the command line it is `ID:key=value[,key=value][@thruster]`; a parameter that is not named stays
neutral:

    rig2sea simulate mmt300 --manoeuvre zig_zag --effect current:north_mps=0.2 \\
        --effect thruster_degraded:thrust_fraction=0.6@upper --to run.mcap

Ranges are the plausible ones of a vehicle of 100 kg; masses, forces, areas and places grow with the
vehicle. `rig2sea effects VEHICLE` says which effects a vehicle can have, with its ranges; `--json`
also has the possible values, beyond which they are refused. *Shows in* are the channels in which
the effect acts first: velocities u v w, rates p q r, attitude phi theta psi, depth z, position x y.

"""


def effects_page() -> str:
    """Return `docs/effects.md`."""
    rows = ["| effect | what it is | parameters | shows in |", "|---|---|---|---|"]
    for effect in effects().values():
        ranges: dict[str, list[str]] = {}
        for one in effect.parameters:
            ranges.setdefault(_range(one), []).append(f"`{one.name}`")
        parameters = ", ".join(f"{' '.join(names)} {span}" for span, names in ranges.items())
        link = f"[`{effect.id}`](../pipeline/effects/{effect.id}.py)"
        rows.append(f"| {link} | {_subject(effect)} | {parameters} | {' '.join(effect.channels)} |")
    answers = [f"- `{name}`: {meaning}." for name, meaning in VERDICTS.items()]
    return (
        _EFFECTS + "\n".join(rows) + "\n\nA diagnosis can also answer\n\n" + "\n".join(answers)
    ) + "\n"


def _subject(effect: Effect) -> str:
    return effect.title + (" (of one thruster)" if effect.scope == "thruster" else "")


def _range(one: Parameter) -> str:
    low, high = one.plausible
    return f"{low:g} to {high:g}" + ("" if one.unit == "1" else f" {one.unit}")


def schema_page(name: str) -> str:
    """Return the keys of a file, model by model, with what the schema says of each.

    Parameters
    ----------
    name : str
        One of `SCHEMAS`.
    """
    return "\n".join([f"# {name}", "", *_models(SCHEMAS[name], set())]) + "\n"


def _models(model: type[BaseModel], told: set[type[BaseModel]]) -> Iterator[str]:
    if model in told:
        return
    told.add(model)
    meanings = _meanings(model)
    yield f"## {model.__name__}"
    yield from ("", inspect.cleandoc(model.__doc__ or ""), "")
    for key, field in model.model_fields.items():
        about = [_kind(field.annotation), *map(_limit, field.metadata), _default(field)]
        meaning = f": {meanings[key]}" if key in meanings else ""
        yield f"- `{key}` ({', '.join(filter(None, about))}){meaning}"
    yield ""
    for field in model.model_fields.values():
        for part in _models_in(field.annotation):
            yield from _models(part, told)


def _kind(annotation: object) -> str:
    """Return a type in words: what a file may hold there."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if not parts:
        return _NAMES.get(annotation, getattr(annotation, "__name__", str(annotation)))
    if origin is Literal:
        return " | ".join(map(repr, parts))
    if origin is Annotated:
        return ", ".join(filter(None, (_kind(parts[0]), *map(_limit, parts[1:]))))
    kinds = [_kind(part) for part in parts if part is not ...]
    if origin is dict:
        return " -> ".join(kinds)
    if origin is tuple:
        alike = f"{len(kinds)} x {kinds[0]}" if len({*kinds}) == 1 else f"[{', '.join(kinds)}]"
        return f"list of {kinds[0]}" if ... in parts else alike
    return " | ".join(kinds)


def _limit(one: object) -> str:
    """Return a bound as the schema states it, such as ``gt=0``; what is no bound is left out."""
    bounds = one.metadata if isinstance(one, FieldInfo) else (one,)
    found = (re.fullmatch(r"(?:Gt|Ge|Lt|Le|MaxLen|MinLen)\((.+)\)", repr(each)) for each in bounds)
    return ", ".join(each[1] for each in found if each)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "needed"
    plain = isinstance(field.default, bool | int | float | str | tuple)
    return f"default {field.default!r}" if plain and field.default not in ("", ()) else "optional"


def _models_in(annotation: object) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models_in(part)


def _meanings(model: type[BaseModel]) -> dict[str, str]:
    """Return the text below each key in the source, inherited keys included."""
    found: dict[str, str] = {}
    for one in reversed(model.__mro__):
        if not issubclass(one, BaseModel) or one is BaseModel:
            continue
        (tree,) = ast.parse(textwrap.dedent(inspect.getsource(one))).body
        body = getattr(tree, "body", [])
        for line, below in pairwise(body):
            if not (isinstance(line, ast.AnnAssign) and isinstance(line.target, ast.Name)):
                continue
            if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant):
                found[line.target.id] = " ".join(str(below.value.value).split())
    return found


def columns_page() -> str:
    """Return what columns of bench files may be called, and every spelling of a unit."""
    lines = ["# columns", "", "A `*` ends a stem. `@pulses` stands for the names of a pulse width."]
    for kind, quantities in _words("bench_words").items():
        if kind in {"groups", "directions", "other", "patterns", "alone"}:
            continue
        lines += ["", f"## {kind}", ""]
        for quantity, words in quantities.items():
            about = [words.get("unit", "no unit")]
            about += [f"{words['default_unit']} assumed"] if "default_unit" in words else []
            names = ", ".join([*words["names"], *(f"`{one}`" for one in words.get("symbols", []))])
            unsure = ", ".join(words.get("with_unit", []))
            unsure = f"; beside a unit: {unsure}" if unsure else ""
            lines.append(f"- `{quantity}` ({', '.join(about)}): {names}{unsure}")
    lines += ["", "## units", ""]
    for kind, units in _words("units").items():
        lines.append(f"- {kind}: {'; '.join(', '.join(texts) for texts in units.values())}")
    return "\n".join(lines) + "\n"


def topics_page() -> str:
    """Return by which fields and names the channels of a log are found, the likeliest first."""
    tables = _words("topics")
    patterns = {f"@{name}": text for name, text in tables["patterns"].items()}
    lines = ["# topics", "", "| quantity | field | name of the topic has | and has not |"]
    lines.append("|---|---|---|---|")
    for rule in sorted(tables["rules"]["by_rank"], key=lambda rule: -rule["rank"]):
        names = (rule.get("topic", ""), rule.get("but_not", ""))
        has, has_not = (patterns.get(name, name).replace("|", r"\|") for name in names)
        lines.append(f"| `{rule['quantity']}` | `{rule['field']}` | {has} | {has_not} |")
    lines += ["", f"Never: {patterns['@not_measured']}", "", "## columns of tables in time", ""]
    for quantity, names in tables["columns"].items():
        lines.append(f"- `{quantity}`: {'; '.join(' '.join(one) for one in names)}")
    return "\n".join(lines) + "\n"


def _words(name: str) -> dict[str, dict[str, Any]]:
    return tomllib.loads((_INGEST / f"{name}.toml").read_text(encoding="utf-8"))


def rooms_page() -> str:
    """Return what is in each room of the package: the first line of its docstring."""
    root = _INGEST.parent
    lines = ["# rooms", ""]
    for file in sorted([*root.glob("*/**/__init__.py"), *root.glob("[!_]*.py")]):
        room = file.parent if file.name == "__init__.py" else file.with_suffix("")
        about = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
        lines.append(f"- `{room.relative_to(root).as_posix()}`: {about.splitlines()[0]}")
    return "\n".join(lines) + "\n"


def commands_page() -> str:
    """Return the help of every command."""
    return "# commands\n" + "".join(_help(cli, "rig2sea"))


def _help(command: click.Command, name: str) -> Iterator[str]:
    context = click.Context(command, info_name=name, max_content_width=100)
    yield f"\n## {name}\n```\n{command.get_help(context)}\n```\n"
    for below, part in getattr(command, "commands", {}).items():
        if not part.hidden:
            yield from _help(part, f"{name} {below}")


PAGES: dict[str, Callable[[], str]] = {
    "effects": effects_page,
    "columns": columns_page,
    "topics": topics_page,
    "rooms": rooms_page,
    "commands": commands_page,
    **{name: partial(schema_page, name) for name in SCHEMAS},
}


def main() -> None:
    """Print a page, or write all of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("name", nargs="?", choices=PAGES)
    parser.add_argument("--to", type=Path, help="a folder for all pages")
    asked = parser.parse_args()
    if asked.to:
        asked.to.mkdir(parents=True, exist_ok=True)
        for name, page in PAGES.items():
            (asked.to / f"{name}.md").write_text(page(), encoding="utf-8")
    print("\n".join(PAGES) if asked.name is None else PAGES[asked.name](), end="")
    if asked.name is None:
        print()


if __name__ == "__main__":
    main()
