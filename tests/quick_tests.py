"""Which tests are quick: those whose modules import nothing that simulates or diagnoses.

Of these a few kinds take as long all the same: they run the workflow, draw whole pages, or compute
characteristics over their whole grid. A test that imports what does that is not quick either.

Told from the imports, so that a new test is on the right side by itself. Only imports at the top of
a module count: a command line that imports the kernel when it is asked to simulate is quick until
then.
"""

import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

#: Folders of tests that run the program, or work on measured data.
WHOLE_PROGRAM = ("acceptance", "faults", "fuzz", "integration")
#: What makes a test slow, however it comes to be imported.
SLOW_MODULES = ("pipeline.simulate.compiled", "pipeline.blind", "pipeline.diagnose", "snakemake")
#: What makes a test long that asks for it itself.
LONG_MODULES = (
    "evaluation.bundled",
    "pipeline.bundled",
    "pipeline.identify.static",
    "evaluation.messages",
    "pipeline.physics.tether_footprint",
    "pipeline.physics.tether_static",
    "pipeline.report.diagnosis_page",
    "pipeline.report.figures",
    "pipeline.report.run_page",
    "pipeline.report.vehicle_page",
    "pipeline.workflow",
)
#: Fixtures whose tests are slow: they build a vehicle, or wait for data outside the repository.
SLOW_FIXTURES = frozenset({"shared_data"})
_IMPORT = re.compile(
    r"^(?:from\s+([\w.]+)\s+import\s+(\([^)]*\)|[^\n]*)|import\s+([\w.]+))", re.MULTILINE
)


@cache
def is_quick(path: Path, root: Path) -> bool:
    """Tell whether the tests of a file are quick.

    Parameters
    ----------
    path : Path
        A test module under ``tests/``, or a module of the package with examples in it.
    root : Path
        The source tree.
    """
    if path.suffix != ".py":
        return False
    tests = root / "tests"
    if path.is_relative_to(tests) and path.relative_to(tests).parts[0] in WHOLE_PROGRAM:
        return False
    if any(_is_of(one, LONG_MODULES) for one in _imports(path) if path.is_relative_to(tests)):
        return False
    beside = [folder / "conftest.py" for folder in path.parents if folder.is_relative_to(tests)]
    return not any(_is_of(one, SLOW_MODULES) for one in _closure([path, *beside], root))


def _is_of(name: str, modules: tuple[str, ...]) -> bool:
    return any(name == one or name.startswith(f"{one}.") for one in modules)


def _closure(paths: Iterable[Path], root: Path) -> set[str]:
    """Names of all modules that are imported from some files, and from what they import."""
    found: set[str] = set()
    waiting = [path for path in paths if path.is_file()]
    helpers = {path.stem: path for path in _helpers(root)}
    while waiting:
        for name in _imports(waiting.pop()):
            if name in found:
                continue
            found.add(name)
            file = helpers.get(name) or _module_file(name, root)
            if file is not None:
                waiting.append(file)
    return found


@cache
def _imports(path: Path) -> frozenset[str]:
    """Names that a module imports at its top; of ``from a import b`` both a and a.b."""
    names: set[str] = set()
    for base, parts, plain in _IMPORT.findall(path.read_text(encoding="utf-8")):
        names.add(base or plain)
        names.update(f"{base}.{part}" for part in re.findall(r"\w+", parts))
    return frozenset(names)


@cache
def _module_file(name: str, root: Path) -> Path | None:
    if not name.startswith("pipeline"):
        return None
    module = root.joinpath(*name.split("."))
    files = (module.with_suffix(".py"), module / "__init__.py")
    return next((file for file in files if file.is_file()), None)


@cache
def _helpers(root: Path) -> tuple[Path, ...]:
    """Modules of the tests that are no tests: their names are theirs alone."""
    return tuple(path for path in (root / "tests").rglob("*.py") if path.name != "conftest.py")
