"""Fits: pure functions from records of measurements to records of characteristics."""
