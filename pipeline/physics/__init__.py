"""Pure functions of the physics: SI units, SNAME axes, no files."""
