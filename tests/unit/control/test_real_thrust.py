import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from paper_static import StaticTable

from pipeline.control.real_thrust import RealThruster
from pipeline.errors import CannotComputeError
from pipeline.physics.thrust_grid import dead_zone_code
from pipeline.records.fits import StaticCharacteristic


@pytest.fixture(scope="module")
def real(paper_static: StaticCharacteristic) -> RealThruster:
    return RealThruster.from_record(paper_static)


@given(code=st.floats(-127.0, 127.0), speed=st.floats(-2.0, 2.0))
def test_grid_is_table_2(
    real: RealThruster, table2: StaticTable, code: float, speed: float
) -> None:
    """Bilinear on whole codes and 0.1 m/s: the curvature of Table 2 is all that is lost."""
    assert float(real.thrust(code, speed)) == pytest.approx(
        float(table2.thrust_n(code, speed)), abs=0.03
    )


@given(code=st.floats(-127.0, 127.0), speed=st.floats(-2.0, 2.0))
def test_odd_in_code_and_speed_together(real: RealThruster, code: float, speed: float) -> None:
    assert float(real.thrust(-code, -speed)) == -float(real.thrust(code, speed))


@given(speed=st.floats(0.0, 2.0))
def test_never_falls_with_the_code(real: RealThruster, speed: float) -> None:
    assert (np.diff(real.thrust(np.linspace(-127, 127, 509), speed)) >= -1e-12).all()


@given(code=st.floats(0.0, 127.0))
def test_never_rises_with_the_speed(real: RealThruster, code: float) -> None:
    assert (np.diff(real.thrust(code, np.linspace(0.0, 2.0, 41))) <= 1e-9).all()


def test_edge_of_the_dead_zone_is_not_the_next_node(
    real: RealThruster, table2: StaticTable
) -> None:
    edge = dead_zone_code(table2.coefficients[0])
    assert float(real.thrust(edge - 0.05, 0.0)) == 0.0
    assert float(real.thrust(edge + 0.05, 0.0)) > 0.0


def test_held_at_the_edges(real: RealThruster) -> None:
    assert real.thrust(200.0, 0.0) == real.thrust(127.0, 0.0)
    assert real.thrust(100.0, 3.0) == real.thrust(100.0, 2.0)
    assert real.thrust_max_n(2.0) == pytest.approx(25.40, abs=0.01)


def test_no_thrust_anywhere(paper_static: StaticCharacteristic) -> None:
    shape = (len(paper_static.speed_mps), len(paper_static.code))
    nothing = paper_static.model_copy(
        update={"thrust_n": tuple((0.0,) * shape[1] for _ in range(shape[0]))}
    )
    with pytest.raises(CannotComputeError, match="no point with thrust"):
        RealThruster.from_record(nothing)


def test_one_live_node_has_no_slope_to_continue() -> None:
    record = StaticCharacteristic.model_validate(
        {
            "speed_mps": (0.0,),
            "code": (50.0, 100.0),
            "thrust_n": ((0.0, 3.0),),
            **dict.fromkeys(
                ("thrust_std_n", "shaft_speed_rpm", "torque_nm", "advance_ratio"), ((0.0, 0.0),)
            ),
            "status": (("dead", "live"),),
            "table2": (),
            "checks": (),
            "explanations": (),
        }
    )
    assert RealThruster.from_record(record).thrust([40.0, 75.0, 100.0], 0.0).tolist() == [
        0.0,
        1.5,
        3.0,
    ]
