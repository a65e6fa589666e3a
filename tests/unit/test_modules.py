"""What must hold of every module, and no linter asks."""

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pipeline

PACKAGE = Path(pipeline.__file__).parent


def given(tree: ast.Module) -> Iterator[str]:
    """Names that a module gives at its top."""
    for one in tree.body:
        if isinstance(one, ast.FunctionDef | ast.ClassDef):
            yield one.name
        targets = one.targets if isinstance(one, ast.Assign) else []
        targets = [one.target] if isinstance(one, ast.AnnAssign) else targets
        for target in targets:
            parts = target.elts if isinstance(target, ast.Tuple) else [target]
            yield from (part.id for part in parts if isinstance(part, ast.Name))


def test_no_name_is_given_to_two_things() -> None:
    """The last one would count everywhere: two constants of modules that were joined."""
    twice = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        names = Counter(given(ast.parse(file.read_text(encoding="utf-8"))))
        found = [name for name, count in names.items() if count > 1]
        if found:
            twice[str(file.relative_to(PACKAGE))] = found
    assert twice == {}
