r"""What the library's effects do to a mooring test of one thruster.

The effects set the same slots of the parameter vector as in simulation (`pipeline.effects`); here
the slots are read at rest, for a thruster that is alone on its supply:

.. math:: N_e = \mathrm{sign}(N)\,(|N| - d) \frac{N_{max}}{N_{max} - d}, \quad
          s = 1 - drop - load\_drop (N / N_{max})^2, \quad T = g\,g_r\,T_0(s N_e)

with g_r for N < 0 only. Shaft speed is n_0(s N_e) and voltage s U_0(N). The motor's power at s N_e
is drawn from a supply of s U_0, so current is I_0(s N_e) / s.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pipeline.diagnose.bench.model import ThrusterAtRest
from pipeline.effects.effect import EffectContext
from pipeline.effects.library import EffectSpec, apply_effects, effects
from pipeline.physics.parameters import neutral_vector, read, write
from pipeline.types import FloatArray

_THRUSTER = "thruster"
_CONTEXT = EffectContext((_THRUSTER,), True, True, False, False, 9.81)
#: Effects that a mooring table can show.
CANDIDATES = (
    "dead_zone",
    "reverse_thrust",
    "thrust_deduction",
    "thruster_degraded",
    "voltage_sag",
)
#: Of one thruster alone these two are the same factor; nothing in a table separates them.
TWIN = ("thrust_deduction", "thruster_degraded")
#: How far a factor on thrust may go along with another shaft speed, or current: a fouled propeller
#: turns slower, a chipped one faster, a motor that lost a phase slower at the same K_T.
_FREE = {"shaft_speed": 0.2, "current": 0.4}
_LEAST_SUPPLY = 0.02


@dataclass(frozen=True)
class BenchPrior:
    """What is believed of a parameter at the bench: normal, cut off at bounds; `start` of search.

    Wider than the library's plausible range where a bench can be further off than a vehicle: a
    supply can be set to anything.
    """

    effect: str
    parameter: str
    unit: str
    mean: float
    std: float
    bounds: tuple[float, float]


def priors(effect: str, code_max: float) -> tuple[BenchPrior, ...]:
    """Priors of an effect's parameters, in the order of the library.

    >>> [one.parameter for one in priors("voltage_sag", 127.0)]
    ['drop', 'load_drop']
    """
    stated: dict[str, tuple[float, float, tuple[float, float]]] = {
        "codes": (0.0, 0.12 * code_max, (0.0, 0.6 * code_max)),
        "fraction": (1.0, 0.25, (0.0, 1.3)),
        "t": (0.0, 0.2, (0.0, 1.0)),
        "thrust_fraction": (1.0, 0.3, (0.0, 1.0)),
        "drop": (0.0, 0.25, (-1.0, 0.9)),
        "load_drop": (0.0, 0.1, (0.0, 0.9)),
    }
    return tuple(
        BenchPrior(effect, one.name, one.unit, *stated[one.name])
        for one in effects()[effect].parameters
    )


def slots(values: Mapping[tuple[str, str], float], code_max: float) -> FloatArray:
    """Return the parameter vector of a lone thruster with effects switched on.

    Parameters
    ----------
    values : mapping of (effect, parameter) to float
        In the library's units.
    code_max : float
        Largest code.
    """
    vector = neutral_vector()
    write(vector, "thruster_count", 1.0)
    write(vector, "code_max", code_max)
    library = effects()
    specs = [
        EffectSpec(
            effect,
            {name: value for (owner, name), value in values.items() if owner == effect},
            _THRUSTER if library[effect].scope == "thruster" else None,
        )
        for effect in sorted({effect for effect, _ in values})
    ]
    return apply_effects(vector, specs, _CONTEXT)


def predict(
    model: ThrusterAtRest,
    values: Mapping[tuple[str, str], float],
    code: FloatArray,
    channels: Sequence[str],
) -> dict[str, FloatArray]:
    """Predict a mooring test with effects at work, channel by channel, each of shape (n,).

    Parameters
    ----------
    model : ThrusterAtRest
        The nominal thruster.
    values : mapping of (effect, parameter) to float
        What departs from neutral; empty for the nominal thruster.
    code : ndarray, shape (n,)
        Signed codes.
    channels : sequence of str
        Which of `bench_model.UNITS`.
    """
    vector = slots(_possible(values), model.code_max)
    lost = float(read(vector, "dead_zone")[0])
    largest = model.code_max
    clipped = np.clip(code, -largest, largest)
    size = np.maximum(np.abs(clipped) - lost, 0.0) * largest / (largest - lost)
    load = (clipped / largest) ** 2
    supply = 1.0 - float(read(vector, "supply_drop")) - float(read(vector, "load_drop")) * load
    supply = np.maximum(supply, _LEAST_SUPPLY)
    act = supply * np.copysign(size, code)
    gain = np.full(code.shape, float(read(vector, "thrust_gain")[0]))
    gain[code < 0.0] *= float(read(vector, "reverse_gain")[0])
    found: dict[str, FloatArray] = {}
    for channel in channels:
        reference = model.channels[channel]
        if channel == "thrust":
            found[channel] = gain * reference.at(act)
        elif channel == "shaft_speed":
            found[channel] = reference.at(act)
        elif channel == "current":
            found[channel] = reference.at(act) / supply
        else:
            found[channel] = supply * reference.at(code)
    return found


def _possible(values: Mapping[tuple[str, str], float]) -> dict[tuple[str, str], float]:
    """Hold drop and load_drop where some voltage is left, as the library demands."""
    held = dict(values)
    drop = held.get(("voltage_sag", "drop"), 0.0)
    load = held.get(("voltage_sag", "load_drop"), 0.0)
    if drop + load > 0.97:
        held["voltage_sag", "load_drop"] = max(0.97 - drop, 0.0)
    return held


def free_share(
    values: Mapping[tuple[str, str], float], channel: str, code: FloatArray
) -> FloatArray:
    """Share by which a channel may follow a factor on thrust, by code: zero where it must not.

    In proportion to the change of thrust up to a tenth, so that no factor gives no freedom.
    """
    share = np.zeros(code.shape)
    if channel in _FREE:
        weak = abs(1.0 - values.get(("thruster_degraded", "thrust_fraction"), 1.0))
        reverse = abs(1.0 - values.get(("reverse_thrust", "fraction"), 1.0))
        share[:] = _FREE[channel] * min(10.0 * weak, 1.0)
        back = _FREE[channel] * min(10.0 * reverse, 1.0)
        share[code < 0.0] = np.maximum(share[code < 0.0], back)
    return share
