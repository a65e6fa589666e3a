"""Logs and trajectories filled with random numbers, for the tests of the MCAP log."""

import numpy as np

from pipeline.simulate.run import Trajectory
from pipeline.simulate.sensors import Channel, Log

# lengths of every remainder of four, and a name outside ASCII: they move the alignment
THRUSTERS = ("bow", "left", "upper", "starboard", "нижний")
DENSITY_KGPM3, GRAVITY_MPS2 = 1025.5, 9.8155
COLUMNS: dict[str, tuple[str, ...]] = {
    "command": THRUSTERS,
    "imu": (
        *("p_radps", "q_radps", "r_radps"),
        *("fx_mps2", "fy_mps2", "fz_mps2"),
        *("qw", "qx", "qy", "qz"),
    ),
    "dvl": ("vx_mps", "vy_mps", "vz_mps"),
    "depth": ("depth_m",),
    "position": ("north_m", "east_m", "down_m"),
    "shaft_speed": THRUSTERS,
    "voltage": ("supply_v",),
}
RATE_HZ = {
    "command": 50.0,
    "imu": 200.0,
    "dvl": 7.3,
    "depth": 20.0,
    "position": 3.0,
    "shaft_speed": 25.0,
    "voltage": 5.0,
}
DELAY_S = {"imu": 0.004, "dvl": 0.137, "depth": 0.02, "position": 0.35, "voltage": 1e-9}


def make_log(duration_s: float, seed: int = 0) -> Log:
    """Every channel, full-precision random numbers of very different size."""
    generator = np.random.default_rng(seed)
    log: Log = {}
    for name, columns in COLUMNS.items():
        valid = np.arange(int(duration_s * RATE_HZ[name]) + 1) / RATE_HZ[name]
        shape = (valid.size, len(columns))
        values = generator.standard_normal(shape) * 10.0 ** generator.integers(-12, 6, shape)
        if name == "command":
            values = generator.integers(-127, 128, shape).astype(float)
        log[name] = Channel(columns, valid, valid + DELAY_S.get(name, 0.0), values)
    return log


def make_truth(duration_s: float, seed: int = 1) -> Trajectory:
    """Samples every 0.02 s for five thrusters."""
    generator = np.random.default_rng(seed)
    count = int(duration_s * 50) + 1
    return Trajectory(
        time_s=np.arange(count) / 50.0,
        position_ned_m=generator.standard_normal((count, 3)),
        quaternion=generator.standard_normal((count, 4)),
        nu=generator.standard_normal((count, 6)),
        nu_dot=generator.standard_normal((count, 6)),
        command=generator.standard_normal((count, 5)),
        actuator=generator.standard_normal((count, 5)),
        thrust_n=generator.standard_normal((count, 5)),
        final_state=np.zeros(18),
    )
