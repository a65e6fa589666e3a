"""The library of effects: one file for each cause of a gap between simulation and vehicle."""
