"""Excitation with many frequencies: multisine, chirp and pseudo-random steps told by commands."""

import itertools
from dataclasses import dataclass

import numpy as np

from pipeline.identify.manoeuvre_signals import PERIOD_S, Signals, slope
from pipeline.types import FloatArray

#: Windows in which a part of a run is looked for. [s]
WINDOW_S = 30.0
#: What makes commands broad-band: their size, the share of their power above 0.1 Hz, the share of
#: the time in which none moves, and the share in which some axis does.
_LEAST_SIZE = 0.08
_LEAST_FAST = 0.55
_FAST_HZ = 0.1
_MOST_STILL = 0.6
_LEAST_MOVING = 0.5
_STILL_STEP = 0.02
#: A controller that feeds noise or one sine through is none: how evenly power must be spread over
#: the band, and how much of it may lie above.
_BAND_HZ = (0.02, 0.6)
_LEAST_EVEN = 0.78
_NOISY_HZ = 1.0
_MOST_NOISY = 0.12
_JUMP = 0.10
#: Or commands that hold and jump, with at least this share of the samples in a jump.
_LEAST_JUMPING = 0.04
#: Slopes above which an axis moves: heading, pitch, roll [rad/s], surge [m/s2], depth [m/s].
_MOVES = {"heading": 0.012, "pitch": 0.009, "roll": 0.009, "surge": 0.03, "depth": 0.03}


@dataclass(frozen=True)
class Broadband:
    """What it is, how plainly, and the axes that move."""

    name: str
    confidence: float
    axes: tuple[str, ...]


def broadband(signals: Signals, begin: int, end: int) -> Broadband | None:
    """Tell whether samples `begin` to `end` are broad-band excitation, and of which kind."""
    command = signals.command[begin:end]
    if len(command) < 100:
        return None
    varied = command - command.mean(axis=0)
    size = float(varied.std(axis=0).max())
    steps = np.abs(np.diff(command, axis=0))
    still = float((steps <= _STILL_STEP).all(axis=1).mean())
    jumping = float((steps > _JUMP).any(axis=1).mean())
    if size < _LEAST_SIZE or (still > _MOST_STILL and jumping < _LEAST_JUMPING):
        return None
    fast, even, noisy = _shape(varied)
    if even < _LEAST_EVEN or noisy > _MOST_NOISY:
        return None
    axes = tuple(
        axis
        for axis, least in _MOVES.items()
        if (channel := getattr(signals, axis)) is not None
        and (np.abs(slope(channel[begin:end])) > least).mean() > _LEAST_MOVING
    )
    if fast < _LEAST_FAST or len(axes) < (1 if still <= _MOST_STILL else 2):
        return None
    busy = max(_MOST_STILL - still, jumping - _LEAST_JUMPING)
    margin = min((fast - _LEAST_FAST) / 0.2, busy / 0.2, (size - _LEAST_SIZE) / 0.1)
    confidence = 0.5 + 0.45 * float(np.clip(margin, 0.0, 1.0))
    # in steps nearly all of the change is in a few jumps
    total = steps.sum(axis=0)
    jumps = np.where(steps > _JUMP, steps, 0.0).sum(axis=0)
    quiet = (steps <= 0.5 * _STILL_STEP).mean(axis=0)
    strongest = int(np.argmax(varied.std(axis=0)))
    centres = [_centre_hz(part) for part in np.array_split(varied, 4)]
    name = "multisine"
    if jumps[strongest] > 0.6 * total[strongest] and quiet[strongest] > 0.35:
        name = "prbs"
    elif all(b > 1.1 * a for a, b in itertools.pairwise(centres)):
        name = "chirp" if centres[3] > 2.0 * centres[0] else name
    return Broadband(name, confidence, axes)


def _spectrum(varied: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Frequencies (k,) [Hz] and power (k,), all thrusters together, less a line each."""
    time = np.linspace(-1.0, 1.0, len(varied))[:, None]
    varied = varied - varied.mean(axis=0)
    varied = varied - time * (time * varied).sum(axis=0) / (time * time).sum()
    window = np.hanning(len(varied))[:, None]
    power = (np.abs(np.fft.rfft(window * varied, axis=0)) ** 2).sum(axis=1)
    return np.fft.rfftfreq(len(varied), PERIOD_S).astype(np.float64), power


def _shape(varied: FloatArray) -> tuple[float, float, float]:
    """Share of the power above 0.1 Hz, how evenly the band holds it (0 to 1), share above 1 Hz."""
    frequency, power = _spectrum(varied)
    total = max(float(power.sum()), 1e-12)
    band = power[(frequency > _BAND_HZ[0]) & (frequency < _BAND_HZ[1])]
    band = band / max(float(band.sum()), 1e-12)
    # entropy of the spectrum: 1 where every line is as strong, near 0 for one line
    even = -float((band * np.log(band + 1e-12)).sum()) / np.log(max(band.size, 2))
    fast, noisy = (float(power[frequency > edge].sum()) / total for edge in (_FAST_HZ, _NOISY_HZ))
    return fast, even, noisy


def _centre_hz(varied: FloatArray) -> float:
    frequency, power = _spectrum(varied)
    return float((frequency * power).sum() / max(power.sum(), 1e-12))
