"""Thresholds of the diagnosis, set on generated cases."""
