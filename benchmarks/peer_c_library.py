"""Compile the C peer with gcc, where there is one, and call it."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np

from benchmarks.peer_numpy import Simulated
from pipeline.physics.parameters import read, slot
from pipeline.simulate.kernel import BODY, STATE
from pipeline.simulate.pack import PackedVehicle
from pipeline.types import FloatArray

SOURCE = Path(__file__).resolve().parent / "peer_c" / "kernel.c"
FLAGS = ("-std=c99", "-O3", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fPIC", "-shared")
#: Members of the C struct, in its order.
MEMBERS = (
    *("mass", "centre_of_mass", "inertia", "weight", "buoyancy", "centre_of_buoyancy"),
    *("added_mass", "coriolis_fraction", "linear_damping", "quadratic_damping"),
    *("crossflow_fraction", "heave_lift_slope", "sway_lift_slope", "pitch_lift_slope"),
    *("yaw_lift_slope", "turnover_slope"),
    *("density", "current", "wall_strength", "wall_radius", "wall_count"),
    *("wall_point", "wall_normal", "tether_point", "tether_drag_area", "tether_pull"),
    *("tether_anchor", "thruster_count", "thruster_position", "thruster_direction"),
    *("thruster_type", "thrust_gain", "reverse_gain", "inflow_fraction", "dead_zone"),
    *("code_max", "code_min", "lag", "rotor_inertia", "supply_drop", "load_drop"),
    *("misalignment_azimuth", "misalignment_elevation"),
)
_Doubles = ctypes.POINTER(ctypes.c_double)


class CVehicle(ctypes.Structure):
    """The C struct Vehicle."""

    _fields_ = [(name, ctypes.c_double * slot(name).size) for name in MEMBERS]


class CTables(ctypes.Structure):
    """The C struct Tables."""

    _fields_ = [
        *((name, _Doubles) for name in ("thrust", "torque", "screws", "steps", "strips")),
        *(
            (name, ctypes.c_long)
            for name in ("speeds", "codes", "torque_codes", "torque_speeds", "strip_count")
        ),
    ]


def compiler() -> str | None:
    """Path of gcc, or None."""
    return shutil.which("gcc")


def version() -> str:
    """Version of gcc."""
    said = subprocess.run(  # noqa: S603 (a compiler found by name)
        [compiler() or "gcc", "-dumpfullversion"], check=True, capture_output=True, text=True
    )
    return said.stdout.strip()


def build(folder: Path, *, native: bool = False) -> "PeerC":
    """Compile the peer into a folder; `native` lets gcc use every instruction of this processor."""
    gcc = compiler()
    if gcc is None:
        raise FileNotFoundError("gcc")
    target = folder / f"peer{'_native' if native else ''}.so"
    extra = ("-march=native",) if native else ()
    command = [gcc, *FLAGS, *extra, str(SOURCE), "-o", str(target), "-lm"]
    subprocess.run(command, check=True)  # noqa: S603 (our own source, a compiler found by name)
    return PeerC(ctypes.CDLL(str(target)))


def _pointer(array: FloatArray) -> "ctypes._Pointer[ctypes.c_double]":
    return array.ctypes.data_as(_Doubles)


class PeerC:
    """The compiled peer; `simulate` has the meaning of `pipeline.simulate.run.run`."""

    def __init__(self, library: ctypes.CDLL) -> None:
        library.vehicle_size.restype = ctypes.c_ulong
        if library.vehicle_size() != ctypes.sizeof(CVehicle):
            raise RuntimeError("struct Vehicle in C and MEMBERS in Python do not agree")
        self._simulate = library.simulate_c
        self._simulate.restype = None
        self._simulate.argtypes = [
            ctypes.POINTER(CVehicle),
            ctypes.POINTER(CTables),
            _Doubles,
            _Doubles,
            ctypes.c_long,
            _Doubles,
            ctypes.c_double,
            ctypes.c_int,
            _Doubles,
            _Doubles,
            _Doubles,
        ]

    def simulate(
        self,
        packed: PackedVehicle,
        commands: FloatArray,
        *,
        dt_s: float,
        start: FloatArray,
        vector: FloatArray | None = None,
        external: FloatArray | None = None,
        method: str = "semi_implicit",
    ) -> Simulated:
        """Integrate commands (m, n), each held for a step; `external` (6,)."""
        values = packed.vector if vector is None else vector
        vehicle = CVehicle()
        for name in MEMBERS:
            getattr(vehicle, name)[:] = np.ravel(read(values, name)).tolist()
        thrust = np.ascontiguousarray(packed.thrust_tables)
        torque = np.ascontiguousarray(packed.torque_tables)
        screws, steps = np.ascontiguousarray(packed.screws), np.ascontiguousarray(packed.steps)
        strips = np.ascontiguousarray(packed.strips)
        tables = CTables(
            *(_pointer(a) for a in (thrust, torque, screws, steps, strips)),
            *thrust.shape[2:],
            *torque.shape[1:],
            len(strips),
        )
        count, thrusters = commands.shape
        padded = np.zeros((count, STATE - BODY))
        padded[:, :thrusters] = commands
        outside = np.zeros(6) if external is None else np.ascontiguousarray(external, float)
        begin = np.ascontiguousarray(start, float)
        states = np.empty((count + 1, STATE))
        accelerations = np.empty((count + 1, 6))
        thrusts = np.empty((count + 1, STATE - BODY))
        self._simulate(
            ctypes.byref(vehicle),
            ctypes.byref(tables),
            _pointer(begin),
            _pointer(padded),
            count,
            _pointer(outside),
            dt_s,
            {"rk4": 0, "semi_implicit": 1}[method],
            *(_pointer(a) for a in (states, accelerations, thrusts)),
        )
        return Simulated(states[:, : BODY + thrusters], accelerations, thrusts[:, :thrusters])
