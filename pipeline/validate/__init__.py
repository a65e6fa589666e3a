"""The allocator flown in simulation: what is flown, what is measured of a flight, the summary."""
