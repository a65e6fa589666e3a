"""Exported models are read as their receivers read them, and are the vehicle that was exported."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from bundled_models import bundled
from pymavlink.mavparm import MAVParmDict
from scipy.spatial.transform import Rotation

from pipeline.actions.receivers import export_to_receiver
from pipeline.bundled.vehicles import bundled_vehicle
from pipeline.errors import CannotComputeError
from pipeline.export.receivers.autopilots import FRAMES, ardusub, px4
from pipeline.export.receivers.exported import Subject, signal, subject_of, thrust_exponent
from pipeline.export.receivers.gazebo import gazebo
from pipeline.export.receivers.stonefish import stonefish
from pipeline.physics.parameters import read
from pipeline.simulate.pack import pack_vehicle
from pipeline.types import FloatArray

_FLIP = np.array([1.0, -1.0, -1.0])


@pytest.fixture(scope="module")
def rov(repository: Path) -> Subject:
    """Eight thrusters, one of them weak, the centre of mass off the origin."""
    vehicle = bundled(repository, "rov8")
    assert vehicle.model is not None
    body = vehicle.model.rigid_body.model_copy(update={"centre_of_mass_m": (0.02, -0.01, 0.03)})
    weak = vehicle.thrusters[1].model_copy(update={"gain_ahead": 0.69, "gain_reverse": 0.5})
    vehicle = vehicle.model_copy(
        update={
            "thrusters": (vehicle.thrusters[0], weak, *vehicle.thrusters[2:]),
            "model": vehicle.model.model_copy(update={"rigid_body": body}),
        }
    )
    return subject_of(vehicle, pack_vehicle(vehicle))


def floats(text: str | None) -> FloatArray:
    return np.array([float(part) for part in (text or "").split()])


def test_px4_gets_effectiveness_about_the_centre_of_gravity(rov: Subject) -> None:
    text = px4(rov).text("# head -- of any kind\n")
    rows = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    assert {len(row) for row in rows} == {5}
    assert {row[4] for row in rows} == {"6", "9"}
    value = {row[2]: float(row[3]) for row in rows}
    count = int(value["CA_ROTOR_COUNT"])
    at, to = (
        np.array([[value[f"CA_ROTOR{k}_{what}{a}"] for a in "XYZ"] for k in range(count)])
        for what in "PA"
    )
    force = np.array([value[f"CA_ROTOR{k}_CT"] for k in range(count)])
    centre = read(rov.packed.vector, "centre_of_mass")
    np.testing.assert_allclose(to.T, rov.matrix[:3], atol=1e-12)
    moment = rov.matrix[3:] - np.cross(centre, rov.matrix[:3].T).T
    np.testing.assert_allclose(np.cross(at, to).T, moment, atol=1e-12)
    assert force[1] / force[0] == pytest.approx(0.69)
    assert 0.0 <= value["THR_MDL_FAC"] <= 1.0


def test_the_signal_of_a_share_gives_that_share() -> None:
    share = np.linspace(-1, 1, 21)
    for factor in (0.0, 0.6, 1.0):
        u = signal(share, factor)
        np.testing.assert_allclose(np.sign(u) * (factor * u**2 + (1 - factor) * abs(u)), share)


def test_ardusub_turns_the_motors_of_its_frame(rov: Subject, tmp_path: Path) -> None:
    file = tmp_path / "rov.param"
    file.write_text(ardusub(rov).text("# head\n"))
    found = MAVParmDict()
    assert found.load(str(file))
    assert found["FRAME_CONFIG"] == 2
    for motor, factors in enumerate(FRAMES[2]):
        push = found[f"MOT_{motor + 1}_DIRECTION"] * rov.matrix[:, motor]
        roll, pitch, yaw, up, ahead, right = factors
        if up:
            assert -push[2] * up > 0.9
            assert push[3] * roll > 0.1
            assert push[4] * pitch > 0.1
        else:
            assert push[0] * ahead > 0.5
            assert push[1] * right > 0.5
            assert push[5] * yaw > 0.1


def test_ardusub_has_no_frame_for_a_torpedo(repository: Path) -> None:
    vehicle = bundled(repository, "cargo_carrier")
    with pytest.raises(CannotComputeError, match="no arrangement"):
        ardusub(subject_of(vehicle, pack_vehicle(vehicle)))


def test_gazebo_has_the_mass_water_and_thrusters_of_the_vehicle(rov: Subject) -> None:
    exported = gazebo(rov)
    root = ET.fromstring(exported.text(exported.comment("a -- b") + "\n"))  # noqa: S314 - ours
    vector = rov.packed.vector
    link = root.find("world/model/link")
    assert link is not None
    centre = floats(link.findtext("inertial/pose"))[:3]
    np.testing.assert_allclose(centre * _FLIP, read(vector, "centre_of_mass"))
    # kinetic energy of a motion about the origin, SNAME against what the link states
    names = ("x", "y", "z", "p", "q", "r")
    added, inertia = np.zeros((6, 6)), np.zeros((3, 3))
    for i in range(6):
        for j in range(i, 6):
            text = link.findtext(f"inertial/fluid_added_mass/{names[i]}{names[j]}")
            added[i, j] = added[j, i] = float(text or "nan")
    for i in range(3):
        for j in range(i, 3):
            text = link.findtext(f"inertial/inertia/i{'xyz'[i]}{'xyz'[j]}")
            inertia[i, j] = inertia[j, i] = float(text or "nan")
    mass = float(link.findtext("inertial/mass") or "nan")
    nu = np.array([0.3, -0.2, 0.5, 0.7, -0.4, 0.6])
    speed, turn = nu[:3] * _FLIP, nu[3:] * _FLIP
    at_centre = np.concatenate([speed + np.cross(turn, centre), turn])
    stated = at_centre @ added @ at_centre + turn @ inertia @ turn
    stated += mass * at_centre[:3] @ at_centre[:3]
    r = read(vector, "centre_of_mass")
    own = nu @ read(vector, "added_mass") @ nu + nu[3:] @ read(vector, "inertia") @ nu[3:]
    own += mass * (nu[:3] @ nu[:3] + 2 * nu[:3] @ np.cross(nu[3:], r))
    assert stated == pytest.approx(own, rel=1e-6)
    # damping slows down, in each axis as stated
    plugins = {one.get("name"): one for one in root.iter("plugin")}
    water = plugins["gz::sim::systems::Hydrodynamics"]
    linear = [float(water.findtext(key) or "nan") for key in ("xU", "yV", "zW", "kP", "mQ", "nR")]
    np.testing.assert_allclose(linear, -np.diag(read(vector, "linear_damping")))
    assert float(water.findtext("xUabsU") or "nan") == -read(vector, "quadratic_damping")[0]
    # a thruster pushes along the x axis of its propeller
    for k, name in enumerate(rov.packed.thruster_names):
        part = root.find(f".//link[@name='{name}_propeller']")
        assert part is not None
        pose = floats(part.findtext("pose"))
        axis = Rotation.from_euler("ZYX", pose[3:][::-1]).apply([1.0, 0.0, 0.0])
        np.testing.assert_allclose(axis * _FLIP, rov.matrix[:3, k], atol=1e-8)
        np.testing.assert_allclose(pose[:3] * _FLIP, read(vector, "thruster_position")[k])
    # the cube displaces what the vehicle displaces
    size = floats(link.findtext("collision/geometry/box/size"))
    volume = read(vector, "buoyancy") / (read(vector, "density") * 9.82)
    assert np.prod(size) == pytest.approx(float(volume), rel=1e-3)


def test_stonefish_has_the_weight_and_thrusters_of_the_vehicle(rov: Subject) -> None:
    exported = stonefish(rov)
    root = ET.fromstring(exported.text(exported.comment("a -- b") + "\n"))  # noqa: S314 - ours
    vector, link = rov.packed.vector, root.find("robot/base_link")
    assert link is not None

    def of(tag: str, key: str, part: ET.Element = link) -> FloatArray:
        found = part.find(tag)
        assert found is not None
        return floats(found.get(key))

    centre = read(vector, "centre_of_mass")
    assert of("mass", "value") == pytest.approx(float(read(vector, "mass")))
    np.testing.assert_allclose(of("cg", "xyz"), centre)
    about = np.diag(read(vector, "inertia")) - of("mass", "value") * (centre @ centre - centre**2)
    np.testing.assert_allclose(of("inertia", "xyz"), about, rtol=1e-6)
    radius, length = of("dimensions", "radius")[0], of("dimensions", "height")[0]
    water = root.find("environment/ocean/water")
    assert water is not None
    density = float(water.get("density", "nan"))
    assert np.pi * radius**2 * length * density * rov.packed.context.gravity_mps2 == pytest.approx(
        float(read(vector, "buoyancy")), rel=1e-6
    )
    np.testing.assert_allclose(of("origin", "xyz"), read(vector, "centre_of_buoyancy"), rtol=1e-8)
    for k, name in enumerate(rov.packed.thruster_names):
        part = root.find(f".//actuator[@name='{name}']")
        assert part is not None
        roll, pitch, yaw = of("origin", "rpy", part)
        axis = Rotation.from_euler("ZYX", [yaw, pitch, roll]).apply([1.0, 0.0, 0.0])
        np.testing.assert_allclose(axis, rov.matrix[:3, k], atol=1e-8)
        codes, thrust = (of(f"thrust_model/{one}", "value", part) for one in ("input", "output"))
        assert (np.diff(codes) > 0).all()
        assert thrust[0] == pytest.approx(-rov.astern[k, -1])
        assert thrust[-1] == pytest.approx(rov.ahead[k, -1])


def test_stonefish_dives_at_the_speed_its_drag_allows(rov: Subject) -> None:
    """Level descent: net thrust equals form drag of the cylinder's side and friction."""
    exported = stonefish(rov)
    root = ET.fromstring(exported.text(""))  # noqa: S314 - ours
    link = root.find("robot/base_link")
    assert link is not None
    size, drag = link.find("dimensions"), link.find("hydrodynamics")
    assert size is not None
    assert drag is not None
    assert exported.fly is not None
    wrench = np.array([0.0, 0.0, 40.0, 0.0, 0.0, 0.0])
    codes = rov.code(np.linalg.pinv(rov.matrix, rcond=1e-6) @ wrench)
    w = exported.fly(codes, 250, 0.02)[:, 2]
    radius, length = float(size.get("radius", "nan")), float(size.get("height", "nan"))
    form, friction = (floats(drag.get(key))[2] for key in ("quadratic_drag", "viscous_drag"))
    density = float(read(rov.packed.vector, "density"))
    along = 2 * np.pi * radius**2 + np.pi * radius * length
    weight = read(rov.packed.vector, "mass") * rov.packed.context.gravity_mps2
    net = 40.0 + float(weight - read(rov.packed.vector, "buoyancy"))
    resists = 0.5 * density * form * 2 * radius * length * w[-1] ** 3
    resists += density * friction * along * w[-1]
    assert w[-1] > 0.2
    assert resists == pytest.approx(net, rel=0.05)


def test_what_the_format_holds_costs_nothing(tmp_path: Path) -> None:
    """Without lag and with thrust that does not fall Gazebo's equations are the vehicle's."""
    source = bundled_vehicle("rov8")
    text = (source if source.is_file() else source / "vehicle.yaml").read_text(encoding="utf-8")
    folder = tmp_path / "raw" / "rov"
    folder.mkdir(parents=True)
    file = folder / "vehicle.yaml"
    costs = {}
    for falls in ("true", "false"):
        changed = text.replace("thrust_falls_with_speed: true", f"thrust_falls_with_speed: {falls}")
        if falls == "false":
            changed = re.sub(r"lag_s: [0-9.]+", "lag_s: 0.0", changed)
        file.write_text(changed, encoding="utf-8")
        done = export_to_receiver(str(folder), "gazebo", tmp_path / falls, tmp_path, tmp_path)
        costs[falls] = max(cost.rms_difference for cost in done.costs)
        assert done.path.read_text().count(done.costs[0].line) == 1
    assert costs["true"] > 1e-2
    assert costs["false"] < 1e-6


def test_one_curve_is_fitted_to_what_the_thrusters_give(rov: Subject) -> None:
    factor, off = thrust_exponent(rov)
    assert 0.3 < factor < 0.9
    assert off < 0.06
