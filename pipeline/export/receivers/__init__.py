"""A vehicle for the programs that people fly: autopilots' parameters, models of simulators."""
