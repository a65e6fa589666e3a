"""Test signals for manoeuvres: pure functions of time, amplitude one."""

import numpy as np

from pipeline.types import FloatArray


def ramp(time_s: FloatArray, start_s: float, rise_s: float) -> FloatArray:
    """0 before `start_s`, then a line to 1 within `rise_s`."""
    return np.clip((time_s - start_s) / rise_s, 0.0, 1.0)


def multisine(time_s: FloatArray, lowest_hz: float, highest_hz: float, lines: int) -> FloatArray:
    """Sum of equally spaced sines with Schroeder's phases, scaled to a peak of one.

    phi_k = -pi k (k - 1) / n keeps the crest factor low (Schroeder 1970, IEEE Trans. Inf. Theory
    16(1), 85-89).
    """
    k = np.arange(1, lines + 1)
    frequency = np.linspace(lowest_hz, highest_hz, lines)
    phase = -np.pi * k * (k - 1) / lines
    signal = np.cos(2 * np.pi * frequency * time_s[:, None] + phase).sum(axis=1)
    return np.asarray(signal / np.abs(signal).max())


def chirp(time_s: FloatArray, start_hz: float, end_hz: float) -> FloatArray:
    """Sine whose frequency grows linearly from start to end over the signal."""
    from scipy.signal import chirp as linear_chirp

    return np.asarray(
        linear_chirp(time_s - time_s[0], start_hz, float(np.ptp(time_s)), end_hz, phi=-90)
    )


def prbs(time_s: FloatArray, hold_s: float, seed: int) -> FloatArray:
    """Pseudo-random binary signal of +1 and -1: a maximum-length sequence held for `hold_s`.

    The seed sets where in the sequence the signal starts.
    """
    from scipy.signal import max_len_seq

    bits = max_len_seq(9)[0] * 2.0 - 1.0
    index = np.floor((time_s - time_s[0]) / hold_s).astype(int) + seed
    return np.asarray(bits[index % bits.size])
