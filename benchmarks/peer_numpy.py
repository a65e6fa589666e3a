"""The vehicle's equations as a textbook writes them in NumPy: 6x6 matrices, built every step.

M nu_r' + C(nu_r) nu_r + D(nu_r) nu_r + g(eta) = tau with the names of Fossen 2021 (m2c, Smtrx, J).
Written from the equations, not from the compiled kernel: a yardstick for its speed and a second
opinion on its results. The inverse of M is made once, as textbook code does.

Every expression is analytic away from the switches (sign, dead zone, limits), and the switches look
at real parts. So the same code runs on complex numbers, and a parameter perturbed by an imaginary
1e-30 gives derivatives to round-off (complex step; Squire and Trapp 1998, SIAM Rev. 40, 110).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from pipeline.physics.parameters import read
from pipeline.simulate.pack import PackedVehicle

Array = Any  # arrays and scalars, float or, for derivatives, complex


def smtrx(a: Array) -> Array:
    """Cross-product matrix S(a) (3, 3)."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def m2c(mass: Array, nu: Array) -> Array:
    """Coriolis matrix C(nu) (6, 6) of a symmetric mass matrix. Fossen 2021, theorem 3.2."""
    momentum = mass @ nu
    coriolis = np.zeros((6, 6), momentum.dtype)
    coriolis[:3, 3:] = coriolis[3:, :3] = -smtrx(momentum[:3])
    coriolis[3:, 3:] = -smtrx(momentum[3:])
    return coriolis


def rquat(q: Array) -> Array:
    """Rotation (3, 3) from body to NED: I + 2 w S(e) + 2 S(e)^2. Fossen 2021, eq. (2.67)."""
    s = smtrx(q[1:])
    return np.eye(3) + 2.0 * q[0] * s + 2.0 * s @ s


def tquat(q: Array) -> Array:
    """Matrix (4, 3) from body rates to the quaternion's rate. Fossen 2021, eq. (2.78)."""
    w, x, y, z = q
    return 0.5 * np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])


def absolute(a: Array) -> Array:
    """Absolute value by the sign of the real part."""
    return np.abs(a) if a.dtype.kind == "f" else np.where(a.real < 0.0, -a, a)


def at_least(a: Array, low: float) -> Array:
    """Larger of a and low, by the real part."""
    return np.maximum(a, low) if a.dtype.kind == "f" else np.where(a.real < low, low, a)


def at_most(a: Array, high: Array | float) -> Array:
    """Smaller of a and high, by the real part."""
    if a.dtype.kind == "f":
        return np.minimum(a, high)
    return np.where(a.real > np.real(high), high, a)


def bilinear(table: Array, kinds: Array, row: Array, column: Array) -> Array:
    """Values (n,) of `table[kinds]` on regular grids; beyond the last row along its slope."""
    rows, columns = table.shape[-2:]
    row, column = at_least(row, 0.0), at_most(at_least(column, 0.0), columns - 1.0)
    j = np.minimum(column.real.astype(int), columns - 2)
    c = column - j
    if rows == 1:
        return table[(*kinds, 0, j)] * (1.0 - c) + table[(*kinds, 0, j + 1)] * c
    i = np.minimum(row.real.astype(int), rows - 2)
    low = table[(*kinds, i, j)] * (1.0 - c) + table[(*kinds, i, j + 1)] * c
    high = table[(*kinds, i + 1, j)] * (1.0 - c) + table[(*kinds, i + 1, j + 1)] * c
    return low + (row - i) * (high - low)


@dataclass(frozen=True)
class Simulated:
    """States (m + 1, 13 + n), accelerations (m + 1, 6) and thrusts (m + 1, n)."""

    states: Array
    accelerations: Array
    thrusts: Array


class TextbookVehicle:
    """A vehicle from a parameter vector, float or complex."""

    def __init__(self, packed: PackedVehicle, vector: Array) -> None:
        self.packed = packed
        self.kind = vector.dtype
        self.count = len(packed.thruster_names)

        def slot(name: str) -> Array:
            return read(vector, name)

        def each(name: str) -> Array:
            return slot(name)[: self.count]

        self.slot, self.each = slot, each
        m, r_g = slot("mass"), slot("centre_of_mass")
        self.rigid_body = np.block(
            [[m * np.eye(3), -m * smtrx(r_g)], [m * smtrx(r_g), slot("inertia")]]
        )
        self.mass = self.rigid_body + slot("added_mass")
        self.inverse = np.linalg.inv(self.mass)
        self.types = each("thruster_type").real.astype(int)
        self.rotors = each("rotor_inertia").real > 0.0
        self.lagging = (each("lag").real > 0.0) & ~self.rotors
        self.configuration = self._configuration()

    def _configuration(self) -> Array:
        """Thrust configuration matrix B (6, n): forces above, moments below."""
        columns = np.zeros((6, self.count), self.kind)
        for i in range(self.count):
            azimuth = self.each("misalignment_azimuth")[i]
            elevation = self.each("misalignment_elevation")[i]
            d = self.each("thruster_direction")[i]
            flat = np.sqrt(d[0] ** 2 + d[1] ** 2)
            level = flat.real > 1e-6
            side = np.array([-d[1], d[0], 0.0]) / flat if level else np.eye(3)[1]
            turned = np.cos(azimuth) * d + np.sin(azimuth) * side
            raised = np.cos(elevation) * turned - np.sin(elevation) * np.cross(d, side)
            columns[:3, i] = raised
            columns[3:, i] = smtrx(self.each("thruster_position")[i]) @ raised
        return columns

    def effective_codes(self, command: Array) -> Array:
        """Codes (n,) after dead zone and supply voltage."""
        largest, lost = self.each("code_max"), self.each("dead_zone")
        code = at_most(at_least(command, self.each("code_min")), largest)
        code = at_least(code, -largest)
        load = np.mean((code / largest) ** 2) if self.count else 0.0
        supply = 1.0 - self.slot("supply_drop") - self.slot("load_drop") * load
        size = at_least(absolute(code) - lost, 0.0) * largest / (largest - lost)
        return supply * np.where(lost == 0.0, code, np.sign(code.real) * size)

    def thrust(self, actuator: Array, inflow: Array) -> Array:
        """Thrusts (n,) from lagged codes or shaft speeds, and inflow speeds along the axes."""
        back = actuator.real < 0.0
        along, size = at_least(np.where(back, -inflow, inflow), 0.0), absolute(actuator)
        steps = self.packed.steps[self.types]
        value = bilinear(
            self.packed.thrust_tables,
            (self.types, back.astype(int)),
            along / steps[:, 0],
            size / steps[:, 1],
        )
        if self.rotors.any():
            screw = self.packed.screws[self.types]
            advance = along / screw[:, 0]
            turning = screw[:, 1] * size**2 + screw[:, 2] * size * advance
            turning = (turning + screw[:, 3] * advance**2) * screw[:, 0] ** 4 * self.slot("density")
            value = np.where(self.rotors, turning, value)
        value = at_least(value, 0.0) * self.each("thrust_gain")
        return np.where(back, -value * self.each("reverse_gain"), value)

    def shaft_rate(self, shaft: Array, codes: Array, inflow: Array) -> Array:
        """Rates of the shaft speeds (n,): (M_drive - M_propeller) / (2 pi J)."""
        screw = self.packed.screws[self.types]
        back = (codes.real < 0.0) | ((codes.real == 0.0) & (inflow.real < 0.0))
        n, along = np.where(back, -shaft, shaft), np.where(back, -inflow, inflow)
        advance = at_least(along, 0.0) / screw[:, 0]
        drive = bilinear(
            self.packed.torque_tables,
            (self.types,),
            absolute(codes) / screw[:, 8],
            n / screw[:, 7],
        )
        forward = screw[:, 5] * n * advance + screw[:, 6] * advance**2
        load = screw[:, 4] * n * absolute(n) + np.where(n.real >= 0.0, forward, 0.0)
        load = load * self.slot("density") * screw[:, 0] ** 5
        balance = np.where(codes == 0.0, 0.0, drive) - load
        inertia = np.where(self.rotors, self.each("rotor_inertia"), 1.0)
        return np.where(back, -balance, balance) / (2.0 * np.pi * inertia)

    def wall_factor(self, position: Array) -> Array:
        """1 + c sum (R / distance)^3 over the walls."""
        strength, radius = self.slot("wall_strength"), self.slot("wall_radius")
        count = int(self.slot("wall_count").real)
        if strength == 0.0 or count == 0:
            return 1.0
        away = position - self.slot("wall_point")[:count]
        distance = np.sum(away * self.slot("wall_normal")[:count], axis=1)
        return 1.0 + strength * np.sum((radius / at_least(distance, radius.real)) ** 3)

    def damping(self, nu_r: Array) -> Array:
        """Damping force (6,) with cross-flow and lift, as D(nu_r) nu_r."""
        quadratic = np.diag(self.slot("quadratic_damping") * absolute(nu_r))
        return np.asarray((self.slot("linear_damping") + quadratic) @ nu_r)

    def crossflow(self, nu_r: Array) -> Array:
        """Force (6,) of what sway and yaw (heave and pitch) do together, by strips."""
        x, height, breadth = self.packed.strips.T
        half = 0.5 * self.slot("density") * self.slot("crossflow_fraction")

        def pressure(v: Array) -> Array:
            return absolute(v) * v

        side = pressure(nu_r[1] + x * nu_r[5]) - pressure(nu_r[1:2]) - pressure(x * nu_r[5])
        down = pressure(nu_r[2] - x * nu_r[4]) - pressure(nu_r[2:3]) - pressure(-x * nu_r[4])
        side, down = half * height * side, half * breadth * down
        return np.array([0.0, -side.sum(), -down.sum(), 0.0, x @ down, -(x @ side)])

    def lift(self, nu_r: Array) -> Array:
        """Force (6,) against the angle of attack; part of the moments turns over astern."""
        u, v, w = nu_r[:3]
        speed = absolute(u)
        turned = self.slot("turnover_slope") * (u - speed)
        return np.array(
            [
                0.0,
                -self.slot("sway_lift_slope") * speed * v,
                -self.slot("heave_lift_slope") * speed * w,
                0.0,
                (self.slot("pitch_lift_slope") * speed + turned[0]) * w,
                (self.slot("yaw_lift_slope") * speed + turned[1]) * v,
            ]
        )

    def restoring(self, rotation: Array) -> Array:
        """g(eta) (6,), on the left side of the equation. Fossen 2021, eq. (4.5)."""
        down = rotation[2]
        weight, buoyancy = self.slot("weight") * down, -self.slot("buoyancy") * down
        moment = smtrx(self.slot("centre_of_mass")) @ weight
        moment = moment + smtrx(self.slot("centre_of_buoyancy")) @ buoyancy
        return -np.concatenate([weight + buoyancy, moment])

    def tether(self, position: Array, rotation: Array, nu_r: Array) -> Array:
        """Force (6,) of the lumped tether."""
        lever = smtrx(self.slot("tether_point"))
        flow = nu_r[:3] - lever @ nu_r[3:]
        drag = 0.5 * self.slot("density") * self.slot("tether_drag_area")
        to_anchor = rotation.T @ (self.slot("tether_anchor") - position)
        to_anchor = to_anchor - self.slot("tether_point")
        length = np.sqrt(to_anchor @ to_anchor)
        reach = length if length.real > 1.0 else 1.0
        force = -drag * np.sqrt(flow @ flow) * flow + self.slot("tether_pull") * to_anchor / reach
        return np.concatenate([force, lever @ force])

    def rates(self, x: Array, codes: Array, external: Array) -> tuple[Array, Array]:
        """Rate of the state (13 + n,) and the thrusts (n,)."""
        rotation = rquat(x[3:7])
        nu, omega = x[7:13], x[10:13]
        nu_c = np.concatenate([rotation.T @ self.slot("current"), np.zeros(3)])
        nu_r = nu - nu_c
        inflow = self.each("inflow_fraction") * (self.configuration.T @ nu_r)
        thrust = self.thrust(x[13:], inflow)
        tau = self.configuration @ thrust + external + self.lift(nu_r)
        if self.slot("tether_drag_area") != 0.0 or self.slot("tether_pull") != 0.0:
            tau = tau + self.tether(x[:3], rotation, nu_r)
        if self.slot("crossflow_fraction") != 0.0:
            tau = tau + self.crossflow(nu_r)
        near_wall = self.wall_factor(x[:3])
        mass = self.mass
        if near_wall != 1.0:
            mass = self.rigid_body + near_wall * self.slot("added_mass")
        coriolis = self.slot("coriolis_fraction") * m2c(mass, nu_r)
        right = tau - coriolis @ nu_r - near_wall * self.damping(nu_r) - self.restoring(rotation)
        nu_dot = self.inverse @ right if near_wall == 1.0 else np.linalg.solve(mass, right)
        # nu_c turns against the body: nu_c' = -omega x nu_c
        nu_dot[:3] -= smtrx(omega) @ nu_c[:3]
        shaft = np.zeros(self.count)
        if self.rotors.any():
            shaft = np.where(self.rotors, self.shaft_rate(x[13:], codes, inflow), 0.0)
        return np.concatenate([self.kinematics(x, nu), nu_dot, shaft]), thrust

    def kinematics(self, x: Array, nu: Array) -> Array:
        """Rates of position and quaternion: J(eta) nu (7,)."""
        jacobian = np.zeros((7, 6), x.dtype)
        jacobian[:3, :3] = rquat(x[3:7])
        jacobian[3:, 3:] = tquat(x[3:7])
        return np.asarray(jacobian @ nu)

    def lagged(self, start: Array, codes: Array, elapsed: float) -> Array:
        """Actuator entries (n,) some time after the start of a step: first order, exact."""
        out: Array = np.where(self.rotors, start, codes)
        if self.lagging.any():
            tau = np.where(self.lagging, self.each("lag"), 1.0)
            late = codes + (start - codes) * np.exp(-elapsed / tau)
            out = np.where(self.lagging, late, out)
        return out


def simulate_numpy(
    packed: PackedVehicle,
    commands: Array,
    *,
    dt_s: float,
    start: Array,
    vector: Array | None = None,
    external: Array | None = None,
    method: str = "semi_implicit",
) -> Simulated:
    """Integrate commands (m, n), each held for a step; `vector` may be complex.

    `start` is the kernel's state (13 + 12,); `external` (6,) a force and moment on the body.
    """
    vehicle = TextbookVehicle(packed, packed.vector if vector is None else vector)
    outside = np.zeros(6) if external is None else external
    n = vehicle.count
    x = start[: 13 + n].astype(vehicle.kind)
    states = np.zeros((len(commands) + 1, 13 + n), vehicle.kind)
    accelerations = np.zeros((len(commands) + 1, 6), vehicle.kind)
    thrusts = np.zeros((len(commands) + 1, n), vehicle.kind)
    for k in range(len(commands) + 1):
        codes = vehicle.effective_codes(commands[min(k, len(commands) - 1)])
        x[13:] = vehicle.lagged(x[13:], codes, 0.0)
        k1, thrust = vehicle.rates(x, codes, outside)
        states[k], accelerations[k], thrusts[k] = x, k1[7:13], thrust
        if k == len(commands):
            break
        if method == "semi_implicit":
            new = x + dt_s * k1
            new[:7] = x[:7] + dt_s * vehicle.kinematics(x, new[7:13])
        else:
            new = _runge_kutta(vehicle, x, k1, codes, outside, dt_s)
        late = vehicle.lagged(x[13:], codes, dt_s)
        new[13:] = np.where(vehicle.rotors, new[13:], late)
        new[3:7] /= np.sqrt(new[3:7] @ new[3:7])
        x = new
    return Simulated(states, accelerations, thrusts)


def _runge_kutta(  # noqa: PLR0917 (the symbols of the formula)
    vehicle: TextbookVehicle, x: Array, k1: Array, codes: Array, outside: Array, dt_s: float
) -> Array:
    """Classical fourth-order step; lagged codes follow their own closed form."""

    def slope(rate: Array, share: float) -> Array:
        stage = x + share * dt_s * rate
        late = vehicle.lagged(x[13:], codes, share * dt_s)
        stage[13:] = np.where(vehicle.rotors, stage[13:], late)
        return vehicle.rates(stage, codes, outside)[0]

    k2 = slope(k1, 0.5)
    k3 = slope(k2, 0.5)
    k4 = slope(k3, 1.0)
    return x + dt_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
