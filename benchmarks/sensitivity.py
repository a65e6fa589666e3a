"""How a simulated run changes with the model's parameters: a finite-difference Jacobian."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import offset, read, slot
from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Method, Trajectory, run
from pipeline.types import FloatArray

#: Columns of `body_states`.
BODY_CHANNELS = ("x", "y", "z", "qw", "qx", "qy", "qz", "u", "v", "w", "p", "q", "r")
#: Share of its scale by which a parameter is moved: the cube root of the rounding error balances
#: the truncation of a central difference, h^2, against its cancellation, 1 / h.
RELATIVE_STEP = float(np.finfo(float).eps ** (1.0 / 3.0))
#: A size that matters, by unit, for a parameter whose value is small or zero.
_SCALE_BY_UNIT = {
    "1": 0.1,
    "m": 0.05,
    "rad": 0.05,
    "m/s": 0.1,
    "s": 0.1,
    "N": 5.0,
    "code": 3.0,
    "m^2": 0.02,
    "kg": 5.0,
    "kg m^2": 1e-4,
    "kg/m^3": 100.0,
    "N s^2/m^2": 5.0,
    "N s^2/m": 5.0,
    "N s^2/m^2, N m s^2": 5.0,
}
#: Weight and buoyancy nearly cancel: a hundredth of either is much.
_SHARE_THAT_MATTERS = {"weight": 0.01, "buoyancy": 0.01}
#: Counts and indices: a trajectory does not depend on them smoothly.
_DISCRETE = frozenset({"thruster_count", "thruster_type", "wall_count"})
#: Below zero these are another model; at zero a one-sided difference is taken.
_NOT_NEGATIVE = frozenset({"dead_zone"})
#: An entry off the diagonal is moved together with its mirror image.
_SYMMETRIC = {"added_mass": 6, "inertia": 3}
#: Zero switches these off, and a small value differs from zero by less than rounding.
_ABOVE_ZERO = frozenset({"lag", "rotor_inertia"})


def body_states(trajectory: Trajectory) -> FloatArray:
    """Position NED, quaternion and velocity of a run, (m + 1, 13) as `BODY_CHANNELS`."""
    return np.hstack([trajectory.position_ned_m, trajectory.quaternion, trajectory.nu])


def parameter_scale(vector: FloatArray, name: str, index: int) -> float:
    """Size by which to measure a change of a parameter.

    Parameters
    ----------
    vector : ndarray
        Parameter vector.
    name, index : str, int
        Slot, and entry of it counted through all its dimensions.

    Returns
    -------
    float
        The parameter's size, or a size that matters for its unit where that is larger; entries
        of a 6x6 matrix are measured by the geometric mean of their two diagonal entries.
        [unit of the slot]

    Examples
    --------
    >>> from pipeline.physics.parameters import neutral_vector
    >>> parameter_scale(neutral_vector(), "density", 0), parameter_scale(neutral_vector(), "lag", 3)
    (1000.0, 0.1)
    """
    entry = slot(name)
    values = np.abs(read(vector, name)).reshape(-1)
    if entry.shape in {(6, 6), (3, 3)}:
        size = entry.shape[0]
        diagonal = values[:: size + 1]
        row, column = divmod(index, size)
        floor = float(np.sqrt(diagonal[row] * diagonal[column])) or 1.0
    else:
        floor = _SCALE_BY_UNIT.get(entry.unit, 1.0)
    return max(_SHARE_THAT_MATTERS.get(name, 1.0) * float(values[index]), floor)


def jacobian(
    packed: PackedVehicle,
    commands: FloatArray,
    parameters: Sequence[tuple[str, int]],
    *,
    dt_s: float,
    vector: FloatArray | None = None,
    start: FloatArray | None = None,
    external: FloatArray | None = None,
    method: Method = "rk4",
    outputs: Callable[[Trajectory], FloatArray] = body_states,
    threads: int = 2,
) -> FloatArray:
    r"""Differentiate a run's outputs by parameters, with central differences.

    .. math:: J_{tcp} = \frac{y_{tc}(\theta + h_p e_p) - y_{tc}(\theta - h_p e_p)}{2 h_p},
              \qquad h_p = \epsilon^{1/3} s_p

    with the parameter's scale s_p. A parameter that stands at the end of its range (a dead zone of
    zero) is moved to one side: (-3 y_0 + 4 y_1 - y_2) / 2 h. Added mass and inertia stay symmetric:
    entries (i, j) and (j, i) are moved as one.

    Parameters
    ----------
    packed : PackedVehicle
        The vehicle.
    commands : ndarray, shape (m, n)
        Codes of the n thrusters, held for a step each.
    parameters : sequence of (str, int)
        Slot and entry of each parameter, the entry counted through all the slot's dimensions.
    dt_s : float
        Step. [s]
    vector, start, external, method : optional
        As in `run`; `vector` is where the derivatives are taken, the nominal one otherwise.
    outputs : callable
        From a run to an array (m + 1, channels); `body_states` otherwise. It is called from
        several threads at once.
    threads : int
        Runs computed side by side.

    Returns
    -------
    ndarray, shape (m + 1, channels, parameters)
        [unit of the channel / unit of the parameter]

    Raises
    ------
    CannotComputeError
        For a parameter that is not there, that is a count, or that is switched off at zero; and
        as `run` does.

    Notes
    -----
    Good to about 1e-8 of the largest derivative of a channel while the motion forgets its past; an
    unstable motion (a hull that turns by the Munk moment) grows rounding errors as it grows the
    derivatives. Where a command sits on a kink (a code within h of the dead zone's edge, a table's
    grid line), the mean of the slopes of its two sides comes out.
    """
    base = packed.vector if vector is None else np.asarray(vector, float)
    places = [_places(base, packed, name, index) for name, index in parameters]

    def moved(k: int, change: float) -> FloatArray:
        changed = base.copy()
        changed[places[k]] += change
        return outputs(
            run(
                packed,
                commands,
                dt_s=dt_s,
                vector=changed,
                start=start,
                external=external,
                method=method,
            )
        )

    first = outputs(
        run(
            packed,
            commands,
            dt_s=dt_s,
            vector=base,
            start=start,
            external=external,
            method=method,
        )
    )
    result = np.empty((*first.shape, len(parameters)))

    def column(k: int) -> None:
        name, index = parameters[k]
        step = RELATIVE_STEP * parameter_scale(base, name, index)
        value = float(base[places[k][0]])
        # the steps that are taken, not the one that was meant: their difference is rounding
        up, down = (value + step) - value, value - (value - step)
        if name in _NOT_NEGATIVE and value < step:
            near, far = moved(k, up), moved(k, 2.0 * up)
            result[:, :, k] = (4.0 * near - far - 3.0 * first) / (2.0 * up)
        else:
            result[:, :, k] = (moved(k, up) - moved(k, -down)) / (up + down)

    if threads <= 1 or len(parameters) < 2:
        for k in range(len(parameters)):
            column(k)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(column, range(len(parameters))))
    return result


def _places(vector: FloatArray, packed: PackedVehicle, name: str, index: int) -> list[int]:
    """Return indices into the vector, once it is clear that there is a derivative."""
    try:
        entry = slot(name)
    except KeyError:
        raise CannotComputeError(f"the model has no parameter called {name}") from None
    if not 0 <= index < entry.size:
        raise CannotComputeError(f"{name} has entries 0 to {entry.size - 1}, not {index}")
    if name in _DISCRETE:
        raise CannotComputeError(f"{name} is a count or an index: a run has no derivative by it")
    begin = offset(name)
    if name in _ABOVE_ZERO and vector[begin + index] <= 0.0:
        names = packed.thruster_names
        whose = f" of thruster {names[index]}" if index < len(names) else ""
        raise CannotComputeError(
            f"{name}{whose} is 0, which switches it off; give it a value ({entry.unit}) to take "
            "the derivative there"
        )
    if name in _SYMMETRIC:
        row, column = divmod(index, _SYMMETRIC[name])
        mirrored = _SYMMETRIC[name] * column + row
        return [begin + index] if mirrored == index else [begin + index, begin + mirrored]
    return [begin + index]
