"""Diagnosis of mooring tables: the same question for one thruster on the bench."""
