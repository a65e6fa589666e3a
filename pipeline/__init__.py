"""rig2sea: rig data in, thruster tables, firmware and a diagnosed sim-to-real gap out.

A library as well as a command: `load_vehicle`, `read_bench`, `read_run`, `thruster_tables`,
`simulate_manoeuvre`, `identify_runs` and `diagnose_runs` return pandas frames. `pipeline.library`
describes them.
"""

from importlib import import_module

__version__ = "0.2.0"

__all__ = [
    "__version__",
    "diagnose_runs",
    "identify_runs",
    "load_vehicle",
    "read_bench",
    "read_run",
    "simulate_manoeuvre",
    "thruster_tables",
]


def __getattr__(name: str) -> object:
    """Import the library when it is asked for: the command line starts without it.

    By its name: an import would make the whole package part of the digest of every stage's code.
    """
    if name in __all__:
        return getattr(import_module("pipeline.library"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
