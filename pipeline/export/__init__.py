"""Firmware source and table files from a fitted characteristic."""
