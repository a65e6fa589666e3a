"""Characteristics that the firmware tests run on, and a strategy that invents more."""

import numpy as np
import numpy.typing as npt
from hypothesis import settings
from hypothesis import strategies as st

from pipeline.control.inverse import thrust_grid
from pipeline.physics import thrust_grid as physics
from pipeline.records.fits import FirmwareBranch, FirmwareCharacteristic

Floats = npt.NDArray[np.float64]

#: No deadline: how long an example takes says nothing about the firmware.
unhurried = settings(deadline=None)

# Kostenko 2023, Table 2.
SPEED_MPS = np.array([0.0, 0.5, 1.0, 1.5, 2.0])
KF0 = np.array([-4.0, -5.0, -8.0, -11.0, -15.0])
KF1 = np.array([0.254, 0.215, 0.211, 0.210, 0.208])
KF2 = np.array([8.82, 10.2, 9.65, 9.07, 8.67]) * 1e-4


def branch(
    sign: int, speed: Floats, thrust: Floats, fraction: Floats, code: Floats
) -> FirmwareBranch:
    return FirmwareBranch(
        sign=sign,
        speed_mps=tuple(speed.tolist()),
        thrust_max_n=tuple(thrust.tolist()),
        fraction=tuple(fraction.tolist()),
        code=tuple(tuple(row) for row in code.tolist()),
        against_motion="the row at rest",
    )


def table2_branch(sign: int, factor: float) -> FirmwareBranch:
    """Table 2 times a factor on 9 speeds and 33 fractions."""
    speed = np.linspace(0.0, 2.0, 9)
    fraction = np.linspace(0.0, 1.0, 33)
    k0, k1, k2 = (factor * np.interp(speed, SPEED_MPS, k) for k in (KF0, KF1, KF2))
    largest = k0 + k1 * 127 + k2 * 127**2
    thrust = fraction * largest[:, None]
    discriminant = k1[:, None] ** 2 - 4 * k2[:, None] * (k0[:, None] - thrust)
    code = (-k1[:, None] + np.sqrt(discriminant)) / (2 * k2[:, None])
    code[:, -1] = 127.0
    return branch(sign, speed, largest, fraction, code)


def table2() -> FirmwareCharacteristic:
    """Kostenko's thruster, somewhat weaker in reverse and with a little wider dead zone."""
    reverse = table2_branch(-1, 0.95)
    shifted = [[c + 2.0 * (127.0 - c) / 127.0 for c in row] for row in reverse.code]
    return FirmwareCharacteristic(
        thrust_dead_n=0.5,
        code_max=127,
        positive=table2_branch(1, 1.0),
        negative=reverse.model_copy(update={"code": tuple(map(tuple, shifted))}),
    )


def power_law(
    sign: int, code_max: int, code_dead: float, *, thrust: Floats, speed: Floats, fraction: Floats
) -> FirmwareBranch:
    """|N| = N_dead + (N_max - N_dead) (T / T_max)^0.6, the dead zone wider at speed."""
    dead = code_dead * (1.0 + 0.2 * speed)[:, None]
    code = dead + (code_max - dead) * fraction**0.6
    code[:, -1] = code_max
    return branch(sign, speed, thrust, fraction, code)


def bench_only() -> FirmwareCharacteristic:
    """A thruster known at rest only, codes as PWM microseconds off neutral, stronger ahead."""
    rest, fraction = np.array([0.0]), np.linspace(0.0, 1.0, 25)
    return FirmwareCharacteristic(
        thrust_dead_n=0.3,
        code_max=400,
        positive=power_law(1, 400, 34.0, thrust=np.array([51.5]), speed=rest, fraction=fraction),
        negative=power_law(-1, 400, 32.0, thrust=np.array([40.2]), speed=rest, fraction=fraction),
    )


def largest_codes() -> FirmwareCharacteristic:
    """The whole range of int16 codes, a strong thruster, fractions dense near zero."""
    speed = np.array([0.0, 0.7, 1.9, 4.4])
    fraction = np.linspace(0.0, 1.0, 33) ** 2
    return FirmwareCharacteristic(
        thrust_dead_n=1.0,
        code_max=32767,
        positive=power_law(
            1, 32767, 900.0, thrust=np.array([950.0, 870, 640, 300]), speed=speed, fraction=fraction
        ),
        negative=power_law(
            -1,
            32767,
            800.0,
            thrust=np.array([700.0, 640, 500, 200]),
            speed=speed,
            fraction=fraction,
        ),
    )


def coarse() -> FirmwareCharacteristic:
    """Few codes, few knots, axes that no binary format holds exactly, codes falling with speed."""
    speed, fraction = np.array([0.0, 0.1, 1.3]), np.array([0.0, 0.1, 0.7, 1.0])
    code = np.array([[2.1, 3.3, 7.9, 10.0], [1.9, 3.1, 7.7, 10.0], [1.3, 3.2, 7.1, 9.9]])
    return FirmwareCharacteristic(
        thrust_dead_n=0.1,
        code_max=10,
        positive=branch(1, speed, np.array([12.3, 14.1, 3.7]), fraction, code),
        negative=branch(-1, speed, np.array([12.3, 14.1, 3.7]), fraction, code),
    )


def weak_reverse() -> FirmwareCharacteristic:
    """A drive that takes fewer negative codes than the mirrored branch has."""
    mirrored = table2_branch(-1, 1.0)
    return table2().model_copy(update={"code_min": -100, "negative": mirrored})


def forward_only() -> FirmwareCharacteristic:
    """A drive that takes no negative code at all."""
    return weak_reverse().model_copy(update={"code_min": 0})


def strongest(thrust_max_n: float) -> FirmwareCharacteristic:
    """The thruster of Table 2 with as much thrust as is asked for."""

    def scaled(one: FirmwareBranch) -> FirmwareBranch:
        factor = thrust_max_n / max(one.thrust_max_n)
        return one.model_copy(update={"thrust_max_n": tuple(factor * t for t in one.thrust_max_n)})

    both = table2()
    return both.model_copy(
        update={"positive": scaled(both.positive), "negative": scaled(both.negative)}
    )


def strong_reverse() -> FirmwareCharacteristic:
    """A drive with more negative codes than positive ones, each sign measured by itself."""
    rest, fraction = np.array([0.0]), np.linspace(0.0, 1.0, 25)
    return FirmwareCharacteristic(
        thrust_dead_n=0.3,
        code_min=-180,
        code_max=100,
        positive=power_law(1, 100, 12.0, thrust=np.array([21.5]), speed=rest, fraction=fraction),
        negative=power_law(-1, 180, 14.0, thrust=np.array([33.2]), speed=rest, fraction=fraction),
    )


def reference_code(
    characteristic: FirmwareCharacteristic, thrust_n: Floats, speed_mps: Floats | float
) -> Floats:
    """Code before it is rounded, in double precision, within the range of the drive."""
    code = physics.code_from_thrust(
        thrust_n,
        speed_mps,
        positive=thrust_grid(characteristic.positive),
        negative=thrust_grid(characteristic.negative),
        thrust_dead_n=characteristic.thrust_dead_n,
    )
    return np.maximum(code, characteristic.code_min)


def reference_thrust(
    characteristic: FirmwareCharacteristic,
    code: npt.NDArray[np.integer],
    speed_mps: Floats | float,
) -> Floats:
    """Thrust in double precision; codes are held within the range of the drive."""
    return physics.thrust_from_code(
        np.maximum(code.astype(float), characteristic.code_min),
        speed_mps,
        positive=thrust_grid(characteristic.positive),
        negative=thrust_grid(characteristic.negative),
    )


def codes_that_return(characteristic: FirmwareCharacteristic, most: int) -> npt.NDArray[np.int64]:
    """Codes that every row of the tables reaches and the drive takes, at most so many."""
    last = min(int(row[-1]) for row in characteristic.positive.code)
    first = max(-int(row[-1]) for row in characteristic.negative.code)
    codes = np.linspace(max(first, characteristic.code_min), last, most)
    return np.unique(codes.astype(np.int64))


CASES = {
    "table2": table2,
    "weak_reverse": weak_reverse,
    "forward_only": forward_only,
    "strong_reverse": strong_reverse,
    "bench_only": bench_only,
    "largest_codes": largest_codes,
    "coarse": coarse,
}


@st.composite
def characteristics(draw: st.DrawFn) -> FirmwareCharacteristic:
    """Any characteristic that the export accepts, within sober slopes."""
    code_max = draw(st.sampled_from([10, 127, 400, 32767]))
    share = draw(st.sampled_from([0.0, 0.5, 1.0]))
    branches = {}
    for name, sign in (("positive", 1), ("negative", -1)):
        steps = st.floats(0.05, 1.0)
        speeds = draw(st.lists(steps, max_size=4))
        widths = np.array(draw(st.lists(steps, min_size=1, max_size=8)))
        rows = []
        for _ in range(len(speeds) + 1):
            rises = draw(st.lists(steps, min_size=len(widths), max_size=len(widths)))
            shape = np.concatenate(([draw(st.floats(0.0, 3.0))], rises)).cumsum()
            rows.append(np.minimum(shape / shape[-1], 1.0) * code_max)
        thrust = [draw(st.floats(0.5, 200.0)) for _ in rows]
        fraction = np.concatenate(([0.0], widths.cumsum() / widths.sum()))
        fraction[-1] = 1.0
        speed = np.concatenate(([0.0], speeds)).cumsum()
        branches[name] = branch(sign, speed, np.array(thrust), fraction, np.array(rows))
    return FirmwareCharacteristic(
        thrust_dead_n=draw(st.floats(0.0, 1.0)),
        code_min=-int(share * code_max),
        code_max=code_max,
        **branches,
    )
