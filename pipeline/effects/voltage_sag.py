"""Voltage sag: the drives get less than the voltage at which they were measured.

A battery that empties, a long cable or a thin one lowers the supply voltage. A drive whose code
sets a share of the supply voltage then turns more slowly at every code. The effect has two parts:
a share that is missing always (state of charge, wrong supply on the bench), and a share that is
missing in proportion to the load (resistance of battery, cable and connectors: the current of a
propeller drive goes about with the square of the code). For all thrusters alike

    N_act = N_eff (1 - drop - load_drop mean((N_i / N_max)^2))

with the mean over the vehicle's thrusters; of a stated dead zone that share is left alone which
comes before the drive. A negative drop is a supply above that of the bench, as
with a freshly charged battery.

It shows as thrust missing at all codes in the same proportion of code (drop), and more so the more
thrusters work hard together (load_drop): then heave weakens while the vehicle drives ahead,
although no thruster is at fault. Easily taken for thrust deduction (a factor on thrust instead of
on the code: hard to tell at a single code level) and for `advance_speed_loss` where speed and load
always rise together; a static pull, or a logged voltage, separates them. Within a run the
library's sag is constant; the diagnosis lets the drop grow along a run as a logged voltage tells.
"""

from collections.abc import Mapping

from pipeline.effects.effect import Effect, EffectContext, Parameter, add
from pipeline.errors import CannotComputeError
from pipeline.physics.parameters import read
from pipeline.types import FloatArray


def _apply(
    vector: FloatArray, values: Mapping[str, float], _target: int | None, _context: EffectContext
) -> None:
    add(vector, "supply_drop", values["drop"])
    add(vector, "load_drop", values["load_drop"])
    if values["drop"] == values["load_drop"] == 0.0:
        return
    drop, load_drop = float(read(vector, "supply_drop")), float(read(vector, "load_drop"))
    if drop + load_drop >= 1.0:
        raise CannotComputeError(
            f"voltage_sag: drop {drop:g} and load_drop {load_drop:g} together "
            "leave no voltage at full load. Their sum must stay below 1."
        )


EFFECT = Effect(
    id="voltage_sag",
    title="the supply voltage is lower than on the bench",
    source=(
        "Kostenko and Tolstonogov 2022, Underwater Investigations and Robotics 2(40), 4-12 (drive "
        "load tests); Healey and others 1995, IEEE J. Oceanic Eng. 20(4), 354-361 (motor equations)"
    ),
    parameters=(
        Parameter(
            "drop",
            unit="1",
            neutral=0.0,
            plausible=(-0.15, 0.3),
            meaning="share of the supply voltage that is missing at no load",
            possible=(-1.0, 0.95),
        ),
        Parameter(
            "load_drop",
            unit="1",
            neutral=0.0,
            plausible=(0.02, 0.3),
            meaning="further share that is missing with every thruster at full code",
            possible=(0.0, 0.95),
        ),
    ),
    channels=("u", "v", "w", "p", "q", "r"),
    vector_slots=("supply_drop", "load_drop"),
    apply=_apply,
    of_thrusters=True,
)
