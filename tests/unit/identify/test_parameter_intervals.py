"""Verdicts on parameters whose posterior is known beforehand."""

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.identify.identifiability import _left
from pipeline.identify.output_error import FitSolution
from pipeline.identify.parameter_intervals import (
    _with_intervals,
    identified_parameters,
    prior_share,
)
from pipeline.identify.thrust_uncertainty import EXACT_THRUST
from pipeline.identify.vehicle_parameters import FreeParameter, free_parameters
from pipeline.records.identification import IdentifiedParameter
from pipeline.simulate.pack import pack_vehicle
from pipeline.types import FloatArray
from pipeline.vehicle.load import load_vehicle
from pipeline.vehicle.model_schema import Uncertainty


@pytest.fixture(scope="module")
def parameters() -> tuple[FreeParameter, ...]:
    return free_parameters(pack_vehicle(load_vehicle(bundled_vehicle("rov8"))), Uncertainty())


def verdicts(
    parameters: tuple[FreeParameter, ...], covariance: FloatArray, inflation: float = 1.0
) -> dict[str, IdentifiedParameter]:
    """Verdicts at the values of the vehicle file, by name."""
    count = len(parameters)
    lowest = [
        -np.inf if p.lowest is None else (p.lowest - p.nominal) / p.prior_std for p in parameters
    ]
    steps = np.zeros(count)
    solution = SimpleNamespace(
        problem=SimpleNamespace(
            parameters=parameters, thrust=EXACT_THRUST, lowest=np.array(lowest), size=count
        ),
        point=SimpleNamespace(steps=steps),
        beyond=np.zeros(count),
    )
    posterior = _with_intervals(
        cast("FitSolution", solution), covariance, np.full(count, inflation)
    )
    return {p.name: p for p in identified_parameters(parameters, steps, posterior)}


def test_what_is_left_of_a_prior_that_ends_at_its_middle(
    parameters: tuple[FreeParameter, ...],
) -> None:
    """Half a normal density: its variance is 1 - 2 / pi."""
    by_name = {p.name: p for p in parameters}
    half = prior_share(by_name["linear_damping_sway"])
    assert half == pytest.approx(np.sqrt(1 - 2 / np.pi))
    assert prior_share(by_name["linear_damping_heave"]) == pytest.approx(1.0, abs=0.01)
    assert prior_share(by_name["added_mass_sway"]) == pytest.approx(1.0, abs=0.01)


def test_the_prior_alone_identifies_nothing(parameters: tuple[FreeParameter, ...]) -> None:
    """Also where the file says zero and zero is the bound, so that the bound alone narrows."""
    found = verdicts(parameters, np.eye(len(parameters)))
    assert [name for name, one in found.items() if one.identified] == []
    for one in found.values():
        assert one.posterior_over_prior == pytest.approx(1.0, abs=0.02)
        assert "hardly excite" in one.reason
    assert found["linear_damping_sway"].std < 0.62 * found["linear_damping_sway"].prior_std


def test_half_of_the_prior_is_identified_at_the_bound_too(
    parameters: tuple[FreeParameter, ...],
) -> None:
    found = verdicts(parameters, 0.25 * np.eye(len(parameters)))
    assert all(one.identified for one in found.values())
    at_bound = found["linear_damping_sway"].posterior_over_prior
    assert at_bound == pytest.approx(0.5, abs=0.01)


def test_windows_that_contradict_each_other_are_named_at_the_bound_too(
    parameters: tuple[FreeParameter, ...],
) -> None:
    found = verdicts(parameters, np.eye(len(parameters)), inflation=1.5)
    assert "contradict" in found["linear_damping_sway"].reason
    assert "contradict" in found["added_mass_sway"].reason


def test_a_forecast_is_as_wide_as_the_fit_found_itself_to_be(
    parameters: tuple[FreeParameter, ...],
) -> None:
    """The same information twice: what is left is what the verdict says."""
    covariance = 0.36 * np.eye(len(parameters))
    found = verdicts(parameters, covariance, inflation=1.5)
    left = _left(np.linalg.inv(covariance), parameters, list(found.values()))
    np.testing.assert_allclose(left, [p.posterior_over_prior for p in found.values()], atol=0.015)
    # a mass has a bound at zero, which cuts a little off
    assert left[0] == pytest.approx(0.9, abs=0.005)
