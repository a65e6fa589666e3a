"""Example files of the design calculations, as ``rig2sea design ... --example`` prints them."""

from pathlib import Path

_HERE = Path(__file__).parent
#: The example that is meant when none is named.
USUAL = {
    "balance": "pilgrim",
    "propeller": "pilgrim",
    "tether": "mokeeva",
    "added-mass": "mmt300",
}


def design_examples(calculator: str) -> tuple[str, ...]:
    """Names of a calculator's examples, the usual one first.

    >>> design_examples("propeller")
    ('pilgrim', 'remus')
    """
    suffix = f"_{calculator}.yaml"
    names = sorted(file.name.removesuffix(suffix) for file in _HERE.glob(f"*{suffix}"))
    return tuple(sorted(names, key=lambda name: name != USUAL[calculator]))


def design_example(calculator: str, name: str) -> Path:
    """Return the file of an example, one of `design_examples`.

    >>> design_example("tether", "mokeeva").name
    'mokeeva_tether.yaml'
    """
    if name not in design_examples(calculator):
        raise KeyError(name)
    return _HERE / f"{name}_{calculator}.yaml"
