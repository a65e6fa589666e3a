"""What the whole-vehicle fit may change: the free parameters, their priors, and how they are set.

Each is a number with a unit, counted from what the vehicle file says in steps of its prior standard
deviation, so that one step means the same for all of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import EllipsisType

import numpy as np

from pipeline.effects.library import candidates
from pipeline.physics.parameters import read
from pipeline.simulate.pack import PackedVehicle, mass_of
from pipeline.types import FloatArray
from pipeline.vehicle.model_schema import Uncertainty

AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
#: Speed at which an unstated linear damping is measured against a stated quadratic one.
_SLOW = 0.1
#: An added mass never falls below this share of the stated one, nor of the body's own inertia.
_SMALLEST_SHARE = 0.02
#: How far a parameter may be off before any run was made, where the vehicle file's `uncertainty`
#: states no more: standard deviation as a share of the stated added mass, damping, metacentric
#: height and lag. A shape formula for a real hull is easily a third off (Potapov and Galyaev
#: compute 12.0 kg and measure 18.9 kg); a lag that is too short passes for added mass.
_SHARE = 0.3
#: The same of the buoyancy as a share of the weight, and of the level distance of the centres [m].
_BUOYANCY_SHARE, _TRIM_M = 0.005, 0.003


@dataclass(frozen=True)
class FreeParameter:
    """One parameter of the fit: nominal value and prior standard deviation in `unit`.

    `lowest` is the smallest value that it may have; None: any.
    """

    name: str
    unit: str
    meaning: str
    nominal: float
    prior_std: float
    write: Callable[[FloatArray, float], None]
    lowest: float | None = None


def free_parameters(
    packed: PackedVehicle, uncertainty: Uncertainty, only: Sequence[str] | None = None
) -> tuple[FreeParameter, ...]:
    """List the parameters of a vehicle that runs can tell about, or `only` those of some names.

    ``added_mass_<axis>``, ``linear_damping_<axis>``, ``quadratic_damping_<axis>``,
    ``residual_buoyancy``, ``metacentric_height``, ``trim_x``, ``trim_y``, ``thruster_lag``,
    ``wake_fraction``.
    """
    found = [
        *_added_masses(packed, max(_SHARE, uncertainty.added_mass)),
        *_dampings(packed, max(_SHARE, uncertainty.damping)),
        *_hydrostatics(packed.vector, uncertainty),
        *_lags(packed),
        *_inflows(packed),
    ]
    return tuple(p for p in found if only is None or p.name in only)


def vector_with(
    nominal: FloatArray, parameters: Sequence[FreeParameter], values: FloatArray
) -> FloatArray:
    """Copy of a parameter vector with the free parameters (p,) set, in their units."""
    vector = nominal.copy()
    for parameter, value in zip(parameters, values, strict=True):
        parameter.write(vector, float(value))
    return vector


def values_from_steps(parameters: Sequence[FreeParameter], steps: FloatArray) -> FloatArray:
    """Values (p,) in their units from steps (p,) of one prior standard deviation each."""
    return np.array(
        [p.nominal + p.prior_std * step for p, step in zip(parameters, steps, strict=True)]
    )


def _added_masses(packed: PackedVehicle, share: float) -> list[FreeParameter]:
    """Diagonal entries; couplings follow, A_ij -> A_ij sqrt(f_i f_j), so A stays positive."""
    stated = np.diag(read(packed.vector, "added_mass")).copy()
    own = np.diag(mass_of(packed.vector, 0.0))
    smallest = _SMALLEST_SHARE * np.where(stated > 0, stated, own)

    def writer(axis: int) -> Callable[[FloatArray, float], None]:
        def write_value(vector: FloatArray, value: float) -> None:
            matrix = read(vector, "added_mass")
            wanted = max(value, float(smallest[axis]))
            if matrix[axis, axis] > 0.0:
                root = np.sqrt(wanted / matrix[axis, axis])
                matrix[axis, :] *= root
                matrix[:, axis] *= root
            matrix[axis, axis] = wanted

        return write_value

    return [
        FreeParameter(
            f"added_mass_{name}",
            "kg" if axis < 3 else "kg m^2",
            f"added {'mass' if axis < 3 else 'inertia'} in {name}, A_{axis + 1}{axis + 1}",
            float(stated[axis]),
            share * float(stated[axis] if stated[axis] > 0 else own[axis]),
            writer(axis),
            min(float(smallest[axis]), float(stated[axis])),
        )
        for axis, name in enumerate(AXES)
    ]


def _dampings(packed: PackedVehicle, share: float) -> list[FreeParameter]:
    """Linear and quadratic damping; a hull takes energy out, so neither is negative."""
    linear = np.diag(read(packed.vector, "linear_damping"))
    quadratic = read(packed.vector, "quadratic_damping")
    own = np.diag(mass_of(packed.vector, 0.0))
    # where the file says nothing: what the other term, or a decay within 20 s, would be
    kinds = (
        ("linear", linear, ("N s/m", "N m s"), quadratic * _SLOW, own / 20.0),
        ("quadratic", quadratic, ("N s^2/m^2", "N m s^2"), linear, own),
    )
    return [
        FreeParameter(
            f"{kind}_damping_{name}",
            units[axis // 3],
            f"linear damping in {name}" if kind == "linear" else f"quadratic damping in {name}",
            float(stated[axis]),
            share * float(stated[axis] or other[axis] or least[axis]),
            _entry(f"{kind}_damping", (axis, axis) if kind == "linear" else axis),
            0.0,
        )
        for kind, stated, units, other, least in kinds
        for axis, name in enumerate(AXES)
    ]


def _entry(
    slot: str, index: int | tuple[int, ...] | EllipsisType, base: float = 0.0, sign: float = 1.0
) -> Callable[[FloatArray, float], None]:
    """Write base + sign value to an entry of a slot."""

    def write_value(vector: FloatArray, value: float) -> None:
        read(vector, slot)[index] = base + sign * value

    return write_value


def _hydrostatics(nominal: FloatArray, uncertainty: Uncertainty) -> list[FreeParameter]:
    """Residual buoyancy, and the centre of buoyancy against the centre of mass.

    The centre of buoyancy is what is moved: that changes the righting moment and nothing else.
    """
    weight = float(read(nominal, "weight"))
    mass_centre = read(nominal, "centre_of_mass").copy()
    offset = mass_centre - read(nominal, "centre_of_buoyancy")

    height = _SHARE * abs(float(offset[2]))
    heights = (
        ("metacentric_height", "centre of mass below the centre of buoyancy", 2, height),
        ("trim_x", "centre of mass ahead of the centre of buoyancy", 0, _TRIM_M),
        ("trim_y", "centre of mass to starboard of the centre of buoyancy", 1, _TRIM_M),
    )
    return [
        FreeParameter(
            "residual_buoyancy",
            "N",
            "buoyancy less weight",
            float(read(nominal, "buoyancy")) - weight,
            max(_BUOYANCY_SHARE * weight, uncertainty.buoyancy_n),
            _entry("buoyancy", ..., weight),
        ),
        *(
            FreeParameter(
                name,
                "m",
                meaning,
                float(offset[axis]),
                max(width, uncertainty.centre_of_mass_m),
                _entry("centre_of_buoyancy", axis, float(mass_centre[axis]), -1.0),
            )
            for name, meaning, axis, width in heights
        ),
    ]


def _lags(packed: PackedVehicle) -> list[FreeParameter]:
    """One time constant for all thrusters that follow their code by a lag."""
    count = len(packed.thruster_names)
    stated = read(packed.vector, "lag")[:count].copy()
    lagged = (stated > 0) & (read(packed.vector, "rotor_inertia")[:count] == 0)
    if not lagged.any():
        return []
    mean = float(stated[lagged].mean())

    def write_value(vector: FloatArray, value: float) -> None:
        lags = read(vector, "lag")[:count]
        lags[lagged] = stated[lagged] * max(value / mean, _SMALLEST_SHARE)

    return [
        FreeParameter(
            "thruster_lag",
            "s",
            "time constant of the thrusters, mean over them",
            mean,
            _SHARE * mean,
            write_value,
            _SMALLEST_SHARE * mean,
        )
    ]


def _inflows(packed: PackedVehicle) -> list[FreeParameter]:
    """One wake fraction for all thrusters, in the proportion stated; where thrust falls with speed.

    Its width is what the file states of it.
    """
    effect = candidates(packed.context).get("advance_speed_loss")
    stated = packed.context.inflow_share
    width = effect.parameters[0].ordinary if effect is not None else 0.0
    if width <= 0.0:
        return []
    count = len(packed.thruster_names)
    own = read(packed.vector, "inflow_fraction")[:count].copy()

    def write_value(vector: FloatArray, value: float) -> None:
        read(vector, "inflow_fraction")[:count] = own * ((1.0 - value) / stated)

    return [
        FreeParameter(
            "wake_fraction",
            "1",
            "share of the inflow that does not reach the blades, mean over the thrusters",
            1.0 - stated,
            width,
            write_value,
        )
    ]
