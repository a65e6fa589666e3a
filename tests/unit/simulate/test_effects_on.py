"""Effects that a user switches on: each once, and what is left can be a vehicle."""

import numpy as np
import pytest

from pipeline.effects.library import apply_effects, parse_effect
from pipeline.errors import CannotComputeError, InputError
from pipeline.physics.parameters import read
from pipeline.simulate.effects_on import body_fault, effects_on
from pipeline.simulate.pack import PackedVehicle


@pytest.mark.parametrize(
    ("effect", "said"),
    [
        ("payload:mass_kg=-5,x_m=0.5", "no body has the principal moments of inertia"),
        ("payload:mass_kg=-2,z_m=0.4", "give less mass, or a place nearer to the centre"),
        ("residual_buoyancy:force_n=-500", "N of buoyancy left. The total must stay positive."),
    ],
)
def test_what_leaves_no_body_is_refused_by_its_name(
    packed_vehicles: dict[str, PackedVehicle], effect: str, said: str
) -> None:
    packed = packed_vehicles["rov8"]
    spec = parse_effect(effect)
    with pytest.raises(CannotComputeError, match=spec.id) as caught:
        effects_on(packed, [spec])(packed.vector)
    assert said in str(caught.value)
    # the diagnosis goes through such points
    assert np.isfinite(apply_effects(packed.vector, [spec], packed.context)).all()


def test_each_vehicle_is_one_as_it_is(packed_vehicles: dict[str, PackedVehicle]) -> None:
    for packed in packed_vehicles.values():
        assert body_fault(packed.vector) is None
        changed = effects_on(packed, [])(packed.vector)
        assert changed.tobytes() == packed.vector.tobytes()


def test_a_module_that_was_part_of_the_body_may_be_taken_off(
    packed_vehicles: dict[str, PackedVehicle],
) -> None:
    packed = packed_vehicles["rov8"]
    specs = [parse_effect(t) for t in ("payload:mass_kg=-1,x_m=0.1", "cg_shift:dz_m=0.1")]
    assert float(read(effects_on(packed, specs)(packed.vector), "mass")) == pytest.approx(
        float(read(packed.vector, "mass")) - 1.0
    )


def test_an_effect_is_given_once_for_each_thruster(
    packed_vehicles: dict[str, PackedVehicle],
) -> None:
    packed = packed_vehicles["rov8"]
    sag = parse_effect("voltage_sag:drop=0.6")
    with pytest.raises(InputError, match="voltage_sag is given twice"):
        effects_on(packed, [sag, parse_effect("voltage_sag:load_drop=0.1")])
    first, second = packed.thruster_names[:2]
    weak = [parse_effect(f"thruster_degraded:thrust_fraction=0.5@{n}") for n in (first, second)]
    gains = read(effects_on(packed, weak)(packed.vector), "thrust_gain")
    assert gains[:3].tolist() == [0.5, 0.5, 1.0]
    with pytest.raises(InputError, match="Put its values together into one"):
        effects_on(packed, [weak[0], weak[0]])
