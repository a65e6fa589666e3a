"""Thrust allocation: wrench demand to control codes, pure functions, SNAME axes."""
