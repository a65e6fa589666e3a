"""Measurements of speed, with peers written for them. See README.md."""
