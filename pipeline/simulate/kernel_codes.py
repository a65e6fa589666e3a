"""What reaches the drives of many commands at once."""

from typing import Any

from pipeline.simulate.compiled import compiled
from pipeline.simulate.kernel_thrusters import effective_codes

Array = Any


@compiled
def codes_that_act(p: Array, commands: Array, codes: Array) -> None:
    """Fill codes (k, 12) with the effective codes of commands (k, 12) at parameters `p`."""
    for k in range(commands.shape[0]):
        effective_codes(p, commands[k], codes[k])
