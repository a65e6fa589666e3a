"""Many short simulations in one call: stretches of runs, each from a start of its own."""

from typing import Any

from pipeline.simulate.compiled import compiled
from pipeline.simulate.kernel import fixed_parts, lag_codes, run_on, work_space
from pipeline.simulate.kernel_lag import set_step

Array = Any


@compiled
def simulate_pieces(
    p: Array,
    starts: Array,
    late: Array,
    external: Array,
    bounds: Array,
    steps_s: Array,
    method: int,
    strips: Array,
    thrust_tables: Array,
    screws: Array,
    torque_tables: Array,
    steps: Array,
    states: Array,
    accelerations: Array,
    thrusts: Array,
) -> None:
    """Simulate stretch k over the codes and external forces [bounds[k], bounds[k + 1]).

    `starts` (k, STATE), `late` (m, 3, 12) of `lag_pieces`, `external` (m, 6) or (1, 6), `steps_s`
    (k,). Of `states` (m + k, STATE) and the others a stretch fills one row more than it has steps,
    so its first row is bounds[k] + k.
    """
    count = starts.shape[0]
    if count == 0:
        return
    fixed = fixed_parts(p, strips, thrust_tables, screws, torque_tables, steps)
    work = work_space(p, starts[0], steps_s[0])
    alike = external.shape[0] == 1
    for k in range(count):
        first, end = bounds[k], bounds[k + 1]
        run_on(
            p,
            starts[k],
            late[first:end],
            external if alike else external[first:end],
            steps_s[k],
            method,
            fixed,
            work,
            states[first + k : end + k + 1],
            accelerations[first + k : end + k + 1],
            thrusts[first + k : end + k + 1],
        )


@compiled
def lag_pieces(
    p: Array, starts: Array, commands: Array, bounds: Array, steps_s: Array, late: Array
) -> None:
    """Fill late (m, 3, 12), the codes of all stretches over the steps of commands (m, 12)."""
    if starts.shape[0] == 0:
        return
    work = work_space(p, starts[0], steps_s[0])
    for k in range(starts.shape[0]):
        first, end = bounds[k], bounds[k + 1]
        set_step(p, steps_s[k], work.lags)
        lag_codes(p, starts[k], commands[first:end], work, late[first:end])
