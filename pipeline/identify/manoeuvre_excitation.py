"""Whether a part of a run is broad-band excitation: multisine, chirp or pseudo-random steps."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pipeline.identify.manoeuvre_signals import PERIOD_S, Range, Signals, slope
from pipeline.records.trial import ManoeuvreName
from pipeline.types import FloatArray

#: What makes commands broad-band: their size, the share of their power above 0.1 Hz, the share of
#: the time in which none moves, and the share in which some axis does.
_LEAST_SIZE, _LEAST_FAST, _FAST_HZ = 0.08, 0.55, 0.1
_MOST_STILL, _STILL_STEP, _LEAST_MOVING = 0.6, 0.02, 0.5
#: A controller that feeds noise or one sine through is none: how evenly power must be spread over
#: the band, and how much of it may lie above.
_BAND_HZ, _LEAST_EVEN, _NOISY_HZ, _MOST_NOISY = (0.02, 0.6), 0.78, 1.0, 0.12
#: Or commands that hold and jump, with at least this share of the samples in a jump.
_JUMP, _LEAST_JUMPING = 0.10, 0.04
#: Slopes above which an axis moves: heading, pitch, roll [rad/s], surge [m/s2], depth [m/s].
_MOVES = {"heading": 0.012, "pitch": 0.009, "roll": 0.009, "surge": 0.03, "depth": 0.03}


@dataclass(frozen=True)
class Group:
    """Samples `begin` to `end`, and what they are."""

    begin: int
    end: int
    name: ManoeuvreName
    sentence: str


def broadband(signals: Signals, part: Range) -> Group | None:
    """Tell whether a part is an excitation, and which."""
    command = signals.command[slice(*part)]
    if len(command) < 100:
        return None
    varied = command - command.mean(axis=0)
    steps = np.abs(np.diff(command, axis=0))
    still = float((steps <= _STILL_STEP).all(axis=1).mean())
    size = varied.std(axis=0)
    jumping = float((steps > _JUMP).any(axis=1).mean()) >= _LEAST_JUMPING
    if size.max() < _LEAST_SIZE or (still > _MOST_STILL and not jumping):
        return None
    axes = [
        axis
        for axis, least in _MOVES.items()
        if axis in signals.channels
        if (np.abs(slope(signals.channels[axis][slice(*part)])) > least).mean() > _LEAST_MOVING
    ]
    if len(axes) < (1 if still <= _MOST_STILL else 2) or not _is_broad(varied):
        return None
    own = steps[:, int(np.argmax(size))]
    centres = []
    for quarter in np.array_split(varied, 4):
        frequency, power = _spectrum(quarter)
        centres.append(float((frequency * power).sum() / max(power.sum(), 1e-12)))
    name: ManoeuvreName = "multisine"
    if own[own > _JUMP].sum() > 0.6 * own.sum() and (own <= 0.5 * _STILL_STEP).mean() > 0.35:
        # nearly all of the change is in a few jumps
        name = "prbs"
    elif all(b > 1.1 * a for a, b in pairwise(centres)) and centres[3] > 2.0 * centres[0]:
        name = "chirp"
    return Group(*part, name, f"commands of many frequencies; {', '.join(axes)} move")


def _spectrum(varied: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Frequencies (k,) [Hz] and power (k,), all thrusters together, less a line each."""
    from scipy.signal import detrend

    rest = np.hanning(len(varied))[:, None] * detrend(varied, axis=0)
    power = np.abs(np.fft.rfft(rest, axis=0)) ** 2
    return np.fft.rfftfreq(len(rest), PERIOD_S).astype(np.float64), power.sum(axis=1)


def _is_broad(varied: FloatArray) -> bool:
    """Whether power is fast enough, spread evenly over the band, and not mostly noise above it."""
    frequency, power = _spectrum(varied)
    total = max(float(power.sum()), 1e-12)
    band = power[(frequency > _BAND_HZ[0]) & (frequency < _BAND_HZ[1])]
    band = band / max(float(band.sum()), 1e-12)
    # entropy of the spectrum: 1 where every line is as strong, near 0 for one line
    even = -float((band * np.log(band + 1e-12)).sum()) / np.log(max(band.size, 2))
    fast, noisy = (float(power[frequency > edge].sum()) / total for edge in (_FAST_HZ, _NOISY_HZ))
    return even >= _LEAST_EVEN and noisy <= _MOST_NOISY and fast >= _LEAST_FAST
