"""Coverage of the 95 % intervals of identified parameters and of thruster gains."""
