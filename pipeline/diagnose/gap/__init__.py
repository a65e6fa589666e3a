"""Where a gap lies: regimes, times, and what a force that is left goes with."""
