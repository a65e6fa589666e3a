"""Which modules this package holds; reads no code, so that a workflow can ask for a digest of all.

The library finds its effects by looking, not by a list: a digest that follows written imports
alone would miss them. Pass `module_names()` to it as well.
"""

import pkgutil

import pipeline.effects


def module_names() -> tuple[str, ...]:
    """Return the dotted names of the package's modules, sorted.

    >>> "pipeline.effects.current" in module_names()
    True
    """
    package = pipeline.effects
    return tuple(
        sorted(f"{package.__name__}.{m.name}" for m in pkgutil.iter_modules(package.__path__))
    )
