"""What moves a vehicle through commands: the kernel alone, or the kernel with its tether."""

from typing import Protocol

from pipeline.simulate.pack import PackedVehicle
from pipeline.simulate.run import Trajectory
from pipeline.types import FloatArray


class Mover(Protocol):
    """Simulates commands held for one step each; `run` is one.

    One that carries a state of its own (a tether) goes on from where its last call ended.
    """

    def __call__(
        self,
        packed: PackedVehicle,
        commands: FloatArray,
        *,
        dt_s: float,
        vector: FloatArray | None = None,
        start: FloatArray | None = None,
        start_time_s: float = 0.0,
    ) -> Trajectory:
        """Return the run of commands (m, n); arguments as `run` takes them."""
        ...
