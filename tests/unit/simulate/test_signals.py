"""Test signals for manoeuvres: by hand, and by what they are made for."""

import numpy as np
import pytest

from pipeline.simulate.manoeuvres import chirp, multisine, prbs, ramp


def test_step_and_ramp_by_hand() -> None:
    time_s = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    assert ramp(time_s, 1.0, 2.0).tolist() == [0.0, 0.0, 0.5, 1.0, 1.0, 1.0]


def test_multisine_holds_its_lines_and_no_other() -> None:
    """1000 s at 10 Hz: lines 0.1 to 0.5 Hz fall on bins of the transform; a peak of one."""
    time_s = np.arange(0.0, 1000.0, 0.1)
    signal = multisine(time_s, 0.1, 0.5, 5)
    assert np.abs(signal).max() == pytest.approx(1.0)
    power = np.abs(np.fft.rfft(signal)) ** 2
    frequency = np.fft.rfftfreq(time_s.size, 0.1)
    loud = frequency[power > 1e-6 * power.max()]
    assert loud == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5])
    assert power[power > 1e-6 * power.max()] == pytest.approx(power.max(), rel=1e-6)


def test_multisine_has_a_low_crest() -> None:
    """Schroeder's phases: far below that of cosines in phase, sqrt(2 n) = 5.3 for 14 lines."""
    signal = multisine(np.arange(0.0, 200.0, 0.05), 0.05, 0.7, 14)
    assert 1.0 / np.sqrt(np.mean(signal**2)) < 2.2


def test_chirp_sweeps_between_its_ends() -> None:
    """The sine's zero crossings lie where the phase pi (2 f0 t + k t^2) passes multiples of pi."""
    time_s = np.arange(0.0, 60.0, 1e-3)
    signal = chirp(time_s, 0.1, 1.0)
    assert signal[0] == pytest.approx(0.0, abs=1e-9)
    assert np.abs(signal).max() == pytest.approx(1.0, abs=1e-3)
    crossings = time_s[1:][np.diff(np.sign(signal)) != 0]
    rate = 0.9 / (time_s[-1] - time_s[0])
    phase = 2 * 0.1 * crossings + rate * crossings**2
    assert np.abs(phase - np.round(phase)).max() < 5e-3
    assert np.diff(crossings)[-5:] == pytest.approx(0.5, rel=0.05)


def test_prbs_is_binary_held_and_balanced() -> None:
    time_s = np.arange(0.0, 511 * 1.5, 0.1)
    signal = prbs(time_s, 1.5, 0)
    assert set(signal.tolist()) == {-1.0, 1.0}
    held = signal.reshape(-1, 15)
    assert (held == held[:, :1]).all()
    # a maximum-length sequence of 511 has one more of one kind, and is white but for 1 / 511
    bits = held[:, 0]
    assert abs(bits.sum()) == 1.0
    assert np.mean(bits * np.roll(bits, 7)) == pytest.approx(-1 / 511)
    assert not np.array_equal(signal, prbs(time_s, 1.5, 61))
