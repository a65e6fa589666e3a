"""rig2sea: rig data in, thruster tables, firmware and a diagnosed sim-to-real gap out."""

__version__ = "0.1.0"
