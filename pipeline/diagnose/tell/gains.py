"""Gains of the thrusters as ``diagnosis.json`` lists them."""

from pipeline.records.diagnosis import Gain
from pipeline.records.gains import ThrusterGains


def told_gains(gains: ThrusterGains) -> tuple[Gain, ...]:
    """Return the gains that the runs tell, on axes that the thruster moves."""
    return tuple(
        Gain(
            run=one.run,
            thruster=one.thruster,
            axis=one.axis,
            value=one.value,
            ci95=one.ci95,
            reference=None if one.reference is None else one.reference.mean,
        )
        for one in gains.gains
        if one.judged and one.moves and one.value is not None and one.ci95 is not None
    )
