"""The bundled examples, read and computed once for all tests of this folder."""

from functools import cache
from pathlib import Path

from pipeline.actions.design import DesignRequest, compute_design
from pipeline.bundled.design import design_example
from pipeline.records.design import BalanceDesign, Design, PropellerDesign, TetherDesign


@cache
def example(calculator: str, name: str) -> Design:
    """Compute a bundled example."""
    return compute_design(DesignRequest(calculator, design_example(calculator, name), Path("raw")))  # type: ignore[arg-type]


def pilgrim_balance() -> BalanceDesign:
    found = example("balance", "pilgrim")
    assert isinstance(found, BalanceDesign)
    return found


def propeller(name: str) -> PropellerDesign:
    found = example("propeller", name)
    assert isinstance(found, PropellerDesign)
    return found


def tether(name: str) -> TetherDesign:
    found = example("tether", name)
    assert isinstance(found, TetherDesign)
    return found
